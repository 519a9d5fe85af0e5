"""The scoring of an attitude estimate: compared with the truth at its stamps, and diagnosed.

The diagnosis says which causes are named, and each in one sentence, with numbers and what to do.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import remarks
from lie_rigid_body.evaluation.arguments import quantity, unit
from lie_rigid_body.evaluation.attitudes import Truth, period_ns
from lie_rigid_body.evaluation.causes import MIN_COVERED, Part, Parts, fit, inflations, late, undone
from lie_rigid_body.evaluation.clock import SIGNIFICANT, Lag, lag_of, other_clock, standard_error
from lie_rigid_body.evaluation.consistency import attitude_nees
from lie_rigid_body.evaluation.cramer_rao_bound import CramerRaoBound
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.evidence import LEAD, MAX_INFLATION, TIE, Choice, Evidence
from lie_rigid_body.evaluation.explanations import PAIRS, SHARE, Explanation
from lie_rigid_body.evaluation.matched import MIN_SAMPLES, Matched, floored, lags_of_rates
from lie_rigid_body.evaluation.score import BiasEstimate, BoundComparison, Finding, Score, ScoreNote
from lie_rigid_body.evaluation.statistics import (
    MIN_LIMIT,
    Limits,
    Statistics,
    Tally,
    largest_of_second_half,
    rms,
    settling_limit,
    time_to_converge,
)
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import in_degrees, shown

UNLIKE_DEG: Final = 5.0
"""Median error above which an estimate is asked whether it turns as the body does, degrees."""
MAX_FAR_S: Final = 10.0
"""Longest lag that is looked for beside turns of the world and of the body, s: clocks set by hand differ by seconds."""
MAX_FAR: Final = 3
"""Number of such lags that are judged: those at which the estimate turns as fast as the body."""
UNHEARD: Final = 20.0
"""Number of samples from which on a lag may be that of a filter without a gyro, whose time constant it is then."""

NOTHING: Final = Choice(Explanation((), (), np.ones(3), np.zeros(0)), of_sensors=False)
"""Choice where there are too few samples."""
NO_GRAVITY: Final = (
    "The accelerometer of this run reads no gravity (accelerometer_mode: free_fall), so no filter can take the "
    "vertical from it: give accelerometer_mode pivot_gravity, or a filter that does without it."
)
"""Sentence about large errors of the vertical in a run without gravity."""


class ScoresEstimates(ABC):
    """Something that scores an estimate against its own truth, as a `Run` does."""

    @abstractmethod
    def score(self, *given: Any, **how: Any) -> Score:
        """The score of an estimate, as `evaluate` makes it."""


@dataclass(frozen=True)
class ScoreOptions:
    """How an estimate is scored; see `evaluate`.

    Raises
    ------
    InputError
        If one is no such number.
    """

    limits: Limits = field(default_factory=Limits)
    converged_deg: float | None = None
    longest_lag_s: float | None = None
    diagnosed: bool = True

    def __post_init__(self) -> None:
        if self.longest_lag_s is not None:
            quantity("longest_lag_s", self.longest_lag_s, "seconds", "longest_lag_s=1.0", or_zero=True)
        if self.converged_deg is not None:
            quantity("converged_deg", self.converged_deg, "degrees", "converged_deg=1.0")
        if not isinstance(self.limits, Limits):
            raise InputError(f"limits: {shown(self.limits)} is none: give for example Limits.parse('1deg', '10s:2deg')")


@dataclass(frozen=True, eq=False)
class SensorLimits:
    """Limits that the sensors of a run set to any estimate of it.

    Attributes
    ----------
    bound : CramerRaoBound or None
        Bound that their noise sets, on the clock of the truth.
    left_rad : float
        Largest constant attitude error that their declared errors cause in a right filter, rad. A smaller one is no
        mistake.
    gyro_at_limit : float
        Share of the gyro's readings that are at the limit of its range.
    weightless : bool
        Whether the accelerometer reads no gravity.
    """

    bound: CramerRaoBound | None = None
    left_rad: float = 0.0
    gyro_at_limit: float = 0.0
    weightless: bool = False


def evaluate(
    stamps_ns: ArrayLike | None,
    attitude_xyzw: ArrayLike | Estimate,
    truth: Truth | ScoresEstimates,
    *,
    limits: Limits | None = None,
    covariance: ArrayLike | None = None,
    covariance_axes: str | None = None,
    converged_deg: float | None = None,
    longest_lag_s: float | None = None,
    diagnosed: bool = True,
) -> Score:
    """Score and diagnose an attitude estimate against the truth at its stamps.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (N,), or None
        Stamps of the estimate, ns, on the clock of the truth, never decreasing. None: those of the `Estimate`.
    attitude_xyzw : array_like, shape (N, 4), or Estimate
        The estimate, taken to be world-from-body, scalar last. What is given beside an `Estimate` takes the place of
        its own; its gyro bias has a score beside a run.
    truth : Truth or Run
        An `ExactTruth`, a `SampledTruth`, or a `Run`, which scores the estimate by its method ``score``.
    limits : Limits, optional
    covariance : array_like, shape (N, 3, 3), (N, 6, 6), (3, 3) or (6, 6), optional
        Covariance that the estimator claims; see `attitude_nees`. A single one is that of every sample.
    covariance_axes : str, optional
        ``"world"`` or ``"body"``.
    converged_deg : float, optional
        Total error below which the estimate counts as converged, degrees.
    longest_lag_s : float, optional
        Longest lag that is looked for, s; at most a quarter of the run. By default 1 s, and a farther one where nothing
        else explains a large error.
    diagnosed : bool
        Whether lag and mistaken conventions are looked for, which takes most of the time.

    Returns
    -------
    Score

    Raises
    ------
    InputError
        If the estimate is empty, out of order, not finite or zero somewhere, or shares no time with the truth. Also if
        another argument is no such number.
    """
    if isinstance(truth, ScoresEstimates):
        return truth.score(
            attitude_xyzw,
            stamps_ns,
            limits=limits,
            covariance=covariance,
            covariance_axes=covariance_axes,
            converged_deg=converged_deg,
            longest_lag_s=longest_lag_s,
            diagnosed=diagnosed,
        )
    if not isinstance(truth, Truth):
        raise InputError(f"truth: {shown(truth)} has no stamps: give the run, an ExactTruth or a SampledTruth")
    estimate = Estimate.of(attitude_xyzw, t_ns=stamps_ns, covariance=covariance, covariance_axes=covariance_axes)
    if estimate.t_ns is None:
        raise InputError("stamps_ns: None, and the estimate has no t_ns: give a stamp for each attitude, in ns")
    options = ScoreOptions(Limits() if limits is None else limits, converged_deg, longest_lag_s, diagnosed)
    return score_estimate(estimate, truth, options)


def score_estimate(
    estimate: Estimate,
    truth: Truth,
    options: ScoreOptions = ScoreOptions(),
    sensors: SensorLimits = SensorLimits(),
    *,
    gyro_bias: BiasEstimate | None = None,
    left_out: int = 0,
    due_ns: int | None = None,
) -> Score:
    """Score an estimate that has stamps.

    Parameters
    ----------
    estimate : Estimate
    truth : Truth
    options : ScoreOptions, optional
    sensors : SensorLimits, optional
    gyro_bias : BiasEstimate, optional
        Estimated biases of the gyro beside the true ones.
    left_out : int
        Number of estimates that were left out before this call. Limits are broken where most were left out.
    due_ns : int, optional
        The stamp until which estimates are due: limits are broken by those that end before half of the time from the
        first on. By default they may end at any time.

    Raises
    ------
    InputError
        As `evaluate`.
    """
    stamps: Integers = estimate.t_ns
    attitude = unit("estimate", estimate.attitude_xyzw)
    first = np.diff(stamps, prepend=stamps[0] - 1) > 0
    whole = Matched(stamps[first], attitude[first], truth)
    known = truth.covers(whole.stamps_ns)
    if stamps[0] == stamps[-1] and len(stamps) > 1:
        raise InputError(f"estimate: all of its {len(stamps)} stamps are {stamps[0]} ns: fill in header.stamp")
    if not known.any():
        raise InputError(_apart(stamps, truth))
    track = whole[known]
    error = track.error()
    total, heading, inclination = np.degrees(np.stack(error))
    t_s = (track.stamps_ns - track.stamps_ns[0]) / 1e9
    statistics = Statistics.of(total)
    tally = Tally(options.limits)
    tally.add(track.stamps_ns, error)
    uncertainty = math.degrees(truth.uncertainty_at(track.stamps_ns))
    limit = options.converged_deg
    settled_deg = None
    if limit is None:
        settled_deg = largest_of_second_half(t_s, total)
        limit = settling_limit(settled_deg)
    found = Diagnosis()
    if options.diagnosed:
        found = diagnose(track, whole, options.longest_lag_s, sensors.left_rad)
    remarked = (
        *remarks.of_series(stamps, first, estimate.attitude_xyzw, truth),
        *remarks.of_span(whole.stamps_ns, known, truth, due_ns),
        *remarks.of_truth(uncertainty, statistics.rms),
    )
    consistency = None
    if estimate.covariance is not None:
        covariance = estimate.rotation_covariance()[first][known]
        consistency = attitude_nees(track.attitude_xyzw, track.truth_xyzw, covariance, estimate.covariance_axes)
    return Score(
        stamps_ns=track.stamps_ns,
        error=error,
        total_deg=statistics,
        heading_deg=Statistics.of(heading),
        inclination_deg=Statistics.of(inclination),
        time_to_converge_s=time_to_converge(t_s, total, limit),
        converged_deg=limit,
        lag_s=found.lag.lag_s,
        lag_standard_error_s=found.lag.standard_error_s,
        findings=(*found.findings, *(Finding(*remark, statistics.rms) for remark in remarked)),
        broken=tuple(tally.broken(len(stamps) + left_out, due_ns)),
        outside=int(np.count_nonzero(~known)),
        truth_uncertainty_deg=uncertainty,
        consistency=consistency,
        gyro_bias=gyro_bias,
        best=None if sensors.bound is None else BoundComparison.of(sensors.bound, track.stamps_ns, statistics.rms),
        limits=options.limits,
        of_sensors_deg=math.degrees(sensors.left_rad) if found.of_sensors else None,
        gyro_at_limit=sensors.gyro_at_limit,
        settled_deg=settled_deg,
        remarks=(NO_GRAVITY,) if sensors.weightless and np.median(inclination) > UNLIKE_DEG else (),
        notes=found.notes,
    )


def _apart(stamps: Integers, truth: Truth) -> str:
    """Error message that none of the stamps is within the truth."""
    ahead = (stamps[0] - truth.first_ns) / 1e9
    return (
        f"estimate: none of its {len(stamps)} stamps is within the truth, from {truth.first_ns / 1e9:.12g} s to "
        f"{truth.last_ns / 1e9:.12g} s: they begin {abs(ahead):.9g} s {'after' if ahead > 0 else 'before'} it; stamp "
        "them by its clock, in ns"
    )


@dataclass(frozen=True)
class Diagnosis:
    """Explanation of the errors of an estimate.

    Attributes
    ----------
    lag : Lag
    findings : tuple of Finding
        Mistakes, and remarks on how it turns.
    of_sensors : bool
        Whether a constant turn was found that is no larger than what the sensors' own errors leave.
    notes : tuple of ScoreNote
    """

    lag: Lag = field(default_factory=Lag)
    findings: tuple[Finding, ...] = ()
    of_sensors: bool = False
    notes: tuple[ScoreNote, ...] = ()


def diagnose(
    track: Matched, whole: Matched, longest_lag_s: float | None = None, left_by_sensors: float = 0.0
) -> Diagnosis:
    """Find the lag and the mistakes, and what is wrong about the turns where nothing else is.

    Parameters
    ----------
    track : Matched
        Samples within the truth's times.
    whole : Matched
        All samples.
    longest_lag_s : float, optional
        As given to `evaluate`.
    left_by_sensors : float, optional
        Largest constant turn that the sensors' own errors leave to a right filter, rad.
    """
    stamps = track.stamps_ns
    turned = remarks.Turns(track)
    error = np.degrees(track.error().total)
    unlike = bool(np.median(error) > UNLIKE_DEG)
    sure = (turned.stuck() or turned.mixed()) if rms(error) > UNLIKE_DEG else None
    if sure:  # of fast turns every sample jumps
        remark = (turned.other() if sure.code == "mixed" else None) or sure
        return Diagnosis(findings=(Finding(*remark, rms(error)),))
    longest_s = min(1.0 if longest_lag_s is None else longest_lag_s, (stamps[-1] - stamps[0]) / 4e9)
    evidence = _evidence(track, longest_s, left_by_sensors)
    choice = evidence.choice() if evidence else NOTHING
    named = choice.named
    lost = unlike and not named.causes and not (evidence and evidence.follows())
    # a motion that nearly repeats has a near lag or a rotation for each far lag
    near = unlike and bool({"world_turned", "body_mounting", "lag"} & {*named.causes})
    may_be_far = lost or near or choice.at_limit
    beyond_s = 0.9 * longest_s if longest_lag_s is None else np.inf
    other = other_clock(whole, beyond_s, rates=lost) if may_be_far else None
    most = (TIE if "lag" in named.causes or named.turned == PAIRS[1] else 0.5) * named.error if near else np.inf
    if other and rms(other[1].error().total) <= most:
        part, moved = other
        after = np.degrees(moved.error().total)
        lag = Lag() if part[0].code == "clock_rate" else Lag(float(part[1][0]), standard_error(moved, [late(0.0)]))
        return Diagnosis(lag, (_finding(part, _errors(whole, []), after, whole.known()),))
    if not evidence:
        return Diagnosis()
    if may_be_far and beyond_s < np.inf and (far := _far(whole, named, longest_s, left_by_sensors)):
        return far
    lag = Lag() if choice.at_limit else lag_of(evidence.whole, named, longest_s, evidence.period_s)
    named = named if lag.lag_s is None or not lag.sure else evidence.with_lag(named, lag.lag_s)
    told = _in_words(track, evidence, named, named.parts) if named.causes else ()
    # a gyro on other axes is the same map as three conventions and a turned world, and has the simpler name
    many = len(named.form) + len(named.turned) > (1 if "world_turned" in named.turned else 2)
    if named.turned == PAIRS[1] and (named.lag_s is not None or error[0] > UNLIKE_DEG):
        many = False  # a filter whose gyro is on other axes begins right
    instead = turned.other() if (lost and not told) or many else None
    if choice.converging and not instead:
        return Diagnosis(of_sensors=choice.of_sensors)
    notes = _ahead(evidence, choice, lag)
    return Diagnosis(lag, (Finding(*instead, rms(error)),) if instead else told, choice.of_sensors, notes)


def _evidence(track: Matched, longest_s: float, left_by_sensors: float) -> Evidence | None:
    """The evidence of the samples that stay within the truth's times by any lag; None of too few."""
    margin = round(longest_s * 1e9)
    stamps = track.stamps_ns
    inner = track[track.truth.covers(stamps - margin) & track.truth.covers(stamps + margin)]
    return Evidence(inner, longest_s, left_by_sensors) if len(inner.stamps_ns) >= MIN_SAMPLES else None


