"""Probes: what a filter can do, each by trials with one thing in the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from lie_rigid_body.arrays import Array
from lie_rigid_body.diagnosis.choice import Outputs, undo
from lie_rigid_body.diagnosis.filter import Answer, Filter, FilterError
from lie_rigid_body.diagnosis.repairs import Repair
from lie_rigid_body.diagnosis.result import Note, Probe
from lie_rigid_body.diagnosis.trial import ALTERNATING, REST, WALK, PathTruth, SensorErrors, Trial, Vector
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import VectorReadings, attitude_nees, unavoidable_error
from lie_rigid_body.evaluation.attitudes import angles_between
from lie_rigid_body.evaluation.causes import Track
from lie_rigid_body.evaluation.estimate import NOT_UNIT
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.unavoidable import UnavoidableError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.sensors import GRADES

GYRO_BIAS: Final = float(np.radians(1.0))
"""Constant error of the gyro, rad/s."""
VECTOR_ERROR: Final = 0.05
"""Constant error of the accelerometer and of the magnetometer, share of the vector."""
SLOW: Final = 0.06
"""Factor of the rates in a slow motion."""
SAME: Final = 1e-9
"""Largest difference of attitudes that are equal, rad."""
WORSE: Final = 2.0
"""Factor of an error that is allowed beside that of the plain run."""
BIAS_GROWTH: Final = 1.5
"""Factor from the worse of the first two quarters to the last that a bias may cause; a smoother errs at both ends."""
BIAS_SHARE: Final = 0.5
"""Share of the turn that the bias alone makes, of which the last quarter may have as much."""
NOISIER: Final = 1.01
"""Factor of the error of single sets of readings that noise may leave."""
SEEDS: Final = 24
"""Runs with noise by which a covariance is judged."""
_HALF_TURNS: Final = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


@dataclass(frozen=True)
class Setup:
    """How a filter is probed: with its mistakes repaired.

    Attributes
    ----------
    trials : tuple of Trial
        The ordinary ones, with the kind of gyro that it expects.
    repairs : tuple of Repair
    outputs : tuple of (str, tuple of float)
        Repairs of the output.
    floor, error : float
        The error below which all are equal, and that of the ordinary trials, rad.
    """

    trials: tuple[Trial, ...]
    repairs: tuple[Repair, ...]
    outputs: Outputs
    floor: float
    error: float

    @property
    def turn(self) -> float:
        """Mean turn between two readings, rad."""
        return float(np.mean([trial.turn for trial in self.trials]))

    @property
    def limit(self) -> float:
        """The error up to which a probe with something in the way is passed, rad."""
        return max(self.floor, WORSE * self.error)


class Bench:
    """A filter with its setup.

    Parameters
    ----------
    run : Filter
    setup : Setup
    """

    def __init__(self, run: Filter, setup: Setup) -> None:
        self._filter, self.setup = run, setup

    @property
    def trial(self) -> Trial:
        """The first ordinary trial."""
        return self.setup.trials[0]

    def answer(self, trial: Trial) -> Answer:
        """What the filter makes of a trial."""
        return self._filter.answer(trial, self.setup.repairs, again=True)

    def mended(self, track: Track) -> Track:
        """A track with the mistakes of the output undone."""
        return undo(track, self.setup.outputs)

    def errors(self, trial: Trial, begin: float = 1.0 / 3.0, end: float = 1.0) -> Array:
        """Total errors between two shares of a trial, rad."""
        return self.mended(self.answer(trial).between(begin, end)).errors()

    def error(self, trial: Trial, begin: float = 1.0 / 3.0, end: float = 1.0) -> float:
        """RMS of the total error between two shares of a trial, rad."""
        return rms(self.errors(trial, begin, end))


@dataclass(frozen=True)
class Probing:
    """A job: one probe.

    Attributes
    ----------
    probe : callable
    setup : Setup
    """

    probe: Callable[[Bench], Probe | Note | None]
    setup: Setup

    def __call__(self, run: Filter) -> Probe | Note | None:
        """What the probe tells; a filter that fails in it fails the probe."""
        try:
            return self.probe(Bench(run, self.setup))
        except FilterError as error:
            if self.probe in NOTES:
                return None
            return Probe(self.probe.__name__, passed=False, message=str(error))


def _at(bench: Bench, attitude_xyzw: object) -> Trial:
    return bench.trial.with_parameters(initial_attitude_xyzw=attitude_xyzw)


def _judged(code: str, error: float, limit: float, what: str) -> Probe:
    value, most = np.degrees([error, limit])
    return Probe(
        code, bool(error <= limit), f"{what} {shown_angle(value)}, allowed are {shown_angle(most)}", float(value)
    )


def shown_angle(value: float) -> str:
    """Degrees with two digits; what is below a thousandth is 0."""
    return f"{value:.2g}°" if value >= 1e-3 else "0°"


def half_turn(bench: Bench) -> Probe:
    """Motions that pass through half turns from the world's axes in their midst."""
    truth = PathTruth(bench.trial.scenario, bench.trial.rest_s)
    start, midst = truth.at(np.array([0, round(5e8 * (bench.trial.rest_s + bench.trial.moving_s))]))
    passed = quaternion.multiply(np.array(_HALF_TURNS), quaternion.conjugate(midst))
    worst = max(bench.error(_at(bench, quaternion.multiply(each, start).tolist())) for each in passed)
    return _judged("half_turn", worst, bench.setup.limit, "through half turns from the world's axes it errs by")


