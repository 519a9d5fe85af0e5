"""Why an estimate is off: conventions, constant rotations (heading, mounting) and a time lag that explain the error.

Each combination of causes is fitted to the run and judged by the median of the angles that it leaves. A cause is named
only if it at least halves that median, given the other causes that are named; of combinations that leave about the
same, the one with fewer and simpler causes is taken. The median is used so that the convergence of a filter counts
little. A cause with a fitted constant must also be constant: fitted to three quarters of the run, it must halve the
median of the fourth, for each choice of the fourth; only the first quarter is excused, where a filter still converges.
Drifts fail that, and so do 97 of 100 random walks. What fails is not replaced by a cause that leaves more, and what
leaves more than `LARGEST_LEFT` over the cube of its number of causes explains nothing. A median below `NEGLIGIBLE` is
not explained at all. Several conventions without constants, of which there are few, may leave as much as errors of
sensors do, in each quarter but the first, and are taken instead of what needs constants to leave hardly less. When
a lag is told, and when a far one is a constant, is said in the file `lag`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.alignment import LAG, MOUNTING, Convention, Misalignment, RunComparison, fit
from lie_rigid_body.evaluation.attitudes import from_mean
from lie_rigid_body.evaluation.estimate import period_ns
from lie_rigid_body.evaluation.explanation import (
    FEWEST_FITTED,
    NEGLIGIBLE,
    TIE_FACTOR,
    Explanation,
    explain,
    explanations,
    median_left,
)
from lie_rigid_body.evaluation.lag import AT_LIMIT, SURE, is_for_all_quarters, is_nearest, told_lag
from lie_rigid_body.evaluation.search import ALONE, spread, written
from lie_rigid_body.evaluation.statistics import FEWEST_SAMPLES, later_quarters, worst_quarter
from lie_rigid_body.wording import short_repr

LARGEST_LEFT: Final = float(np.radians(20.0))
"""Largest median angle that a convention or a constant rotation may leave to be named, rad; a lag may leave more.

