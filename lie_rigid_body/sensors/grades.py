"""Grades of sensors: the error parameters of real ones, from data sheets.

Values are those of the sheets, which docs/reference/imu.md names. An error that a sheet does not tell is left out. The
random walk of a bias, which sheets do not give, follows from the lowest Allan deviation σ and the noise density N. The
sum N²/τ + K²τ/3 has the minimum 2 N K / √3, so K = √3 σ² / (2 N). Errors of scale, mounting and iron are of unknown
sign; the signs taken are +, −, + along x, y, z.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from lie_rigid_body.parameters import Value, Vector

GRADE: Final = "sensor_grade"
"""Name of the parameter that chooses a grade."""
PERFECT: Final = "perfect"
"""The grade without any error."""

_DEGREE: Final = math.radians(1.0)
_PER_HOUR: Final = _DEGREE / 3600.0
"""Conversion of a gyro's bias from data sheets, (rad/s) / (°/h)."""
_PER_ROOT_HOUR: Final = _DEGREE / 60.0
"""Conversion of an angle random walk from data sheets, (rad/s/√Hz) / (°/√h)."""
_G: Final = 9.80665
"""Standard gravity, m/s²."""
_PPM: Final = 1e-6


def _walk(lowest_allan_deviation: float, noise_density: float) -> float:
    return math.sqrt(3.0) / 2.0 * lowest_allan_deviation**2 / noise_density


def _signed(size: float, offset: float = 0.0) -> Vector:
    """Three numbers that differ from an offset by a size, with the signs +, −, +."""
    return (offset + size, offset - size, offset + size)


def _stretched(size: float) -> Vector:
    """Soft-iron matrix, row by row, of errors of scale alone."""
    x, y, z = _signed(size, 1.0)
    return (x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z)


_NAVIGATION: Final[dict[str, Value]] = {
    "gyro_noise_density": 0.002 * _PER_ROOT_HOUR,
    "gyro_turn_on_bias": 0.0035 * _PER_HOUR,
    "gyro_scale_factor": _signed(5.0 * _PPM, 1.0),
    "accelerometer_noise_density": 7e-6 * _G / math.sqrt(10.0),
    "accelerometer_turn_on_bias": 25e-6 * _G,
    "accelerometer_scale_factor": _signed(100.0 * _PPM, 1.0),
    "magnetometer_noise_density": 6e-12,
    "magnetometer_hard_iron": _signed(5e-9),
    "magnetometer_soft_iron": _stretched(0.005),
    "magnetometer_range": 70e-6,
}
_STIM300_GYRO: Final = 0.15 * _PER_ROOT_HOUR
_STIM300_ACCELEROMETER: Final = 0.06 / 60.0
_TACTICAL: Final[dict[str, Value]] = {
    "gyro_noise_density": _STIM300_GYRO,
    "gyro_bias_random_walk": _walk(0.5 * _PER_HOUR, _STIM300_GYRO),
    "gyro_turn_on_bias": 5.0 * _PER_HOUR,
    "gyro_scale_factor": _signed(500.0 * _PPM, 1.0),
    "gyro_misalignment": _signed(1e-3),
    "gyro_resolution": 0.22 * _PER_HOUR,
    "gyro_range": 400.0 * _DEGREE,
    "accelerometer_noise_density": _STIM300_ACCELEROMETER,
    "accelerometer_bias_random_walk": _walk(0.05e-3 * _G, _STIM300_ACCELEROMETER),
    "accelerometer_turn_on_bias": 0.75e-3 * _G,
    "accelerometer_scale_factor": _signed(300.0 * _PPM, 1.0),
    "accelerometer_misalignment": _signed(1e-3),
    "accelerometer_resolution": 1.9e-6 * _G,
    "accelerometer_range": 10.0 * _G,
    "magnetometer_noise_density": 1.2e-9,
    "magnetometer_hard_iron": _signed(15e-9),
    "magnetometer_resolution": 13e-9,
    "magnetometer_range": 800e-6,
}
_BMI088_GYRO: Final = 0.014 * _DEGREE
_MEMS: Final[dict[str, Value]] = {
    "gyro_noise_density": _BMI088_GYRO,
    "gyro_bias_random_walk": _walk(2.0 * _PER_HOUR, _BMI088_GYRO),
    "gyro_turn_on_bias": 1.0 * _DEGREE,
    "gyro_scale_factor": _signed(0.01, 1.0),
    "gyro_misalignment": _signed(0.01),
    "gyro_resolution": _DEGREE / 16.384,
    "gyro_range": 2000.0 * _DEGREE,
    "accelerometer_noise_density": 175e-6 * _G,
    "accelerometer_turn_on_bias": 20e-3 * _G,
    "accelerometer_misalignment": _signed(0.005),
    "accelerometer_resolution": _G / 5460.0,
    "accelerometer_range": 6.0 * _G,
    "magnetometer_noise_density": 0.3e-6 / math.sqrt(20.0),
    "magnetometer_hard_iron": _signed(30e-6 * math.tan(2.5 * _DEGREE)),
    "magnetometer_resolution": 0.3e-6,
    "magnetometer_range": 1300e-6,
}

GRADES: Final[Mapping[str, Mapping[str, Value]]] = MappingProxyType(
    {PERFECT: {}, "navigation": _NAVIGATION, "tactical": _TACTICAL, "mems": _MEMS}
)
"""The error parameters that each grade sets; the others stay at their defaults, without error."""


def graded(given: Mapping[str, object]) -> dict[str, object]:
    """Add the errors of a grade to the parameters that are given, which override them.

    Parameters
    ----------
    given : mapping of str to object
        Parameters by their names; an unknown grade is left for the table of parameters to refuse.
    """
    grade = given.get(GRADE, PERFECT)
    return {**(GRADES.get(grade, {}) if isinstance(grade, str) else {}), **given}
