"""Sensors and motions that the tests share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.foundation.parameters import read_table
from lie_rigid_body.sensors import SENSORS, Imu, Magnetometer, Sensors, graded
from lie_rigid_body.sensors.sensor import Carrier

BODY = RigidBody([1.1, 0.1, -0.05, 1.9, 0.2, 2.6])
START = State(np.array([0.1, -0.7, 0.4, 0.3]) / np.linalg.norm([0.1, -0.7, 0.4, 0.3]), [0.7, -1.3, 0.4])
STEP_NS = 10_000_000
MOTION = ClosedForm(BODY, START)

EVERYTHING: dict[str, object] = {
    "imu_rate": 100.0,
    "magnetometer_rate": 100.0,
    "sensor_seed": 7,
    "gyro_rate": "integrated",
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-4,
    "gyro_turn_on_bias": 1e-2,
    "gyro_scale_factor": [1.01, 0.98, 1.02],
    "gyro_misalignment": [0.01, -0.02, 0.03],
    "accelerometer_mode": "pivot_gravity",
    "accelerometer_lever_arm": [0.1, -0.2, 0.05],
    "accelerometer_noise_density": 2e-3,
    "accelerometer_bias_random_walk": 3e-4,
    "accelerometer_turn_on_bias": 5e-2,
    "accelerometer_resolution": 1e-3,
    "accelerometer_range": 20.0,
    "magnetometer_noise_density": 1e-8,
    "magnetometer_hard_iron": [1e-6, 2e-6, -3e-6],
    "magnetometer_soft_iron": [1.1, 0.02, 0.01, -0.03, 0.95, 0.04, 0.05, 0.02, 1.05],
}


def sensors_of(given: Mapping[str, object]) -> Any:
    """The sensors of some parameters, the rest at their defaults."""
    return Sensors.from_values(read_table(SENSORS.parameters.values(), graded(given)))


def times(count: int) -> np.ndarray:
    return np.arange(count, dtype=np.int64) * STEP_NS


def imu_model(**given: object) -> Any:
    return sensors_of({"imu_rate": 100.0, "accelerometer_mode": "free_fall", **given}).imu


def magnetometer_model(**given: object) -> Any:
    return sensors_of({"magnetometer_rate": 100.0, **given}).magnetometer


def imu(before_ns: int = -STEP_NS, /, **given: object) -> Imu:
    """An IMU on the body of this file, which is in motion; its first reading comes one step after a time."""
    made = Imu(imu_model(**given), Carrier(BODY))
    made.begin_after(before_ns, lambda: MOTION.at(before_ns))
    return made


def magnetometer(**given: object) -> Magnetometer:
    return Magnetometer(magnetometer_model(**given))


def at_rest(count: int) -> State:
    return State(np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), np.zeros((count, 3)))


def readings_at_rest(count: int, **given: object) -> dict[str, np.ndarray]:
    """What an IMU reads of a body at rest in free fall: its errors alone."""
    model = imu_model(**given)
    period = round(1e9 / model.rate)
    return Imu(model, Carrier(BODY)).measure(np.arange(count, dtype=np.int64) * period, at_rest(count))
