"""``evaluate``: types of messages, where the truth comes from, limits, outputs, one clear line for bad input."""

from __future__ import annotations

import html
import json
import os
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from estimates import Make, beside, messages, write

from lie_rigid_body import Run, simulate
from lie_rigid_body.cli.bag_progress import progress_bar
from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.evaluation import Score
from lie_rigid_body.lie import quaternion
from lie_rigid_body.report.figure import svg
from lie_rigid_body.runs.recorded_estimate import recorded_estimate

SIZE = np.radians(0.5)
P = np.eye(3) * SIZE**2
HOW = messages(P)
POSE = "geometry_msgs/msg/PoseStamped"
IMU = "sensor_msgs/msg/Imu"
TF = "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"


@pytest.fixture(scope="module")
def run() -> Run:
    motion: dict[str, Any] = {
        "initial_body_rate": [0.4, 0.6, -0.3],
        "motion": "closed_form",
        "rate": 20.0,
        "imu_rate": 25.0,
    }
    return simulate("tumbling_cubesat", duration=10.0, **motion)


@pytest.fixture(scope="module")
def stamps(run: Run) -> np.ndarray:
    assert run.imu is not None
    return run.imu.t_ns


@pytest.fixture(scope="module")
def noisy(run: Run, stamps: np.ndarray) -> np.ndarray:
    noise = np.random.default_rng(1).normal(size=(len(stamps), 3)) * SIZE
    return quaternion.multiply(quaternion.exp(noise), run.attitude().at(stamps))


