"""Probes: what a filter can do, each by courses with one thing in the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.course import NOISE, REST, TINY, Course, readings
from lie_rigid_body.diagnosis.repairs import Answer, Job
from lie_rigid_body.diagnosis.search import NEAR, Search
from lie_rigid_body.evaluation import CramerRaoBound, ExactTruth, evaluate
from lie_rigid_body.evaluation.attitudes import error_vectors
from lie_rigid_body.evaluation.ensemble_consistency import ensemble_consistency
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.evaluation.remarks import NOT_UNIT
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import FilterError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs import simulate
from lie_rigid_body.sensors import GRADES

GYRO_BIAS: Final = float(np.radians(1.0))
"""Constant error of the gyro, rad/s."""
VECTOR_ERROR: Final = 0.05
"""Constant error of the accelerometer and of the magnetometer, share of the vector."""
SLOW: Final = 0.06
"""Factor of the rates in a slow motion."""
WRONG_SIGN: Final = "as where a correction has the wrong sign"
"""Words for a filter that makes small errors large."""
WITHOUT_REPAIR: Final = ("stuck", "mixed", "gaps", "turn_rate", "turn_axes")
"""Findings of `evaluate` that no repair undoes: they are told where nothing helps."""
SEEDS: Final = 12
"""Short runs with noise by which a covariance is judged, and as many others. One honest covariance of twenty is found
dishonest by chance, and two of these verdicts are not."""
SHORT_S: Final = 5.0
"""Length of the motion of a short run with noise, s."""
JUDGED: Final = 20
"""Number of samples of a short run by which a covariance is judged."""


SAME: Final = 1e-9
"""Largest difference of two estimates, rad, that count as the same."""
Judged = tuple[bool, str, float]
"""Whether a probe is passed, what is said of it, and the number that was judged."""


@short_dataclass(frozen=True)
class Probe:
    """Whether a filter has an ability.

    Attributes
    ----------
    code : str
    passed : bool
    message : str
    value : float or None
        The number that was judged: an error in degrees, if the message tells nothing else.
    """

    code: str
    passed: bool
    message: str
    value: float | None = None


class ProbeRow(NamedTuple):
    """A probe: its code, the courses that are run, and what is judged; without courses it is not told."""

    code: str
    courses: Callable[[Search], Sequence[Course]]
    judge: Callable[[Search, Sequence[Answer]], Judged]

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


def limited(said: str, value: float, most: float, beside: str = "", unit: str = "°") -> Judged:
    """Judge a value by the largest one that is allowed, both in rad where they are told in degrees."""
    told, limit = np.degrees(np.minimum([value, most], np.pi)).tolist() if unit == "°" else (float(value), most)
    return bool(value <= most), f"{said} {with_unit(told, unit)} (limit {with_unit(limit, unit)}){beside}", told


def worst(answers: Sequence[Answer], begin: float = 1.0 / 3.0) -> float:
    """Largest RMS error of several runs after a share of their time, rad."""
    return max(answer.error(begin) for answer in answers)


def _limit(search: Search, least: float = 0.0) -> float:
    """The error up to which a probe with something in the way is passed, rad, and at least so much."""
    return max(search.floor, least, NEAR * search.chosen.error)


def _follows(search: Search, answers: Sequence[Answer]) -> Judged:
    """Whether the filter, with its mistakes repaired, follows a motion with perfect sensors."""
    what = "its mistakes repaired" if search.chosen.codes else "perfect sensors"
    alike = "; it begins with one attitude whatever it reads, and so do the bodies here" * search.begins_alike
    passed, said, value = limited(f"with {what} it errs by", search.chosen.error, search.floor, alike)
    if passed or search.chosen.codes:
        return True, said, value
    return False, f"{said}{_without_repair(search, answers[0].track)}", value


def _without_repair(search: Search, track: Matched) -> str:
    """Sentences about an error that no repair removes."""
    if search.is_by_chance:
        return f"; two equal runs differ by {with_unit(float(np.degrees(search.scatter)))}: no repair is looked for"
    if search.change:
        return (
            f"; it is unstable: sensors off by {TINY * search.course.turn:.1g} of what they read change it by "
            f"{with_unit(float(np.degrees(search.change)))}, {WRONG_SIGN}"
        )
    known = ExactTruth(track.truth.at, int(track.stamps_ns[0]), int(track.stamps_ns[-1]))
    score = evaluate(track.stamps_ns, track.attitude_xyzw, known)
    told = [f"{each.code}: {each.message}" for each in score.findings if each.code in WITHOUT_REPAIR]
    if search.chosen.parts[0] <= search.floor:
        told.append("its vertical is right, and its heading alone is wrong: see whether it uses the magnetometer")
    return "".join(f"; {each}" for each in told)


def _half_turns(search: Search) -> list[Course]:
    """Motions whose attitude is half a turn about an axis of the world, in the middle of the course."""
    start, midst = search.course.at(np.array([0, round(5e8 * (search.course.rest_s + search.course.moving_s))]))
    starts = quaternion.multiply(quaternion.multiply(np.eye(4)[:3], quaternion.conjugate(midst)), start)
    return [search.course.of_scenario(initial_attitude_xyzw=each) for each in starts.tolist()]


def _starts(search: Search) -> list[Course]:
    """The ordinary motion, and those that begin turned by each rotation of a cube."""
    start = scipy.spatial.transform.Rotation.from_quat(search.course.scenario.start().attitude_xyzw)
    return [
        search.course,
        *(
            search.course.of_scenario(initial_attitude_xyzw=(start * turn).as_quat().tolist())
            for turn in scipy.spatial.transform.Rotation.create_group("O")
        ),
    ]


def _biased(search: Search) -> list[Course]:
    bias = tuple((GYRO_BIAS / np.sqrt(3.0) * np.array([1.0, -1.0, 1.0])).tolist())
    return [replace(search.course, moving_s=60.0 - REST, off=(("gyro", bias),))]


def _cut(search: Search) -> list[Course]:
    """A course on which the gyro has a bias, the same again, and its first half.

    With perfect sensors smoothers and causal filters alike give the truth.
    """
    whole = replace(_biased(search)[0], moving_s=search.course.moving_s)
    return [whole, whole, replace(whole, moving_s=0.5 * whole.moving_s)]


def _bias_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    """Error of the last quarter; its limit follows from the second, and from the turn that the bias alone makes.

    A twentieth of that turn is allowed: smoothers err at both ends, and more than in the second quarter.
    """
    second, last = (answers[0].error(begin, begin + 0.25) for begin in (0.25, 0.75))
    turn = GYRO_BIAS * 52.5
    most = max(search.floor, 0.05 * turn, min(1.5 * second, 0.5 * turn))
    removed = last <= min(most, max(_limit(search), 0.1 * second))
    kept = f"makes more of it than it is alone, {WRONG_SIGN}" if last > turn else "keeps an error that the bias makes"
    return limited(
        "with a gyro off by 1°/s it errs, in the last quarter of 60 s, by",
        last,
        most,
        f"; it {'removes the bias' if removed else kept}",
    )


def _level(search: Search) -> float:
    """Cosine of the dip of the magnetic field."""
    return float(np.hypot(*search.course.field[:2]) / np.linalg.norm(search.course.field))


def _off(search: Search, name: str) -> list[Course]:
    """Courses with a constant error of a vector along each axis; none for a field without a level part."""
    size = VECTOR_ERROR * np.linalg.norm(readings(search.course).vectors[name][0])
    errors = (size * np.eye(3)).tolist() if _level(search) > VECTOR_ERROR else []
    return [replace(search.course, off=((name, tuple(error)),)) for error in errors]


def _off_judged(search: Search, answers: Sequence[Answer], sensor: str) -> Judged:
    return limited(
        f"with {sensor} off by {VECTOR_ERROR:.0%} along one axis it errs by",
        worst(answers),
        max(float(np.arcsin(VECTOR_ERROR / _level(search))), _limit(search)),
    )


def _noisy(search: Search, seed: int = 1) -> Course:
    """The ordinary course with the white noise of tactical sensors, which its scenario tells."""
    return replace(search.course.of_scenario(**{name: GRADES["tactical"][name] for name in NOISE}), seed=seed)


def _noise_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    """Error with noise; its limit is that of TRIAD at the readings that are answered; the least possible is told."""
    course = _noisy(search)
    stamps = answers[0].track.stamps_ns
    read = readings(course)
    held = np.maximum(np.searchsorted(read.field_t_ns, read.t_ns, side="right") - 1, 0)
    world = _axes(np.array([0.0, 0.0, 1.0]), course.field)
    body = _axes(read.vectors["specific_force"], read.vectors["field"][held])
    single = Matched(read.t_ns, quaternion.from_matrix(world @ np.swapaxes(body, -1, -2)), course)
    answered = np.maximum(np.searchsorted(read.t_ns, stamps, side="right") - 1, 0)
    bound = simulate(course.scenario, duration=course.rest_s + course.moving_s).cramer_rao_bound()
    assert bound
    least = CramerRaoBound.rms(bound.filtered[len(bound.filtered) // 3 :])
    return limited(
        "with the noise of tactical sensors it errs by",
        answers[0].error(),
        1.01 * error_of([single[answered[len(stamps) // 3 :]]]),
        f"; the best filter errs by {with_unit(float(np.degrees(least)))} over many such runs",
    )


def _axes(first: Array, second: Array) -> Array:
    """The axes that two directions span (TRIAD), in columns, shape (..., 3, 3)."""
    across = np.cross(first, second)
    axes = np.stack([first, across, np.cross(first, across)], axis=-1)
    return np.asarray(axes / np.linalg.norm(axes, axis=-2, keepdims=True))


def _gaps(search: Search) -> list[Course]:
    slow = search.course.of_scenario(initial_body_rate=(SLOW * search.course.scenario.start().body_rate).tolist())
    return [replace(slow, moving_s=60.0 - REST, gaps_s=(10.0, 20.0, 30.0))]


def _gaps_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    errors = answers[0].track.error().total
    t_s = answers[0].track.stamps_ns / 1e9
    last = error_of([answers[0].track[t_s >= 40.0]])
    most = max(search.floor, 0.5 * errors[t_s >= 31.0].max(initial=0.0))
    passed, said, value = limited("after gaps of a second in a slow motion it keeps at the end", last, most)
    return (False, f"{said}: attitudes are not finite", value) if answers[0].broken.size else (passed, said, value)


def _rests_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    without, plain, longer = (answer.error() for answer in answers)
    return limited(
        f"without a rest before the motion, or after {REST:g} s, it errs by",
        max(without, plain),
        max(search.floor, NEAR * min(plain, longer)),
        f"; after {3.0 * REST:g} s it is {with_unit(float(np.degrees(longer)))}",
    )


def _broken(search: Search, answers: Sequence[Answer]) -> Judged:
    broken = answers[0].broken
    first = f"; the first is sample {broken[0]}" if broken.size else ""
    return limited("attitudes that are NaN, infinite or zero:", broken.size, 0.0, first, "")


def _norms_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    norms = quaternion.norm(np.delete(answers[0].given.attitude_xyzw, answers[0].broken, axis=0))
    return limited(
        "the square of the quaternions' norm is off 1 by",
        np.abs(norms**2 - 1.0).max(initial=0.0),
        NOT_UNIT,
        unit="",
    )


def _noisy_runs(search: Search) -> list[Course]:
    """Short runs for an estimate that has a covariance."""
    has_one = search.trials[0].unrepaired[0].given.covariance is not None
    return [replace(_noisy(search, seed), moving_s=SHORT_S) for seed in range(2 * SEEDS * has_one)]


def _covariance_judged(search: Search, answers: Sequence[Answer]) -> Judged:
    """Whether a covariance is honest, and what is wrong with it, by the rule of a campaign."""
    count = min(len(answer.track.stamps_ns) for answer in answers)
    axes = answers[0].given.covariance_axes
    at = np.linspace(count // 3, count - 1, JUDGED).astype(np.int64)
    tracks = [answer.track[at] for answer in answers]
    estimate, truth = np.stack([(track.attitude_xyzw, track.truth.at(track.stamps_ns)) for track in tracks], axis=1)
    errors = error_vectors(estimate, truth, axes)
    covariance = np.stack([answer.given.rotation_covariance()[at] for answer in answers])
    verdicts = [
        ensemble_consistency(tracks[0].stamps_ns / 1e9, errors[runs], covariance[runs], estimate[runs], axes)
        for runs in (slice(SEEDS), slice(SEEDS, None))
    ]
    found = min(verdicts, key=lambda each: (not each.passed, each.cause in ("", "factor")))
    return found.passed, f"with the noise of tactical sensors: {found.message}", found.nees_mean


PROBES: Final = (
    ProbeRow("follows", lambda s: [s.course], _follows),
    ProbeRow(
        "half_turn",
        _half_turns,
        lambda s, o: limited("through half turns from the world's axes it errs by", worst(o), _limit(s)),
    ),
    ProbeRow(
        "irregular_steps",
        lambda s: [replace(s.course, grid="alternating")],
        lambda s, o: limited(
            "with steps of 2/3 and 4/3 of a period in turn it errs by", worst(o), _limit(s, s.course.turn / 3.0)
        ),
    ),
    ProbeRow(
        "converges",
        _starts,
        lambda s, o: limited(
            "from the worst of 24 first attitudes it keeps at the end",
            worst(o[1:], 2.0 / 3.0),
            max(s.floor, NEAR * o[0].error(2.0 / 3.0)),
        ),
    ),
    ProbeRow("gyro_bias", _biased, _bias_judged),
    ProbeRow(
        "accelerometer_bias", lambda s: _off(s, "specific_force"), lambda s, o: _off_judged(s, o, "an accelerometer")
    ),
    ProbeRow("hard_iron", lambda s: _off(s, "field"), lambda s, o: _off_judged(s, o, "a magnetometer")),
    ProbeRow("noise", lambda s: [_noisy(s)], _noise_judged),
    ProbeRow("dropouts", _gaps, _gaps_judged),
    ProbeRow(
        "long_run",
        lambda s: [replace(s.course, moving_s=10.0 * s.course.moving_s)],
        lambda s, o: limited(
            "in the last tenth of a run ten times as long it errs by",
            o[0].error(0.9),
            max(s.floor, NEAR * o[0].error(0.1, 0.2)),
        ),
    ),
    ProbeRow(
        "repeatable",
        lambda s: [s.course, s.course],
        lambda s, o: limited(
            "called twice it gives estimates that differ by",
            o[0].track.max_difference(o[1].track),
            SAME,
            "; one that differs goes by a clock of its own, or by the order in which readings arrive",
            " rad",
        ),
    ),
    ProbeRow("norm", lambda s: [s.course], _norms_judged),
    ProbeRow("finite", lambda s: [s.course], _broken),
    ProbeRow("covariance", _noisy_runs, _covariance_judged),
    ProbeRow(
        "needs_rest",
        lambda s: [replace(s.course, rest_s=rest_s) for rest_s in (0.0, REST, 3.0 * REST)],
        _rests_judged,
    ),
)
"""The probes in the order in which they are told."""
NOTES: Final = (
    ProbeRow(
        "constant_step",
        lambda s: [replace(s.course, grid="walk")],
        lambda s, o: limited(
            "The filter takes all steps for equal, which matters where readings are late or lost: with steps at "
            "random, 2/3 to 4/3 of a period, it errs by",
            worst(o),
            _limit(s, s.course.turn / 3.0),
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


def told(search: Search, rows: Iterable[ProbeRow]) -> Iterator[Probe]:
    """Results of probes; those without courses, as of a covariance where there is none, are left out."""
    asked = [(row, courses) for row in rows if (courses := row.courses(search))]
    answers = search.ask([Job(course, search.chosen.repairs) for _, courses in asked for course in courses])
    return (row.told(search, [next(answers) for _ in courses]) for row, courses in asked)
