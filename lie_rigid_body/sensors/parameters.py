"""Parameters that several kinds of sensors have, those of their faults, and grades: the errors of real sensors.

Faults are all off by default. The values of grades are those of data sheets, which docs/reference/imu.md names. An
error that a sheet does not tell is left out. The random walk of a bias, which sheets do not give, follows from the
lowest Allan deviation σ and the noise density N. The sum N²/τ + K²τ/3 has the minimum 2 N K / √3, so K = √3 σ² / (2 N).
Errors of scale, mounting and iron are of unknown sign; the signs taken are +, −, + along x, y, z.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Given, Names, Parameter, Value, Vector
from lie_rigid_body.foundation.wording import numerals
from lie_rigid_body.motion.harmonics import HARMONICS, STEPS_PER_HZ

Parameters: TypeAlias = tuple[Parameter, ...]
"""Parameters in the order in which they are shown."""
Fields: TypeAlias = dict[str, Any]
"""Values of the fields of a model, by their names."""
Values: TypeAlias = Mapping[str, Any]
"""Values of all parameters of sensors by their names, each of the type of its parameter."""

MAX_PARAMETER: Final = 1e9
"""Largest value of a parameter that has no narrower limit, in its unit."""
_MAX_DURATION_S: Final = 1e9
"""Longest duration of a fault, s."""
_MAX_DELAY_S: Final = 10.0
"""Longest latency of a reading, and largest jitter, s."""
_MAX_OFFSET_S: Final = 2.2e9
"""Largest offset of a sensor's clock, s: it may begin at 0 when it is switched on, in any year that ROS can stamp."""
_MAX_FREQUENCY: Final = 1e6
"""Highest frequency of a harmonic, Hz."""
_MAX_SKEW: Final = 0.01
"""Largest skew of a sensor's clock, s/s."""


def values_of(kind: type, name: str, values: Values) -> Fields:
    """Values of the parameters that a dataclass has as fields: FIELD for each parameter NAME_FIELD."""
    found = {field.name: values.get(f"{name}_{field.name}") for field in fields(kind)}
    return {field: value for field, value in found.items() if value is not None}


def not_negative(name: str, description: str, default: float = 0.0, maximum: float = MAX_PARAMETER) -> Parameter:
    """A parameter whose values are not below 0."""
    return Parameter(name, "double", default, description, minimum=0.0, maximum=maximum)


def angle(name: str, description: str) -> Parameter:
    """A parameter that is an angle from 0 to π, rad."""
    return not_negative(name, description, maximum=math.pi)


def numbers(name: str, default: Vector, description: str) -> Parameter:
    """A parameter that is an array as long as its default."""
    return Parameter(name, "double_array", default, description, lengths=(len(default),))


def seed(name: str, description: str) -> Parameter:
    """A parameter that is a seed of random numbers."""
    return Parameter(name, "int", 0, description, minimum=0, maximum=2**63 - 1)


def harmonics_parameters(name: str, what: str, band: tuple[float, float]) -> tuple[Parameter, Parameter]:
    """Parameters of a sum of harmonics on three axes: its RMS, and the band of its frequencies."""
    return (
        Parameter(
            f"{name}_acceleration",
            "double_array",
            (0.0, 0.0, 0.0),
            f"RMS of {what}, over a long time, m/s².",
            lengths=(3,),
            minimum=0.0,
            maximum=MAX_PARAMETER,
        ),
        Parameter(
            f"{name}_band",
            "double_array",
            band,
            f"Lowest and highest frequency of its {HARMONICS} harmonics on each axis, Hz.",
            lengths=(2,),
            minimum=1.0 / STEPS_PER_HZ,
            maximum=_MAX_FREQUENCY,
        ),
    )


def require_band(name: str, band: Vector) -> None:
    """Refuse a band of frequencies that is upside down.

    Raises
    ------
    ParameterError
    """
    low, high = band
    if low > high:
        raise ParameterError(name, f"{numerals(band)} Hz is no band: give the lowest frequency first")


def triad_parameters(sensor: str, unit: str) -> Parameters:
    """The parameters of a triad's errors; ``unit`` is the unit of a reading."""
    name = sensor.capitalize()
    return (
        not_negative(f"{sensor}_noise_density", f"{name}: white noise, {unit}/√Hz; 0: none."),
        not_negative(f"{sensor}_bias_random_walk", f"{name}: random walk of the bias, {unit}/s/√Hz; 0: none."),
        not_negative(
            f"{sensor}_turn_on_bias",
            f"{name}: standard deviation of the bias at the start on each axis, drawn from the seed, {unit}; 0: none.",
        ),
        numbers(f"{sensor}_scale_factor", (1.0, 1.0, 1.0), f"{name}: factor on each of its axes."),
        numbers(
            f"{sensor}_misalignment",
            (0.0, 0.0, 0.0),
            f"{name}: rotation vector from the body's axes to its own, rad, of norm at most π.",
        ),
        not_negative(f"{sensor}_resolution", f"{name}: step of its readings, {unit}; 0: continuous."),
        not_negative(f"{sensor}_range", f"{name}: largest size of a reading on each axis, {unit}; 0: no limit."),
    )


def episode_parameters(name: str, what: str, duration: float) -> Parameters:
    """Parameters of the interval and the duration of episodes; ``what`` names the episodes, with a capital."""
    return (
        not_negative(f"{name}_interval", f"{what}: one in each interval of so many seconds; 0: none."),
        not_negative(f"{name}_duration", f"{what}: how long each lasts, s.", duration, _MAX_DURATION_S),
    )


