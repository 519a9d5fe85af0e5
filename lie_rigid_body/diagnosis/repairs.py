"""Repairs: changes of the readings that undo what a filter does wrong with them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from functools import partial
from typing import Any, Final

import numpy as np

from lie_rigid_body.diagnosis.course import MARGIN, Readings
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, named
from lie_rigid_body.evaluation.causes import IDENTITY, NED, UP
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion

HALVED: Final = 0.5
"""Largest share of the error that a repair may leave if it brings the error below the floor."""
SENSOR_READINGS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Names of the readings of each sensor, by the sensor's name in codes."""
PERTURBED: Final = math.radians(2.0)
"""Angle by which the readings of a sensor are rotated to see whether a filter hears it, rad."""
SCALE: Final = 0.02
"""Distance from 1 up to which a factor of the gyro is a property of the filter."""
DRIFT: Final = 0.1
"""Rate error of a drifting gyro, as a share of the body's mean rate: in a course it makes hundreds of times the floor
of the error."""


@short_dataclass
class Repair:
    """A change of the readings, or of the estimate.

    Attributes
    ----------
    code : str
        The mistake that it undoes; empty of a change that undoes none.
    text : str
        What is done, in as few characters as tell it: ``y x -z``.
    fact : str
        The mistake in a sentence without a full stop.
    deed : str
        The repair in words, before what it leaves; of all but `JOINT` with the verb.
    change : callable or None
        The readings that a filter with the mistake is to be given; None of a repair of the estimate.
    price : int
        Number of fitted constants.
    constants : ndarray
        Constants of the cause that is undone in the estimate, or the factor of the gyro; else empty.
    """

    code: str = ""
    text: str = ""
    fact: str = ""
    deed: str = ""
    change: Callable[[Readings], Readings] | None = field(default=None, compare=False)
    price: int = 0
    constants: Array = field(default_factory=lambda: np.zeros(0), compare=False)

    @property
    def is_near_another(self) -> bool:
        """Whether it is a fitted factor of the gyro within `SCALE` of one that is not fitted, or of 1."""
        return self.price > 0 and bool(np.any(np.abs(self.constants[:, np.newaxis] / EXACT_FACTORS - 1.0) <= SCALE))


Repairs = tuple[Repair, ...]
"""Repairs in the order in which they are applied: those of the input, `JOINT` if it is used, those of the output."""


def _multiplied(sensors: Sequence[str], matrix: Array, given: Readings) -> Readings:
    """Readings of some sensors, multiplied by a matrix from the left, shape (3, 3)."""
    return given.changed(lambda rows: rows @ matrix.T, *(SENSOR_READINGS[name] for name in sensors))


def _moved(sensors: Sequence[str], count: int, given: Readings) -> Readings:
    """Readings of some sensors from ``count`` samples later, none from before the filter's first one."""

    def moved(rows: Array) -> Array:
        places = np.arange(len(rows))
        return rows[np.clip(places + count, np.minimum(places, MARGIN), len(rows) - 1)]

    return given.changed(moved, *(SENSOR_READINGS[name] for name in sensors))


def _on_world_axes(matrix: Array, given: Readings) -> Readings:
    """Readings of the gyro on the axes of a world, whose matrix from ours has shape (3, 3)."""
    return given.changed(lambda gyro: quaternion.rotate(given.course.at(given.t_ns), gyro) @ matrix.T, "gyro")


def _exchanged(given: Readings) -> Readings:
    vectors = given.vectors
    return replace(given, vectors={**vectors, "gyro": vectors["specific_force"], "specific_force": vectors["gyro"]})


def _as_euler_rates(world: Array, given: Readings) -> Readings:
    """Rates of roll, pitch and yaw, in the order 3-2-1, in place of the body's; quaternion of the world, shape (4,)."""
    attitude = quaternion.multiply(world, given.course.at(given.t_ns))
    x, y, z = quaternion.to_matrix(attitude)[:, 2].T  # the vertical on the axes of the body
    p, q, r = given.vectors["gyro"].T
    roll = np.arctan2(y, z)
    level = np.maximum(np.hypot(y, z), 1e-6)  # cosine of the pitch
    across = np.sin(roll) * q + np.cos(roll) * r
    rates = [p - x / level * across, np.cos(roll) * q - np.sin(roll) * r, across / level]
    return given.changed(lambda gyro: np.stack(rates, axis=1), "gyro")


