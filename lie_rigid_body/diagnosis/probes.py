"""Probes: what a filter can do, each by courses with one thing in the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.course import HOLD, REST, TURN, Course, Headings, readings
from lie_rigid_body.diagnosis.filter_runs import UNJUDGED
from lie_rigid_body.diagnosis.noise_probes import covariance, first_given, noise, of_single_sets
from lie_rigid_body.diagnosis.probing import (
    Courses,
    ProbeRow,
    Probing,
    in_degrees,
    limited,
    tolerated,
    worst,
)
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.diagnosis.trials import NEAR
from lie_rigid_body.evaluation.remarks import NOT_UNIT, Turns
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

GYRO_BIAS: Final = math.radians(1.0)
"""Size of a constant error of the gyro, rad/s."""
BIAS: Final = GYRO_BIAS / np.sqrt(3.0) * np.array([1.0, -1.0, 1.0])
"""That error on each axis, rad/s."""
VECTOR_ERROR: Final = 0.05
"""Constant error of the accelerometer and of the magnetometer, share of the vector."""
BIAS_PEAK: Final = (0.5 + 0.5 * 5.0**0.5) ** 0.5
"""Largest response of a steady Kalman filter of an angle and a gyro bias, (√2 s + 1) / (s² + √2 s + 1). It enlarges an
error of the vectors that rotates with the body by no more."""
SLOW_RATE: Final = 0.1
"""Body rate of a slow motion with gaps, rad/s."""
SLOW_RATES: Final = (0.1, 0.05, 0.02)
"""Body rates of slow motions, rad/s."""
MINUTE: Final = 60.0 - REST
"""Length of a motion that ends a minute after the course begins to count, s."""
FIELDS_T: Final = (25e-6, 65e-6)
"""Sizes of the weakest and of the strongest field of the Earth, T."""
DIPS: Final = (0.0, 75.0, -75.0)
"""Dips of a field at the equator and near the poles, degrees."""
LEARNING_S: Final = 60.0
"""Least rest in which a filter learns the bias of the gyro before it is rotated through eight headings, s."""
RESTS: Final = (0.0, REST, 3.0 * REST)
"""Rests before the motion that are compared, s."""
SAME: Final = 1e-9
"""Largest difference of two estimates, rad, that count as the same."""


def _follows(search: Search) -> Probing:
    """Whether the filter, with its mistakes repaired, follows a motion with perfect sensors."""
    [answer] = yield [search.course]
    chosen = search.chosen
    what = "its mistakes repaired" if chosen.codes else "perfect sensors"
    settled = f"; it needs {search.settles_s:.0f} s at rest to settle" * (search.settles_s > 0.0)
    passed, said, value = limited(f"with {what} its error is", chosen.error, search.floor, settled)
    if passed or chosen.codes or chosen.error <= NEAR * search.chatter:
        return True, said, value
    if search.is_by_chance:
        return False, f"{said}; two equal runs differ by {in_degrees(search.scatter)}: no repair is looked for", value
    turns = Turns(answer.track)
    remark = turns.stuck() or turns.mixed() or turns.other()
    return False, f"{said}; {remark.code}: {remark.message}" if remark else said, value


def _at(course: Course, attitude_xyzw: Array, **parameters: object) -> Course:
    """A course that begins with an attitude."""
    return course.of_scenario(initial_attitude_xyzw=attitude_xyzw.tolist(), **parameters)


def _half_turn(search: Search) -> Courses:
    """Motions whose attitude is half a turn about an axis of the world, in the middle of the course."""
    course = search.course
    start, midst = course.at(np.array([0, course.begin_ns + round(5e8 * course.counted_s)]))
    starts = quaternion.multiply(quaternion.multiply(np.eye(4)[:3], quaternion.conjugate(midst)), start)
    return [search.settled(_at(course, each)) for each in starts]


def _cube() -> Any:
    """The 24 rotations of a cube."""
    return scipy.spatial.transform.Rotation.create_group("O")


def _exact_starts(search: Search) -> Probing:
    """Two seconds at rest in each rotation of a cube, without a declination, and with readings without round-off."""
    field = [0.0, float(np.hypot(*search.course.field[:2])), search.course.field[2]]
    rest = replace(search.course, rest_s=0.0, settle_s=0.0, moving_s=2.0, is_rounded=True)
    answers = yield [
        _at(rest, rotation.as_quat(), initial_body_rate=[0.0] * 3, magnetic_field=field) for rotation in _cube()
    ]
    failed = sum(answer.broken.size > 0 for answer in answers)
    what = "of 24 rotations of a cube, at rest and read without round-off, without an attitude:"
    return limited(what, failed, 0.0, unit="")


def _starts(search: Search) -> Courses:
    """The ordinary motion without a rest to settle, and those that begin rotated by each rotation of a cube."""
    course = replace(search.course, settle_s=0.0)
    start = scipy.spatial.transform.Rotation.from_quat(course.scenario.start().attitude_xyzw)
    return [course, *(_at(course, (start * rotation).as_quat()) for rotation in _cube())]


def _converges(search: Search) -> Probing:
    plain, *others = yield _starts(search)
    most = max(search.floor, NEAR * plain.error(2.0 / 3.0))
    return limited("from the worst of 24 first attitudes its error at the end is", worst(others, 2.0 / 3.0), most)


def _first_attitude(search: Search) -> Probing:
    """Largest error of the first answer; where it is, and how long until the filter errs as little as later on."""
    _, *starts = yield _starts(search)
    errors = [answer.track.error().total for answer in starts]
    limit = tolerated(search)
    off = [error[0] for error in errors if error[0] > limit]
    if not off:
        return True, "", 0.0
    last = max(answer.t_s[error > limit].max(initial=0.0) for answer, error in zip(starts, errors, strict=True))
    is_down = all(
        error[0] <= limit or quaternion.to_matrix(answer.track.truth_xyzw[0])[2, 2] < 0.0
        for answer, error in zip(starts, errors, strict=True)
    )
    return limited(
        f"Of {len(starts)} first answers {len(off)}{', all with z down,' * is_down} are off, by "
        f"{in_degrees(float(np.median(off)))} in the median, for {'more than ' * bool(last >= starts[0].t_s[-1])}"
        f"{last:.3g} s at the longest, and at most by",
        max(off),
        limit,
    )


def _other_fields(search: Search) -> Courses:
    """The ordinary course in fields of other sizes."""
    field = search.course.field
    return _in_fields(search, np.outer(FIELDS_T, field / np.linalg.norm(field)))


def _dipping_fields(search: Search) -> Courses:
    """The ordinary course in fields of the same size and of other dips."""
    field = search.course.field
    level = field[:2] / (np.hypot(*field[:2]) or 1.0)
    dips = np.radians(DIPS)
    return _in_fields(search, np.linalg.norm(field) * np.column_stack([np.outer(np.cos(dips), level), -np.sin(dips)]))


def _in_fields(search: Search, fields: Array) -> Courses:
    """The ordinary course in other fields, shape (n, 3), T."""
    return [search.settled(search.course.of_scenario(magnetic_field=each)) for each in fields.tolist()]


def _at_rate(search: Search, rate: float, moving_s: float) -> Course:
    """The ordinary course with a slower body."""
    body_rate = search.course.scenario.start().body_rate
    slow = search.course.of_scenario(initial_body_rate=(rate / norm(body_rate) * body_rate).tolist())
    return search.settled(replace(slow, moving_s=moving_s))


def _headings(search: Search) -> Probing:
    """A nearly level body that is rotated through eight headings, with a bias of the gyro that is learnt at rest."""
    level = quaternion.exp(np.radians([3.0, -2.0, 10.0]))
    scenario = _at(search.course, level).scenario
    course: Course = Headings(scenario, settle_s=LEARNING_S + search.settles_s, off=_biased(search).off)
    is_right = search.chosen.error <= search.floor and not any(each.change for each in search.chosen.mistakes)
    if search.course.ramp_s and is_right:
        course = max(course, search.settled(course, course.settle_s), key=lambda each: each.settle_s)
    [answer] = yield [course] * bool(search.course.ramp_s)
    errors = answer.track.error().total
    before_end = answer.t_s - REST - (TURN + HOLD) * np.arange(1, 9)[:, np.newaxis]
    held = [rms(errors[(each > -0.5 * HOLD) & (each < 0.0)]) for each in before_end]
    most = max(search.floor, min(4.0 * float(np.median(held)), UNJUDGED))
    return limited("in the worst of eight headings, each held for 30 s, its error is", max(held), most)


def _biased(search: Search) -> Course:
    """A minute with a gyro bias."""
    return replace(search.course, moving_s=MINUTE, off=(("gyro", tuple(BIAS.tolist())),))


def _gyro_bias(search: Search) -> Probing:
    """Error of the last quarter; its limit follows from the second, and from the rotation that the bias alone makes.

    A twentieth of that is allowed: smoothers err at both ends, and more than in the second quarter.
    """
    [answer] = yield [_biased(search)]
    second, last = (answer.error(begin, begin + 0.25) for begin in (0.25, 0.75))
    drift = GYRO_BIAS * 52.5
    most = max(search.floor, 0.05 * drift, min(1.5 * second, 0.5 * drift))
    removed = last <= min(most, max(tolerated(search), 0.1 * second))
    return limited(
        "with a gyro off by 1°/s, in the last quarter of 60 s, its error is",
        last,
        most,
        f"; it {'removes the bias' if removed else 'keeps an error that the bias makes'}" * ("gyro" not in search.deaf),
    )


def _bias_estimate(search: Search) -> Probing:
    """The estimated bias beside the one put in, in the last quarter: sign, unit and size."""
    [answer] = yield [_biased(search)] * (first_given(search).gyro_bias is not None)
    told = answer.given.gyro_bias
    last = np.mean(told[-len(told) // 4 :], axis=0)
    ratio = float(last @ BIAS / GYRO_BIAS**2)
    is_along = norm(last - ratio * BIAS) <= 0.5 * norm(last)
    faults = {
        "in degrees a second": is_along and 0.5 < abs(ratio) * GYRO_BIAS < 1.5,
        "with the opposite sign": is_along and ratio < -0.5,
        "as it never moves": np.ptp(told, axis=0).max() < 0.01 * GYRO_BIAS,
    }
    passed = bool(norm(last - BIAS) <= 0.5 * GYRO_BIAS)
    fault = " and ".join(words for words, is_so in faults.items() if is_so)
    fault = fault or f"of another {'size' if is_along else 'direction'}"
    said = f"of a gyro bias of 1°/s its estimate is, after 60 s, {ratio:.3g} times as much"
    return passed, said if passed else f"{said}, {fault}", ratio


def _linear_acceleration(search: Search) -> Probing:
    """A carried body, for a minute: a filter that averages its accelerations needs some seconds."""
    course = replace(search.course, is_carried=True, moving_s=MINUTE)
    [answer] = yield [course]
    return limited(
        "carried with 2 m/s² along each axis its error is",
        answer.error(),
        max(search.floor, 0.5 * of_single_sets(search, course, answer)),
        "; the limit is half of what single sets of readings give",
    )


def _off(search: Search, name: str, sensor: str) -> Probing:
    """Courses with a constant error of a vector along each axis; none for a field without a level part."""
    level = float(np.hypot(*search.course.field[:2]) / np.linalg.norm(search.course.field))  # cosine of the dip
    size = VECTOR_ERROR * np.linalg.norm(readings(search.course).vectors[name][0])
    errors = (size * np.eye(3)).tolist() if level > VECTOR_ERROR else []
    answers = yield [replace(search.course, off=((name, tuple(error)),)) for error in errors]
    most = max(BIAS_PEAK * float(np.arcsin(VECTOR_ERROR / level)), tolerated(search))
    return limited(f"with {sensor} off by {VECTOR_ERROR:.0%} along one axis its error is", worst(answers), most)


def _dropouts(search: Search) -> Probing:
    [answer] = yield [replace(_at_rate(search, SLOW_RATE, MINUTE), gaps_s=(10.0, 20.0, 30.0))]
    errors = answer.track.error().total
    last = rms(errors[answer.t_s >= 40.0])
    most = max(search.floor, 0.5 * errors[answer.t_s >= 31.0].max(initial=0.0))
    passed, said, value = limited("after gaps of a second in a slow motion its error at the end is", last, most)
    return (False, f"{said}: attitudes are not finite", value) if answer.broken.size else (passed, said, value)


def _long_run(search: Search) -> Probing:
    [answer] = yield [search.long]
    most = max(search.floor, NEAR * answer.error(0.1, 0.2))
    return limited("in the last tenth of a run ten times as long its error is", answer.error(0.9), most)


def _repeatable(search: Search) -> Probing:
    first, second = yield _twice(search.course)
    return limited(
        "called twice it gives estimates that differ by",
        first.track.max_difference(second.track),
        SAME,
        "; one that differs goes by a clock of its own, or by the order in which readings arrive",
        " rad",
    )


def _twice(course: Course) -> Courses:
    """Two courses with the same readings: the seed is that of a noise which they do not have."""
    return [course, replace(course, seed=1)]


def _causal(search: Search) -> Probing:
    """A course on which the gyro has a bias, the same again, and its first half.

    With perfect sensors smoothers and causal filters alike give the truth.
    """
    whole = replace(_biased(search), moving_s=search.course.moving_s)
    first, again, half = yield [*_twice(whole), replace(whole, moving_s=0.5 * whole.moving_s)]
    return limited(
        "The estimate uses later readings, as smoothers do: without them it is another, by up to",
        first.track.max_difference(half.track),
        SAME if first.track.max_difference(again.track) <= SAME else np.inf,
    )


def _norms(search: Search) -> Probing:
    [answer] = yield [search.course]
    norms = quaternion.norm(np.delete(answer.given.attitude_xyzw, answer.broken, axis=0))
    off = np.abs(norms**2 - 1.0).max(initial=0.0)
    return limited("the square of the quaternions' norm is off 1 by", off, NOT_UNIT, unit="")


def _finite(search: Search) -> Probing:
    [answer] = yield [search.course]
    broken = answer.broken
    first = f"; the first is sample {broken[0]}" if broken.size else ""
    return limited("attitudes that are NaN, infinite or zero:", broken.size, 0.0, first, "")


def _needs_rest(search: Search) -> Probing:
    """Rests of several lengths before the motion, of a filter that settles at once."""
    settles = search.settles_s and not search.needs_rest
    rests = RESTS if search.course.ramp_s and not settles else ()
    without, plain, longer = yield [replace(search.course, settle_s=0.0, rest_s=rest_s) for rest_s in rests]
    return limited(
        f"without a rest before the motion, or after {REST:g} s, its error is",
        max(without.error(), plain.error()),
        max(search.floor, NEAR * min(plain.error(), longer.error())),
        f"; after {3.0 * REST:g} s it is {in_degrees(longer.error())}",
    )


def _alternating(search: Search) -> Courses:
    """Steps of 2/3 and 4/3 of a period, as many of each, so that a filter which takes their median takes the period."""
    course = search.course
    odd = 0.5 * (1 - course.updates % 2) / course.rate
    return [replace(course, grid="alternating", moving_s=course.moving_s + odd)]


def _within(said: str, courses: Callable[[Search], Courses], step: float = 0.0) -> Callable[[Search], Probing]:
    """Judge the worst of several runs by the floor, twice the error of the plain run, or a share of a step's turn."""

    def probing(search: Search) -> Probing:
        answers = yield courses(search)
        return limited(said, worst(answers), tolerated(search, step * search.course.turn))

    return probing


