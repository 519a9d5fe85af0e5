"""Repairs of the input: changes of the readings that undo what a filter does wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import permutations, product
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.trial import MARGIN, TrialReadings
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

SENSORS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Sensors by the names that codes have, and their readings."""

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Repair:
    """A change of the readings.

    Attributes
    ----------
    code : str
        The mistake that it undoes.
    text : str
        What is done, in as few characters as tell it: ``y x -z``.
    price : int
        Number of fitted constants.
    change : callable
        The readings that a filter with the mistake is to be given.
    fact : str
        The mistake in a sentence without a full stop.
    deed : str
        The repair in words, before "leave".
    """

    code: str
    text: str
    price: int
    change: Callable[[TrialReadings], TrialReadings] = field(compare=False)
    fact: str
    deed: str

    __repr__ = short_repr

    @property
    def group(self) -> str:
        """What is repaired: of each group one repair at most makes sense."""
        return self.code.partition("_")[0]


def _turned(sensors: tuple[str, ...], axes: Rows, readings: TrialReadings) -> TrialReadings:
    matrix = np.array(axes)
    return readings.changed(**{SENSORS[name]: readings.vectors[SENSORS[name]] @ matrix.T for name in sensors})


def _scaled(sensor: str, factor: float, readings: TrialReadings) -> TrialReadings:
    return readings.changed(**{SENSORS[sensor]: readings.vectors[SENSORS[sensor]] * factor})


def _moved(sensors: tuple[str, ...], count: int, readings: TrialReadings) -> TrialReadings:
    """Readings from so many samples later; before the first that a filter is given there is none."""
    moved = {}
    for name in (SENSORS[sensor] for sensor in sensors):
        rows = readings.vectors[name]
        places = np.arange(len(rows))
        moved[name] = rows[np.clip(places + count, np.minimum(places, MARGIN), len(rows) - 1)] if len(rows) else rows
    return readings.changed(**moved)


def _on_world_axes(readings: TrialReadings) -> TrialReadings:
    return readings.changed(gyro=quaternion.rotate(readings.truth.at(readings.t_ns), readings.vectors["gyro"]))


JOINT: Final = Repair(
    "ahead_by_a_sample",
    "accelerometer and magnetometer one sample later",
    0,
    partial(_moved, ("accelerometer", "magnetometer"), -1),
    "The filter compares readings with the attitude before its gyro step, as most do",
    "With accelerometer and magnetometer one sample later",
)
"""The change that makes a right filter of one that is ahead by a sample: no mistake, and without a price."""

WORLD_AXES: Final = Repair(
    "gyro_world_axes",
    "gyro on the world's axes",
    0,
    _on_world_axes,
    "The filter turns about the world's axes, as where the turn is multiplied on the wrong side",
    "Given on the world's axes",
)


def _signed_permutations() -> Iterator[tuple[str, Rows, bool]]:
    """Every choice of axes with signs but the right one: name, matrix, whether it is a rotation."""
    for places, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.diag(signs) @ np.eye(3)[list(places)]
        name = " ".join(f"{'-' if sign < 0 else ''}{'xyz'[place]}" for place, sign in zip(places, signs, strict=True))
        if name != "x y z":
            yield name, tuple(map(tuple, matrix.tolist())), bool(np.linalg.det(matrix) > 0)


def _axes(sensor: str) -> Iterator[Repair]:
    for name, rows, _ in _signed_permutations():
        fact = f"The filter takes the axes of the {sensor} for others"
        if name == "-x -y -z":
            fact = f"The filter takes the {sensor} for one of the opposite sign"
        yield Repair(
            f"{sensor}_axes", name, 0, partial(_turned, (sensor,), rows), fact, f"Given as {name} its readings"
        )


def _body_axes() -> Iterator[Repair]:
    for name, rows, proper in _signed_permutations():
        if proper:
            yield Repair(
                "body_axes",
                name,
                0,
                partial(_turned, tuple(SENSORS), rows),
                "The filter takes the axes of the body for others, of all sensors alike",
                f"Given as {name} the readings",
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
"""Units that filters take readings for, and their number in the SI unit."""


def _units(sensor: str) -> Iterator[Repair]:
    for unit, factor in _UNITS[sensor].items():
        for value, fact in (
            (factor, f"The filter takes {sensor} readings for {unit}"),
            (1.0 / factor, f"The filter turns {sensor} readings into {unit} where SI units belong"),
        ):
            yield Repair(
                f"{sensor}_units",
                f"× {value:.6g}",
                0,
                partial(_scaled, sensor, value),
                fact,
                f"Multiplied by {value:.3g} they",
            )


def factor(value: float) -> Repair:
    """Turns of the gyro by a factor; ½ and 2 are no fitted constants."""
    plain = {2.0: ", the ½ of the quaternion's rate too often", 0.5: ", the ½ of the quaternion's rate too seldom"}
    return Repair(
        "time_step",
        f"gyro × {value:.6g}",
        0 if value in plain else 1,
        partial(_scaled, "gyro", value),
        f"The filter turns by {1.0 / value:.4g} times what the gyro tells: a wrong time step{plain.get(value, '')}",
        f"With the gyro multiplied by {value:.5g} the readings",
    )


def late(sensor: str, samples: float) -> Repair:
    """Readings of one sensor moved in time by a whole number of samples."""
    count = int(samples)
    how = "late" if count > 0 else "early"
    return Repair(
        f"{sensor}_late",
        f"{abs(count)} samples {'earlier' if count > 0 else 'later'}",
        1,
        partial(_moved, (sensor,), count),
        f"The filter uses the readings of the {sensor} {abs(count)} samples too {how}",
        "Moved by as many they",
    )


def exact_repairs() -> tuple[Repair, ...]:
    """Every repair without a fitted constant, in the order of the table of mistakes."""
    found = [repair for sensor in SENSORS for repair in _axes(sensor)]
    found += _body_axes()
    found += [repair for sensor in SENSORS for repair in _units(sensor)]
    return (*found, WORLD_AXES, factor(2.0), factor(0.5))


FITTED: Final[dict[str, Callable[[float], Repair]]] = {
    "time_step": factor,
    **{f"{sensor}_late": partial(late, sensor) for sensor in SENSORS},
}
"""Repairs with one constant."""

ORDER: Final = (
    "inverted",
    "scalar_first",
    "ned_world",
    "euler_order",
    "gyro_axes",
    "accelerometer_axes",
    "magnetometer_axes",
    "body_axes",
    "gyro_units",
    "accelerometer_units",
    "magnetometer_units",
    "gyro_world_axes",
    "time_step",
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
"""Mistakes in the order in which they are named where several do as well and cost as much."""