def delivery_parameters(sensor: str, title: str) -> Parameters:
    """Parameters of how the readings of a sensor arrive."""
    name = f"{title[:1].upper()}{title[1:]}"
    return (
        not_negative(
            f"{sensor}_dropout_probability", f"{name}: probability that a reading is lost; 0: none.", maximum=1.0
        ),
        *episode_parameters(f"{sensor}_outage", f"{name}, outages, in which every reading is lost", 1.0),
        not_negative(f"{sensor}_latency", f"{name}: time from a measurement to its message, s.", maximum=_MAX_DELAY_S),
        not_negative(
            f"{sensor}_latency_jitter",
            f"{name}: most that is added to the latency, drawn evenly for each reading, and no longer than 100 000 of "
            "them take, s.",
            maximum=_MAX_DELAY_S,
        ),
        Parameter(
            f"{sensor}_clock_offset",
            "double",
            0.0,
            f"{name}: how far its clock, which stamps, is ahead at the epoch, s.",
            minimum=-_MAX_OFFSET_S,
            maximum=_MAX_OFFSET_S,
        ),
        Parameter(
            f"{sensor}_clock_skew",
            "double",
            0.0,
            f"{name}: by how much its clock is too fast, s/s.",
            minimum=-_MAX_SKEW,
            maximum=_MAX_SKEW,
        ),
    )


def triad_fault_parameters(sensor: str, unit: str, spike: float, density: float, level: float) -> Parameters:
    """Parameters of the faults of a sensor's axes; sizes are defaults for when a fault is switched on."""
    name = sensor.capitalize()
    return (
        not_negative(
            f"{sensor}_spike_probability",
            f"{name}: probability of a spike in a reading, on one axis; 0: none.",
            maximum=1.0,
        ),
        not_negative(f"{sensor}_spike_size", f"{name}: size of a spike, of either sign, {unit}.", spike),
        *episode_parameters(f"{sensor}_noise_burst", f"{name}, bursts of noise", 1.0),
        not_negative(f"{sensor}_noise_burst_density", f"{name}: white noise that a burst adds, {unit}/√Hz.", density),
        *episode_parameters(f"{sensor}_stuck", f"{name}, an axis that is stuck at its last reading", 1.0),
        *episode_parameters(f"{sensor}_saturation", f"{name}, saturation below its range", 1.0),
        not_negative(
            f"{sensor}_saturation_level", f"{name}: largest size of a reading during a saturation, {unit}.", level
        ),
        not_negative(
            f"{sensor}_temperature_drift",
            f"{name}: standard deviation on each axis of the bias' change with temperature, {unit}; 0: none.",
        ),
        not_negative(
            f"{sensor}_temperature_drift_duration",
            f"{name}: time from fault_begin on in which that change comes about, s.",
            600.0,
            _MAX_DURATION_S,
        ),
    )


def fault_switches(parameters: Iterable[Parameter]) -> dict[str, Names]:
    """The parameters that switch a fault on, each with how the names of the others of that fault begin."""
    names = [parameter.name for parameter in parameters]
    some = {name: (f"{name.rpartition('_')[0]}_",) for name in names if name.endswith(("_interval", "_probability"))}
    return {**some, **{name: (f"{name}_",) for name in names if name.endswith("_temperature_drift")}}


WINDOW_PARAMETERS: Final = (
    not_negative(
        "fault_begin",
        "Lost readings, spikes and episodes of faults: from so many seconds after a start on.",
        maximum=_MAX_DURATION_S,
    ),
    not_negative(
        "fault_end", "The same: until so many seconds after a start; 0: without end.", maximum=_MAX_DURATION_S
    ),
)
"""The parameters that limit all faults that have a switch."""

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


_STIM300_GYRO: Final = 0.15 * _PER_ROOT_HOUR
_STIM300_ACCELEROMETER: Final = 0.06 / 60.0
_BMI088_GYRO: Final = 0.014 * _DEGREE

GRADES: Final[Mapping[str, Mapping[str, Value]]] = MappingProxyType(
    {
        PERFECT: {},
        "navigation": {
            "gyro_noise_density": 0.002 * _PER_ROOT_HOUR,
            "gyro_turn_on_bias": 0.0035 * _PER_HOUR,
            "gyro_scale_factor": _signed(5.0 * _PPM, 1.0),
            "accelerometer_noise_density": 7e-6 * _G / math.sqrt(10.0),
            "accelerometer_turn_on_bias": 25e-6 * _G,
            "accelerometer_scale_factor": _signed(100.0 * _PPM, 1.0),
            "magnetometer_noise_density": 6e-12,
            "magnetometer_hard_iron": _signed(5e-9),
            "magnetometer_soft_iron": (1.005, 0.0, 0.0, 0.0, 0.995, 0.0, 0.0, 0.0, 1.005),
            "magnetometer_range": 70e-6,
        },
        "tactical": {
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
        },
        "mems": {
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
        },
    }
)
"""The error parameters that each grade sets; the others stay at their defaults, without error."""


def graded(given: Given) -> Given:
    """Add the errors of a grade to the parameters that are given, which override them.

    Parameters
    ----------
    given : mapping of str to object
        Parameters by their names; an unknown grade is left for the table of parameters to refuse.
    """
    grade = given.get(GRADE, PERFECT)
    return {**(GRADES.get(grade, {}) if isinstance(grade, str) else {}), **given}
