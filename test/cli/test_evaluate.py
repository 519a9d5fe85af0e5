"""``evaluate``: the score of each type of message, and what it is shown as: texts, a picture, a page, JSON."""

from __future__ import annotations

import html
import os
import re
from dataclasses import replace

import numpy as np
import pytest
from estimate_messages import beside
from evaluating import HOW, IMU, ODOMETRY, POSE, refused, scored

from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.evaluation import Limits
from lie_rigid_body.report.drawing import svg
from lie_rigid_body.report.scores import draw
from lie_rigid_body.system.console import progress_of_bags


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


def test_json_is_json_whatever_the_name_of_a_file(bag, tmp_path, capsys):
    name = tmp_path / "a\x85\u200b°.mcap"  # a control character and one without width, which a terminal gets escaped
    name.symlink_to(bag)
    assert scored(capsys, name, "--estimate", "filter/Imu")["bag"] == str(name)


def test_ten_times_as_fast_as_the_truth(own, run, tmp_path, capsys):
    t = np.arange(0, 10 * 10**9, 10_000_000)
    bag = beside(own, tmp_path / "fast.mcap", (POSE, HOW[POSE], "/estimate", t, run.attitude().at(t)))
    content = scored(capsys, bag, "--estimate", "/estimate")
    assert content["samples"] == 1000
    assert content["total_deg"]["max"] < 1e-12


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


def test_picture_and_page(bag, tmp_path, capsys):
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    given = [str(bag), "--estimate", "/filter/Imu", "--max-after", "1s:5deg", "--plot", str(picture)]
    assert main([*given, "--report", str(page)]) == 0
    assert capsys.readouterr().out.split()[-3::2] == [str(picture), str(page)]
    assert picture.read_bytes().startswith(b"\x89PNG")
    content = page.read_text(encoding="utf-8")
    assert content.count("<svg") == 2  # for a desk and a phone
    assert "tumbling" not in content
    for wanted in ("PASSED", "inclination", "NEES", "&quot;inertia&quot;", "</html>"):
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


def test_the_series_are_in_the_json_on_request(bag, stamps, capsys):
    series = scored(capsys, bag, "--estimate", "/filter/Imu", "--series")["series"]
    assert series["stamps_ns"] == stamps.tolist()
    assert len(series["total_deg"]) == len(series["nees"]) == 250


def test_without_a_bag_it_is_the_other_verb(capsys):
    for arguments in ((), ("--wait", "1")):
        assert "bug" not in refused(capsys, *arguments)
