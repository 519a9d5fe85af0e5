"""``evaluate``: the score of each type of message, what it is shown as, findings, and notes of stamps and frames."""

from __future__ import annotations

import html
import json
import os
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from estimate_messages import beside, messages
from evaluating import HOW, IMU, ODOMETRY, POSE, TF, P, refused, scored

from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.evaluation import Limits
from lie_rigid_body.lie import quaternion
from lie_rigid_body.report.drawing import svg
from lie_rigid_body.report.scores import draw
from lie_rigid_body.system.console import progress_of_bags
from said import numbers


@pytest.mark.parametrize("kind", list(HOW))
def test_every_type_of_message_has_the_same_score(kind, bag, score, capsys):
    content = scored(capsys, bag, "--estimate", f"filter/{kind.rpartition('/')[2]}")
    assert content["type"] == kind
    assert content["samples"] == 250
    assert content["truth"] == "poses and scenario"
    assert content["total_deg"]["rms"] == pytest.approx(score.total_deg.rms, rel=1e-12)
    assert content["findings"] == []
    assert content["remarks"] == []
    assert content["passed"] is True
    told = kind in (IMU, ODOMETRY, "geometry_msgs/msg/PoseWithCovarianceStamped")
    assert (content["nees"] is not None) == told
    if told:
        assert {*content["nees"]} == {"mean", "expected", "inside", "remark"}
        assert content["nees"]["mean"] == pytest.approx(3.0, rel=0.5)


def test_json_is_json_whatever_the_name_of_a_file(bag, stamps, tmp_path, capsys):
    name = tmp_path / "a\x85\u200b°.mcap"  # a control character and one without width, which a terminal gets escaped
    name.symlink_to(bag)
    content = scored(capsys, name, "--estimate", "filter/Imu", "--series")
    assert content["bag"] == str(name)
    assert content["series"]["stamps_ns"] == stamps.tolist()


@pytest.mark.parametrize("topic", ["estimate", "/estimate"])
def test_a_topic_is_found_as_it_stands_in_the_file_with_a_slash_or_without(topic, own, run, tmp_path, capsys):
    t = np.arange(0, 10**9, 10_000_000)
    bag = beside(own, tmp_path / "other.mcap", (POSE, HOW[POSE], topic, t, run.attitude().at(t)))
    assert scored(capsys, bag, "--estimate", "estimate")["samples"] == 100


def test_progress_tells_every_byte_read(own, bag):
    steps: list[int] = []
    recorded_estimate(bag, "/filter/Imu", own, progress=steps.append)
    size = bag.stat().st_size + own.stat().st_size
    assert 0.3 * size < sum(steps) <= size  # all but the index at the end, which is much of a small file
    with progress_of_bags([bag, own], passes=1) as bar:
        assert bar.total == size
        assert bar.disable  # as stderr is no terminal


@pytest.mark.slow
def test_picture_and_page(bag, tmp_path, capsys):
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    given = [str(bag), "--estimate", "/filter/Imu", "--max-after", "1s:5deg", "--plot", str(picture)]
    assert main([*given, "--report", str(page)]) == 0
    assert capsys.readouterr().out.split()[-3::2] == [str(picture), str(page)]
    assert picture.read_bytes().startswith(b"\x89PNG")
    content = page.read_text(encoding="utf-8")
    assert content.count("<svg") == 1
    assert "tumbling" not in content
    for wanted in ("PASSED", "inclination", "NEES", "</html>"):
        assert wanted in content
    # it needs no other file: nothing is loaded from anywhere
    assert not re.search(r"<(script|link|img|iframe)|url\(h|@import|src=", content)
    for option, file in (("--plot", picture), ("--report", page)):  # before the work
        refused(capsys, "absent.mcap", "--estimate", "/filter/Imu", option, file)
    assert main([*given, "--force"]) == 0


@pytest.mark.filterwarnings("error")
def test_a_picture_has_any_name(score):
    name = os.fsdecode(b"'$\\frac{$ <b>&r\xff\n\x1b") + "日本.mcap"
    title = re.search(r"<text[^>]*>('[^<]*)</text>", svg(lambda: draw(f"{name}: {40 * 'm'}", score)))
    assert title is not None
    said = html.unescape(title[1])
    assert said.startswith(r"'$\frac{$ <b>&r\udcff\n\x1b日本.mcap: mmm")
    long = re.search(r"<text[^>]*>('[^<]*)</text>", svg(lambda: draw(f"{name}: {300 * 'm'}", score)))
    assert long is not None
    assert len(html.unescape(long[1])) <= 110


def test_a_limit_is_on_its_picture_also_far_above_the_errors(score):
    limit = 10.0 * score.total_deg.max
    total, parts, *_ = draw("far", replace(score, limits=Limits(max_rms_deg=limit))).axes
    assert total.get_ylim()[1] > limit
    assert (total.get_yscale(), parts.get_ylim()[0]) == ("log", 0.0)


def test_without_a_bag_it_is_the_other_verb(capsys):
    for arguments in ((), ("--wait", "1")):
        assert "bug" not in refused(capsys, *arguments)


FAR = 2**31 * 10**9 - 10**9
"""A stamp of the year 2038, ns."""