def _far(whole: Matched, named: Explanation, longest_s: float, left_by_sensors: float) -> Diagnosis | None:
    """A lag beyond the longest one, with what else there is by that: turns of the world or of the body; else None.

    It must leave a third of the error in each quarter, at most, beside what is named without it.
    """
    for lag_s in lags_of_rates(whole, MAX_FAR_S)[:MAX_FAR]:
        moved = undone(whole, [late(lag_s)]).known()
        enough = abs(lag_s) > 0.9 * longest_s and len(moved.stamps_ns) >= MIN_COVERED * len(whole.stamps_ns)
        evidence = _evidence(moved, longest_s, left_by_sensors) if enough else None
        best = evidence.choice().named if evidence else named
        turns = [part for part in best.parts if part[0].unit != "s"]
        near_s = best.lag_s or 0.0
        explains = best.explains and np.all(floored(best.left) <= SHARE**2 * floored(named.left))
        if evidence and explains and max(inflations(evidence.track, [*turns, late(near_s)])) <= MAX_INFLATION:
            near = lag_of(evidence.whole, best, longest_s, evidence.period_s)
            lag = Lag(lag_s + near.lag_s, near.standard_error_s) if near.lag_s is not None else Lag()
            return Diagnosis(lag, _in_words(whole, evidence, best, [*turns, late(lag_s + near_s)]))
    return None