@pytest.fixture(scope="module")
def own(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("evaluate") / "run.mcap"
    run.to_bag(path)
    return path


@pytest.fixture(scope="module")
def bag(own: Path, stamps: np.ndarray, noisy: np.ndarray) -> Path:
    """The run with the same estimate in each type of message."""
    topics = [(kind, how, f"/filter/{kind.rpartition('/')[2]}", stamps, noisy) for kind, how in HOW.items()]
    return beside(own, own.with_name("bag.mcap"), *topics)


def scored(capsys: pytest.CaptureFixture[str], *arguments: object, status: int = 0) -> dict[str, Any]:
    capsys.readouterr()
    assert main([*map(str, arguments), "--json"]) == status
    out, err = capsys.readouterr()
    assert err == ""
    content: dict[str, Any] = json.loads(out)
    return content


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    capsys.readouterr()
    assert main([str(a) for a in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


@pytest.fixture(scope="module")
def score(run: Run, noisy: np.ndarray) -> Score:
    return run.score(noisy)


@pytest.mark.parametrize("kind", list(HOW))
def test_every_type_of_message_has_the_same_score(kind, bag, score, capsys):
    content = scored(capsys, bag, "--estimate", f"filter/{kind.rpartition('/')[2]}")
    assert content["type"] == kind
    assert content["samples"] == 250
    assert content["truth"] == "poses and scenario"
    assert content["total_deg"]["rms"] == pytest.approx(score.total_deg.rms, rel=1e-12)
    assert content["findings"] == []
    assert content["notes"] == []
    assert content["passed"] is True
    told = kind in (IMU, ODOMETRY, "geometry_msgs/msg/PoseWithCovarianceStamped")
    assert (content["nees"] is not None) == told
    if told:
        assert content["nees"]["verdict"] == "consistent"


def test_the_truth_in_another_bag_or_by_the_scenario_alone(own, bag, stamps, noisy, tmp_path, capsys):
    alone = write(tmp_path / "alone.mcap", POSE, HOW[POSE], "/pose", stamps, noisy)
    rms = scored(capsys, bag, "--estimate", "/filter/PoseStamped")["total_deg"]["rms"]
    other = scored(capsys, alone, "--estimate", "/pose", "--truth", own)
    assert other["total_deg"]["rms"] == rms
    assert "has no truth, neither a topic .../scenario nor .../pose" in refused(capsys, alone, "--estimate", "/pose")
    only = beside(own, tmp_path / "only.mcap", (POSE, HOW[POSE], "/filter/pose", stamps, noisy), without="/pose /twist")
    by_scenario = scored(capsys, only, "--estimate", "/filter/pose")
    assert by_scenario["truth"] == "scenario"
    assert by_scenario["total_deg"]["rms"] == pytest.approx(rms, rel=1e-12)
    assert "from 0 s on; the estimate begins 0 s after that" in by_scenario["notes"][0]
    poses = beside(own, tmp_path / "poses.mcap", without="/lie_rigid_body/scenario /twist")
    by_poses = scored(capsys, alone, "--estimate", "/pose", "--truth", poses)
    assert by_poses["truth"] == "poses"
    # the geodesic from one sample of the truth to the next misses it by |ω̇| h²/8 at most
    assert by_poses["total_deg"]["rms"] == pytest.approx(rms, abs=0.02)


def test_of_several_truths_that_beside_the_estimate_is_meant(own, stamps, noisy, tmp_path, capsys):
    run = Run.from_bag(own)
    poses = [(POSE, HOW[POSE], f"/{name}/pose", run.t_ns, run.truth.attitude_xyzw[::step]) for name, step in AB]
    ours = [(POSE, HOW[POSE], topic, stamps[:200], noisy[:200]) for topic in ("/a/estimate", "/estimate")]
    bag = beside(own, tmp_path / "two.mcap", *poses, *ours, without="/pose /twist /lie_rigid_body/scenario")
    assert scored(capsys, bag, "--estimate", "/a/estimate")["total_deg"]["max"] < 5.0
    assert "has several topics .../pose: /a/pose, /b/pose" in refused(capsys, bag, "--estimate", "/estimate")
    others = beside(own, tmp_path / "truth.mcap", *poses, without="/pose /twist /lie_rigid_body/scenario")
    assert scored(capsys, bag, "--estimate", "/a/estimate", "--truth", others)["total_deg"]["max"] < 5.0


AB = (("a", 1), ("b", -1))


def test_a_truth_of_other_names_is_told_by_topic(own, run, stamps, noisy, tmp_path, capsys):
    poses = [(POSE, HOW[POSE], f"/{name}", run.t_ns, run.truth.attitude_xyzw[::step]) for name, step in MOCAP]
    ours = (POSE, HOW[POSE], "/b/pose", stamps, noisy)
    bag = beside(own, tmp_path / "renamed.mcap", *poses, ours, without="/pose /twist")
    given = [bag, "--estimate", "/b/pose"]
    by_scenario = scored(capsys, *given)
    named = scored(capsys, *given, "--topic", "pose:=/mocap/truth")
    assert (by_scenario["truth"], named["truth"]) == ("scenario", "poses and scenario")
    assert named["total_deg"]["rms"] == pytest.approx(by_scenario["total_deg"]["rms"], rel=1e-9)
    assert scored(capsys, *given, "--topic", "pose:=/mocap/other")["total_deg"]["median"] > 10.0
    elsewhere = ["--truth", bag, "--topic", "scenario:=/lie_rigid_body/scenario"]
    assert scored(capsys, *given, *elsewhere)["total_deg"]["rms"] == by_scenario["total_deg"]["rms"]
    for topic, message in [
        ("pose:=/mocap/truht", "there is no topic /mocap/truht: did you mean /mocap/truth"),
        ("pose:=/imu/data_raw", "topic /imu/data_raw is of Imu, not PoseStamped"),
        ("twist:=/twist", "no topic 'twist': the topics of a body are pose, scenario"),
        ("pose:=/b/pose", "that is the estimate: name the topic of the truth"),
        ("pose", "not NAME:=/TOPIC"),
    ]:
        assert message in refused(capsys, *given, "--topic", topic)


MOCAP = (("mocap/truth", 1), ("mocap/other", -1))


def test_progress_tells_every_byte_read(own, bag):
    steps: list[int] = []
    recorded_estimate(bag, "/filter/Imu", own, progress=steps.append)
    size = bag.stat().st_size + own.stat().st_size
    assert 0.3 * size < sum(steps) <= size  # all but the index at the end, which is much of a small file
    with progress_bar([bag, own], passes=1) as bar:
        assert bar.total == size
        assert bar.disable  # as stderr is no terminal


def test_limits_are_the_exit_status(bag, capsys):
    given = [bag, "--estimate", "/filter/Imu"]
    assert scored(capsys, *given, "--max-rms", "1deg", "--max-after", "2s:3deg")["passed"] is True
    broken = scored(capsys, *given, "--max-rms", "0.1deg", "--max-after", "2s:1e-3rad", status=1)
    assert broken["passed"] is False
    assert len(broken["broken"]) == 2
    assert main([str(a) for a in given]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^total +0\.\d+ ", out, re.MULTILINE)
    assert "no findings" in out
    assert "PASSED" not in out
    assert main([*map(str, given), "--max-rms", "1deg"]) == 0
    assert "PASSED: every limit is kept." in capsys.readouterr().out
    assert main([*map(str, given), "--max-rms", "0.1deg"]) == 1
    assert "BROKEN: the error is" in capsys.readouterr().out
    assert "is not an angle such as 1deg" in refused(capsys, *given, "--max-rms", "1")
    assert "give for example 10s:2deg" in refused(capsys, *given, "--max-after", "10s")


FAR = 2**31 * 10**9 - 10**9
"""A stamp of the year 2038, ns."""
LITTLE: dict[str, Any] = {
    "stamps are 0": (lambda t, q: (0 * t, q), "only 1 of 250 estimates"),
    "reversed": (lambda t, q: (t[::-1], q[::-1]), "only 1 of 250 estimates"),
    "in microseconds": (lambda t, q: (1000 * t, q), "only 1 of 250 estimates"),
    "ends early": (lambda t, q: (t[:6], q[:6]), "only 0.2 of 10 s since the first estimate"),
}


@pytest.mark.parametrize("case", LITTLE)
def test_a_limit_is_not_kept_by_the_little_that_could_be_compared(case, own, run, stamps, tmp_path, capsys):
    change, said = LITTLE[case]
    q = run.attitude().at(stamps)
    bag = beside(own, tmp_path / "little.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, q)))
    given = bag, "--estimate", "/estimate"
    assert scored(capsys, *given)["broken"] == []
    content = scored(capsys, *given, "--max-rms", "180deg", status=1)
    assert said in content["broken"][0]
    late = beside(own, tmp_path / "late.mcap", (POSE, HOW[POSE], "/estimate", stamps[200:], q[200:]))
    assert scored(capsys, late, "--estimate", "/estimate", "--max-rms", "1deg")["passed"]


def test_one_stamp_far_ahead_does_not_hide_what_follows(own, run, stamps, tmp_path, capsys):
    t, q = stamps.copy(), run.attitude().at(stamps)
    t[3] = FAR
    bag = beside(own, tmp_path / "far.mcap", (POSE, HOW[POSE], "/estimate", t, q))
    content = scored(capsys, bag, "--estimate", "/estimate", "--max-rms", "1deg")
    assert content["samples"] == 249
    [note] = content["notes"]
    assert note.startswith("Left out of 250 estimates: 1 stamped far ahead of the truth, the first by 21474836")


def test_a_finding_is_told_with_what_to_do(own, stamps, noisy, tmp_path, capsys):
    inverse = (POSE, HOW[POSE], "/inverse", stamps, quaternion.conjugate(noisy))
    bag = beside(own, tmp_path / "inverse.mcap", inverse)
    [finding] = scored(capsys, bag, "--estimate", "/inverse")["findings"]
    assert finding["code"] == "inverted"
    assert finding["rms_deg_after"] < 1.0
    assert main([str(bag), "--estimate", "/inverse"]) == 0
    assert "inverted: The quaternion is the inverse" in capsys.readouterr().out


def test_picture_and_page(bag, tmp_path, capsys):
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    given = [str(bag), "--estimate", "/filter/Imu", "--max-after", "1s:5deg", "--plot", str(picture)]
    assert main([*given, "--report", str(page)]) == 0
    assert f"wrote {picture}\nwrote {page}" in capsys.readouterr().out
    assert picture.read_bytes().startswith(b"\x89PNG")
    content = page.read_text(encoding="utf-8")
    assert content.count("<svg") == 1
    assert "tumbling" not in content
    for wanted in ("PASSED", "inclination", "NEES", "&quot;inertia&quot;", "</html>"):
        assert wanted in content
    # it needs no other file: nothing is loaded from anywhere
    assert not re.search(r"<(script|link|img|iframe)|url\(h|@import|src=", content)
    for option, file in (("--plot", picture), ("--report", page)):  # before the work
        assert "exists and is kept" in refused(capsys, "absent.mcap", "--estimate", "/filter/Imu", option, file)
    assert main([*given, "--force"]) == 0
    assert "only PNG is written" in refused(capsys, *given[:3], "--plot", "a.svg")
    assert "only HTML is written" in refused(capsys, *given[:3], "--report", "a.pdf")


@pytest.mark.filterwarnings("error")
def test_a_picture_has_any_name(score):
    name = os.fsdecode(b"'$\\frac{$ <b>&r\xff\n\x1b") + "日本.mcap"
    title = re.search(r"<text[^>]*>('[^<]*)</text>", svg(f"{name}: {300 * 'm'}", score))
    assert title is not None
    said = html.unescape(title[1])
    assert said.startswith(r"'$\frac{$ <b>&r\udcff\n\x1b日本.mcap: mmm")
    assert len(said) <= 110


def test_the_series_are_in_the_json_on_request(bag, stamps, capsys):
    series = scored(capsys, bag, "--estimate", "/filter/Imu", "--series")["series"]
    assert series["stamps_ns"] == stamps.tolist()
    assert len(series["total_deg"]) == len(series["nees"]) == 250


BAD: dict[str, Any] = {
    "not a number": (
        lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, np.nan, q)),
        "1 of 250 rows are not finite",
    ),
    "zero": (
        lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, 0.0, q)),
        "or fill in the orientation",
    ),
    "another clock": (lambda t, q: (t + 10**18, q), "none of its 250 stamps"),
    "empty": (lambda t, q: (t[:0], q[:0]), "has no topic /estimate|has no message on /estimate"),
}


@pytest.mark.parametrize("case", BAD)
def test_unusable_estimates_are_refused_in_one_line(case, own, stamps, noisy, tmp_path, capsys):
    change, message = BAD[case]
    bag = beside(own, tmp_path / "bad.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, noisy)))
    assert re.search(message, refused(capsys, bag, "--estimate", "/estimate"))


NAMED: dict[str, Any] = {
    "not of unit norm": (lambda t, q: (t, 1.1 * q), ["not_unit"]),
    "with gaps": (lambda t, q: (np.delete(t, slice(50, 75)), np.delete(q, slice(50, 75), axis=0)), ["gaps"]),
    "with doubles": (lambda t, q: (np.repeat(t, 2), np.repeat(q, 2, axis=0)), ["gaps"]),
}


@pytest.mark.parametrize("case", NAMED)
def test_flawed_estimates_are_scored_and_named(case, own, stamps, noisy, tmp_path, capsys):
    change, codes = NAMED[case]
    bag = beside(own, tmp_path / "flawed.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, noisy)))
    assert [f["code"] for f in scored(capsys, bag, "--estimate", "/estimate")["findings"]] == codes


def test_what_is_stamped_before_an_earlier_one_is_left_out_and_counted(own, run, stamps, noisy, tmp_path, capsys):
    order = np.r_[100:125, :125, 125:250]
    bag = beside(own, tmp_path / "back.mcap", (IMU, HOW[IMU], "/estimate", stamps[order], noisy[order]))
    content = scored(capsys, bag, "--estimate", "/estimate")
    [note] = content["notes"]
    assert note.startswith("124 of 275 estimates were stamped before one that had come, and are left out")
    kept = np.r_[100:125, 125:250]
    expected = run.score(noisy[kept], stamps[kept], covariance=P).to_json()
    assert content["total_deg"] == pytest.approx(expected["total_deg"])
    assert content["nees"]["mean"] == pytest.approx(expected["nees"]["mean"])
    assert main([str(bag), "--estimate", "/estimate"]) == 0
    assert "note: 124 of 275 estimates" in capsys.readouterr().out


def test_ten_times_as_fast_as_the_truth(own, run, tmp_path, capsys):
    t = np.arange(0, 10 * 10**9, 10_000_000)
    bag = beside(own, tmp_path / "fast.mcap", (POSE, HOW[POSE], "/estimate", t, run.attitude().at(t)))
    content = scored(capsys, bag, "--estimate", "/estimate")
    assert content["samples"] == 1000
    assert content["total_deg"]["max"] < 1e-12


@pytest.mark.parametrize(
    ("kind", "names", "note"),
    [
        (POSE, {"world": "odom"}, "The frame of the estimate is 'odom', that of the truth 'world'"),
        (
            POSE,
            {"world": "o" * 300},
            "The frame of the estimate is 'ooooooooooooooooooooooo...oooooooooooooooooooooooo', that",
        ),
        (IMU, {"sensor": "odom"}, "The frame of the estimate is 'odom', that of the truth 'world'"),
        (ODOMETRY, {"body": "lidar"}, "The body of the estimate is 'lidar', that of the truth 'base_link'"),
    ],
)
def test_other_frames_are_named(kind, names, note, own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "named.mcap", (kind, messages(P, **names)[kind], "/estimate", stamps, noisy))
    [told] = scored(capsys, bag, "--estimate", "/estimate")["notes"]
    assert told.startswith(note)
    assert main([str(bag), "--estimate", "/estimate"]) == 0
    assert "note: The " in capsys.readouterr().out


def alternating(one: Make, other: Make) -> Make:
    return lambda stamp, q: (one if stamp % 80_000_000 else other)(stamp, q)


def test_two_bodies_are_refused(own, stamps, noisy, tmp_path, capsys):
    other = messages(P, world="b/world", body="b/base_link")
    for kind in (POSE, ODOMETRY):
        topic = (kind, alternating(messages(P, world="a/world")[kind], other[kind]), "/estimate", stamps, noisy)
        bag = beside(own, tmp_path / f"{kind.rpartition('/')[2]}.mcap", topic)
        assert "b/world" in refused(capsys, bag, "--estimate", "/estimate")
    transforms = (TF, other[TF], "/tf", stamps, noisy)
    said = refused(capsys, beside(own, tmp_path / "tf.mcap", transforms), "--estimate", "/tf")
    assert "map to odometer, b/world to b/base_link, none of which is world to base_link" in said
    truths = [(POSE, HOW[POSE], f"/{name}/pose", stamps, noisy) for name in "ab"]
    two = beside(own, tmp_path / "two.mcap", *truths, without="/lie_rigid_body/scenario /pose")
    assert "several topics .../pose: /a/pose, /b/pose" in refused(capsys, own, "--estimate", "/pose", "--truth", two)


def test_texts_that_another_node_calls_scenario_tell_no_truth(own, stamps, noisy, tmp_path, capsys):
    text = (
        "std_msgs/msg/String",
        lambda stamp, q: SimpleNamespace(data="highway 7"),
        "/x/scenario",
        stamps[:1],
        noisy[:1],
    )
    estimate = (POSE, HOW[POSE], "/estimate", stamps, noisy)
    with_text = scored(capsys, beside(own, tmp_path / "text.mcap", text, estimate), "--estimate", "/estimate")
    without = scored(capsys, beside(own, tmp_path / "plain.mcap", estimate), "--estimate", "/estimate")
    assert with_text["total_deg"] == without["total_deg"]


def test_other_estimates_are_not_taken_for_the_truth(own, stamps, noisy, tmp_path, capsys):
    inverse = quaternion.conjugate(noisy)
    topics = [(POSE, HOW[POSE], f"/{name}/pose", stamps, q) for name, q in (("one", noisy), ("two", inverse))]
    bag = beside(own, tmp_path / "several.mcap", *topics)
    assert scored(capsys, bag, "--estimate", "/one/pose")["total_deg"]["rms"] < 1.0
    without = beside(own, tmp_path / "without.mcap", *topics, without="/pose /twist")
    content = scored(capsys, without, "--estimate", "/one/pose")
    assert content["truth"] == "scenario"
    assert content["total_deg"]["rms"] < 1.0


def test_topics_without_an_attitude_are_refused(own, bag, tmp_path, capsys):
    assert "attitudes are on /pose, /imu/data_raw, /imu/bias" in refused(capsys, own, "--estimate", "/imu/data")
    assert "has no orientation" in refused(capsys, own, "--estimate", "/imu/data_raw")
    assert "is of TwistStamped: give PoseStamped, " in refused(capsys, own, "--estimate", "/twist")
    assert "does not exist" in refused(capsys, tmp_path / "no.mcap", "--estimate", "/pose")
    assert "does not exist" in refused(capsys, bag, "--estimate", "/pose", "--truth", tmp_path / "no.mcap")
    assert "the following arguments are required: --estimate" in refused(capsys, bag)


@pytest.mark.parametrize(
    ("covariance", "note"),
    [
        (np.zeros((3, 3)), None),
        (np.diag([-1.0, 0.0, 0.0]), None),
        (np.diag([0.0, 0.0, 1e-4]), "There is no NEES: covariance: not symmetric with positive variances"),
    ],
)
def test_covariances_that_cannot_be_used(covariance, note, own, stamps, noisy, tmp_path, capsys):
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    bag = beside(own, tmp_path / "c.mcap", (kind, messages(covariance)[kind], "/estimate", stamps, noisy))
    content = scored(capsys, bag, "--estimate", "/estimate")
    assert content["nees"] is None
    assert [told.startswith(note) for told in content["notes"]] == ([True] if note else [])


def test_a_covariance_about_the_bodys_axes_is_recognised_and_can_be_said(own, run, stamps, tmp_path, capsys):
    deviations = np.radians([0.05, 0.5, 2.0])
    noise = np.random.default_rng(4).normal(size=(len(stamps), 3)) * deviations
    estimate = quaternion.multiply(run.attitude().at(stamps), quaternion.exp(noise))
    how = messages(np.diag(deviations**2))[IMU]
    bag = beside(own, tmp_path / "body.mcap", (IMU, how, "/estimate", stamps, estimate))
    found = scored(capsys, bag, "--estimate", "/estimate")["nees"]
    assert found["verdict"] == "overconfident"
    assert re.search(r"about the body's axes it would be [23]\.\d+: .* give covariance_axes body", found["remark"])
    assert main([str(bag), "--estimate", "/estimate"]) == 0
    assert "\nremark        about the body's axes" in capsys.readouterr().out
    said = scored(capsys, bag, "--estimate", "/estimate", "--covariance-axes", "body")["nees"]
    assert (said["verdict"], said["remark"]) == ("consistent", "")
    assert "invalid choice: 'map'" in refused(capsys, bag, "--estimate", "/estimate", "--covariance-axes", "map")


def test_damaged_messages_are_refused(own, stamps, noisy, tmp_path, capsys):
    for kind in (TF, ODOMETRY):
        good = write(tmp_path / "good.mcap", kind, HOW[kind], "/estimate", stamps[:1], noisy[:1])
        assert main([str(good), "--estimate", "/estimate", "--truth", str(own)]) == 0
        from mcap.reader import make_reader
        from mcap.writer import Writer

        with good.open("rb") as stream:
            [(_, _, message)] = make_reader(stream).iter_messages()
        for data in (message.data[:-20], message.data + bytes(16), message.data[:30], b"\x07\x07\x00\x00", b""):
            with (tmp_path / "bad.mcap").open("wb") as out:
                writer = Writer(out)
                writer.start(profile="ros2")
                channel = writer.register_channel("/estimate", "cdr", writer.register_schema(kind, "ros2msg", b""))
                writer.add_message(channel, 0, data, 0)
                writer.finish()
            said = refused(capsys, tmp_path / "bad.mcap", "--estimate", "/estimate", "--truth", own)
            assert "topic /estimate: message 0" in said


def test_a_negative_limit_and_a_second_one_are_told_as_such(capsys):
    assert "'-1deg' is not an angle" in refused(capsys, "run.mcap", "--estimate", "/pose", "--max-rms", "-1deg")
    twice = refused(capsys, "run.mcap", "--estimate", "/pose", "--max-rms", "1deg", "--max-rms", "2deg")
    assert "--max-rms is given 2 times, 1deg, 2deg: give one limit" in twice
    assert "'-1s' is not a time" in refused(capsys, "run.mcap", "--estimate", "/pose", "--max-after", "-1s:1deg")