def irregular_steps(bench: Bench) -> Probe:
    """Steps of 2/3 and 4/3 in turn."""
    error = bench.error(replace(bench.trial, grid=ALTERNATING))
    limit = max(bench.setup.turn / 3.0, WORSE * bench.setup.error)
    return _judged("irregular_steps", error, limit, "with steps of 2/3 and 4/3 of a period in turn it errs by")


def constant_step(bench: Bench) -> Note | None:
    """What steps at random leave, where that is more than a constant step leaves of a right filter otherwise."""
    error = bench.error(replace(bench.trial, grid=WALK))
    if error <= max(bench.setup.turn / 3.0, bench.setup.limit):
        return None
    value = float(np.degrees(error))
    return Note(
        "constant_step",
        f"The filter takes all steps for equal: with steps at random, 2/3 to 4/3 of a period, it errs by {value:.2g}°; "
        "give it the stamps where readings are late or lost.",
        value,
    )


def converges(bench: Bench) -> Probe:
    """First attitudes of all kinds."""
    turns = [
        Rotation.from_quat(bench.trial.scenario.start().attitude_xyzw) * turn for turn in Rotation.create_group("O")
    ]
    worst = max(bench.error(_at(bench, turn.as_quat().tolist()), 2.0 / 3.0) for turn in turns)
    limit = max(bench.setup.floor, WORSE * bench.error(bench.trial, 2.0 / 3.0))
    return _judged("converges", worst, limit, f"from the worst of {len(turns)} first attitudes it keeps at the end")


