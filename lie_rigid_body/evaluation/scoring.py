"""The scoring of an attitude estimate: compared with the truth at its stamps, and diagnosed; or as its samples come."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Booleans
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import remarks
from lie_rigid_body.evaluation.arguments import quantity, read_series, real_numbers
from lie_rigid_body.evaluation.attitudes import attitude_error
from lie_rigid_body.evaluation.causes import Track
from lie_rigid_body.evaluation.consistency import attitude_nees
from lie_rigid_body.evaluation.findings import Diagnosis, diagnose
from lie_rigid_body.evaluation.score import LARGEST_SETTLED_DEG, BestPossible, Score, seconds
from lie_rigid_body.evaluation.statistics import Limits, Statistics, largest, settling_limit, time_to_converge
from lie_rigid_body.evaluation.truth import HasTruth, Truth
from lie_rigid_body.evaluation.unavoidable import UnavoidableError
from lie_rigid_body.wording import shown


def evaluate(
    stamps_ns: ArrayLike,
    attitude_xyzw: ArrayLike,
    truth: Truth | HasTruth,
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
        The estimate, taken to be world-from-body, scalar last.
    truth : Truth or HasTruth
        A `Run`, an `ExactTruth` or a `SampledTruth`.
    limits : Limits, optional
    covariance : array_like, shape (N, 3, 3), (N, 6, 6), (3, 3) or (6, 6), optional
        The estimator's own; see `attitude_nees`. A single one is that of every sample.
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
        Largest constant turn that the declared errors of the sensors leave to a right filter, rad: none as small is a
        mistake.
    left_out : int
        Further estimates that were given, and left out before: limits are broken where most were.
    due_ns : int, optional
        The stamp until which estimates are due: limits are broken by those that end before half of the time from the
        first on. By default they may end at any time.

    Returns
    -------
    Score

    Raises
    ------
    InputError
        If the estimate is empty, out of order, not finite or zero somewhere, or shares no time with the truth.
    """
    if longest_lag_s is not None:
        longest_lag_s = quantity("longest_lag_s", longest_lag_s, "seconds", "longest_lag_s=1.0", or_zero=True)
    if converged_deg is not None:
        quantity("converged_deg", converged_deg, "degrees", "converged_deg=1.0")
    if not isinstance(limits, Limits | None):
        raise InputError(f"limits: {shown(limits)} is none: give for example Limits.parse('1deg', '10s:2deg')")
    truth = truth.attitude() if isinstance(truth, HasTruth) else truth
    if not isinstance(truth, Truth):
        raise InputError(f"truth: {shown(truth)} has no stamps: give the run, an ExactTruth or a SampledTruth")
    (stamps, attitude), limits = read_series("estimate", stamps_ns, attitude_xyzw), limits or Limits()
    first = np.diff(stamps, prepend=stamps[0] - 1) > 0
    whole = Track(stamps[first], attitude[first], truth)
    known = truth.covers(whole.stamps_ns)
    if not known.any():
        raise InputError(_apart(whole, len(stamps)))
    if stamps[0] == stamps[-1] and len(stamps) > 1:
        raise InputError(f"estimate: all {len(stamps)} stamps are {stamps[0]} ns: give each its own")
    track = whole.part(known)
    true = truth.at(track.stamps_ns)
    error = attitude_error(track.attitude_xyzw, true)
    total, heading, inclination = np.degrees(np.stack(error))
    t_s, statistics = seconds(track.stamps_ns), Statistics.of(total)
    uncertainty = float(np.degrees(truth.uncertainty_at(track.stamps_ns)))
    limit = min(settling_limit(t_s, total), LARGEST_SETTLED_DEG) if converged_deg is None else converged_deg
    due_s = 0.0 if due_ns is None else (due_ns - int(track.stamps_ns[0])) / 1e9
    diagnosis = diagnose(track, whole, longest_lag_s, sensors) if diagnosed else Diagnosis()
    found = (
        *diagnosis.findings,
        *remarks.of_series(stamps, first, np.asarray(attitude_xyzw, dtype=np.float64)),
        *remarks.of_span(track.stamps_ns, len(known), truth, due_ns),
        *remarks.of_truth(uncertainty, statistics.rms),
    )
    consistency = None
    if covariance is not None:
        P = _at_samples(real_numbers("covariance", covariance, "(..., 3, 3)"), first, known)
        consistency = attitude_nees(track.attitude_xyzw, true, P, covariance_axes)
    worst = [largest(start, t_s, total) for start, _ in limits.max_after]
    return Score(
        stamps_ns=track.stamps_ns,
        error=error,
        total_deg=statistics,
        heading_deg=Statistics.of(heading),
        inclination_deg=Statistics.of(inclination),
        time_to_converge_s=time_to_converge(t_s, total, limit),
        converged_deg=limit,
        lag_s=diagnosis.lag.lag_s,
        lag_standard_error_s=diagnosis.lag.standard_error_s,
        findings=tuple(replace(f, rms_deg_after=statistics.rms) if np.isnan(f.rms_deg_after) else f for f in found),
        broken=(
            *limits.broken(statistics.rms, worst, float(t_s[-1])),
            *limits.too_little(len(t_s), len(stamps) + left_out, float(t_s[-1]), due_s),
        ),
        outside=int(np.count_nonzero(~known)),
        truth_uncertainty_deg=uncertainty,
        consistency=consistency,
        best=None if bound is None else BestPossible.of(bound, track.stamps_ns, statistics.rms),
        limits=limits,
        of_sensors_deg=float(np.degrees(sensors)) if diagnosis.of_sensors else None,
    )


def _apart(whole: Track, given: int) -> str:
    """Error message that no stamp of so many estimates is within the truth; some may share one stamp."""
    stamps, truth = whole.stamps_ns, whole.truth
    ahead = (int(stamps[0]) - truth.first_ns) / 1e9
    span = f"within the truth, from {truth.first_ns / 1e9:.12g} s to {truth.last_ns / 1e9:.12g} s"
    if len(stamps) < min(given, 2):
        return (
            f"estimate: all of its {given} messages have the stamp {stamps[0] / 1e9:.12g} s, which is not {span}: "
            "fill in header.stamp"
        )
    return (
        f"estimate: none of its {given} stamps is {span}: they begin {abs(ahead):.9g} s "
        f"{'after' if ahead > 0 else 'before'} it; stamp them by its clock, in ns"
    )


def _at_samples(covariance: Array, first: Booleans, known: Booleans) -> Array:
    """Covariances of the samples that were compared: the first of each stamp at which the truth is known."""
    if covariance.ndim != 3:
        return covariance
    if len(covariance) != len(first):
        raise InputError(f"covariance: {len(covariance)} of them for {len(first)} estimates: give one, or one for each")
    return np.asarray(covariance[first][known])
