"""Probes: what a filter can do, each by courses with one thing in the way."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.answers import Answer
from lie_rigid_body.diagnosis.course import HOLD, REST, TURN, Course, Headings, readings
from lie_rigid_body.diagnosis.search import GRADE_OF_NOISE, UNJUDGED, Search
from lie_rigid_body.diagnosis.trials import NEAR
from lie_rigid_body.evaluation import CramerRaoBound
from lie_rigid_body.evaluation.attitudes import error_vectors
from lie_rigid_body.evaluation.ensemble_consistency import ensemble_consistency
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.evaluation.remarks import NOT_UNIT, Turns
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.runs import simulate

GYRO_BIAS: Final = float(np.radians(1.0))
"""Size of a constant error of the gyro, rad/s."""
BIAS: Final = GYRO_BIAS / np.sqrt(3.0) * np.array([1.0, -1.0, 1.0])
"""That error on each axis, rad/s."""
VECTOR_ERROR: Final = 0.05
"""Constant error of the accelerometer and of the magnetometer, share of the vector."""
BIAS_PEAK: Final = (0.5 + 0.5 * 5.0**0.5) ** 0.5
"""Largest response of a steady Kalman filter of an angle and a gyro bias, (√2 s + 1) / (s² + √2 s + 1). It enlarges an
error of the vectors that turns with the body by no more."""
SLOW_RATE: Final = 0.1
"""Body rate of a slow motion with gaps, rad/s."""
SLOW_RATES: Final = (0.1, 0.05, 0.02)
"""Body rates of slow motions, rad/s."""
FIELDS_T: Final = (25e-6, 65e-6)
"""Sizes of the weakest and of the strongest field of the Earth, T."""
DIPS: Final = (0.0, 75.0, -75.0)
"""Dips of a field at the equator and near the poles, degrees."""
LEARNING_S: Final = 60.0
"""Least rest in which a filter learns the bias of the gyro before it is turned through eight headings, s."""
_RESTS: Final = (0.0, REST, 3.0 * REST)
"""Rests before the motion that are compared, s."""
SEEDS: Final = 12
"""Short runs with noise by which a covariance is judged, and as many others. Of twenty right covariances one is called
inconsistent by chance, and two of these verdicts are not."""
SHORT_S: Final = 5.0
"""Length of the motion of a short run with noise, s."""
JUDGED: Final = 20
"""Number of samples of a short run by which a covariance is judged."""


SAME: Final = 1e-9
"""Largest difference of two estimates, rad, that count as the same."""
Courses = list[Course]
"""Courses of a probe, in the order in which their answers are judged."""
Answers = Sequence[Answer]
"""Answers of the filter to these courses."""
Judged = tuple[bool | None, str, float]
"""Whether a probe is passed, None where it is not judged; what is said of it, and the number that was judged."""


@short_dataclass(frozen=True)
class Probe:
    """Whether a filter has an ability.

    Attributes
    ----------
    code : str
    passed : bool or None
        None where it is not judged.
    message : str
    value : float or None
        The number that was judged: an error in degrees, if the message tells nothing else.
    """

    code: str
    passed: bool | None
    message: str
    value: float | None = None


class ProbeRow(NamedTuple):
    """A probe: its code, the courses that are run, and what is judged; without courses it is not told.

    Attributes
    ----------
    code : str
    courses : callable
    judge : callable
    needs_error : bool
        Whether it is judged beside the error of the filter, and says nothing where that is above `UNJUDGED`.
    """

    code: str
    courses: Callable[[Search], Courses]
    judge: Callable[[Search, Answers], Judged]
    needs_error: bool = True

    def told(self, search: Search, answers: Sequence[Answer | FilterError]) -> Probe:
        """Result of the probe by the filter's answers; a filter that raises an error fails the probe."""
        try:
            for each in answers:
                if isinstance(each, FilterError):
                    raise each
            return Probe(self.code, *self.judge(search, [each for each in answers if isinstance(each, Answer)]))
        except InputError as error:
            return Probe(self.code, passed=False, message=str(error).removeprefix(f"{self.code}: "))


