"""Repairs, changes of the readings or of the estimate that undo what a filter does wrong; and runs with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

import numpy as np

from lie_rigid_body.diagnosis.course import MARGIN, Course, Readings, readings
from lie_rigid_body.estimates.estimators import Estimator, called
from lie_rigid_body.evaluation.arguments import MIN_NORM
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, angles_between, named
from lie_rigid_body.evaluation.causes import BY_CODE, CAUSES, UP, Cause, undone
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.matched import Matched, MatchedRuns, error_of
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion

ALIKE: Final = 0.25
"""Largest ratio of the turn between two first attitudes of a filter to that between the true ones, where it does not
begin with its readings."""
SENSOR_READINGS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Names of the readings of each sensor, by the sensor's name in codes."""

MAX_NORM: Final = float(np.sqrt(np.finfo(np.float64).max))
"""Norm of a quaternion from which its square is beyond float64."""
DRIFT: Final = 0.1
"""Rate error of a drifting gyro, as a share of the body's mean rate: in a course it makes hundreds of times the floor
of the error."""


@short_dataclass(frozen=True)
class Repair:
    """A change of the readings, or of the estimate.

    Attributes
    ----------
    code : str
        The mistake that it undoes.
    text : str
        What is done, in as few characters as tell it: ``y x -z``.
    price : int
        Number of fitted constants.
    change : callable or None
        The readings that a filter with the mistake is to be given; None leaves them.
    fact : str
        The mistake in a sentence without a full stop.
    deed : str
        The repair in words, before what it leaves; of all but `JOINT` with the verb.
    constants : ndarray or None
        Constants of the cause that is undone in the estimate; None leaves the estimate.
    """

    code: str
    text: str
    price: int
    change: Callable[[Readings], Readings] | None = field(compare=False)
    fact: str
    deed: str
    constants: Array | None = field(default=None, compare=False)


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


def _on_world_axes(given: Readings) -> Readings:
    return given.changed(lambda gyro: quaternion.rotate(given.course.at(given.t_ns), gyro), "gyro")


JOINT: Final = Repair(
    "ahead_by_a_sample",
    "accelerometer and magnetometer one sample later",
    0,
    partial(_moved, ("accelerometer", "magnetometer"), -1),
    "The filter compares readings with the attitude before its gyro step, as most do",
    "With accelerometer and magnetometer one sample later",
)
"""Change for a filter that is ahead by one sample and otherwise right: it is no mistake, and has no price."""


def _axes() -> Iterator[Repair]:
    """Wrong axes of one sensor, with any permutation and signs, and of all sensors, with any such rotation."""
    for matrix in SIGNED_PERMUTATIONS[1:]:
        name = named(matrix).replace(",", "")
        wrong = "the axes of the {} in another order or sign" if name != "-x -y -z" else "the {} with the opposite sign"
        for sensor in SENSOR_READINGS:
            yield Repair(
                f"{sensor}_axes",
                name,
                0,
                partial(_multiplied, (sensor,), matrix),
                f"The filter takes {wrong.format(sensor)}",
                f"Given as {name} its readings leave",
            )
        if np.linalg.det(matrix) > 0.0:
            yield Repair(
                "body_axes",
                name,
                0,
                partial(_multiplied, tuple(SENSOR_READINGS), matrix),
                "The filter takes the axes of the body, of all sensors alike, in another order or sign",
                f"Given as {name} the readings leave",
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
                partial(_multiplied, (sensor,), value * np.eye(3)),
                fact,
                f"Multiplied by {value:.3g} they leave",
            )


def factor(value: float) -> Repair:
    """Repair of a wrong time step: the gyro's readings multiplied by a factor; ½ and 2 are no fitted constants."""
    plain = {2.0: ", as with the ½ of the quaternion's rate twice", 0.5: ", as without the ½ of the quaternion's rate"}
    return Repair(
        "time_step",
        f"gyro × {value:.6g}",
        0 if value in plain else 1,
        partial(_multiplied, ("gyro",), value * np.eye(3)),
        f"The filter turns by {1.0 / value:.4g} times what the gyro tells: a wrong time step{plain.get(value, '')}",
        f"With the gyro multiplied by {value:.5g} the readings leave",
    )


def drifting(sensor: str, share: float, given: Readings) -> Readings:
    """Readings of a gyro that drifts about the direction which only one sensor corrects.

    The drift is a tenth of the body's mean rate, about the magnetic field for the accelerometer, else about the
    vertical. The readings of the sensor are multiplied by a share.
    """
    axis = given.course.field / np.linalg.norm(given.course.field) if sensor == "accelerometer" else UP
    rate = DRIFT * given.course.turn * given.course.parameter("imu_rate") * axis
    drifts = quaternion.rotate(quaternion.conjugate(given.course.at(given.t_ns)), rate)
    return given.changed(lambda gyro: gyro + drifts, "gyro").changed(lambda rows: share * rows, SENSOR_READINGS[sensor])


