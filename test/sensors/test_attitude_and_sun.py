"""Attitude and sun sensors, the orientation of an IMU: their errors are those that they tell, in the frame they say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation
from sensor_models import MOTION, imu, sensors_of, times

from lie_rigid_body import simulate
from lie_rigid_body.sensors import (
    AttitudeSensor,
    AttitudeSensorModel,
    SunSensor,
)

COUNT = 20_000
T = times(COUNT)
STATES = MOTION.at(T)
TRUTH = Rotation.from_quat(STATES.attitude_xyzw)
BORESIGHT = np.array([1.0, -2.0, 2.0]) / 3.0
CROSS, ROLL = 1e-4, 2e-3
ODD = 0.999
"""Share of good seeds that a test would accept."""


def attitude_model(**given: Any) -> AttitudeSensorModel:
    model = sensors_of({"attitude_sensor_rate": 4.0, **given}).attitude_sensor
    assert model is not None
    return model


NOISY = attitude_model(
    attitude_sensor_boresight=[2.0, -4.0, 4.0],
    attitude_sensor_cross_boresight_noise=CROSS,
    attitude_sensor_roll_noise=ROLL,
    sensor_seed=5,
)


def nees(error: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    return np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariance), error)


def assert_chi_square(values: np.ndarray) -> None:
    """Of 3 degrees of freedom each: in their sum, and as a distribution."""
    low, high = stats.chi2(3 * len(values)).ppf([(1 - ODD) / 2, (1 + ODD) / 2])
    assert low < values.sum() < high
    assert stats.kstest(values, stats.chi2(3).cdf).pvalue > 1 - ODD


def test_perfect_sensors_read_the_truth() -> None:
    assert (
        AttitudeSensor(attitude_model()).measure(T, STATES)["attitude_xyzw"].tobytes() == STATES.attitude_xyzw.tobytes()
    )
    assert not attitude_model().covariance(STATES.attitude_xyzw).any()
    assert not sensors_of({}).on


def test_the_error_is_on_the_right_and_worst_about_the_boresight() -> None:
    read = AttitudeSensor(NOISY).measure(T, STATES)["attitude_xyzw"]
    error = (TRUTH.inv() * Rotation.from_quat(read)).as_rotvec()
    roll = error @ BORESIGHT
    across = np.linalg.norm(error - roll[:, np.newaxis] * BORESIGHT, axis=1)
    assert roll.std() == pytest.approx(ROLL, rel=5 / np.sqrt(2 * COUNT))
    assert np.sqrt((across**2).mean() / 2) == pytest.approx(CROSS, rel=5 / np.sqrt(4 * COUNT))
    assert np.abs(np.linalg.norm(read, axis=1) - 1.0).max() < 4e-15
    assert ((read * STATES.attitude_xyzw).sum(axis=1) > 0.99).all()  # the sign goes on as that of the truth


def test_its_covariance_is_of_rotations_about_the_axes_of_the_world() -> None:
    """Read is exp(δ) true with δ about fixed axes: its NEES is chi-square with the covariance that is told."""
    read = AttitudeSensor(NOISY).measure(T, STATES)["attitude_xyzw"]
    fixed = (Rotation.from_quat(read) * TRUTH.inv()).as_rotvec()
    body = (TRUTH.inv() * Rotation.from_quat(read)).as_rotvec()
    covariance = NOISY.covariance(read)
    assert_chi_square(nees(fixed, covariance))
    assert nees(body, covariance).mean() > 30.0
    assert np.array_equal(covariance, np.swapaxes(covariance, 1, 2))
    turned = np.einsum("nij,nik,nkl->njl", TRUTH.as_matrix(), covariance, TRUTH.as_matrix())
    wanted = CROSS**2 * np.eye(3) + (ROLL**2 - CROSS**2) * np.outer(BORESIGHT, BORESIGHT)
    np.testing.assert_allclose(turned, np.broadcast_to(wanted, turned.shape), rtol=0, atol=1e-8)


def test_the_orientation_of_an_imu_errs_about_the_axes_of_the_world() -> None:
    given = {"imu_orientation": True, "imu_inclination_noise": 3e-3, "imu_heading_noise": 3e-2}
    sensor = imu(**given)
    read = sensor.measure(T, STATES)["orientation_xyzw"]
    error = (Rotation.from_quat(read) * TRUTH.inv()).as_rotvec()
    np.testing.assert_allclose(error.std(axis=0), [3e-3, 3e-3, 3e-2], rtol=5 / np.sqrt(2 * COUNT))
    model = sensors_of({"imu_rate": 100.0, **given}).imu
    assert model is not None
    assert model.orientation is not None
    covariance = np.broadcast_to(np.reshape(model.orientation.covariance, (3, 3)), (COUNT, 3, 3))
    assert_chi_square(nees(error, covariance))
    assert "orientation_xyzw" not in imu().measure(T[:3], STATES[:3])


def test_an_evaluation_finds_them_as_large_as_they_say() -> None:
    """From a run to a verdict: conventions of quaternion, frame and covariance are those of the evaluation."""
    run = simulate(
        duration=400.0,
        motion="closed_form",
        rate=5.0,
        initial_body_rate=[0.3, 0.2, -0.4],
        attitude_sensor_boresight=BORESIGHT,
        attitude_sensor_roll_noise=5e-3,
        attitude_sensor_rate=5.0,
        attitude_sensor_cross_boresight_noise=2e-4,
        imu_rate=5.0,
        imu_orientation=True,
        imu_inclination_noise=0.01,
        imu_heading_noise=0.05,
    )
    tracker, imu_arrays = run.attitude_sensor, run.imu
    assert tracker is not None
    assert imu_arrays is not None
    assert imu_arrays.orientation_xyzw is not None
    ahrs = np.diag([0.01**2, 0.01**2, 0.05**2])
    for attitude, t_ns, covariance in (
        (tracker.attitude_xyzw, tracker.t_ns, tracker.covariance),
        (imu_arrays.orientation_xyzw, imu_arrays.t_ns, ahrs),
    ):
        consistency = run.score(attitude, t_ns, covariance=covariance, diagnosed=False).consistency
        assert consistency is not None
        assert consistency.verdict == "consistent"


def test_the_sun_is_a_unit_vector_in_the_body() -> None:
    given = {"sun_sensor_rate": 1.0, "sun_direction": [0.0, 3.0, 4.0]}
    perfect, noisy = (sensors_of({**given, "sun_sensor_noise": noise}).sun_sensor for noise in (0.0, 0.01))
    assert perfect is not None
    assert noisy is not None
    true = TRUTH.inv().apply([0.0, 0.6, 0.8])
    np.testing.assert_allclose(SunSensor(perfect).measure(T, STATES)["direction"], true, rtol=0, atol=4e-15)
    read = SunSensor(noisy).measure(T, STATES)["direction"]
    assert np.abs(np.linalg.norm(read, axis=1) - 1.0).max() < 4e-15
    angle = np.linalg.norm(np.cross(read, true), axis=1)
    assert np.sqrt((angle**2).mean() / 2) == pytest.approx(0.01, rel=5 / np.sqrt(4 * COUNT))


@pytest.mark.parametrize("cuts", [[1, 2, 3, 700], [256], [500, 501]])
def test_where_batches_begin_changes_nothing(cuts: list[int]) -> None:
    sun = sensors_of({"sun_sensor_rate": 1.0, "sun_sensor_noise": 0.01}).sun_sensor
    assert sun is not None
    for make in (lambda: AttitudeSensor(NOISY), lambda: SunSensor(sun)):
        sensor, bounds = make(), zip([0, *cuts], [*cuts, 1000], strict=True)
        parts = [sensor.measure(T[a:b], STATES[a:b], a) for a, b in bounds]
        for name, whole in make().measure(T[:1000], STATES[:1000]).items():
            assert np.concatenate([part[name] for part in parts]).tobytes() == whole.tobytes()