def with_unit(value: float, unit: str = "°") -> str:
    """A number with three digits and its unit; degrees below a thousandth are 0."""
    told = 0.0 if unit == "°" and value < 1e-3 else value
    return f"{told:.0f}{unit}" if told >= 100.0 else f"{told:.3g}{unit}"


def in_degrees(angle_rad: float) -> str:
    """An angle in degrees with three digits."""
    return with_unit(float(np.degrees(angle_rad)))


def limited(said: str, value: float, most: float, beside: str = "", unit: str = "°") -> Judged:
    """Judge a value by the largest one that is allowed, both in rad where they are told in degrees."""
    told, limit = np.degrees(np.minimum([value, most], np.pi)).tolist() if unit == "°" else (float(value), most)
    return bool(value <= most), f"{said} {with_unit(told, unit)} (limit {with_unit(limit, unit)}){beside}", told


def worst(answers: Answers, begin: float = 1.0 / 3.0) -> float:
    """Largest RMS error of several runs after a share of their time, rad."""
    return max(answer.error(begin) for answer in answers)


def _limit(search: Search, least: float = 0.0) -> float:
    """The error up to which a probe with something in the way is passed, rad, and at least so much."""
    return max(search.floor, least, NEAR * search.chosen.error)


def _follows(search: Search, answers: Answers) -> Judged:
    """Whether the filter, with its mistakes repaired, follows a motion with perfect sensors."""
    what = "its mistakes repaired" if search.chosen.codes else "perfect sensors"
    settled = f"; it needs {search.settles_s:.0f} s at rest to settle" * (search.settles_s > 0.0)
    passed, said, value = limited(f"with {what} its error is", search.chosen.error, search.floor, settled)
    if passed or search.chosen.codes or search.chosen.error <= NEAR * search.chatter:
        return True, said, value
    return False, f"{said}{_without_repair(search, answers[0].track)}", value


def _without_repair(search: Search, track: Matched) -> str:
    """Sentence about an error that no repair removes."""
    if search.is_by_chance:
        return f"; two equal runs differ by {in_degrees(search.scatter)}: no repair is looked for"
    turns = Turns(track)
    remark = turns.stuck() or turns.mixed() or turns.other()
    return f"; {remark.code}: {remark.message}" if remark else ""


def _half_turns(search: Search) -> Courses:
    """Motions whose attitude is half a turn about an axis of the world, in the middle of the course."""
    course = search.course
    start, midst = course.at(np.array([0, course.begin_ns + round(5e8 * course.counted_s)]))
    starts = quaternion.multiply(quaternion.multiply(np.eye(4)[:3], quaternion.conjugate(midst)), start)
    return [search.settled(_at(course, each)) for each in starts]


def _starts(search: Search) -> Courses:
    """The ordinary motion without a rest to settle, and those that begin turned by each rotation of a cube."""
    course = replace(search.course, settle_s=0.0)
    start = scipy.spatial.transform.Rotation.from_quat(course.scenario.start().attitude_xyzw)
    return [course, *(_at(course, (start * turn).as_quat()) for turn in _cube())]


def _cube() -> Any:
    """The 24 rotations of a cube."""
    return scipy.spatial.transform.Rotation.create_group("O")


def _at(course: Course, attitude_xyzw: Array, **parameters: object) -> Course:
    """A course that begins with an attitude."""
    return course.of_scenario(initial_attitude_xyzw=attitude_xyzw.tolist(), **parameters)


def _cube_at_rest(search: Search) -> Courses:
    """Two seconds at rest in each rotation of a cube, without a declination, and with readings without round-off."""
    field = [0.0, float(np.hypot(*search.course.field[:2])), search.course.field[2]]
    rest = replace(search.course, rest_s=0.0, settle_s=0.0, moving_s=2.0, is_rounded=True)
    return [_at(rest, turn.as_quat(), initial_body_rate=[0.0] * 3, magnetic_field=field) for turn in _cube()]


def _cube_judged(search: Search, answers: Answers) -> Judged:
    failed = sum(answer.broken.size > 0 for answer in answers)
    return limited(
        "of 24 rotations of a cube, at rest and read without round-off, without an attitude:", failed, 0.0, "", ""
    )


