"""The scoring of an attitude estimate: compared with the truth at its stamps, and diagnosed; or as its samples come."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import quantity, real_numbers
from lie_rigid_body.evaluation.attitude_error import AttitudeError, attitude_error
from lie_rigid_body.evaluation.best_possible import BestPossible
from lie_rigid_body.evaluation.causes import Track
from lie_rigid_body.evaluation.clock import Lag, clock_lag, lag_of, other_clock
from lie_rigid_body.evaluation.consistency import attitude_nees
from lie_rigid_body.evaluation.estimate import GAP, ReadEstimate, Remark, period_ns
from lie_rigid_body.evaluation.explanations import TIE
from lie_rigid_body.evaluation.findings import Finding, choose, clock_finding, findings
from lie_rigid_body.evaluation.limits import Largest, Limits, largest
from lie_rigid_body.evaluation.score import LARGEST_SETTLED_DEG, Score, seconds
from lie_rigid_body.evaluation.statistics import SMALLEST_LIMIT, Statistics, rms, settling_limit, time_to_converge
from lie_rigid_body.evaluation.truth import HasTruth, Truth
from lie_rigid_body.evaluation.turning import Turns
from lie_rigid_body.evaluation.unavoidable import UnavoidableError
from lie_rigid_body.wording import shown

LONGEST_LAG_S: Final = 1.0
"""Longest lag looked for, s, either way, unless the errors ask for more."""
ABSENT: Final = 0.05
"""Largest share of the truth's times by which a filter may begin late or end early without a remark."""

MOST_NAMED: Final = 2
"""Number of causes, one if the world is turned, above which it is asked whether the turns have a simpler name."""
UNLIKE_DEG: Final = 5.0
"""Median error above which an estimate is asked whether it turns as the body does, degrees."""


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
    whole, limits = ReadEstimate.read(stamps_ns, attitude_xyzw), limits or Limits()
    known = truth.covers(whole.stamps_ns)
    if not known.any():
        raise InputError(_apart(whole.stamps_ns, np.size(stamps_ns), truth))
    if len(whole.stamps_ns) < np.size(stamps_ns) and whole.stamps_ns[0] == whole.stamps_ns[-1]:
        raise InputError(f"estimate: all {np.size(stamps_ns)} stamps are {whole.stamps_ns[0]} ns: give each its own")
    estimate = ReadEstimate(whole.stamps_ns[known], whole.attitude_xyzw[known], whole.remarks)
    true = truth.at(estimate.stamps_ns)
    error = attitude_error(estimate.attitude_xyzw, true)
    total, heading, inclination = (np.degrees(angle) for angle in error)
    t_s = seconds(estimate.stamps_ns)
    uncertainty = float(np.degrees(truth.uncertainty_at(estimate.stamps_ns)))
    limit = min(settling_limit(t_s, total), LARGEST_SETTLED_DEG) if converged_deg is None else converged_deg
    statistics = Statistics.of(total)
    given, due_s = np.size(stamps_ns) + left_out, 0.0 if due_ns is None else (due_ns - int(estimate.stamps_ns[0])) / 1e9
    diagnosis = _Diagnosed()
    if diagnosed:
        diagnosis = _diagnosis(estimate, whole, truth, true, longest_lag_s, sensors)
    remarks = (
        *diagnosis.turns,
        *estimate.remarks,
        *_absence(estimate.stamps_ns, len(known), truth, due_ns),
        *_interpolation(uncertainty, statistics),
    )
    consistency = None
    if covariance is not None:
        P = _at_samples(real_numbers("covariance", covariance, "(..., 3, 3)"), stamps_ns, known)
        consistency = attitude_nees(estimate.attitude_xyzw, true, P, covariance_axes)
    return Score(
        stamps_ns=estimate.stamps_ns,
        error=error,
        total_deg=statistics,
        heading_deg=Statistics.of(heading),
        inclination_deg=Statistics.of(inclination),
        time_to_converge_s=time_to_converge(t_s, total, limit),
        converged_deg=limit,
        lag_s=diagnosis.lag.lag_s,
        lag_standard_error_s=diagnosis.lag.standard_error_s,
        findings=(*diagnosis.found, *(Finding(r.code, r.message, statistics.rms) for r in remarks)),
        broken=(*limits.broken(t_s, total), *limits.too_little(len(t_s), given, float(t_s[-1]), due_s)),
        outside=int(np.count_nonzero(~known)),
        truth_uncertainty_deg=uncertainty,
        consistency=consistency,
        best=None if bound is None else BestPossible.of(bound, estimate.stamps_ns, statistics.rms),
        limits=limits,
        of_sensors_deg=float(np.degrees(sensors)) if diagnosis.of_sensors else None,
    )