@pytest.mark.usefixtures("undiagnosed")
def test_one_stamp_far_ahead_does_not_hide_what_follows(own, run, stamps, tmp_path, capsys):
    t, q = stamps.copy(), run.attitude().at(stamps)
    t[3] = FAR
    bag = beside(own, tmp_path / "far.mcap", (POSE, HOW[POSE], "/estimate", t, q))
    content = scored(capsys, bag, "--estimate", "/estimate", "--max-rms", "1deg")
    assert content["samples"] == 249
    [note] = content["remarks"]
    assert numbers(note) == [1, 250, FAR / 1e9]


@pytest.mark.usefixtures("undiagnosed")
def test_what_is_out_of_order_is_left_out_and_counted(own, run, stamps, noisy, tmp_path, capsys):
    order = np.r_[100:125, :125, 125:250]
    heard = np.arange(len(order)) * 40_000_000
    bag = beside(own, tmp_path / "back.mcap", (IMU, HOW[IMU], "/estimate", stamps[order], noisy[order], heard))
    content = scored(capsys, bag, "--estimate", "/estimate")
    [note] = content["remarks"]
    assert numbers(note) == [25, 275, 4]
    expected = run.score(noisy[:250], stamps[:250], covariance=P).to_dict()
    assert content["total_deg"] == pytest.approx(expected["total_deg"])
    assert content["nees"]["mean"] == pytest.approx(expected["nees"]["mean"])


IN_FILE: dict[str, Any] = {
    "reversed": (np.arange(250)[::-1], lambda stamps: stamps),
    "swapped neighbours": (np.arange(250).reshape(-1, 2)[:, ::-1].ravel(), lambda stamps: stamps + 10**9),
    "one log time": (np.random.default_rng(3).permutation(250), np.zeros_like),
    "few log times": (np.random.default_rng(3).permutation(250), lambda stamps: stamps // 10**9 * 10**9),
}


@pytest.mark.parametrize("kind", [IMU, TF])
@pytest.mark.parametrize("case", IN_FILE)
def test_messages_count_in_the_order_of_their_log_times(case, kind, own, stamps, noisy, score, tmp_path, capsys):
    """As they are played: by log time, of one log time by stamp, whatever their order in the file."""
    order, logged = IN_FILE[case]
    t = stamps[order]
    bag = beside(own, tmp_path / "file.mcap", (kind, HOW[kind], "/estimate", t, noisy[order], logged(t)))
    content = scored(capsys, bag, "--estimate", "/estimate")
    assert (content["samples"], content["remarks"], content["findings"]) == (250, [], [])
    assert content["total_deg"]["rms"] == pytest.approx(score.total_deg.rms, rel=1e-12)


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("kind", "names", "told"),
    [
        (POSE, {"world": "odom"}, ["odom", "world"]),
        (POSE, {"world": "o" * 300}, [f"{23 * 'o'}...{24 * 'o'}", "world"]),
        (IMU, {"sensor": "odom"}, ["odom", "world"]),
        (ODOMETRY, {"body": "lidar"}, ["lidar", "base_link"]),
    ],
)
def test_other_frames_are_named(kind, names, told, own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "named.mcap", (kind, messages(P, **names)[kind], "/estimate", stamps, noisy))
    [note] = scored(capsys, bag, "--estimate", "/estimate")["remarks"]
    assert re.findall("'([^']+)'", note) == told


ASYMMETRIC = np.array([[2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("covariance", "faults"),
    [
        (np.diag([0.0, 0.0, 0.0]), 0),
        (np.diag([-1.0, 0.0, 0.0]), 0),
        (np.diag([0.0, 0.0, 1e-4]), 1),
        (np.diag([1e-4, 1e-4, -1e-4]), 1),
        (np.diag([1e-4, 1e-4, np.nan]), 1),
        (ASYMMETRIC, 1),
    ],
)
def test_covariances_that_cannot_be_used(covariance, faults, own, stamps, noisy, tmp_path, capsys):
    """Unknown ones are none; of others the attitudes have their score, beside one line and status 2."""
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    bag = beside(own, tmp_path / "c.mcap", (kind, messages(covariance)[kind], "/estimate", stamps, noisy))
    assert main([str(bag), "--estimate", "/estimate", "--max-rms", "1deg", "--json"]) == 2 * faults
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert (content["nees"], content["samples"], len(content["remarks"])) == (None, len(stamps), faults)
    assert err.count("\n") == faults == err.count("/estimate: covariance: ")


def test_a_covariance_about_the_bodys_axes_is_recognised_and_can_be_said(own, run, stamps, tmp_path, capsys):
    deviations = np.radians([0.05, 0.5, 2.0])
    noise = np.random.default_rng(4).normal(size=(len(stamps), 3)) * deviations
    estimate = quaternion.multiply(run.attitude().at(stamps), quaternion.exp(noise))
    how = messages(np.diag(deviations**2))[IMU]
    bag = beside(own, tmp_path / "body.mcap", (IMU, how, "/estimate", stamps, estimate))
    found = scored(capsys, bag, "--estimate", "/estimate")["nees"]
    assert found["mean"] > 30.0
    assert 2.0 <= numbers(found["remark"])[1] < 4.0
    assert found["remark"].endswith(" covariance_axes body")
    said = scored(capsys, bag, "--estimate", "/estimate", "--covariance-axes", "body")["nees"]
    assert said["remark"] == ""
    assert said["mean"] == pytest.approx(3.0, rel=0.3)
