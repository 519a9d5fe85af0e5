"""Clock, mounting and factor of a gyro beside a truth, against what was put in."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lie_rigid_body import simulate
from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.gyro import compare_with_truth

MOUNTING = Rotation.from_rotvec([0.4, -0.3, 1.2])


def test_clock_mounting_and_factor_are_those_put_in() -> None:
    factor = -57.3
    run = simulate("hand", duration=30.0, imu_rate=100.0, gyro_rate="integrated", sensor_grade="perfect")
    truth = SampledTruth(
        run.t_ns + 300_000_000, (Rotation.from_quat(run.truth.attitude_xyzw) * MOUNTING.inv()).as_quat()
    )
    fit, errors = compare_with_truth(run.imu.t_ns, factor * run.imu.gyro, truth)
    assert fit.late_s == pytest.approx(0.295, abs=2e-4)  # an integrated rate is that of the middle of its interval
    assert fit.factor == pytest.approx(1.0 / factor, rel=1e-3)
    assert np.degrees((Rotation.from_quat(fit.mounting_xyzw) * MOUNTING.inv()).magnitude()) < 0.1
    assert errors.shape == (5,)
    assert errors[0] < 1e-3


def test_of_delays_by_which_a_motion_recurs_the_shortest_is_taken() -> None:
    run = simulate("asymmetric_top", duration=20.0, imu_rate=100.0, gyro_rate="integrated", sensor_grade="perfect")
    fit, _ = compare_with_truth(run.imu.t_ns, run.imu.gyro, SampledTruth(run.t_ns, run.truth.attitude_xyzw))
    assert fit.late_s == pytest.approx(-0.005, abs=2e-4)


def test_a_slow_tumble_that_hides_a_delay_has_an_error_that_says_so() -> None:
    run = simulate("tumbling_cubesat", duration=60.0, imu_rate=100.0, sensor_grade="mems")
    fit, errors = compare_with_truth(run.imu.t_ns, run.imu.gyro, SampledTruth(run.t_ns, run.truth.attitude_xyzw))
    assert abs(fit.late_s) < 2.0 * errors[0]
