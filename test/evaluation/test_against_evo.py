"""The RMS of the total error against evo's absolute pose error, `evo_ape … -r angle_deg`."""

from __future__ import annotations

import json
from typing import Any

import estimate_messages
import numpy as np
import pytest
from evo.core import metrics, sync, trajectory
from mcap.reader import make_reader
from motions import STAMPS, attitude, truth_of, turns

from lie_rigid_body import simulate
from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.evaluation import evaluate
from lie_rigid_body.lie import quaternion


def evo_trajectory(attitude_xyzw):
    wxyz = np.roll(attitude_xyzw, 1, axis=-1)
    return trajectory.PoseTrajectory3D(np.zeros((len(wxyz), 3)), wxyz, STAMPS / 1e9)


@pytest.mark.parametrize("size_deg", [0.01, 1.0, 30.0])
def test_rms_is_evos_to_round_off(size_deg):
    truth = attitude("dzhanibekov")
    estimate = quaternion.multiply(truth, turns(size_deg, seed=7))
    ape = metrics.APE(metrics.PoseRelation.rotation_angle_deg)
    ape.process_data((evo_trajectory(truth), evo_trajectory(estimate)))
    score = evaluate(STAMPS, estimate, truth_of("dzhanibekov"), diagnosed=False)
    assert score.total_deg.rms == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), rel=1e-12, abs=1e-13)
    assert score.total_deg.median == pytest.approx(ape.get_statistic(metrics.StatisticsType.median), rel=1e-11)
    assert score.total_deg.max == pytest.approx(ape.get_statistic(metrics.StatisticsType.max), rel=1e-11)


def test_the_verb_has_evos_rms_of_two_topics_of_a_bag(tmp_path, capsys):
    """As `evo_ape mcap run.mcap /pose /estimate -r angle_deg`, both topics read by `rosbags`."""
    run = simulate(
        "tumbling_cubesat", duration=10.0, rate=50.0, initial_body_rate=[0.3, 0.5, -0.2], motion="closed_form"
    )
    run.to_bag(tmp_path / "run.mcap")
    estimate = quaternion.multiply(run.truth.attitude_xyzw, turns(2.0, 5, len(run.t_ns)))[::3]
    kind = "geometry_msgs/msg/PoseStamped"
    topic = (kind, estimate_messages.messages(np.eye(3))[kind], "/estimate", run.t_ns[::3], estimate)
    bag = estimate_messages.beside(tmp_path / "run.mcap", tmp_path / "both.mcap", topic)
    pair = sync.associate_trajectories(read_by_rosbags(bag, "/pose"), read_by_rosbags(bag, "/estimate"))
    ape = metrics.APE(metrics.PoseRelation.rotation_angle_deg)
    ape.process_data(pair)
    assert main([str(bag), "--estimate", "/estimate", "--json"]) == 0
    score = json.loads(capsys.readouterr().out)
    assert score["samples"] == len(estimate) == len(pair[0].timestamps)
    assert score["total_deg"]["rms"] == pytest.approx(ape.get_statistic(metrics.StatisticsType.rmse), rel=1e-12)


def read_by_rosbags(bag, topic):
    read: list[Any] = []
    with bag.open("rb") as stream:
        for schema, _, message in make_reader(stream).iter_messages([topic]):
            assert schema is not None
            read.append(estimate_messages.STORE.deserialize_cdr(message.data, schema.name))
    q = [[getattr(m.pose.orientation, axis) for axis in "wxyz"] for m in read]
    stamps = [m.header.stamp.sec + m.header.stamp.nanosec / 1e9 for m in read]
    return trajectory.PoseTrajectory3D(np.zeros((len(q), 3)), np.array(q), np.array(stamps))