def _first_judged(search: Search, answers: Answers) -> Judged:
    """Largest error of the first answer; where it is, and how long until the filter errs as little as later on."""
    starts = answers[1:]
    errors = [answer.track.error().total for answer in starts]
    limit = _limit(search)
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


def _in_fields(search: Search, fields: Array) -> Courses:
    """The ordinary course in other fields, shape (n, 3), T."""
    return [search.settled(search.course.of_scenario(magnetic_field=each)) for each in fields.tolist()]


def _turned_fields(search: Search) -> Courses:
    """The ordinary course in fields of other sizes."""
    field = search.course.field
    return _in_fields(search, np.outer(FIELDS_T, field / np.linalg.norm(field)))


def _dipping_fields(search: Search) -> Courses:
    """The ordinary course in fields of the same size and of other dips."""
    field = search.course.field
    level = field[:2] / (np.hypot(*field[:2]) or 1.0)
    dips = np.radians(DIPS)
    return _in_fields(search, np.linalg.norm(field) * np.column_stack([np.outer(np.cos(dips), level), -np.sin(dips)]))


def _at_rate(search: Search, rate: float, moving_s: float) -> Course:
    """The ordinary course with a slower body."""
    body_rate = search.course.scenario.start().body_rate
    slow = search.course.of_scenario(initial_body_rate=(rate / norm(body_rate) * body_rate).tolist())
    return search.settled(replace(slow, moving_s=moving_s))


def _headings(search: Search) -> Courses:
    """A nearly level body that is turned through eight headings, with a bias of the gyro that is learnt at rest."""
    if not search.course.ramp_s:
        return []
    level = quaternion.exp(np.radians([3.0, -2.0, 10.0]))
    scenario = _at(search.course, level).scenario
    course = Headings(scenario, settle_s=LEARNING_S + search.settles_s, off=_biased(search)[0].off)
    if search.chosen.error > search.floor or any(repair.change for repair in search.chosen.mistakes):
        return [course]
    return [max(course, search.settled(course, course.settle_s), key=lambda each: each.settle_s)]


def _headings_judged(search: Search, answers: Answers) -> Judged:
    errors = answers[0].track.error().total
    before_end = answers[0].t_s - REST - (TURN + HOLD) * np.arange(1, 9)[:, np.newaxis]
    held = [rms(errors[(each > -0.5 * HOLD) & (each < 0.0)]) for each in before_end]
    most = max(search.floor, min(4.0 * float(np.median(held)), UNJUDGED))
    return limited("in the worst of eight headings, each held for 30 s, its error is", max(held), most)


def _first_given(search: Search) -> Estimate:
    """Estimate of the filter as it is, on the first course."""
    return search.trials[0].unrepaired[0].given


def _of_bias(search: Search) -> Courses:
    """The run with a bias of the gyro, of an estimate that tells one."""
    return _biased(search) if _first_given(search).gyro_bias is not None else []


def _bias_estimate_judged(search: Search, answers: Answers) -> Judged:
    """The estimated bias beside the one put in, in the last quarter: sign, unit and size."""
    told = answers[0].given.gyro_bias
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


def _biased(search: Search) -> Courses:
    return [replace(search.course, moving_s=60.0 - REST, off=(("gyro", tuple(BIAS.tolist())),))]


def _cut(search: Search) -> Courses:
    """A course on which the gyro has a bias, the same again, and its first half.

    With perfect sensors smoothers and causal filters alike give the truth.
    """
    [whole] = _biased(search)
    moving_s = search.course.moving_s
    return [*_twice(replace(whole, moving_s=moving_s)), replace(whole, moving_s=0.5 * moving_s)]


def _twice(course: Course) -> Courses:
    """Two courses with the same readings: the seed is that of a noise which they do not have."""
    return [course, replace(course, seed=1)]


def _bias_judged(search: Search, answers: Answers) -> Judged:
    """Error of the last quarter; its limit follows from the second, and from the turn that the bias alone makes.

    A twentieth of that turn is allowed: smoothers err at both ends, and more than in the second quarter.
    """
    second, last = (answers[0].error(begin, begin + 0.25) for begin in (0.25, 0.75))
    turn = GYRO_BIAS * 52.5
    most = max(search.floor, 0.05 * turn, min(1.5 * second, 0.5 * turn))
    removed = last <= min(most, max(_limit(search), 0.1 * second))
    return limited(
        "with a gyro off by 1°/s, in the last quarter of 60 s, its error is",
        last,
        most,
        f"; it {'removes the bias' if removed else 'keeps an error that the bias makes'}" * ("gyro" not in search.deaf),
    )