For n causes together it is divided by n³: many constants fit anything to some degrees."""

SHARE_OF_EACH: Final = 0.25
"""Largest share of the median error that each of several causes may leave: n causes leave its n-th power."""

CONVENTIONS_LEFT: Final = float(np.radians(10.0))
"""Largest median angle that several conventions without constants may leave, rad, as MEMS sensors make it."""
CONVENTIONS_SHARE: Final = 0.125
"""Largest share of the median error that several conventions without constants may leave."""
BY_EACH_CONSTANT: Final = 4.0
"""Ratio of medians, for each fitted constant, from which on an explanation with constants beats such conventions."""

OF_SENSORS: Final = float(np.radians(1.0))
"""Median angle that errors of sensors make, rad; they are nearer to a constant turn than to a lag."""
LAG_FACTOR: Final = 3.0
"""Ratio of two medians up to which a lag is told as an alternative to a cause of small errors."""

UNLIKE: Final = 0.5
"""Largest median angle that a named cause may leave, as a share of `from_mean` of the truth."""

UNLIKE_MOUNTED: Final = 0.25
"""Share as `UNLIKE` for causes with a mounting, whose three constants fit any attitudes that change little."""

MOST_CAUSES: Final = 3
"""Largest number of causes that tell whether an estimate follows the body; more fit anything."""

LEAST_SAMPLES_LATE: Final = 0.5
"""Least lag, in samples, that is named where other errors are larger."""

FIT_SAMPLES: Final = 400
"""Largest number of samples that explanations are fitted to."""


@dataclass(frozen=True)
class Diagnosis:
    """Best explanation of an error, the others that were tried, and the lag.

    Attributes
    ----------
    explanation : Explanation
    tried : tuple of Explanation
    lag_s : float or None
        The time lag that explains most of the error, beside the misalignment; positive if the estimate is late.
        None if the motion does not tell it.
    lag_standard_error_s : float or None
    lag_at_limit : bool
        Whether a lag at the limit of the search leaves clearly less: the true one may be longer.
    """

    explanation: Explanation
    tried: tuple[Explanation, ...]
    lag_s: float | None
    lag_standard_error_s: float | None
    lag_at_limit: bool = False

    __repr__ = short_repr

    def instead_of(self, cause: str) -> tuple[str, ...]:
        """Causes that, put in place of the given one, leave about the same median."""
        best = self.explanation
        rest = set(best.causes) - {cause}
        without = [e.median for e in self.tried if (e.free, e.convention) == best.without(cause)]
        # as good: about the same is left, and half of what the cause explains is explained
        half = min([(m + best.median) / 2.0 for m in without], default=np.inf)
        found: dict[str, Explanation] = {}
        for other in self.tried:
            new = set(other.causes) - rest - {cause}
            swapped = rest <= set(other.causes) and len(new) == 1 and len(other.causes) == len(best.causes)
            small = LAG in new and min(without, default=np.inf) < OF_SENSORS
            if swapped and other.median <= min((LAG_FACTOR if small else TIE_FACTOR) * best.median, half):
                found[new.pop()] = other
        return tuple(found)


def diagnose(comparison: RunComparison, nearer: tuple[Explanation, ...] = ()) -> Diagnosis:
    """Find the causes of an estimate's errors.

    Parameters
    ----------
    comparison : RunComparison
        Of samples whose true time, shifted by the longest lag either way, is within the truth's times.
    nearer : tuple of Explanation
        What was tried with a shorter longest lag: far lags are held against these as well.

    Returns
    -------
    Diagnosis
    """
    few = comparison.part(spread(len(comparison.stamps_ns), FIT_SAMPLES))
    plain = Explanation(Convention(), frozenset(), Misalignment(), median_left(few, Convention(), Misalignment()))
    tried: tuple[Explanation, ...] = (plain,)
    if len(few.stamps_ns) >= FEWEST_FITTED and plain.median > NEGLIGIBLE:
        tried = tuple(sorted(explanations(few, plain), key=lambda e: e.cost))
    limit = AT_LIMIT * comparison.longest_lag_s
    best = _conventions(few, plain.median, _named(few, tried, limit, nearer))
    most = TIE_FACTOR * min((e.median for e in tried if abs(e.misalignment.lag_s) >= limit), default=np.inf)
    at_limit = best.median > most
    lag_s, standard_error_s = told_lag(comparison, best)
    least_s = LEAST_SAMPLES_LATE * period_ns(comparison.stamps_ns) / 1e9
    if lag_s is not None and standard_error_s is not None and abs(lag_s) >= max(SURE * standard_error_s, least_s):
        best = _with_lag(few, best, lag_s)
    return Diagnosis(best, tried, lag_s, standard_error_s, at_limit)


def follows(comparison: RunComparison, diagnosis: Diagnosis) -> bool:
    """Whether a few causes explain nearly all of the error, be they sure enough to be named or not.

    A gyro on other axes, or of another unit, leaves attitudes that nothing constant explains.
    """
    error = median_left(comparison, Convention(), Misalignment())
    turned = from_mean(comparison.true_states(0.0)[0])
    most = min(CONVENTIONS_LEFT, CONVENTIONS_SHARE * error, UNLIKE_MOUNTED * turned)
    return any(e.median <= most for e in diagnosis.tried if 0 < len(e.causes) <= MOST_CAUSES)


def _with_lag(comparison: RunComparison, best: Explanation, lag_s: float) -> Explanation:
    """Explanation with a sure lag beside its causes, if that explains anything."""
    if LAG in best.free:
        return best
    found = explain(comparison, best.convention, best.free | {LAG}, replace(best.misalignment, lag_s=lag_s))
    return found if found.median < min(best.median, LARGEST_LEFT) else best


def _named(
    comparison: RunComparison, tried: tuple[Explanation, ...], limit_s: float, nearer: tuple[Explanation, ...]
) -> Explanation:
    """First of the explanations tried, by cost, whose constants are constant and that leaves little enough."""
    unconstant: list[Explanation] = []
    beyond = abs(tried[0].misalignment.lag_s) >= limit_s
    plain = next(e for e in tried if not e.causes)
    turned = from_mean(comparison.true_states(0.0)[0])
    for e in tried:
        at_limit = abs(e.misalignment.lag_s) >= limit_s or (beyond and e.free)
        if at_limit or not e.is_canonical or any(_is_no_better(e, other) for other in unconstant):
            continue
        explains = e is plain or (_explains(e, plain.median, turned) and is_nearest(comparison, e, tried + nearer))
        if explains and _is_constant(comparison, e, tried):
            return e
        unconstant.append(e)
    return plain


def _conventions(comparison: RunComparison, error: float, named: Explanation) -> Explanation:
    """Explanation by several conventions alone, where they explain nearly all; else the one that is named."""
    if error <= CONVENTIONS_LEFT or len(comparison.stamps_ns) < FEWEST_SAMPLES:
        return named
    late = np.concatenate(later_quarters(len(comparison.stamps_ns)))
    left = [written(comparison, convention).angles(Misalignment()) for convention in ALONE]
    medians = [worst_quarter(angles) for angles in left]
    first, second = np.argsort(medians)[:2]
    turned = from_mean(comparison.true_states(0.0)[0][late])
    most = min(CONVENTIONS_LEFT, CONVENTIONS_SHARE * error, UNLIKE * turned, medians[second] / 2.0)
    found = Explanation(ALONE[first], frozenset(), Misalignment(), float(np.median(left[first][late])))
    if len(found.causes) < 2 or medians[first] > most or named.convention == found.convention:
        return named
    if len(named.causes) == 1 and named.median <= found.median:
        return named
    least = named.median * BY_EACH_CONSTANT ** len(named.free)
    return found if not named.causes or found.median <= least else named


def _explains(explanation: Explanation, error: float, turned: float) -> bool:
    """Whether an explanation leaves little of an error, and little beside the turn of the body."""
    share = UNLIKE_MOUNTED if MOUNTING in explanation.free else UNLIKE
    causes = len(explanation.causes)
    largest = np.inf if set(explanation.causes) <= {LAG} else LARGEST_LEFT / max(causes, 1) ** 3
    most = min(largest, share * turned, error * SHARE_OF_EACH**causes if causes > 1 else np.inf)
    return explanation.median <= max(most, NEGLIGIBLE)


def _is_no_better(explanation: Explanation, other: Explanation) -> bool:
    """Whether an explanation leaves about as much as another, or more, and is no part of it."""
    return TIE_FACTOR * explanation.median >= other.median and not explanation.is_part_of(other)


def _is_constant(comparison: RunComparison, explanation: Explanation, tried: tuple[Explanation, ...]) -> bool:
    """Whether constants fitted to three quarters of a run halve the median of the fourth, each of them and in each.

    A far lag must also be the best in each.
    """
    if not explanation.free:
        return True
    every = np.arange(len(comparison.stamps_ns))
    known = {(e.free, e.convention): e for e in tried}
    simpler = [known[key] for key in map(explanation.without, explanation.free) if key in known]
    for quarter in np.array_split(every, 4):
        others = written(comparison, explanation.convention).part(np.setdiff1d(every, quarter))
        fitted = fit(others, explanation.free, explanation.misalignment, smallest_step=1e-7)
        left = median_left(comparison.part(quarter), explanation.convention, fitted)
        for e in simpler:
            before = median_left(comparison.part(quarter), e.convention, e.misalignment)
            # a filter that is worse off at first still converges: that quarter says nothing
            if before < 2.0 * left and not (quarter[0] == 0 and before >= e.median):
                return False
    return is_for_all_quarters(comparison, explanation)
