"""Parameters that several kinds of sensors have, as they stand in the table."""

from __future__ import annotations

import math
from typing import Final

from lie_rigid_body.parameters import Parameter

LARGEST: Final = 1e9
"""Largest value of a parameter that has no narrower limit, in its own unit."""
_HALF_TURN: Final = math.pi
_ONES: Final = (1.0, 1.0, 1.0)
_ZEROS: Final = (0.0, 0.0, 0.0)


def not_negative(name: str, description: str, default: float = 0.0, maximum: float = LARGEST) -> Parameter:
    """A parameter whose values are not below 0."""
    return Parameter(name, "double", default, description, minimum=0.0, maximum=maximum)


def angle(name: str, description: str) -> Parameter:
    """A parameter that is an angle from 0 to π, rad."""
    return not_negative(name, description, maximum=_HALF_TURN)


def numbers(name: str, default: tuple[float, ...], description: str) -> Parameter:
    """A parameter that is an array as long as its default."""
    return Parameter(name, "double_array", default, description, lengths=(len(default),))


def triad_parameters(sensor: str, unit: str) -> tuple[Parameter, ...]:
    """The parameters of a triad's errors; ``unit`` is the unit of a reading."""
    name = sensor.capitalize()
    return (
        not_negative(f"{sensor}_noise_density", f"{name}: white noise, {unit}/√Hz; 0: none."),
        not_negative(f"{sensor}_bias_random_walk", f"{name}: random walk of the bias, {unit}/s/√Hz; 0: none."),
        not_negative(
            f"{sensor}_turn_on_bias",
            f"{name}: standard deviation of the bias at the start on each axis, drawn from the seed, {unit}; 0: none.",
        ),
        numbers(f"{sensor}_scale_factor", _ONES, f"{name}: factor on each of its axes."),
        numbers(
            f"{sensor}_misalignment",
            _ZEROS,
            f"{name}: rotation vector from the body's axes to its own, rad, of norm at most π.",
        ),
        not_negative(f"{sensor}_resolution", f"{name}: step of its readings, {unit}; 0: continuous."),
        not_negative(f"{sensor}_range", f"{name}: largest size of a reading on each axis, {unit}; 0: no limit."),
    )