def gyro_bias(bench: Bench) -> Probe:
    """A gyro that is off by 1°/s all the time."""
    size = GYRO_BIAS / np.sqrt(3.0)
    trial = replace(bench.trial, moving_s=60.0 - REST, errors=SensorErrors(gyro=(size, -size, size)))
    errors = bench.errors(trial, 0.0)
    first, second, last = (rms(errors[len(errors) * k // 4 : len(errors) * (k + 1) // 4]) for k in (0, 1, 3))
    alone = BIAS_SHARE * GYRO_BIAS * 52.5
    removed = "removes it" if last <= max(bench.setup.limit, 0.1 * second) else "keeps an error that it makes"
    return _judged(
        "gyro_bias",
        last,
        max(bench.setup.floor, min(BIAS_GROWTH * max(first, second), alone)),
        f"a gyro off by 1°/s: the filter {removed}; in the last quarter of 60 s it errs by",
    )


def _constant_error(
    bench: Bench, code: str, along: Callable[[float, int], SensorErrors], vector: object, what: str
) -> Probe | None:
    size = float(np.linalg.norm(np.asarray(vector, dtype=float)))
    field = np.array(bench.trial.scenario.parameters()["magnetic_field"], dtype=float)
    level = float(np.hypot(field[0], field[1]) / np.linalg.norm(field))
    if not size * level > VECTOR_ERROR * size:
        return None
    worst = max(bench.error(replace(bench.trial, errors=along(VECTOR_ERROR * size, i))) for i in range(3))
    limit = max(float(np.arcsin(VECTOR_ERROR / level)), bench.setup.limit)
    return _judged(code, worst, limit, f"{what} off by {VECTOR_ERROR:.0%} along one axis: it errs by")


def _axis(size: float, axis: int) -> Vector:
    x, y, z = (size * np.eye(3)[axis]).tolist()
    return x, y, z


def accelerometer_bias(bench: Bench) -> Probe | None:
    """One axis of the accelerometer that is off by a share of gravity."""
    gravity = bench.trial.scenario.parameters()["gravity"]
    return _constant_error(
        bench,
        "accelerometer_bias",
        lambda size, axis: SensorErrors(specific_force=_axis(size, axis)),
        [gravity],
        "an accelerometer",
    )


def hard_iron(bench: Bench) -> Probe | None:
    """One axis of the magnetometer that is off by a share of the field."""
    field = bench.trial.scenario.parameters()["magnetic_field"]
    return _constant_error(
        bench, "hard_iron", lambda size, axis: SensorErrors(field=_axis(size, axis)), field, "a magnetometer"
    )


def _noisy(trial: Trial, seed: int = 1) -> Trial:
    """A trial with the white noise of tactical sensors, which its scenario tells."""
    grade = GRADES["tactical"]
    names = [f"{sensor}_noise_density" for sensor in ("gyro", "accelerometer", "magnetometer")]
    densities = [float(str(grade[name])) for name in names]
    rates = [float(str(trial.scenario.parameters()[name])) for name in ("imu_rate", "imu_rate", "magnetometer_rate")]
    gyro, force, field = (density * rate**0.5 for density, rate in zip(densities, rates, strict=True))
    told = trial.with_parameters(**dict(zip(names, densities, strict=True)))
    return replace(told, errors=SensorErrors(noise=(gyro, force, field), seed=seed))


def noise(bench: Bench) -> Probe:
    """White noise of all sensors, beside what single sets of readings tell."""
    trial = _noisy(bench.trial)
    single, bound = _single_sets(trial), _bound(trial)
    error = bench.error(trial)
    least = f"{shown_angle(float(np.degrees(bound)))} are the least that such noise leaves"
    what = f"with the noise of tactical sensors ({least}, {error / bound:.2g} times less than here) it errs by"
    return _judged("noise", error, NOISIER * single, what)


def _single_sets(trial: Trial) -> float:
    """RMS of the total error of the attitudes that each pair of readings tells, rad."""
    run, truth = trial.readings().run(), trial.readings().truth
    assert run.imu
    assert run.magnetometer
    parameters, stamps = trial.scenario.parameters(), run.imu.t_ns
    held = np.maximum(np.searchsorted(run.magnetometer.t_ns, stamps, side="right") - 1, 0)
    world = _axes(np.array([0.0, 0.0, 1.0]), np.array(parameters["magnetic_field"], dtype=float))
    body = _axes(run.imu.specific_force, run.magnetometer.field[held])
    attitude = quaternion.from_matrix(world @ np.swapaxes(body, -1, -2))
    settled = slice(len(stamps) // 3, None)
    return rms(Track(stamps[settled], attitude[settled], truth).errors())


def _axes(first: Array, second: Array) -> Array:
    """The axes that two directions span (TRIAD), in columns, shape (..., 3, 3)."""
    across = np.cross(first, second)
    axes = np.stack([first, across, np.cross(first, across)], axis=-1)
    return np.asarray(axes / np.linalg.norm(axes, axis=-2, keepdims=True))


def _bound(trial: Trial) -> float:
    """RMS of the total error at best, rad."""
    run = trial.readings().run()
    assert run.imu
    assert run.magnetometer
    stamps, parameters, (gyro, force, field) = run.imu.t_ns, trial.scenario.parameters(), trial.errors.noise
    found = unavoidable_error(
        stamps,
        trial.readings().truth.at(stamps),
        gyro_noise=gyro,
        vectors=(
            VectorReadings(stamps, [0.0, 0.0, float(str(parameters["gravity"]))], force),
            VectorReadings(run.magnetometer.t_ns, np.array(parameters["magnetic_field"], dtype=float), field),
        ),
    )
    return float(UnavoidableError.rms(found.filtered[len(stamps) // 3 :]))


def dropouts(bench: Bench) -> Probe:
    """Gaps of a second in a slow motion."""
    rate = np.array(bench.trial.scenario.start().body_rate) * SLOW
    slow = bench.trial.with_parameters(initial_body_rate=rate.tolist())
    answer = bench.answer(replace(slow, moving_s=60.0 - REST, gaps_s=(10.0, 20.0, 30.0)))
    errors = bench.mended(answer.track).errors()
    after = answer.track.stamps_ns >= 31e9
    largest, last = float(errors[after].max()), rms(errors[answer.track.stamps_ns >= 40e9])
    limit = max(bench.setup.limit, 0.5 * largest) if answer.broken < 0 else -1.0
    return _judged("dropouts", last, limit, "after gaps of a second in a slow motion it keeps at the end")


def long_run(bench: Bench) -> Probe:
    """A run ten times as long."""
    errors = bench.errors(replace(bench.trial, moving_s=10.0 * bench.trial.moving_s), 0.0)
    second, last = (rms(errors[len(errors) * k // 10 : len(errors) * (k + 1) // 10]) for k in (1, 9))
    what = "in the last tenth of a run ten times as long it errs by"
    return _judged("long_run", last, max(bench.setup.floor, WORSE * second), what)


def repeatable(bench: Bench) -> Probe:
    """Two calls in a row."""
    first, second = (bench.answer(bench.trial).track.attitude_xyzw for _ in range(2))
    off = float(np.max(angles_between(first, second))) if first.shape == second.shape else np.pi
    return Probe("repeatable", off <= SAME, f"called twice, the estimates differ by {off:.2g} rad at most", off)


def norm(bench: Bench) -> Probe:
    """Quaternions of unit norm."""
    off = max(bench.answer(trial).largest_norm_error for trial in bench.setup.trials)
    return Probe("norm", off <= NOT_UNIT, f"the square of the quaternions' norm is off 1 by {off:.2g} at most", off)


def finite(bench: Bench) -> Probe:
    """Numbers that are finite."""
    first = max(bench.answer(trial).broken for trial in bench.setup.trials)
    said = "every attitude is finite" if first < 0 else f"sample {first} is the first that is NaN, infinite or zero"
    return Probe("finite", first < 0, said, None if first < 0 else float(first))


def covariance(bench: Bench) -> Probe | None:
    """The covariance of the last sample of many runs beside its error."""
    errors, truths, told, axes = [], [], [], "world"
    for seed in range(SEEDS):
        answer = bench.answer(_noisy(bench.trial, seed))
        if answer.covariance is None:
            return None
        track = bench.mended(answer.track)
        errors.append(track.attitude_xyzw[-1])
        truths.append(track.truth.at(track.stamps_ns[-1:])[0])
        given = np.asarray(answer.covariance, dtype=float)
        told.append((given[-1] if given.ndim == 3 else given)[-3:, -3:])
        axes = answer.covariance_axes
    try:
        found = attitude_nees(np.array(errors), np.array(truths), np.array(told), axes=axes)
    except InputError as error:
        return Probe("covariance", passed=False, message=str(error))
    low, high = found.mean_bounds
    said = (
        f"mean NEES of {SEEDS} runs with noise: {found.mean:.3g}, {found.verdict}; {low:.3g} to {high:.3g} are honest"
    )
    return Probe("covariance", low <= found.mean <= high, said, found.mean)


def needs_rest(bench: Bench) -> Probe:
    """Runs without a rest, and with a longer one, before the motion."""
    without, longer = (bench.error(replace(bench.trial, rest_s=rest_s)) for rest_s in (0.0, 3.0 * REST))
    plain = bench.error(bench.trial)
    right = min(plain, longer)
    limit = max(bench.setup.floor, WORSE * right)
    said = (
        f"without a rest before the motion it errs by {shown_angle(float(np.degrees(without)))}, after {REST:g} s by "
    )
    said += (
        f"{shown_angle(float(np.degrees(plain)))}, after {3.0 * REST:g} s by {shown_angle(float(np.degrees(longer)))}"
    )
    return Probe("needs_rest", max(without, plain) <= limit, said, float(np.degrees(without)))


def causal(bench: Bench) -> Note | None:
    """Estimates that change when later readings are left out."""
    whole = bench.answer(bench.trial).track
    short = bench.answer(replace(bench.trial, moving_s=bench.trial.moving_s / 2.0)).track
    both = min(len(short.stamps_ns), len(whole.stamps_ns))
    off = float(np.max(angles_between(whole.attitude_xyzw[:both], short.attitude_xyzw[:both])))
    if off <= SAME:
        return None
    value = float(np.degrees(off))
    said = f"The estimate uses later readings, as smoothers do: without them it is another by up to {value:.2g}°."
    return Note("causal", said, value)


PROBES: Final = (
    half_turn,
    irregular_steps,
    converges,
    gyro_bias,
    accelerometer_bias,
    hard_iron,
    noise,
    dropouts,
    long_run,
    repeatable,
    norm,
    finite,
    covariance,
    needs_rest,
)
"""The probes in the order in which they are told."""
NOTES: Final = (constant_step, causal)
"""Probes whose outcome is a note."""
