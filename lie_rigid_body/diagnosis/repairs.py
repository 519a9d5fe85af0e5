"""Repairs, changes of the readings or of the estimate that undo what a filter does wrong; and runs with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any, Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.course import MARGIN, Course, Readings, readings
from lie_rigid_body.estimates.estimators import Estimator, called
from lie_rigid_body.evaluation.arguments import MIN_NORM
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, angles_between, named
from lie_rigid_body.evaluation.causes import CAUSES, EULER_ORDERS, IDENTITY, NED, UP, Cause, euler_angles, undone
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.matched import Matched, MatchedRuns, error_of
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion

HALVED: Final = 0.5
"""Largest share of the error that a repair may leave if it brings the error below the floor."""
CONSTANT: Final = 0.95
"""Least ratio of a constant in the last third of a run to that in the first, of a filter that does not converge."""
ALIKE: Final = 0.25
"""Largest ratio of the turn between two first attitudes of a filter to that between the true ones, where it does not
begin with its readings."""
STILL: Final = float(np.radians(0.01))
"""Largest change of the mean answer from one second at rest to the next, rad, of a filter that has settled."""
CALM: Final = 5
"""Number of such seconds after which it has settled."""
SENSOR_READINGS: Final = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
"""Names of the readings of each sensor, by the sensor's name in codes."""

MAX_NORM: Final = float(np.sqrt(np.finfo(np.float64).max))
"""Norm of a quaternion from which its square is beyond float64."""
PERTURBED: Final = float(np.radians(2.0))
"""Angle by which the readings of a sensor are turned to see whether a filter hears it, rad."""
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

    @property
    def is_near_another(self) -> bool:
        """Whether it is a factor of the gyro that differs by `SCALE` at most from one without a constant, or from 1."""
        if self.code not in ("time_step", "gyro_scale"):
            return False
        others = (1.0, 0.5, 2.0, *(f for unit in _UNITS["gyro"].values() for f in (unit, 1.0 / unit)))
        return self.price > 0 and any(abs(float(self.text.split()[-1]) / other - 1.0) <= SCALE for other in others)


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
    A = quaternion.to_matrix(quaternion.multiply(world, given.course.at(given.t_ns)))
    roll = np.arctan2(A[:, 2, 1], A[:, 2, 2])
    level = np.maximum(np.hypot(A[:, 2, 1], A[:, 2, 2]), 1e-6)  # cosine of the pitch
    p, q, r = given.vectors["gyro"].T
    across = np.sin(roll) * q + np.cos(roll) * r
    rates = [p - A[:, 2, 0] / level * across, np.cos(roll) * q - np.sin(roll) * r, across / level]
    return given.changed(lambda gyro: np.stack(rates, axis=1), "gyro")


JOINT: Final = Repair(
    "ahead_by_a_sample",
    "accelerometer and magnetometer one sample later",
    0,
    partial(_moved, ("accelerometer", "magnetometer"), -1),
    "The filter compares readings with the attitude before its gyro step, as most do",
    "With accelerometer and magnetometer one sample later",
)
"""Change for a filter that is ahead by one sample and otherwise right: it is no mistake, and has no price."""


def text_of(matrix: Array) -> str:
    """Text of a permutation of axes with signs: ``y x -z``."""
    return named(matrix).replace(",", "")


def _axes() -> Iterator[Repair]:
    """Wrong axes of one sensor, with any permutation and signs, and of all sensors, with any such rotation."""
    for matrix in SIGNED_PERMUTATIONS[1:]:
        name = text_of(matrix)
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
    """Repair of a wrong time step: the gyro's readings multiplied by a factor; ½ and 2 are no fitted constants.

    Within 2 % of 1 it is a property of the filter, not a mistake of its user.
    """
    plain = {2.0: ", as with the ½ of the quaternion's rate twice", 0.5: ", as without the ½ of the quaternion's rate"}
    return Repair(
        "gyro_scale" if abs(value - 1.0) <= SCALE else "time_step",
        f"gyro × {value:.6g}",
        0 if value in plain else 1,
        partial(_multiplied, ("gyro",), value * np.eye(3)),
        f"The filter rotates {1.0 / value:.4g} times as far as the gyro says: a wrong time step{plain.get(value, '')}",
        f"With the gyro multiplied by {value:.5g} the readings leave",
    )