@dataclass(frozen=True)
class _Diagnosed:
    """What is found about an estimate beside its errors: the lag, mistakes, and remarks on how it turns."""

    lag: Lag = field(default_factory=Lag)
    found: tuple[Finding, ...] = ()
    turns: tuple[Remark, ...] = ()
    of_sensors: bool = False


def _diagnosis(
    estimate: ReadEstimate,
    whole: ReadEstimate,
    truth: Truth,
    true_xyzw: Array,
    longest_lag_s: float | None,
    sensors: float,
) -> _Diagnosed:
    """Find the lag and the mistakes, and what is wrong about the turns where nothing else is.

    `whole` has the estimates outside of the truth as well; `true_xyzw` are the true attitudes of the others.
    """
    stamps, track = estimate.stamps_ns, Track(estimate.stamps_ns, estimate.attitude_xyzw, truth)
    turned, error = Turns(stamps, estimate.attitude_xyzw, true_xyzw), np.degrees(track.errors())
    unlike = float(np.median(error)) > UNLIKE_DEG
    if rms(error) > UNLIKE_DEG:
        sure = turned.stuck() or turned.mixed()
        if sure:  # of fast turns every sample jumps
            return _Diagnosed(turns=turned.other() or sure if sure[0].code == "mixed" else sure)
    quarter = float(stamps[-1] - stamps[0]) / 4e9
    longest_s = min(LONGEST_LAG_S if longest_lag_s is None else longest_lag_s, quarter)
    margin = round(longest_s * 1e9)
    inner = track.part(np.flatnonzero(truth.covers(stamps - margin) & truth.covers(stamps + margin)))
    choice = choose(inner, longest_s, sensors)
    at_limit = choice is not None and choice.at_limit
    lost = unlike and (choice is None or not (choice.named.causes or choice.follows))
    everything = Track(whole.stamps_ns, whole.attitude_xyzw, truth)
    # a motion that nearly repeats has a near lag with a mounting for each far one
    causes = {*choice.named.causes} if choice is not None else set[str]()
    near = bool({"world_turned", "body_mounting", "lag"} & causes) and unlike
    found = other_clock(everything, 0.9 * longest_s) if longest_lag_s is None and (lost or at_limit or near) else None
    most = np.inf if choice is None or not near else (TIE if "lag" in causes else 0.5) * choice.named.error
    if found is not None and rms(found[1].errors()) <= most:
        clock, moved = found
        lag = clock_lag(clock, moved)
        return _Diagnosed(lag, (clock_finding(everything.known(), moved, clock),))
    if choice is None:
        return _Diagnosed()
    lag = Lag() if at_limit else lag_of(inner, choice.named, longest_s, period_ns(stamps) / 1e9)
    choice = choice.with_lag(lag.lag_s if lag.sure else None)
    named = findings(track, choice) if choice.named.causes else ()
    # a gyro on other axes is the same map as three conventions and a turned world
    many = len(named) > (1 if "world_turned" in choice.named.turned else MOST_NAMED)
    other = turned.other() if (lost and not named) or many else ()
    return _Diagnosed(lag, () if other else named, other, choice.of_sensors)


def _apart(stamps: Integers, given: int, truth: Truth) -> str:
    """Error message that no stamp of so many estimates is within the truth; some may share one stamp."""
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