JOINT: Final = Repair(
    "ahead_by_a_sample",
    "accelerometer and magnetometer one sample later",
    "The filter compares readings with the attitude before its gyro step, as most do",
    "With accelerometer and magnetometer one sample later",
    partial(_moved, ("accelerometer", "magnetometer"), -1),
)
"""Change for a filter that is ahead by one sample and otherwise right: it is no mistake, and has no price."""


def text_of(matrix: Array) -> str:
    """Text of a permutation of axes with signs: ``y x -z``."""
    return named(matrix).replace(",", "")


def _axes() -> Iterator[Repair]:
    """Wrong axes of one sensor, with any permutation and signs, and of all sensors, with any such rotation."""
    for sensor in (*SENSOR_READINGS, "body"):
        sensors = tuple(SENSOR_READINGS) if sensor == "body" else (sensor,)
        for matrix in SIGNED_PERMUTATIONS[1:]:
            name = text_of(matrix)
            wrong = f"the axes of the {sensor}{', of all sensors alike,' * (sensor == 'body')} in another order or sign"
            if name == "-x -y -z":
                wrong = f"the {sensor} with the opposite sign"
            if sensor != "body" or np.linalg.det(matrix) > 0.0:
                yield Repair(
                    f"{sensor}_axes",
                    name,
                    f"The filter takes {wrong}",
                    f"Given as {name} {'the' if sensor == 'body' else 'its'} readings leave",
                    partial(_multiplied, sensors, matrix),
                )


_UNITS: Final = {
    "gyro": {
        "degrees a second": 180.0 / np.pi,
        "turns a minute": 30.0 / np.pi,
        "thousandths of a radian a second": 1e3,
        "degrees an hour": 3600.0 * 180.0 / np.pi,
    },
    "accelerometer": {"multiples of g": 1.0 / 9.80665, "thousandths of g": 1e3 / 9.80665, "cm/s²": 1e2},
    "magnetometer": {"gauss": 1e4, "µT": 1e6, "mT": 1e3, "milligauss": 1e7, "nT": 1e9},
}
"""Wrong units in which filters may take readings, and the number of these units in one SI unit."""


def _units() -> Iterator[Repair]:
    for sensor, units in _UNITS.items():
        for unit, number in units.items():
            for value, fact in (
                (number, f"takes {sensor} readings for {unit}"),
                (1.0 / number, f"turns {sensor} readings into {unit} where SI units belong"),
            ):
                yield Repair(
                    f"{sensor}_units",
                    f"× {value:.6g}",
                    f"The filter {fact}",
                    f"Multiplied by {value:.3g} they leave",
                    partial(_multiplied, (sensor,), value * np.eye(3)),
                )


def factor(value: float) -> Repair:
    """Repair of a wrong time step: the gyro's readings multiplied by a factor; ½ and 2 are no fitted constants.

    Within 2 % of 1 it is a property of the filter, not a mistake of its user.
    """
    plain = {2.0: ", as with the ½ of the quaternion's rate twice", 0.5: ", as without the ½ of the quaternion's rate"}
    return Repair(
        "gyro_scale" if abs(value - 1.0) <= SCALE else "time_step",
        f"gyro × {value:.6g}",
        f"The filter rotates {1.0 / value:.4g} times as far as the gyro says: a wrong time step{plain.get(value, '')}",
        f"With the gyro multiplied by {value:.5g} the readings leave",
        partial(_multiplied, ("gyro",), value * np.eye(3)),
        value not in plain,
        np.array([value]),
    )


EXACT_FACTORS: Final = np.array([1.0, 0.5, 2.0, *(each for n in _UNITS["gyro"].values() for each in (n, 1.0 / n))])
"""Factors of the gyro that other repairs, or none, have without a fitted constant."""


def late(sensor: str, count: int) -> Repair:
    """Repair that moves the readings of one sensor in time by a number of samples."""
    size = f"{abs(count)} sample{'s' if abs(count) > 1 else ''}"
    return Repair(
        f"{sensor}_late",
        f"{size} {'earlier' if count > 0 else 'later'}",
        f"The filter uses the readings of the {sensor} {size} too {'late' if count > 0 else 'early'}",
        "Moved by as many they leave",
        partial(_moved, (sensor,), count),
        1,
    )


