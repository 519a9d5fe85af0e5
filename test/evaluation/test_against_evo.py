"""The RMS of the total error against evo's absolute pose error, `evo_ape … -r angle_deg`."""

from __future__ import annotations

import numpy as np
import pytest
from evo.core import metrics, trajectory
from motions import STAMPS, attitude, truth_of, turns

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
