"""Where ``evaluate`` has the truth from, what it refuses, and what limits make of its exit status."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from estimate_messages import Make, beside, messages, told
from evaluating import HOW, IMU, ODOMETRY, POSE, TF, P, refused, scored

from foreign_bags import bag_of
from lie_rigid_body import Run, SampledTruth, evaluate
from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.lie import quaternion
from said import numbers

pytestmark = pytest.mark.usefixtures("undiagnosed")


def test_the_truth_in_another_bag_or_by_the_scenario_alone(own, bag, stamps, noisy, tmp_path, capsys):
    alone = tmp_path / "alone.mcap"
    alone.write_bytes(bag_of(told(POSE, HOW[POSE], "/pose", stamps, noisy)))
    rms = scored(capsys, bag, "--estimate", "/filter/PoseStamped")["total_deg"]["rms"]
    other = scored(capsys, alone, "--estimate", "/pose", "--truth", own)
    assert other["total_deg"]["rms"] == rms
    refused(capsys, alone, "--estimate", "/pose")
    only = beside(own, tmp_path / "only.mcap", (POSE, HOW[POSE], "/filter/pose", stamps, noisy), without="/pose /twist")
    by_scenario = scored(capsys, only, "--estimate", "/filter/pose")
    assert by_scenario["truth"] == "scenario"
    assert by_scenario["total_deg"]["rms"] == pytest.approx(rms, rel=1e-12)
    assert len(by_scenario["remarks"]) == 1
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
    assert "/a/pose, /b/pose" in refused(capsys, bag, "--estimate", "/estimate")
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


MOCAP = (("mocap/truth", 1), ("mocap/other", -1))


@pytest.mark.parametrize("kind", list(HOW))
def test_the_truth_is_of_every_type_that_an_estimate_has(kind, own, run, stamps, noisy, tmp_path, capsys):
    """As Gazebo gives it in Odometry, and a motion capture system in TransformStamped; a scenario names the frames."""
    truth = (kind, HOW[kind], "/mocap/body", run.t_ns, run.truth.attitude_xyzw)
    ours = (POSE, HOW[POSE], "/estimate", stamps, noisy)
    given = ["--estimate", "/estimate", "--truth", "/mocap/body"]
    with_frames = beside(own, tmp_path / "frames.mcap", truth, ours, without="/pose /twist")
    content = scored(capsys, with_frames, *given)
    assert (content["truth"], content["remarks"]) == ("poses and scenario", [])
    alone = beside(own, tmp_path / "alone.mcap", truth, ours, without="/pose /twist /lie_rigid_body/scenario")
    if kind == TF:
        assert "world to base_link" in refused(capsys, alone, *given)
        return
    content = scored(capsys, alone, *given)
    expected = evaluate(stamps, noisy, SampledTruth(run.t_ns, run.truth.attitude_xyzw), diagnosed=False)
    assert (content["truth"], content["remarks"], content["samples"]) == ("poses", [], expected.samples)
    assert content["total_deg"]["rms"] == pytest.approx(expected.total_deg.rms, rel=1e-12)
    assert (
        scored(capsys, alone, given[0], given[1], "--topic", "pose:=/mocap/body")["total_deg"] == content["total_deg"]
    )


def test_a_topic_or_a_file_tells_the_truth(own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "one.mcap", (POSE, HOW[POSE], "/estimate", stamps, noisy))
    given = [bag, "--estimate", "/estimate", "--truth"]
    by_file = scored(capsys, *given, own)["total_deg"]
    assert scored(capsys, *given, "/pose")["total_deg"] == by_file
    assert scored(capsys, *given, "/lie_rigid_body/scenario")["total_deg"]["rms"] == pytest.approx(by_file["rms"])
    for absent in ("absent.mcap", "/poses", "/twist", "/estimate"):
        assert absent in refused(capsys, *given, absent)


def test_texts_that_another_node_calls_scenario_tell_no_truth(own, stamps, noisy, tmp_path, capsys):
    said = SimpleNamespace(data="highway 7")
    text = ("std_msgs/msg/String", lambda stamp, q: said, "/x/scenario", stamps[:1], noisy[:1])
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


BAD: dict[str, Any] = {
    "not a number": lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, np.nan, q)),
    "zero": lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, 0.0, q)),
    "another clock": lambda t, q: (t + 10**18, q),
    "empty": lambda t, q: (t[:0], q[:0]),
}


@pytest.mark.parametrize("case", BAD)
def test_unusable_estimates_are_refused_in_one_line(case, own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "bad.mcap", (POSE, HOW[POSE], "/estimate", *BAD[case](stamps, noisy)))
    assert "estimate" in refused(capsys, bag, "--estimate", "/estimate")


LATER = [(0, [0, 0]), (86_400, [0, 2]), (1_700_000_000, [2, 2])]


@pytest.mark.parametrize(("later_s", "statuses"), LATER)
def test_another_clock_beside_a_scenario_alone_is_refused(later_s, statuses, own, stamps, noisy, tmp_path, capsys):
    """A scenario tells an attitude at any time: a run may last a day if no reading ends it, and no 50 years."""
    ours = (IMU, HOW[IMU], "/imu/data", stamps + later_s * 10**9, noisy)
    readings = "/imu/data_raw /imu/bias"
    for status, without in zip(statuses, (f"/pose /twist {readings}", "/pose /twist"), strict=True):
        bag = beside(own, tmp_path / f"{len(without)}.mcap", ours, without=without)
        if status:
            assert "clock" in refused(capsys, bag, "--estimate", "/imu/data")
        else:
            assert scored(capsys, bag, "--estimate", "/imu/data")["samples"] == len(stamps)


def alternating(one: Make, other: Make) -> Make:
    return lambda stamp, q: (one if stamp % 80_000_000 else other)(stamp, q)


def test_two_bodies_are_refused(own, stamps, noisy, tmp_path, capsys):
    other = messages(P, world="b/world", body="b/base_link")
    for kind in (POSE, ODOMETRY):
        topic = (kind, alternating(messages(P, world="a/world")[kind], other[kind]), "/estimate", stamps, noisy)
        bag = beside(own, tmp_path / f"{kind.rpartition('/')[2]}.mcap", topic)
        assert "b/world" in refused(capsys, bag, "--estimate", "/estimate")
    transforms = (TF, other[TF], "/tf", stamps, noisy)
    assert "b/base_link" in refused(capsys, beside(own, tmp_path / "tf.mcap", transforms), "--estimate", "/tf")
    truths = [(POSE, HOW[POSE], f"/{name}/pose", stamps, noisy) for name in "ab"]
    two = beside(own, tmp_path / "two.mcap", *truths, without="/lie_rigid_body/scenario /pose")
    assert "/a/pose, /b/pose" in refused(capsys, own, "--estimate", "/pose", "--truth", two)


def test_damaged_messages_are_refused(own, stamps, noisy, tmp_path, capsys):
    for kind in (TF, ODOMETRY):
        [good] = told(kind, HOW[kind], "/estimate", stamps[:1], noisy[:1])
        bag, given = tmp_path / "one.mcap", ["--estimate", "/estimate", "--truth", str(own)]
        bag.write_bytes(bag_of([good]))
        assert main([str(bag), *given]) == 0
        for data in (good.data[:-20], good.data + bytes(16), good.data[:30], b"\x07\x07\x00\x00", b""):
            bag.write_bytes(bag_of([good._replace(data=data)]))
            assert "/estimate" in refused(capsys, bag, *given)


def test_limits_are_the_exit_status(bag, capsys):
    given = [bag, "--estimate", "/filter/Imu"]
    assert scored(capsys, *given, "--max-rms", "1deg", "--max-after", "2s:3deg")["passed"] is True
    broken = scored(capsys, *given, "--max-rms", "0.1deg", "--max-after", "2s:1e-3rad", status=1)
    assert broken["passed"] is False
    assert len(broken["broken"]) == 2
    assert main([str(a) for a in given]) == 0
    assert re.search(r"^total +0\.\d+ ", capsys.readouterr().out, re.MULTILINE)


LITTLE: dict[str, Any] = {
    "reversed": (lambda t, q: (t[::-1], q[::-1], t), [1, 250]),
    "in microseconds": (lambda t, q: (1000 * t, q), [1, 250]),
    "ends early": (lambda t, q: (t[:6], q[:6]), [0.2, 10]),
}


@pytest.mark.parametrize("case", LITTLE)
def test_a_limit_is_not_kept_by_the_little_that_could_be_compared(case, own, run, stamps, tmp_path, capsys):
    change, little = LITTLE[case]
    q = run.attitude().at(stamps)
    bag = beside(own, tmp_path / "little.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, q)))
    given = bag, "--estimate", "/estimate"
    assert scored(capsys, *given)["broken"] == []
    content = scored(capsys, *given, "--max-rms", "180deg", status=1)
    assert numbers(content["broken"][0]) == little
    late = beside(own, tmp_path / "late.mcap", (POSE, HOW[POSE], "/estimate", stamps[200:], q[200:]))
    assert scored(capsys, late, "--estimate", "/estimate", "--max-rms", "1deg")["passed"]