def scaled(sensor: str, share: float) -> Repair:
    """Change that multiplies the readings of a sensor by a factor."""
    return Repair(change=partial(_multiplied, (sensor,), share * np.eye(3)))


def drifting(sensor: str, given: Readings) -> Readings:
    """Readings of a gyro that drifts about the direction which only one sensor corrects.

    The drift is a tenth of the body's mean rate, about the magnetic field for the accelerometer, else about the
    vertical. For the gyro there is no drift: it is heard where the filter errs without it.
    """
    course = given.course
    axis = course.field / np.linalg.norm(course.field) if sensor == "accelerometer" else UP
    drift = DRIFT * (sensor != "gyro") * course.turn * course.rate * axis
    drifts = quaternion.rotate(quaternion.conjugate(course.at(given.t_ns)), drift)
    return given.changed(lambda gyro: gyro + drifts, "gyro")


def perturbed(sensor: str, since_ns: int, given: Readings) -> Readings:
    """Readings of a sensor, rotated by `PERTURBED` about a diagonal of the body from a stamp on; a gyro's are halved.

    So small a rotation passes every gate that a filter may have.
    """
    stamps = given.field_t_ns if sensor == "magnetometer" else given.t_ns
    since = (stamps >= since_ns)[:, np.newaxis]
    rotation = quaternion.exp(PERTURBED / np.sqrt(3.0) * np.ones(3))
    return given.changed(
        lambda rows: np.where(since, 0.5 * rows if sensor == "gyro" else quaternion.rotate(rotation, rows), rows),
        SENSOR_READINGS[sensor],
    )


def exact_repairs() -> tuple[Repair, ...]:
    """Every repair without a fitted constant, in the order of the table of mistakes."""
    exchanged = Repair(
        "sensors_exchanged",
        "gyro and accelerometer exchanged",
        "The filter takes the readings of the gyro for those of the accelerometer, and these for the gyro's",
        "Exchanged they leave",
        _exchanged,
    )
    euler = (
        Repair(
            "euler_rates",
            f"rates of roll, pitch and yaw, z {side}",
            "The filter takes the readings of the gyro for the rates of roll, pitch and yaw",
            "Turned into these its readings leave",
            partial(_as_euler_rates, world),
        )
        for side, world in (("up", IDENTITY), ("down", NED))
    )
    worlds = (
        Repair(
            "gyro_world_axes",
            f"gyro on the axes {text_of(matrix)} of the world",
            "The filter rotates about the world's axes, as where the rotation is multiplied on the wrong side",
            "Given on the world's axes its readings leave",
            partial(_on_world_axes, matrix),
        )
        for matrix in SIGNED_PERMUTATIONS
        if np.linalg.det(matrix) > 0.0
    )
    return (*_axes(), *_units(), exchanged, *euler, *worlds, factor(2.0), factor(0.5))


FITTED: Final[dict[str, tuple[Callable[[Any], Repair], tuple[float, ...]]]] = {
    "time_step": (factor, (0.25, 0.4, 0.6, 0.75, 0.87, 0.95, 1.05, 1.15, 1.33, 1.67, 2.5, 4.0)),
    **{f"{sensor}_late": (partial(late, sensor), (-2, -1, 1, 2, 3, 5, 8, 13, 21, 40)) for sensor in SENSOR_READINGS},
}
"""Repairs with one fitted constant, each with the constants that are tried first, in order."""

ORDER: Final = (
    "inverted",
    "scalar_first",
    "ned_world",
    "euler_order",
    "output_axes",
    "gyro_axes",
    "accelerometer_axes",
    "magnetometer_axes",
    "body_axes",
    "gyro_units",
    "accelerometer_units",
    "magnetometer_units",
    "sensors_exchanged",
    "euler_rates",
    "gyro_world_axes",
    "time_step",
    "gyro_scale",
    "gyro_late",
    "accelerometer_late",
    "magnetometer_late",
    "heading_offset",
    "world_turned",
    "lagging",
    "leading",
    "clock_rate",
    "body_mounting",
)
"""Order in which mistakes are named if several repairs do equally well at equal cost."""
