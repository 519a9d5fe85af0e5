"""Sensors that a bag's scenario declares otherwise than they were are caught by what they read."""

from __future__ import annotations

import numpy as np
import pytest
from phrases import telling
from sensor_bags import AT, BIAS, IMU, MAG, broken, certificate
from tampering import at, declared, on, with_numbers


@pytest.mark.parametrize(
    ("name", "value", "law"),
    [
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
        ("imu_rate", 0.0, None),
    ],
)
def test_parameters_of_the_sensors_that_are_declared_otherwise_are_caught(bag, tmp_path, name, value, law):
    found = certificate(bag, tmp_path, declared(**{name: value}))
    if law is None:  # as if another program had recorded an IMU beside the body
        assert found.sensors == (MAG,)
    else:
        assert law in broken(found)


def test_a_scenario_of_another_version(bag, tmp_path):
    older = declared(software="lie_rigid_body 0.0.9")
    assert certificate(bag, tmp_path, older).sensors == (IMU, BIAS, MAG)  # it computes the same
    forged = on(MAG, at(AT, lambda m: with_numbers(m, 12, lambda x: np.concatenate([1.01 * x[:3], x[3:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(older(ms)))
    assert found.passed
    assert found.sensors == ()
    assert telling(found, "another version", software="lie_rigid_body 0.0.9")