def drifting(sensor: str, share: float, given: Readings) -> Readings:
    """Readings of a gyro that drifts about the direction which only one sensor corrects.

    The drift is a tenth of the body's mean rate, about the magnetic field for the accelerometer, else about the
    vertical. The readings of the sensor are multiplied by a share. For the gyro there is no drift: it is heard where
    the filter errs without it.
    """
    axis = given.course.field / np.linalg.norm(given.course.field) if sensor == "accelerometer" else UP
    share_of_rate = 0.0 if sensor == "gyro" else DRIFT
    rate = share_of_rate * given.course.turn * given.course.rate * axis
    drifts = quaternion.rotate(quaternion.conjugate(given.course.at(given.t_ns)), rate)
    return given.changed(lambda gyro: gyro + drifts, "gyro").changed(lambda rows: share * rows, SENSOR_READINGS[sensor])


def perturbed(sensor: str, since_ns: int, given: Readings) -> Readings:
    """Readings of a sensor, turned by `PERTURBED` about a diagonal of the body from a stamp on; of a gyro half of them.

    So small a turn passes every gate that a filter may have.
    """
    stamps = given.field_t_ns if sensor == "magnetometer" else given.t_ns
    turn = quaternion.exp(PERTURBED / np.sqrt(3.0) * np.ones(3))
    return given.changed(
        lambda rows: np.where(
            (stamps >= since_ns)[:, np.newaxis], 0.5 * rows if sensor == "gyro" else quaternion.rotate(turn, rows), rows
        ),
        SENSOR_READINGS[sensor],
    )


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
    if cause is OUTPUT_AXES:
        text = _name_of_axes(constants)
    return Repair(cause.code, text, cause.price, None, cause.fact(constants), cause.deed(constants), constants)


OF_VECTOR: Final = [P for P in SIGNED_PERMUTATIONS[1:] if np.trace(P) > -3.0]
"""Permutations with signs of the vector part of a quaternion, but the inverse."""


def _name_of_axes(chosen: Array) -> str:
    return text_of(OF_VECTOR[int(chosen[0])])


def _vector_permuted(track: Matched, chosen: Array) -> Matched:
    matrix = np.eye(4)
    matrix[:3, :3] = OF_VECTOR[int(chosen[0])]
    return replace(track, attitude_xyzw=track.attitude_xyzw @ matrix.T)


def _composed(angles: Array, chosen: Array) -> Array:
    """Attitudes of angles with signs, put together about the axes in another order than they were taken in."""
    wrong, right, sign = (int(number) for number in chosen)
    places = [EULER_ORDERS[wrong].index(axis) for axis in EULER_ORDERS[right]]
    signed = (angles * SIGNS[sign])[..., places].reshape(-1, 3)
    found = scipy.spatial.transform.Rotation.from_euler(EULER_ORDERS[right], signed).as_quat()
    return np.asarray(found).reshape(*angles.shape[:-1], 4)


def _best_order(tracks: MatchedRuns) -> list[Array]:
    """The orders and signs of Euler angles that leave the least error."""
    few = [track.thinned() for track in tracks]
    truth = np.concatenate([track.truth_xyzw for track in few])
    of_order = [np.concatenate([euler_angles(track, order) for track in few]) for order in EULER_ORDERS]
    every = np.ndindex(len(EULER_ORDERS), len(EULER_ORDERS), len(SIGNS))
    chosen = [np.array(each) for each in every if each[0] != each[1] or each[2]]
    alike = [np.sum(np.sum(_composed(of_order[each[0]], each) * truth, axis=-1) ** 2) for each in chosen]
    return [chosen[int(np.argmax(alike))]]


def _order_told(c: Array) -> str:
    wrong, right, sign = (int(number) for number in c)
    signs = "".join(" " + ("-" if s < 0 else "") + axis for s, axis in zip(SIGNS[sign], "xyz", strict=True))
    signed = f", of the angles about{signs}" * (sign > 0)
    if wrong == right:
        return f"have other signs than those of a turn about the axes{signs}"
    wrong_order, right_order = (" ".join(EULER_ORDERS[number].lower()) for number in (wrong, right))
    return f"are put together as {wrong_order} instead of {right_order}{signed}"


