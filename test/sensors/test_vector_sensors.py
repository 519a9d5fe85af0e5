"""What a magnetometer, an attitude sensor and a sun sensor read."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation
from sensor_models import MOTION, at_rest, imu, magnetometer, magnetometer_model, sensors_of, times

from lie_rigid_body.sensors import AttitudeSensor, SunSensor
from untyped import simulate

FIELD = [2e-5, -1e-5, 4e-5]
SOFT_IRON = [1.1, 0.02, 0.01, -0.03, 0.95, 0.04, 0.05, 0.02, 1.05]
HARD_IRON = [1e-6, 2e-6, -3e-6]
FEW_STATES = MOTION.at(times(100))
MANY = 50_000


def on_body_axes(field: list[float]) -> np.ndarray:
    return Rotation.from_quat(FEW_STATES.attitude_xyzw).inv().apply(field)


def test_it_reads_the_world_field_on_body_axes() -> None:
    read = magnetometer(magnetic_field=FIELD).measure(times(100), FEW_STATES)["field"]
    assert np.abs(read - on_body_axes(FIELD)).max() < 1e-15 * np.linalg.norm(FIELD) * 10


def test_iron_distorts_first_and_adds_then() -> None:
    sensor = magnetometer(magnetic_field=FIELD, magnetometer_soft_iron=SOFT_IRON, magnetometer_hard_iron=HARD_IRON)
    expected = on_body_axes(FIELD) @ np.reshape(SOFT_IRON, (3, 3)).T + HARD_IRON
    assert np.abs(sensor.measure(times(100), FEW_STATES)["field"] - expected).max() < 1e-18


def test_the_default_field_is_that_of_the_north() -> None:
    """East, north, up: to the north, and steeply down, of some 50 µT."""
    east, north, up = magnetometer().measure(times(1), at_rest(1))["field"][0]
    assert abs(east) < north < -up
    assert 4e-5 < np.linalg.norm([east, north, up]) < 6e-5


def test_range_and_resolution_come_last() -> None:
    sensor = magnetometer(magnetic_field=FIELD, magnetometer_range=2.5e-5, magnetometer_resolution=1e-5)
    assert sensor.measure(times(1), at_rest(1))["field"][0] == pytest.approx([2e-5, -1e-5, 2e-5])


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_noise_is_the_density_times_the_root_of_the_rate(rate: float) -> None:
    settings = {"magnetometer_rate": rate, "magnetometer_noise_density": 2e-8, "magnetometer_resolution": 5e-8}
    errors = (
        magnetometer(**settings).measure(times(MANY), at_rest(MANY))["field"]
        - magnetometer().measure(times(1), at_rest(1))["field"]
    )
    assert np.abs(errors.var(axis=0) / (4e-16 * rate + 25e-16 / 12.0) - 1.0).max() < 10.0 / np.sqrt(MANY)
    assert magnetometer_model(**settings).variance == pytest.approx(4e-16 * rate + 25e-16 / 12.0)
    assert magnetometer_model().variance == 0.0


COUNT = 20_000
T = times(COUNT)
STATES = MOTION.at(T)
TRUTH = Rotation.from_quat(STATES.attitude_xyzw)
BORESIGHT = np.array([1.0, -2.0, 2.0]) / 3.0
CROSS, ROLL = 1e-4, 2e-3
ODD = 0.999
"""Share of good seeds that a test would accept."""


def attitude_model(**given: Any) -> Any:
    return sensors_of({"attitude_sensor_rate": 4.0, **given}).attitude_sensor


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
    ahrs = np.diag([0.01**2, 0.01**2, 0.05**2])
    for attitude, t_ns, covariance in (
        (tracker.attitude_xyzw, tracker.t_ns, tracker.covariance),
        (imu_arrays.orientation_xyzw, imu_arrays.t_ns, ahrs),
    ):
        consistency = run.score(attitude, t_ns, covariance=covariance, diagnosed=False).consistency
        assert consistency.mean == pytest.approx(3.0, rel=0.3)


def test_the_sun_is_a_unit_vector_in_the_body() -> None:
    given = {"sun_sensor_rate": 1.0, "sun_direction": [0.0, 3.0, 4.0]}
    perfect, noisy = (sensors_of({**given, "sun_sensor_noise": noise}).sun_sensor for noise in (0.0, 0.01))
    true = TRUTH.inv().apply([0.0, 0.6, 0.8])
    np.testing.assert_allclose(SunSensor(perfect).measure(T, STATES)["direction"], true, rtol=0, atol=4e-15)
    read = SunSensor(noisy).measure(T, STATES)["direction"]
    assert np.abs(np.linalg.norm(read, axis=1) - 1.0).max() < 4e-15
    angle = np.linalg.norm(np.cross(read, true), axis=1)
    assert np.sqrt((angle**2).mean() / 2) == pytest.approx(0.01, rel=5 / np.sqrt(4 * COUNT))
