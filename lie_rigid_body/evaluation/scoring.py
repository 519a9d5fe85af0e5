"""The scoring of an attitude estimate: compared with the truth at its stamps, and diagnosed.

The diagnosis says which causes are named, and each in one sentence, with numbers and what to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import remarks
from lie_rigid_body.evaluation.arguments import quantity, read_series, real_numbers
from lie_rigid_body.evaluation.attitudes import Truth, attitude_error, period_ns
from lie_rigid_body.evaluation.causes import Part, fit, late, undone
from lie_rigid_body.evaluation.clock import Clock, Lag, lag_of, other_clock, standard_error
from lie_rigid_body.evaluation.consistency import attitude_nees, require_axes
from lie_rigid_body.evaluation.explanations import TIE, Evidence, Explanation
from lie_rigid_body.evaluation.score import LARGEST_SETTLED_DEG, BestPossible, Finding, Score
from lie_rigid_body.evaluation.statistics import Limits, Statistics, Tally, rms, settling_limit, time_to_converge
from lie_rigid_body.evaluation.track import FEWEST, Track
from lie_rigid_body.evaluation.unavoidable import UnavoidableError
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, as_double, whole_number
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown

UNLIKE_DEG: Final = 5.0
"""Median error above which an estimate is asked whether it turns as the body does, degrees."""


@runtime_checkable
class HasScore(Protocol):
    """Something that scores an estimate against its own truth, as a run does."""

    def score(self, *given: Any, **how: Any) -> Score:
        """The score of an estimate, as `evaluate` makes it."""


class HasAttitude(Protocol):
    """Something with attitudes, as an `Estimate`; a run scores it."""

    @property
    def attitude_xyzw(self) -> Any:
        """The attitudes."""


def evaluate(
    stamps_ns: ArrayLike,
    attitude_xyzw: ArrayLike | HasAttitude,
    truth: Truth | HasScore,
    *,
    limits: Limits | None = None,
    covariance: ArrayLike | None = None,
    covariance_axes: str = "world",
    converged_deg: float | None = None,
    longest_lag_s: float | None = None,
    diagnosed: bool = True,
    bound: UnavoidableError | None = None,
    sensors: float = 0.0,
    left_out: int = 0,
    due_ns: int | None = None,
) -> Score:
    """Score and diagnose an attitude estimate against the truth at its stamps.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (N,)
        Stamps of the estimate, ns, on the clock of the truth, never decreasing.
    attitude_xyzw : array_like, shape (N, 4)
        The estimate, taken to be world-from-body, scalar last; beside a run also an `Estimate`.
    truth : Truth or HasScore
        An `ExactTruth`, a `SampledTruth`, or a `Run`. A run scores the estimate by its method ``score``; it knows
        `bound` and `sensors`, and takes no `left_out` or `due_ns`.
    limits : Limits, optional
    covariance : array_like, shape (N, 3, 3), (N, 6, 6), (3, 3) or (6, 6), optional
        Covariance that the estimator claims; see `attitude_nees`. A single one is that of every sample.
    covariance_axes : str
        ``"world"`` or ``"body"``.
    converged_deg : float, optional
        Total error below which the estimate counts as converged, degrees.
    longest_lag_s : float, optional
        Longest lag that is looked for, s; at most a quarter of the run. By default 1 s, and a quarter of the run if a
        lag of 1 s seems to be too short.
    diagnosed : bool
        Whether lag and mistaken conventions are looked for, which takes most of the time.
    bound : UnavoidableError, optional
        What the sensors' noise leaves at best, on the same clock.
    sensors : float
        Largest constant attitude error, rad, that the declared sensor errors cause in a right filter. A smaller one is
        no mistake.
    left_out : int
        Number of estimates that were left out before this call. Limits are broken where most were left out.
    due_ns : int, optional
        The stamp until which estimates are due: limits are broken by those that end before half of the time from the
        first on. By default they may end at any time.

    Returns
    -------
    Score

    Raises
    ------
    InputError
        If the estimate is empty, out of order, not finite or zero somewhere, or shares no time with the truth. Also if
        another argument is no such number.
    """
    require_axes(covariance_axes)
    if longest_lag_s is not None:
        longest_lag_s = quantity("longest_lag_s", longest_lag_s, "seconds", "longest_lag_s=1.0", or_zero=True)
    if converged_deg is not None:
        quantity("converged_deg", converged_deg, "degrees", "converged_deg=1.0")
    if not isinstance(limits, Limits | None):
        raise InputError(f"limits: {shown(limits)} is none: give for example Limits.parse('1deg', '10s:2deg')")
    if isinstance(truth, HasScore):
        if (bound, sensors, left_out, due_ns) != (None, 0.0, 0, None):
            raise InputError(
                "bound, sensors, left_out, due_ns: a run tells them: leave them out, or give run.attitude()"
            )
        return truth.score(
            attitude_xyzw,
            stamps_ns,
            limits=limits,
            covariance=covariance,
            covariance_axes=None if covariance is None else covariance_axes,
            converged_deg=converged_deg,
            longest_lag_s=longest_lag_s,
            diagnosed=diagnosed,
        )
    if not isinstance(truth, Truth):
        raise InputError(f"truth: {shown(truth)} has no stamps: give the run, an ExactTruth or a SampledTruth")
    if not (isinstance(bound, UnavoidableError | None) and as_double(sensors) >= 0.0):
        raise InputError(
            f"bound {shown(bound)}, sensors {shown(sensors)}: give what unavoidable_error() returns, and rad from 0 on"
        )
    left_out = whole_number("left_out", left_out, 0)
    due_ns = None if due_ns is None else whole_number("due_ns", due_ns, -(2**63), 2**63 - 1)
    (stamps, attitude), limits = (
        read_series("estimate", stamps_ns, cast("ArrayLike", attitude_xyzw)),
        limits or Limits(),
    )
    first = np.diff(stamps, prepend=stamps[0] - 1) > 0
    whole = Track(stamps[first], attitude[first], truth)
    known = truth.covers(whole.stamps_ns)
    if stamps[0] == stamps[-1] and len(stamps) > 1:
        raise InputError(f"estimate: all of its {len(stamps)} stamps are {stamps[0]} ns: fill in header.stamp")
    if not known.any():
        raise InputError(_apart(stamps, truth))
    track = whole.part(known)
    true = truth.at(track.stamps_ns)
    error = attitude_error(track.attitude_xyzw, true)
    total, heading, inclination = np.degrees(np.stack(error))
    t_s, statistics = (track.stamps_ns - track.stamps_ns[0]) / 1e9, Statistics.of(total)
    tally = Tally(limits)
    tally.add(track.stamps_ns, error)
    uncertainty = float(np.degrees(truth.uncertainty_at(track.stamps_ns)))
    limit = min(settling_limit(t_s, total), LARGEST_SETTLED_DEG) if converged_deg is None else converged_deg
    lag, causes, of_sensors = diagnose(track, whole, longest_lag_s, sensors) if diagnosed else (Lag(), (), False)
    found = (
        *causes,
        *remarks.of_series(stamps, first, np.asarray(attitude_xyzw, dtype=np.float64), truth),
        *remarks.of_span(whole.stamps_ns, known, truth, due_ns),
        *remarks.of_truth(uncertainty, statistics.rms),
    )
    return Score(
        stamps_ns=track.stamps_ns,
        error=error,
        total_deg=statistics,
        heading_deg=Statistics.of(heading),
        inclination_deg=Statistics.of(inclination),
        time_to_converge_s=time_to_converge(t_s, total, limit),
        converged_deg=limit,
        lag_s=lag.lag_s,
        lag_standard_error_s=lag.standard_error_s,
        findings=tuple(replace(f, rms_deg_after=statistics.rms) if np.isnan(f.rms_deg_after) else f for f in found),
        broken=tuple(tally.broken(len(stamps) + left_out, due_ns)),
        outside=int(np.count_nonzero(~known)),
        truth_uncertainty_deg=uncertainty,
        consistency=None
        if covariance is None
        else attitude_nees(track.attitude_xyzw, true, _at_samples(covariance, first, known), covariance_axes),
        best=None if bound is None else BestPossible.of(bound, track.stamps_ns, statistics.rms),
        limits=limits,
        of_sensors_deg=float(np.degrees(sensors)) if of_sensors else None,
    )


def _apart(stamps: Integers, truth: Truth) -> str:
    """Error message that none of the stamps is within the truth."""
    ahead = (int(stamps[0]) - truth.first_ns) / 1e9
    return (
        f"estimate: none of its {len(stamps)} stamps is within the truth, from {truth.first_ns / 1e9:.12g} s to "
        f"{truth.last_ns / 1e9:.12g} s: they begin {abs(ahead):.9g} s {'after' if ahead > 0 else 'before'} it; stamp "
        "them by its clock, in ns"
    )


def _at_samples(covariance: ArrayLike, first: Booleans, known: Booleans) -> Array:
    """Covariances of the samples that were compared: the first of each stamp at which the truth is known."""
    P = real_numbers("covariance", covariance, "(..., 3, 3)")
    if P.ndim == 3 and len(P) != len(first):
        raise InputError(f"covariance: {len(P)} of them for {len(first)} estimates: give one, or one for each")
    return P[first][known] if P.ndim == 3 else P


def diagnose(
    track: Track, whole: Track, longest_lag_s: float | None = None, sensors: float = 0.0
) -> tuple[Lag, tuple[Finding, ...], bool]:
    """Find the lag and the mistakes, and what is wrong about the turns where nothing else is.

    Parameters
    ----------
    track : Track
        Samples within the truth's times.
    whole : Track
        All samples.
    longest_lag_s : float, optional
        As given to `evaluate`.
    sensors : float, optional
        Largest constant turn that the sensors' own errors leave to a right filter, rad.

    Returns
    -------
    Lag
    tuple of Finding
        Mistakes, and remarks on how it turns.
    bool
        Whether a constant turn was found that is no larger than what the sensors' own errors leave.
    """
    stamps, truth, turned, error = track.stamps_ns, track.truth, remarks.Turns(track), np.degrees(track.error().total)
    unlike = bool(np.median(error) > UNLIKE_DEG)
    sure = (turned.stuck() or turned.mixed()) if rms(error) > UNLIKE_DEG else None
    if sure:  # of fast turns every sample jumps
        return Lag(), ((turned.other() if sure.code == "mixed" else None) or sure,), False
    quarter = float(stamps[-1] - stamps[0]) / 4e9
    longest_s = min(1.0 if longest_lag_s is None else longest_lag_s, quarter)
    margin = round(longest_s * 1e9)
    inner = track.part(truth.covers(stamps - margin) & truth.covers(stamps + margin))
    evidence = Evidence(inner, longest_s, sensors) if len(inner.stamps_ns) >= FEWEST else None
    named, of_sensors, at_limit = evidence.choice() if evidence else (None, False, False)
    causes = {*named.causes} if named else set[str]()
    lost = unlike and not causes and not (evidence and evidence.follows())
    # a motion that nearly repeats has a near lag with a mounting for each far one
    near = unlike and bool({"world_turned", "body_mounting", "lag"} & causes)
    found = other_clock(whole, 0.9 * longest_s) if longest_lag_s is None and (lost or at_limit or near) else None
    most = (TIE if "lag" in causes else 0.5) * named.error if named and near else np.inf
    if found is not None and rms(found[1].error().total) <= most:
        return _of_clock(whole, *found)
    if not evidence or not named:
        return Lag(), (), False
    lag = Lag() if at_limit else lag_of(inner, named, longest_s, period_ns(stamps) / 1e9)
    named = named if lag.lag_s is None or not lag.sure else evidence.with_lag(named, lag.lag_s)
    told = _in_words(track, evidence, named) if named.causes else ()
    # a gyro on other axes is the same map as three conventions and a turned world, and has the simpler name
    many = len(told) > (1 if "world_turned" in named.turned else 2)
    other = turned.other() if (lost and not told) or many else None
    return lag, (other,) if other else told, of_sensors


def _in_words(track: Track, evidence: Evidence, named: Explanation, most: int = 2000) -> tuple[Finding, ...]:
    """Put the causes that are named into words, in the order of their effect; those without constants come first.

    Their constants are fitted to `most` samples. Nothing is said if the errors of all samples grow when all causes are
    undone, as where most are of something else.
    """
    parts, few = named.parts, track.share(0.25).few(most)
    rest = fit([few.part(few.truth.covers(undone(few, parts).stamps_ns))], parts)
    found, done, errors = list[Finding](), list[Part](), [_errors(track, [])]
    while rest:
        # all constants are those of one fit: they hold together, and the last finding tells what they leave
        fixed = [part for part in rest if not part[0].price]
        nearest = min(fixed[:1] or rest, key=lambda part: rms(_errors(track, [*done, part])))
        rest = [part for part in rest if part is not nearest]
        done.append(nearest)
        errors.append(_errors(track, done))
        others = evidence.instead_of(named, "lag" if nearest[0].code in {"lagging", "leading"} else nearest[0].code)
        found.append(_finding(nearest, errors[-2], errors[-1], track, others))
    return tuple(found) if rms(errors[-1]) <= rms(errors[0]) else ()


def _of_clock(whole: Track, clock: Clock, track: Track) -> tuple[Lag, tuple[Finding, ...], bool]:
    """Put another clock into words, of all samples and of those that it puts within the truth's times."""
    *rate, (_, lag_s) = clock
    part = rate[0] if rate else late(float(lag_s[0]))
    lag = Lag() if rate else Lag(float(lag_s[0]), standard_error(track, [late(0.0)]))
    return lag, (_finding(part, _errors(whole, []), np.degrees(track.error().total), whole.known()),), False