SIGNS: Final = np.array(list(product((1.0, -1.0), repeat=3)))
"""Signs of three angles, shape (8, 3)."""
EULER: Final = Cause(
    "euler_order",
    0,
    lambda track, chosen: replace(
        track, attitude_xyzw=_composed(euler_angles(track, EULER_ORDERS[int(chosen[0])]), chosen)
    ),
    _best_order,
    lambda c: f"The three Euler angles {_order_told(c)}",
    lambda c: "Put together in the right way they leave",
)
OUTPUT_AXES: Final = Cause(
    "output_axes",
    0,
    _vector_permuted,
    lambda tracks: [np.array([float(number)]) for number in range(len(OF_VECTOR))],
    lambda c: "The vector part of the quaternion has its numbers in another order or with other signs",
    lambda c: f"Given as {_name_of_axes(c)} they leave",
)
OUTPUTS: Final = (*(EULER if cause.code == EULER.code else cause for cause in CAUSES), OUTPUT_AXES)
"""Causes in the output that are undone."""
CODED: Final = {cause.code: cause for cause in OUTPUTS}


def _is_converging(cause: Cause, tracks: MatchedRuns) -> bool:
    """Whether the constant of a cause is smaller at the end than at the beginning: then the filter still converges."""
    none = 1.0 if cause.code == "clock_rate" else 0.0
    thirds = ([track.fraction(begin, begin + 1.0 / 3.0) for track in tracks] for begin in (0.0, 2.0 / 3.0))
    first, last = (float(np.linalg.norm(cause.fitted(third)[0] - none)) for third in thirds)
    return last < CONSTANT * first


def without(tracks: MatchedRuns, causes: Iterable[Cause], *, pairs: bool) -> Iterator[tuple[Repairs, float]]:
    """Undo each cause, or each pair whose first has no constant; yield the repairs and the error left."""
    before = error_of(tracks)
    for cause in causes:
        constants, error = cause.fitted(tracks)
        if cause.price and error < HALVED * before and _is_converging(cause, tracks):
            continue
        repair = of_output(cause, constants)
        yield (repair,), error
        if pairs and not cause.price:
            mended = [cause.undo(track, constants) for track in tracks]
            for second, left in without(mended, [other for other in OUTPUTS if other.code != cause.code], pairs=False):
                yield (repair, *second), left


def exact_repairs() -> tuple[Repair, ...]:
    """Every repair without a fitted constant, in the order of the table of mistakes."""
    worlds = (
        Repair(
            "gyro_world_axes",
            f"gyro on the axes {text_of(matrix)} of the world",
            0,
            partial(_on_world_axes, matrix),
            "The filter rotates about the world's axes, as where the rotation is multiplied on the wrong side",
            "Given on the world's axes its readings leave",
        )
        for matrix in SIGNED_PERMUTATIONS
        if np.linalg.det(matrix) > 0.0
    )
    exchanged = Repair(
        "sensors_exchanged",
        "gyro and accelerometer exchanged",
        0,
        _exchanged,
        "The filter takes the readings of the gyro for those of the accelerometer, and these for the gyro's",
        "Exchanged they leave",
    )
    euler = (
        Repair(
            "euler_rates",
            f"rates of roll, pitch and yaw, z {side}",
            0,
            partial(_as_euler_rates, world),
            "The filter takes the readings of the gyro for the rates of roll, pitch and yaw",
            "Turned into these its readings leave",
        )
        for side, world in (("up", IDENTITY), ("down", NED))
    )
    units = (repair for sensor in SENSOR_READINGS for repair in _units(sensor))
    every = (*_axes(), *units, exchanged, *euler, *worlds, factor(2.0), factor(0.5))
    return tuple(sorted(every, key=lambda each: ORDER.index(each.code)))


