"""Sensors that a bag's scenario declares otherwise than they were are caught by what they read."""

from __future__ import annotations

import numpy as np
import pytest
from phrases import telling
from sensor_bags import AT, BIAS, IMU, MAG, broken, certificate
from tampering import at, declared, on, with_numbers

DECLARED: dict[str, list[tuple[str, object, str]]] = {
    "bag": [
        ("sensor_seed", 12, "gyro bias"),
        ("gyro_noise_density", 1.0001e-3, "gyro"),
        ("gyro_bias_random_walk", 1.0001e-3, "gyro bias"),
        ("gyro_turn_on_bias", 0.0100001, "gyro bias"),
        ("gyro_misalignment", [0.0, 1e-9, 0.0], "gyro"),
        ("gyro_range", 1.0, "gyro"),
        ("gyro_rate", "integrated", "gyro"),
        ("accelerometer_lever_arm", [0.1, -0.2, 0.0500001], "accelerometer"),
        ("accelerometer_mode", "free_fall", "accelerometer"),
        ("gravity", 9.80666, "accelerometer"),
        ("accelerometer_scale_factor", [1.0, 1.0, 1.0 + 1e-8], "accelerometer"),
        ("magnetic_field", [1.5e-6, 21.0e-6, -43.50001e-6], "magnetometer"),
        ("magnetometer_soft_iron", [1.0, 1e-8, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "magnetometer"),
        ("magnetometer_resolution", 1e-12, "magnetometer"),
        ("imu_rate", 333.0, "IMU stamps"),
        ("magnetometer_rate", 70.1, "magnetometer stamps"),
        ("imu_frame", "imu_lunk", "IMU frame and covariances"),
    ],
    "pointing": [
        ("attitude_sensor_roll_noise", 1.0001e-3, "attitude sensor covariance"),
        ("attitude_sensor_boresight", [0.0, 0.1, 1.0], "attitude sensor"),
        ("sun_direction", [0.0, 1e-9, 1.0], "sun sensor"),
        ("sun_sensor_noise", 0.0, "sun sensor"),
        ("imu_heading_noise", 0.0100001, "IMU frame and covariances"),
        ("imu_orientation", False, "IMU frame and covariances"),
        ("sensor_seed", 1, "IMU orientation"),
    ],
}


@pytest.mark.parametrize(
    ("which", "name", "value", "law"), [(which, *row) for which, rows in DECLARED.items() for row in rows]
)
def test_a_parameter_that_is_declared_otherwise_breaks_a_law(request, tmp_path, which, name, value, law):
    assert law in broken(certificate(request.getfixturevalue(which), tmp_path, declared(**{name: value})))


def test_a_sensor_that_is_declared_away_is_one_of_another_program(bag, tmp_path):
    assert certificate(bag, tmp_path, declared(imu_rate=0.0)).sensors == (MAG,)


def test_a_scenario_of_another_version(bag, tmp_path):
    older = declared(software="lie_rigid_body 0.0.9")
    assert certificate(bag, tmp_path, older).sensors == (IMU, BIAS, MAG)  # it computes the same
    forged = on(MAG, at(AT, lambda m: with_numbers(m, 12, lambda x: np.concatenate([1.01 * x[:3], x[3:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(older(ms)))
    assert found.passed
    assert found.sensors == ()
    assert telling(found, "another version", software="lie_rigid_body 0.0.9")
