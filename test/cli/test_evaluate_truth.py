"""Where ``evaluate`` has the truth from: poses, scenarios, other bags and topics, and what is none."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from estimate_messages import beside, write
from evaluating import HOW, POSE, refused, scored

from lie_rigid_body import Run
from lie_rigid_body.lie import quaternion


def test_the_truth_in_another_bag_or_by_the_scenario_alone(own, bag, stamps, noisy, tmp_path, capsys):
    alone = write(tmp_path / "alone.mcap", POSE, HOW[POSE], "/pose", stamps, noisy)
    rms = scored(capsys, bag, "--estimate", "/filter/PoseStamped")["total_deg"]["rms"]
    other = scored(capsys, alone, "--estimate", "/pose", "--truth", own)
    assert other["total_deg"]["rms"] == rms
    refused(capsys, alone, "--estimate", "/pose")
    only = beside(own, tmp_path / "only.mcap", (POSE, HOW[POSE], "/filter/pose", stamps, noisy), without="/pose /twist")
    by_scenario = scored(capsys, only, "--estimate", "/filter/pose")
    assert by_scenario["truth"] == "scenario"
    assert by_scenario["total_deg"]["rms"] == pytest.approx(rms, rel=1e-12)
    assert len(by_scenario["notes"]) == 1
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