FITTED: Final[dict[str, tuple[Callable[[Any], Repair], Vector]]] = {
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


@short_dataclass(eq=False)
class Answer:
    """Estimate of a filter in a course.

    Attributes
    ----------
    track : Matched
        Repaired and normalised attitudes of the part of the course that counts, beside the truth; the identity where
        one is broken.
    broken : ndarray of int64
        Numbers of the samples that are zero, or whose norm has no finite square.
    given : Estimate
        Estimate as the filter returned it, of the same part.
    settled_s : float
        Time at rest after which the answers stand still, s; infinite where that is not seen.
    restless : float
        RMS of their motion about the mean of each second then, rad.
    """

    track: Matched
    broken: Integers
    given: Estimate
    settled_s: float
    restless: float

    @property
    def t_s(self) -> Array:
        """Times since the first sample that counts, s, shape (N,)."""
        return np.asarray((self.track.stamps_ns - self.track.stamps_ns[0]) / 1e9)

    def error(self, begin: float = 1.0 / 3.0, end: float = 1.0) -> float:
        """RMS of the total error, rad, from one share of the samples to another; by default of the last two thirds."""
        return error_of([self.track.fraction(begin, end)])


def first_attitude(answers: Sequence[Answer]) -> Array | None:
    """The attitude with which a filter begins, if that is nearly the same where two bodies begin with others."""
    told = [answer.track.attitude_xyzw[0] for answer in answers]
    true = [answer.track.truth_xyzw[0] for answer in answers]
    return told[0] if len(told) == 2 and angles_between(*told) < ALIKE * angles_between(*true) else None


def at_rest(stamps_ns: Integers, attitude_xyzw: Array) -> tuple[float, float]:
    """Time at rest after which the answers stand still, s, and RMS of their motion in the last calm seconds, rad.

    A second is calm where the mean of its answers is within `STILL` of that of the second before. The time is infinite
    where fewer than `CALM` calm seconds are there.
    """
    second, first = np.unique(stamps_ns // 10**9, return_index=True)
    if len(second) <= CALM:
        return np.inf, 0.0
    matrices = quaternion.to_matrix(attitude_xyzw)
    counts = np.diff([*first, len(matrices)])
    mean = np.add.reduceat(matrices, first, axis=0) / counts[:, np.newaxis, np.newaxis]
    moved = _angle(np.diff(mean, axis=0))
    restless = np.flatnonzero(~(moved <= STILL))
    begin = int(restless[-1]) + 1 if restless.size else 0
    settled = float(second[begin]) if len(moved) - begin >= CALM else np.inf
    return settled, rms(_angle(matrices - np.repeat(mean, counts, axis=0))[first[-CALM] :])


def _angle(difference: Array) -> Array:
    """Angle of the small rotation between matrices, rad, from their difference, shape (N, 3, 3)."""
    return np.asarray(np.sqrt(0.5) * np.linalg.norm(difference, axis=(1, 2)))


@dataclass(frozen=True)
class Job:
    """One run of the filter: a course whose readings are repaired, and the estimate.

    Attributes
    ----------
    course : Course
    repairs : tuple of Repair
    is_level : bool
        Whether the error is that of the vertical alone, as of a filter without a magnetometer.
    """

    course: Course
    repairs: Repairs = ()
    is_level: bool = False

    def __call__(self, estimate: Estimator) -> Answer:
        """Run the filter, and repair its estimate.

        Raises
        ------
        FilterError
            With the line in the user's file, or with the shape; or if no attitude is of the last two thirds.
        """
        course = self.course
        given = readings(course)
        for repair in self.repairs:
            given = repair.change(given) if repair.change else given
        found = called(estimate, given.run(), course.settle_s + course.counted_s / 3.0)
        norms = quaternion.norm(found.attitude_xyzw)
        broken = ~((norms > MIN_NORM) & (norms < MAX_NORM))
        attitude = quaternion.normalize(np.where(broken[:, np.newaxis], IDENTITY, found.attitude_xyzw))
        rest = found.t_ns < 10**9 * int(course.settle_s + course.rest_s)
        counted = slice(int(np.searchsorted(found.t_ns, course.begin_ns)), None)
        track = Matched(found.t_ns[counted], attitude[counted], course, origin_ns=0, is_level=self.is_level)
        causes = [(CODED[each.code], each.constants) for each in self.repairs if each.constants is not None]
        return Answer(
            undone(track, causes),
            np.flatnonzero(broken[counted]),
            found[counted],
            *at_rest(found.t_ns[rest], attitude[rest]),
        )