def late(sensor: str, count: int) -> Repair:
    """Repair that moves the readings of one sensor in time by a number of samples."""
    size = f"{abs(count)} sample{'s' if abs(count) > 1 else ''}"
    return Repair(
        f"{sensor}_late",
        f"{size} {'earlier' if count > 0 else 'later'}",
        1,
        partial(_moved, (sensor,), count),
        f"The filter uses the readings of the {sensor} {size} too {'late' if count > 0 else 'early'}",
        "Moved by as many they leave",
    )


def of_output(cause: Cause, constants: Array) -> Repair:
    """A repair of the estimate by undoing a cause."""
    text = " ".join([*(f"{constant:.5g}" for constant in constants), cause.unit]) if cause.price else "undone"
    return Repair(cause.code, text, cause.price, None, cause.fact(constants), cause.deed(constants), constants)


def without(tracks: MatchedRuns, causes: Iterable[Cause], *, pairs: bool) -> Iterator[tuple[Repairs, float]]:
    """Undo each cause, or each pair whose first has no constant; yield the repairs and the error left."""
    for cause in causes:
        constants, error = cause.fitted(tracks)
        repair = of_output(cause, constants)
        yield (repair,), error
        if pairs and not cause.price:
            mended = [cause.undo(track, constants) for track in tracks]
            for second, left in without(mended, [other for other in CAUSES if other.code != cause.code], pairs=False):
                yield (repair, *second), left


def exact_repairs() -> tuple[Repair, ...]:
    """Every repair without a fitted constant, in the order of the table of mistakes."""
    world = Repair(
        "gyro_world_axes",
        "gyro on the world's axes",
        0,
        _on_world_axes,
        "The filter turns about the world's axes, as where the turn is multiplied on the wrong side",
        "Given on the world's axes its readings leave",
    )
    units = (repair for sensor in SENSOR_READINGS for repair in _units(sensor))
    return tuple(sorted((*_axes(), *units, world, factor(2.0), factor(0.5)), key=lambda each: ORDER.index(each.code)))


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
"""Order in which mistakes are named if several repairs do equally well at equal cost."""


@short_dataclass(frozen=True, eq=False)
class Answer:
    """Estimate of a filter in a course.

    Attributes
    ----------
    track : Matched
        Matched of the repaired and normalised attitudes beside the truth; the identity where one is broken.
    broken : ndarray of int64
        Numbers of the samples that are zero, or whose norm has no finite square.
    given : Estimate
        Estimate as the filter returned it.
    """

    track: Matched
    broken: Integers
    given: Estimate

    def error(self, begin: float = 1.0 / 3.0, end: float = 1.0) -> float:
        """RMS of the total error, rad, from one share of the samples to another; by default of the last two thirds."""
        return error_of([self.track.fraction(begin, end)])


def first_attitude(answers: Sequence[Answer]) -> list[float] | None:
    """The attitude with which a filter begins, if that is nearly the same where two bodies begin with others."""
    told = [answer.track.attitude_xyzw[0] for answer in answers]
    true = [answer.track.truth.at(answer.track.stamps_ns[:1])[0] for answer in answers]
    return told[0].tolist() if len(told) == 2 and angles_between(*told) < ALIKE * angles_between(*true) else None


@dataclass(frozen=True)
class Job:
    """One run of the filter: a course whose readings are repaired, and the estimate."""

    course: Course
    repairs: Repairs = ()

    def __call__(self, estimate: Estimator) -> Answer:
        """Run the filter, and repair its estimate.

        Raises
        ------
        FilterError
            With the line in the user's file, or with the shape; or if no attitude is of the last two thirds.
        """
        given = readings(self.course)
        for repair in self.repairs:
            given = repair.change(given) if repair.change else given
        found = called(estimate, given.run(), (self.course.rest_s + self.course.moving_s) / 3.0)
        norms = quaternion.norm(found.attitude_xyzw)
        broken = ~((norms > MIN_NORM) & (norms < MAX_NORM))
        attitude = np.where(broken[:, np.newaxis], (0.0, 0.0, 0.0, 1.0), found.attitude_xyzw)
        track = Matched(found.t_ns, quaternion.normalize(attitude), self.course)
        causes = [(BY_CODE[each.code], each.constants) for each in self.repairs if each.constants is not None]
        return Answer(undone(track, causes), np.flatnonzero(broken), found)