PROBES: Final = (
    ProbeRow("follows", _follows, needs_error=False),
    ProbeRow("half_turn", _within("through half turns from the world's axes its error is", _half_turn)),
    ProbeRow("exact_starts", _exact_starts, needs_error=False),
    ProbeRow("other_fields", _within("in fields of 25 and 65 µT its error is", _other_fields)),
    ProbeRow("headings", _headings, needs_error=False),
    ProbeRow(
        "irregular_steps",
        _within("with steps of 2/3 and 4/3 of a period in turn its error is", _alternating, 1.0 / 3.0),
    ),
    ProbeRow("converges", _converges),
    ProbeRow("gyro_bias", _gyro_bias),
    ProbeRow("bias_estimate", _bias_estimate),
    ProbeRow(
        "slow",
        _within(
            "of a body that turns by 0.1, 0.05 and 0.02 rad/s for a minute its error is",
            lambda search: [_at_rate(search, rate, 60.0) for rate in SLOW_RATES],
        ),
    ),
    ProbeRow("linear_acceleration", _linear_acceleration),
    ProbeRow("accelerometer_bias", lambda search: _off(search, "specific_force", "an accelerometer")),
    ProbeRow("hard_iron", lambda search: _off(search, "field", "a magnetometer")),
    ProbeRow("noise", noise),
    ProbeRow("dropouts", _dropouts),
    ProbeRow("long_run", _long_run),
    ProbeRow("repeatable", _repeatable, needs_error=False),
    ProbeRow("norm", _norms, needs_error=False),
    ProbeRow("finite", _finite, needs_error=False),
    ProbeRow("covariance", covariance),
    ProbeRow("needs_rest", _needs_rest),
)
"""The probes in the order in which they are told."""
NOTES: Final = (
    ProbeRow("first_attitude", _first_attitude),
    ProbeRow(
        "fixed_field",
        _within(
            "In fields that dip by 0° and ±75° it keeps another field in its code, or hardly corrects: its error is",
            _dipping_fields,
        ),
    ),
    ProbeRow(
        "constant_step",
        _within(
            "The filter takes all steps for equal, which matters where readings are late or lost: with steps at "
            "random, 2/3 to 4/3 of a period, its error is",
            lambda search: [replace(search.course, grid="walk")],
            1.0 / 3.0,
        ),
    ),
    ProbeRow("causal", _causal),
)
"""Probes that are told as notes where they are not passed."""