def _errors(track: Track, parts: Sequence[Part]) -> Array:
    """Errors without some causes where the truth is known, degrees."""
    return np.asarray(np.degrees(undone(track, parts).known().error().total))


def _finding(part: Part, before: Array, after: Array, track: Track, instead: Sequence[str] = ()) -> Finding:
    """Put a cause into words, with the errors before and after it is undone, degrees, and causes that do as well."""
    (cause, constants), others = part, [name.replace("_", " ") for name in instead]
    fact, _, deed = cause.fact(constants).partition(": ")
    if cause.code in {"lagging", "leading"}:
        fact += f", {abs(constants[0]) / (period_ns(track.stamps_ns) / 1e9):.3g} of its samples"
        others += ["an error of the gyro's scale or bias"] if others else []
    gain = (
        f"median error {np.median(before):.3g}° before and {np.median(after):.3g}° after, "
        f"rms {rms(before):.3g}° and {rms(after):.3g}°"
    )
    if np.median(after) >= np.median(before):  # alone it need not help
        gain = "helps only together with what follows"
    doubt = f"; this motion does not tell it from {' or '.join(others)}" if others else ""
    told = ": ".join(filter(None, (fact, cause.remedy(constants) or deed)))
    return Finding(cause.code, f"{told} ({gain}){doubt}.", rms(after))