def _absence(stamps: Integers, given: int, truth: Truth, due_ns: int | None) -> tuple[Remark, ...]:
    """Remarks on the parts of the truth's times that an estimate leaves out at either end, or exceeds.

    Estimates that are due longer than the truth goes on are absent too: in lock-step both end where a filter dies.
    """
    remarks = []
    last_ns, end = truth.last_ns, "ends {:g} s before the truth"
    if due_ns is not None and due_ns > last_ns:
        last_ns, end = due_ns, "ends {:g} s before it was to end"
    duration, least = last_ns - truth.first_ns, GAP * period_ns(stamps)
    absent = int(stamps[0]) - truth.first_ns, last_ns - int(stamps[-1])
    for missing, what in zip(absent, ("begins {:g} s after the truth", end), strict=True):
        if missing > max(ABSENT * duration, least):
            message = f"The estimate {what.format(missing / 1e9)}: that part of the run is not in the score."
            remarks.append(Remark("gaps", message))
    if given - len(stamps) > ABSENT * given:
        message = (
            f"{given - len(stamps)} of {given} estimates lie where the truth is not known and are not in the score: "
            "compare with the truth of the same run, by the same clock."
        )
        remarks.append(Remark("gaps", message))
    return tuple(remarks)


def _interpolation(uncertainty: float, total: Statistics) -> tuple[Remark, ...]:
    if not uncertainty > max(0.25 * total.rms, SMALLEST_LIMIT):
        return ()
    message = (
        f"Samples of the truth are so far apart that it is uncertain by {uncertainty:.2g}° between them, beside an "
        f"error of {total.rms:.2g}° rms: give the truth at a higher rate, or its scenario."
    )
    return (Remark("gaps", message),)


def _at_samples(covariance: Array, stamps_ns: ArrayLike, known: Booleans) -> Array:
    """Covariances of the samples that were compared."""
    if covariance.ndim != 3:
        return covariance
    stamps = np.asarray(stamps_ns)
    if len(covariance) != len(stamps):
        raise InputError(
            f"covariance: {len(covariance)} of them for {len(stamps)} estimates: give one, or one for each"
        )
    first_of_stamp = np.concatenate([[True], np.diff(stamps) > 0])
    return np.asarray(covariance[first_of_stamp][known])


class Tally:
    """Number, RMS and largest error of all samples so far, and what limits need to know of them.

    Parameters
    ----------
    limits : Limits

    Attributes
    ----------
    count : int
    largest_deg : ndarray, shape (3,)
        Largest total, heading and inclination error, degrees.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits, self.count = limits, 0
        self._squares, self.largest_deg = np.zeros(3), np.zeros(3)
        self._first_ns = self._last_ns = 0
        self._worst: list[Largest] = [None for _ in limits.max_after]

    def add(self, stamps_ns: Integers, error: AttitudeError) -> None:
        """Take samples that come next: at least one, with their errors, rad."""
        angles_deg = np.degrees(np.stack(error))
        self._first_ns = int(stamps_ns[0]) if not self.count else self._first_ns
        self._last_ns = int(stamps_ns[-1])
        self.count += len(stamps_ns)
        self._squares += np.sum(angles_deg**2, axis=1)
        self.largest_deg = np.maximum(self.largest_deg, angles_deg.max(axis=1))
        t_s = (stamps_ns - self._first_ns) / 1e9
        before = zip(self.limits.max_after, self._worst, strict=True)
        self._worst = [largest(start, t_s, angles_deg[0], worst) for (start, _), worst in before]

    @property
    def rms_deg(self) -> Array:
        """RMS of the total, heading and inclination error, degrees, shape (3,)."""
        return np.asarray(np.sqrt(self._squares / max(self.count, 1)))

    def broken(self) -> tuple[str, ...]:
        """Sentences about the limits that the samples so far break, one for each."""
        return self.limits.broken_by(float(self.rms_deg[0]), self._worst, (self._last_ns - self._first_ns) / 1e9)

    def exact(self, score: Score, given: int, due_ns: int) -> Score:
        """Replace RMS, largest error and limits in a score of some of the samples by those of all.

        Parameters
        ----------
        score : Score
        given : int
            Estimates, of which those that were compared were added.
        due_ns : int
            The stamp until which they are due.
        """
        span_s, due_s = ((end - self._first_ns) / 1e9 for end in (self._last_ns, due_ns))
        broken = (*self.broken(), *self.limits.too_little(self.count, given, span_s, due_s))
        parts = zip(("total_deg", "heading_deg", "inclination_deg"), self.rms_deg, self.largest_deg, strict=True)
        exact = {name: replace(getattr(score, name), rms=float(mean), max=float(most)) for name, mean, most in parts}
        return replace(score, broken=broken, **exact)
