"""Right filters are told no mistake where the scenario is known, and those of imu_tools their declination alone.

The filters are models of imu_tools' two: Madgwick's takes magnetic north for y of its world, the complementary filter
takes it for x and does not estimate a bias. Both compare readings with the attitude before or after the gyro's step.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.bound import left_by_errors_of
from untyped import simulate

UP = np.array([0.0, 0.0, 1.0])
DECLINATION_DEG = float(np.degrees(np.arctan2(1.5, 21.0)))
"""That of the simulator's field."""
TO_Y = ([0.0, 1.0, 0.0], DECLINATION_DEG, 0.3)
TO_X = ([1.0, 0.0, 0.0], -85.91, 0.5)
"""Norths that filters take, the heading that each is off by, and how exactly that is told, degrees."""
RATE = 50.0
CONSUMER = {
    "gyro_noise_density": 1e-4,
    "accelerometer_noise_density": 2e-3,
    "magnetometer_noise_density": 5e-8,
}


@cache
def recorded(grade: str, **given: Any) -> Any:
    return simulate(
        "tumbling_cubesat",
        duration=30.0,
        imu_rate=RATE,
        magnetometer_rate=RATE,
        accelerometer_mode="pivot_gravity",
        initial_body_rate=[0.2, 0.3, -0.15],
        sensor_grade=grade,
        motion="closed_form",
        **given,
    )


def true(run: Any) -> np.ndarray:
    """True attitudes at the readings of the IMU."""
    return run.attitude().at(run.imu.t_ns)


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def filtered(run: Any, north: np.ndarray | None, gain: float, *, ahead: bool) -> np.ndarray:
    """Gyro steps with corrections towards up and the field, in whose horizontal part north is; None: as it is known."""
    force, field, h = unit(run.imu.specific_force), unit(run.magnetometer.field), 1.0 / RATE
    known = unit(np.array([1.5, 21.0, -43.0]))
    q = run.attitude().at(run.imu.t_ns[:1])[0]
    if north is not None:  # they begin by what they read of gravity and of the field
        q = quaternion.multiply(quaternion.exp((np.arctan2(north[1], north[0]) - np.arctan2(21.0, 1.5)) * UP), q)
    found = [q]
    for k in range(1, len(force)):
        turn = quaternion.exp(run.imu.gyro[k] * h)
        turned = q if ahead else quaternion.multiply(q, turn)
        back = quaternion.conjugate(turned)
        if north is not None:
            x, y, z = quaternion.rotate(turned, field[k])
            known = np.hypot(x, y) * north + z * UP
        error = np.cross(force[k], quaternion.rotate(back, UP)) + np.cross(field[k], quaternion.rotate(back, known))
        turned = quaternion.multiply(turned, quaternion.exp(gain * h * error))
        q = quaternion.normalize(quaternion.multiply(turned, turn) if ahead else turned)
        found.append(q)
    return np.array(found)


@pytest.mark.parametrize(
    ("grade", "north", "offset_deg", "within_deg"),
    [
        ("perfect", *TO_Y),
        pytest.param("consumer", *TO_X, marks=pytest.mark.slow),
        pytest.param("tactical", *TO_Y, marks=pytest.mark.slow),
        pytest.param("perfect", *TO_X, marks=pytest.mark.slow),
        pytest.param("consumer", *TO_Y, marks=pytest.mark.slow),
        pytest.param("tactical", *TO_X, marks=pytest.mark.slow),
    ],
)
def test_a_filter_whose_north_is_magnetic_is_told_the_declination_and_nothing_else(
    grade, north, offset_deg, within_deg
):
    run = recorded("perfect", **CONSUMER) if grade == "consumer" else recorded(grade)
    score = run.score(filtered(run, np.array(north), 2.0, ahead=offset_deg > 0.0))
    [finding] = score.findings
    assert finding.code == "heading_offset"
    angle = float(re.findall(r"turned by (\S+)°", finding.message)[0])
    assert abs(angle) == pytest.approx(abs(offset_deg), abs=within_deg)
    assert "lie-rigid-body diagnose" in finding.message


@pytest.mark.slow
@pytest.mark.parametrize(
    ("grade", "ahead"),
    [
        ("perfect", False),
        ("tactical", True),
        pytest.param("mems", False, marks=pytest.mark.slow),
        pytest.param("perfect", True, marks=pytest.mark.slow),
        pytest.param("tactical", False, marks=pytest.mark.slow),
        pytest.param("mems", True, marks=pytest.mark.slow),
    ],
)
def test_a_right_filter_is_told_nothing(grade, ahead):
    run = recorded(grade)
    score = run.score(filtered(run, None, 1.0, ahead=ahead))
    assert score.findings == ()
    assert (left_by_errors_of(run.segments) > 0.0) == (grade != "perfect")


def test_what_declared_hard_iron_turns_is_said_to_be_of_the_sensors():
    """Without any noise as well, where nothing bounds an estimator's error."""
    run = recorded("perfect", magnetometer_hard_iron=(1.3e-6, -1.3e-6, 1.3e-6))
    turned = quaternion.multiply(quaternion.exp(np.radians(2.0) * UP), true(run))
    score = run.score(turned)
    assert score.findings == ()
    assert score.of_sensors_deg == pytest.approx(np.degrees(left_by_errors_of(run.segments)))
    larger = quaternion.multiply(quaternion.exp(np.radians(20.0) * UP), true(run))
    assert [finding.code for finding in run.score(larger).findings] == ["heading_offset"]