def _ahead(evidence: Evidence, choice: Choice, lag: Lag) -> tuple[ScoreNote, ...]:
    """The note on a filter that compares readings with the attitude before the gyro's step, where the lead shows."""
    lag_s = lag.lag_s or 0.0
    is_lead = -LEAD * evidence.period_s <= lag_s < -SIGNIFICANT * (lag.standard_error_s or 0.0)
    by_lag = -lag_s * evidence.root_mean_square_rate if is_lead else 0.0
    turn = math.degrees(by_lag or (0.0 if choice.named.causes else evidence.lead[0]))
    if turn <= MIN_LIMIT:
        return ()
    message = (
        f"The filter compares readings with the attitude before its gyro step, as most do: its estimate is ahead by up "
        f"to a sample, {in_degrees(turn, 3)}. It is no mistake; with the readings one sample later it vanishes."
    )
    return (ScoreNote("ahead_by_a_sample", message, turn),)


def _in_words(
    track: Matched, evidence: Evidence, named: Explanation, parts: Parts, most: int = 2000
) -> tuple[Finding, ...]:
    """Put the causes that are named into words, in the order of their effect; those without constants come first.

    Their constants are fitted to `most` samples. Nothing is said if the errors of all samples grow when all causes are
    undone, as where most are of something else.
    """
    few = track.fraction(0.25).thinned(most)
    rest = fit([few[few.truth.covers(undone(few, parts).stamps_ns)]], parts)
    found = list[Finding]()
    done = list[Part]()
    errors = [_errors(track, [])]
    while rest:
        # all constants are those of one fit: they hold together, and the last finding tells what they leave
        fixed = [part for part in rest if not part[0].price]
        nearest = min(fixed[:1] or rest, key=lambda part: rms(_errors(track, [*done, part])))
        rest = [part for part in rest if part is not nearest]
        done.append(nearest)
        errors.append(_errors(track, done))
        code = "lag" if nearest[0].unit == "s" else nearest[0].code
        others = evidence.instead_of(named, code) if code in named.causes else ()
        found.append(_finding(nearest, errors[-2], errors[-1], track, others))
    return tuple(found) if rms(errors[-1]) <= rms(errors[0]) else ()