def _level(search: Search) -> float:
    """Cosine of the dip of the magnetic field."""
    return float(np.hypot(*search.course.field[:2]) / np.linalg.norm(search.course.field))


def _off(search: Search, name: str) -> Courses:
    """Courses with a constant error of a vector along each axis; none for a field without a level part."""
    size = VECTOR_ERROR * np.linalg.norm(readings(search.course).vectors[name][0])
    errors = (size * np.eye(3)).tolist() if _level(search) > VECTOR_ERROR else []
    return [replace(search.course, off=((name, tuple(error)),)) for error in errors]


def _off_judged(search: Search, answers: Answers, sensor: str) -> Judged:
    return limited(
        f"with {sensor} off by {VECTOR_ERROR:.0%} along one axis its error is",
        worst(answers),
        max(BIAS_PEAK * float(np.arcsin(VECTOR_ERROR / _level(search))), _limit(search)),
    )


def _noisy(search: Search, seed: int = 1) -> Course:
    """The ordinary course with white noise: that which the filter assumes, or else of tactical sensors."""
    return replace(search.course.of_scenario(**(search.noise or GRADE_OF_NOISE)), seed=seed)


def _noise_judged(search: Search, answers: Answers) -> Judged:
    """Error with noise; its limit is that of TRIAD at the readings that are answered; the least possible is told."""
    course = _noisy(search)
    bound = simulate(course.scenario, duration=course.counted_s).cramer_rao_bound()
    assert bound
    least = CramerRaoBound.rms(bound.filtered[len(bound.filtered) // 3 :])
    return limited(
        f"with the noise of {_grade(search)} its error is",
        answers[0].error(),
        1.01 * _of_single_sets(search, course, answers[0]),
        f"; the Cramér–Rao bound of filters is {in_degrees(least)} over many such runs",
    )


def _of_single_sets(search: Search, course: Course, answer: Answer) -> float:
    """RMS error, rad, of TRIAD from each single set of readings that is answered, without the first third."""
    stamps = answer.track.stamps_ns
    read = readings(course)
    held = np.maximum(np.searchsorted(read.field_t_ns, read.t_ns, side="right") - 1, 0)
    world = _axes(np.array([0.0, 0.0, 1.0]), course.field)
    body = _axes(read.vectors["specific_force"], read.vectors["field"][held])
    attitude = quaternion.from_matrix(world @ np.swapaxes(body, -1, -2))
    single = Matched(read.t_ns, attitude, course, is_level=search.is_level)
    answered = np.maximum(np.searchsorted(read.t_ns, stamps, side="right") - 1, 0)
    return error_of([single[answered[len(stamps) // 3 :]]])


def _carried(search: Search) -> Courses:
    """A carried body, for a minute: a filter that averages its accelerations needs some seconds."""
    return [replace(search.course, is_carried=True, moving_s=60.0 - REST)]


def _grade(search: Search) -> str:
    return "the given sensors" if search.noise else "tactical sensors"


def _axes(first: Array, second: Array) -> Array:
    """The axes that two directions span (TRIAD), in columns, shape (..., 3, 3)."""
    across = np.cross(first, second)
    axes = np.stack([first, across, np.cross(first, across)], axis=-1)
    return np.asarray(axes / np.linalg.norm(axes, axis=-2, keepdims=True))


def _gaps(search: Search) -> Courses:
    return [replace(_at_rate(search, SLOW_RATE, 60.0 - REST), gaps_s=(10.0, 20.0, 30.0))]


def _gaps_judged(search: Search, answers: Answers) -> Judged:
    errors = answers[0].track.error().total
    t_s = answers[0].t_s
    last = error_of([answers[0].track[t_s >= 40.0]])
    most = max(search.floor, 0.5 * errors[t_s >= 31.0].max(initial=0.0))
    passed, said, value = limited("after gaps of a second in a slow motion its error at the end is", last, most)
    return (False, f"{said}: attitudes are not finite", value) if answers[0].broken.size else (passed, said, value)


def _rests(search: Search) -> Courses:
    """Rests of several lengths before the motion, of a filter that settles at once."""
    if not search.course.ramp_s or (search.settles_s and not search.needs_rest):
        return []
    return [replace(search.course, settle_s=0.0, rest_s=rest_s) for rest_s in _RESTS]


def _rests_judged(search: Search, answers: Answers) -> Judged:
    without, plain, longer = (answer.error() for answer in answers)
    return limited(
        f"without a rest before the motion, or after {REST:g} s, its error is",
        max(without, plain),
        max(search.floor, NEAR * min(plain, longer)),
        f"; after {3.0 * REST:g} s it is {in_degrees(longer)}",
    )


def _broken(search: Search, answers: Answers) -> Judged:
    broken = answers[0].broken
    first = f"; the first is sample {broken[0]}" if broken.size else ""
    return limited("attitudes that are NaN, infinite or zero:", broken.size, 0.0, first, "")


def _norms_judged(search: Search, answers: Answers) -> Judged:
    norms = quaternion.norm(np.delete(answers[0].given.attitude_xyzw, answers[0].broken, axis=0))
    return limited(
        "the square of the quaternions' norm is off 1 by",
        np.abs(norms**2 - 1.0).max(initial=0.0),
        NOT_UNIT,
        unit="",
    )


def _noisy_runs(search: Search) -> Courses:
    """Short runs for an estimate that has a covariance."""
    has_one = _first_given(search).covariance is not None
    return [replace(_noisy(search, seed), moving_s=SHORT_S) for seed in range(2 * SEEDS * has_one)]


def _covariance_judged(search: Search, answers: Answers) -> Judged:
    """Whether a covariance is consistent, and what is wrong with it, by the rule of a campaign."""
    count = min(len(answer.track.stamps_ns) for answer in answers)
    axes = answers[0].given.covariance_axes
    at = np.linspace(count // 3, count - 1, JUDGED).astype(np.int64)
    tracks = [answer.track[at] for answer in answers]
    estimate = np.stack([track.attitude_xyzw for track in tracks])
    errors = error_vectors(estimate, np.stack([track.truth_xyzw for track in tracks]), axes)
    covariance = np.stack([answer.given.rotation_covariance()[at] for answer in answers])
    verdicts = [
        ensemble_consistency(tracks[0].stamps_ns / 1e9, errors[runs], covariance[runs], estimate[runs], axes)
        for runs in (slice(SEEDS), slice(SEEDS, None))
    ]
    found = min(verdicts, key=lambda each: (not each.passed, each.cause in ("", "factor")))
    passed = found.passed if search.noise else None
    return passed, f"with the noise of {_grade(search)}: {found.message}", found.nees_mean


def _alternating(search: Search) -> Courses:
    """Steps of 2/3 and 4/3 of a period, as many of each, so that a filter which takes their median takes the period."""
    course = search.course
    odd = 0.5 * (1 - course.updates % 2) / course.rate
    return [replace(course, grid="alternating", moving_s=course.moving_s + odd)]


def _within(said: str, turn: float = 0.0) -> Callable[[Search, Answers], Judged]:
    """Judge the worst of several runs by the floor, twice the error of the plain run, or a share of a step's turn."""
    return lambda search, answers: limited(said, worst(answers), _limit(search, turn * search.course.turn))


PROBES: Final = (
    ProbeRow("follows", lambda s: [s.course], _follows, needs_error=False),
    ProbeRow("half_turn", _half_turns, _within("through half turns from the world's axes its error is")),
    ProbeRow("exact_starts", _cube_at_rest, _cube_judged, needs_error=False),
    ProbeRow("other_fields", _turned_fields, _within("in fields of 25 and 65 µT its error is")),
    ProbeRow("headings", _headings, _headings_judged, needs_error=False),
    ProbeRow(
        "irregular_steps",
        _alternating,
        _within("with steps of 2/3 and 4/3 of a period in turn its error is", 1.0 / 3.0),
    ),
    ProbeRow(
        "converges",
        _starts,
        lambda s, o: limited(
            "from the worst of 24 first attitudes its error at the end is",
            worst(o[1:], 2.0 / 3.0),
            max(s.floor, NEAR * o[0].error(2.0 / 3.0)),
        ),
    ),
    ProbeRow("gyro_bias", _biased, _bias_judged),
    ProbeRow("bias_estimate", _of_bias, _bias_estimate_judged),
    ProbeRow(
        "slow",
        lambda s: [_at_rate(s, rate, 60.0) for rate in SLOW_RATES],
        _within("of a body that turns by 0.1, 0.05 and 0.02 rad/s for a minute its error is"),
    ),
    ProbeRow(
        "linear_acceleration",
        _carried,
        lambda s, o: limited(
            "carried with 2 m/s² along each axis its error is",
            o[0].error(),
            max(s.floor, 0.5 * _of_single_sets(s, _carried(s)[0], o[0])),
            "; the limit is half of what single sets of readings give",
        ),
    ),
    ProbeRow(
        "accelerometer_bias", lambda s: _off(s, "specific_force"), lambda s, o: _off_judged(s, o, "an accelerometer")
    ),
    ProbeRow("hard_iron", lambda s: _off(s, "field"), lambda s, o: _off_judged(s, o, "a magnetometer")),
    ProbeRow("noise", lambda s: [_noisy(s)], _noise_judged),
    ProbeRow("dropouts", _gaps, _gaps_judged),
    ProbeRow(
        "long_run",
        lambda s: [s.long],
        lambda s, o: limited(
            "in the last tenth of a run ten times as long its error is",
            o[0].error(0.9),
            max(s.floor, NEAR * o[0].error(0.1, 0.2)),
        ),
    ),
    ProbeRow(
        "repeatable",
        lambda s: _twice(s.course),
        lambda s, o: limited(
            "called twice it gives estimates that differ by",
            o[0].track.max_difference(o[1].track),
            SAME,
            "; one that differs goes by a clock of its own, or by the order in which readings arrive",
            " rad",
        ),
        needs_error=False,
    ),
    ProbeRow("norm", lambda s: [s.course], _norms_judged, needs_error=False),
    ProbeRow("finite", lambda s: [s.course], _broken, needs_error=False),
    ProbeRow("covariance", _noisy_runs, _covariance_judged),
    ProbeRow(
        "needs_rest",
        _rests,
        _rests_judged,
    ),
)
"""The probes in the order in which they are told."""
NOTES: Final = (
    ProbeRow("first_attitude", _starts, _first_judged),
    ProbeRow(
        "fixed_field",
        _dipping_fields,
        _within(
            "In fields that dip by 0° and ±75° it keeps another field in its code, or hardly corrects: its error is"
        ),
    ),
    ProbeRow(
        "constant_step",
        lambda s: [replace(s.course, grid="walk")],
        _within(
            "The filter takes all steps for equal, which matters where readings are late or lost: with steps at "
            "random, 2/3 to 4/3 of a period, its error is",
            1.0 / 3.0,
        ),
    ),
    ProbeRow(
        "causal",
        _cut,
        lambda s, o: limited(
            "The estimate uses later readings, as smoothers do: without them it is another, by up to",
            o[0].track.max_difference(o[2].track),
            SAME if o[0].track.max_difference(o[1].track) <= SAME else np.inf,
        ),
    ),
)
"""Probes that are told as notes where they are not passed."""


def told(search: Search, rows: Sequence[ProbeRow]) -> Iterator[Probe]:
    """Results of probes; those without courses, as of a covariance where there is none, are left out."""
    chosen = search.chosen
    is_judged = chosen.error <= UNJUDGED
    courses = {row: row.courses(search) for row in rows if is_judged or not row.needs_error}
    new = dict.fromkeys(course for each in courses.values() for course in each if course not in search.known)
    answers = zip(new, search.ask((course, chosen.repairs) for course in new), strict=False)
    for row in rows:
        asked = courses.get(row)
        if asked is None:
            yield Probe(row.code, None, f"not judged, as the error of the filter is {in_degrees(chosen.error)}")
        elif asked:
            while not search.known.keys() >= {*asked}:
                search.known.update([next(answers)])
            yield row.told(search, [search.known[course] for course in asked])