def _errors(track: Matched, parts: Parts) -> Array:
    """Errors without some causes where the truth is known, degrees."""
    return np.degrees(undone(track, parts).known().error().total)


def _finding(part: Part, before: Array, after: Array, track: Matched, instead: Sequence[str] = ()) -> Finding:
    """Put a cause into words, with the errors before and after it is undone, degrees, and causes that do as well."""
    (cause, constants) = part
    others = [name.replace("_", " ") for name in instead]
    fact, _, deed = cause.fact(constants).partition(": ")
    remedy = cause.remedy(constants) or deed
    if cause.code in {"lagging", "leading"}:
        samples = abs(constants[0]) / (period_ns(track.stamps_ns) / 1e9)
        late = "late by" if cause.code == "lagging" else "stamped before the truth by"
        fact = f"The estimate is {late} {abs(constants[0]):.4g} s, {samples:.3g} of its samples"
        remedy += "; or the gyro is not heard (its unit)" if cause.code == "lagging" and samples > UNHEARD else ""
        others += ["an error of the gyro's scale or bias"] if others else []
    gain = (
        f"median error {in_degrees(np.median(before), 3)} before and {in_degrees(np.median(after), 3)} after, "
        f"rms {in_degrees(rms(before), 3)} and {in_degrees(rms(after), 3)}"
    )
    if np.median(after) >= np.median(before):  # alone it need not help
        gain = "helps only together with what follows"
    doubt = f"; this motion does not tell it from {' or '.join(others)}" if others else ""
    told = ": ".join(filter(None, (fact, remedy)))
    return Finding(cause.code, f"{told} ({gain}){doubt}.", rms(after))
