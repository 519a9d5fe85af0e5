"""Why an estimate is off: conventions, constant rotations (heading, mounting) and a time lag that explain the error.

Each combination of causes is fitted to the run and judged by the median of the angles that it leaves. A cause is named
only if it at least halves that median, given the other causes that are named; of combinations that leave about the
same, the one with fewer and simpler causes is taken. The median is used so that the convergence of a filter counts
little. A cause with a fitted constant must also be constant: fitted to three quarters of the run, it must halve the
median of the fourth, for each choice of the fourth; only the first quarter is excused, where a filter still converges.
Drifts fail that, and so do 97 of 100 random walks. What fails is not replaced by a cause that leaves more, and what
leaves more than `LARGEST_LEFT` over the cube of its number of causes explains nothing. A median below `NEGLIGIBLE` is
not explained at all. Several conventions without constants, of which there are few, may leave as much as errors of
sensors do, in each quarter but the first, and are taken instead of what needs constants to leave hardly less.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.alignment import (
    HEADING,
    LAG,
    MOUNTING,
    Comparison,
    Convention,
    Misalignment,
    columns,
    fit,
    lag_standard_error,
    separable,
)
from lie_rigid_body.evaluation.search import ALONE, CONVENTIONS, Grid, from_mean, spread, written
from lie_rigid_body.wording import short_repr

NEGLIGIBLE: Final = float(np.radians(1e-3))
"""Medians below this, rad, count as this, and need no explanation."""

LARGEST_LEFT: Final = float(np.radians(20.0))
"""A convention or a constant rotation that leaves a larger median, rad, is not the cause; a lag may leave more.

Of n causes together, this over n³: many fit something else to some degrees."""

SHARE_OF_EACH: Final = 0.25
"""Several causes that leave a larger share of the median than this to the power of their number are not the cause."""

CONVENTIONS_LEFT: Final = float(np.radians(10.0))
"""The same for several conventions without constants: as much as errors of MEMS sensors leave of a filter, rad."""
CONVENTIONS_SHARE: Final = 0.125
"""They leave no larger share of the median error; other conventions leave at least twice as much."""
BY_EACH_CONSTANT: Final = 4.0
"""What leaves so many times less by each constant that it fits, or more, is taken instead of such conventions."""

UNLIKE: Final = 0.5
"""Nor is what leaves a larger share of the median that an attitude leaves which does not follow the body."""

UNLIKE_MOUNTED: Final = 0.25
"""The same for causes with a mounting, whose three constants fit any attitudes that change little."""

FEWEST_SAMPLES: Final = 12
"""Smallest number of samples from which a cause is named or a lag given."""

FIT_SAMPLES: Final = 400
"""Largest number of samples that explanations are fitted to."""

LAG_SAMPLES: Final = 20_000
"""Largest number of samples that the lag is fitted to."""

PRUNING_MARGIN: Final = 0.25
"""Margin above the grid's lowest cost, a mean sine of half angles, beyond which a convention is not fitted."""

TIE_FACTOR: Final = 1.25
"""Ratio of two medians, up to which their explanations are as good as each other."""

AT_LIMIT: Final = 0.999
"""Share of the longest lag from which on a fitted lag counts as at the limit."""

SIGNIFICANT: Final = 3.0
"""A lag is told from none if it is so many standard errors."""

SURE: Final = 8.0
"""A lag of so many standard errors is told, and named, also where other errors are larger."""

LEAST_SAMPLES_LATE: Final = 0.5
"""Lags below this many samples are named only where they are most of the error."""

CONSTANT_SUBSETS: Final = tuple(frozenset(c) for k in range(4) for c in combinations((HEADING, MOUNTING, LAG), k))
"""The sets of constants that may be fitted, from none to all."""
ALL_CONSTANTS: Final = CONSTANT_SUBSETS[-1]


@dataclass(frozen=True)
class Explanation:
    """A combination of causes, fitted to a run.

    Attributes
    ----------
    convention : Convention
    free : frozenset of str
        Which constants were fitted.
    misalignment : Misalignment
    median : float
        Of the angles that are left, rad.
    """

    convention: Convention
    free: frozenset[str]
    misalignment: Misalignment
    median: float

    __repr__ = short_repr

    @property
    def causes(self) -> tuple[str, ...]:
        """The names of its causes, in the order in which they are undone."""
        of_convention = {
            "scalar_first": self.convention.scalar_first,
            "inverted": self.convention.inverted,
            "ned_world": self.convention.ned_world,
        }
        named = [name for name, holds in of_convention.items() if holds]
        if self.convention.conjugated_last:
            named[:2] = reversed(named[:2])
        return (*named, *(name for name in (HEADING, MOUNTING, LAG) if name in self.free))

    @property
    def cost(self) -> float:
        """Score to minimise: number of causes + simplicity penalty + log₂ of the median angle, rad.

        The penalty decides only between explanations that leave the same: a mounting of half a turn counts more than
        the convention that is half a turn.
        """
        mounting = 0.04 * self.misalignment.mounting_angle / np.pi if MOUNTING in self.free else 0.0
        simplicity = 0.005 * len(columns(self.free)) + 0.02 * self.convention.frd_body + mounting
        return len(self.causes) + simplicity + float(np.log2(max(self.median, NEGLIGIBLE)))

    @property
    def is_canonical(self) -> bool:
        """Whether its mounting is the smaller one of the two that a body forward-right-down, or not, goes with."""
        x, _, _, w = self.misalignment.mounting
        return not self.convention.ned_world or abs(x) <= abs(w)

    def is_part_of(self, other: Explanation) -> bool:
        """Whether each of its causes is one of another's, with the same body axes."""
        same_body = self.convention.frd_body == other.convention.frd_body or not self.convention.ned_world
        return same_body and set(self.causes) <= set(other.causes)

    def without(self, cause: str) -> tuple[frozenset[str], Convention]:
        """Free constants and convention of the same causes but one."""
        return self.free - {cause}, Convention(
            self.convention.scalar_first and cause != "scalar_first",
            self.convention.inverted and cause != "inverted",
            self.convention.ned_world and cause != "ned_world",
            self.convention.frd_body and cause != "ned_world",
            self.convention.conjugated_last and cause not in {"scalar_first", "inverted"},
        )


@dataclass(frozen=True)
class Diagnosis:
    """The best explanation, the others that were tried, and the lag.

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
        most = min(TIE_FACTOR * max(best.median, NEGLIGIBLE), *((m + best.median) / 2.0 for m in without), np.inf)
        found: dict[str, Explanation] = {}
        for other in self.tried:
            new = set(other.causes) - rest - {cause}
            swapped = rest <= set(other.causes) and len(new) == 1 and len(other.causes) == len(best.causes)
            if swapped and max(other.median, NEGLIGIBLE) <= max(most, NEGLIGIBLE):
                found[new.pop()] = other
        return tuple(found)


def diagnose(comparison: Comparison) -> Diagnosis:
    """Explain what an estimate is off by.

    Parameters
    ----------
    comparison : Comparison
        Of samples whose true time, shifted by the longest lag either way, is within the truth's times.

    Returns
    -------
    Diagnosis
    """
    few = comparison.part(spread(len(comparison.stamps_ns), FIT_SAMPLES))
    plain = Explanation(Convention(), frozenset(), Misalignment(), _median(few, Convention(), Misalignment()))
    tried: tuple[Explanation, ...] = (plain,)
    if len(few.stamps_ns) >= FEWEST_SAMPLES and plain.median > NEGLIGIBLE:
        tried = tuple(sorted(_explanations(few, plain), key=lambda e: e.cost))
    limit = AT_LIMIT * comparison.longest_lag_s
    best = _conventions(few, plain.median, _named(few, tried, limit))
    most = TIE_FACTOR * min((e.median for e in tried if abs(e.misalignment.lag_s) >= limit), default=np.inf)
    at_limit = max(best.median, NEGLIGIBLE) > most
    lag_s, standard_error_s = _lag(comparison, best)
    if lag_s is not None and standard_error_s is not None and abs(lag_s) >= SURE * standard_error_s:
        best = _with_lag(few, best, lag_s, _period_s(comparison))
    return Diagnosis(best, tried, lag_s, standard_error_s, at_limit)


def _with_lag(comparison: Comparison, best: Explanation, lag_s: float, period_s: float) -> Explanation:
    """An explanation with a lag beside it that is sure, if it is not too short to matter, and explains anything."""
    if LAG in best.free or abs(lag_s) < LEAST_SAMPLES_LATE * period_s:
        return best
    found = explain(comparison, best.convention, best.free | {LAG}, replace(best.misalignment, lag_s=lag_s))
    return found if found.median < min(best.median, LARGEST_LEFT) else best


def _period_s(comparison: Comparison) -> float:
    return float(np.median(np.diff(comparison.stamps_ns))) / 1e9


def _named(comparison: Comparison, tried: tuple[Explanation, ...], limit_s: float) -> Explanation:
    """The first of those tried, the simplest last, whose constants are constant and that leaves little enough."""
    unconstant: list[Explanation] = []
    beyond = abs(tried[0].misalignment.lag_s) >= limit_s
    plain = next(e for e in tried if not e.causes)
    turned = float(np.median(from_mean(comparison.true_states(0.0)[0])))
    for e in tried:
        at_limit = abs(e.misalignment.lag_s) >= limit_s or (beyond and e.free)
        if at_limit or not e.is_canonical or any(_is_no_better(e, other) for other in unconstant):
            continue
        if e is plain or (_explains(e, plain.median, turned) and _is_constant(comparison, e, tried)):
            return e
        unconstant.append(e)
    return plain


def _conventions(comparison: Comparison, error: float, named: Explanation) -> Explanation:
    """Several conventions that alone explain nearly all, instead of what is named, or that."""
    if error <= CONVENTIONS_LEFT or len(comparison.stamps_ns) < FEWEST_SAMPLES:
        return named
    # in the first quarter a filter may converge
    late = comparison.part(slice(len(comparison.stamps_ns) // 4, None))
    left = [written(late, convention).angles(Misalignment()) for convention in ALONE]
    medians = [max(float(np.median(quarter)) for quarter in np.array_split(angles, 3)) for angles in left]
    first, second = np.argsort(medians)[:2]
    turned = float(np.median(from_mean(late.true_states(0.0)[0])))
    most = min(CONVENTIONS_LEFT, CONVENTIONS_SHARE * error, UNLIKE * turned, medians[second] / 2.0)
    found = Explanation(ALONE[first], frozenset(), Misalignment(), float(np.median(left[first])))
    if len(found.causes) < 2 or medians[first] > most or named.convention == found.convention:
        return named
    least = max(named.median, NEGLIGIBLE) * BY_EACH_CONSTANT ** len(named.free)
    return found if not named.causes or found.median <= least else named


def _explains(explanation: Explanation, error: float, turned: float) -> bool:
    """Whether little is left of an error, and of what the body turns."""
    share = UNLIKE_MOUNTED if MOUNTING in explanation.free else UNLIKE
    causes = len(explanation.causes)
    largest = np.inf if set(explanation.causes) <= {LAG} else LARGEST_LEFT / max(causes, 1) ** 3
    most = min(largest, share * turned, error * SHARE_OF_EACH**causes if causes > 1 else np.inf)
    return explanation.median <= max(most, NEGLIGIBLE)


def _is_no_better(explanation: Explanation, other: Explanation) -> bool:
    """Whether an explanation leaves about as much as another, or more, and is no part of it."""
    as_much = TIE_FACTOR * max(explanation.median, NEGLIGIBLE) >= max(other.median, NEGLIGIBLE)
    return as_much and not explanation.is_part_of(other)


def _explanations(comparison: Comparison, plain: Explanation) -> Iterator[Explanation]:
    """The explanations that may be the best, or as good."""
    grid = Grid.of(comparison)
    points = {convention: grid.best(convention, ALL_CONSTANTS) for convention in CONVENTIONS}
    limit = min(cost for cost, _ in points.values()) + PRUNING_MARGIN
    near = [convention for convention in CONVENTIONS if points[convention][0] <= limit]
    full = [explain(comparison, convention, ALL_CONSTANTS, points[convention][1]) for convention in near]
    lowest = min([plain, *full], key=lambda e: e.cost).cost
    yield plain
    yield from full
    for most in sorted(full, key=lambda e: e.median):
        for free in CONSTANT_SUBSETS[:-1]:
            # fewer constants cannot explain more, up to the difference between a median and what is minimised
            if replace(most, free=free, median=most.median / TIE_FACTOR).cost < lowest + 0.5:
                found = explain(comparison, most.convention, free, grid.best(most.convention, free)[1])
                lowest = min(lowest, found.cost)
                yield found


def explain(comparison: Comparison, convention: Convention, free: frozenset[str], start: Misalignment) -> Explanation:
    """A combination of causes fitted to a run."""
    found = fit(written(comparison, convention), free, start, steps=12, smallest_step=1e-7)
    return Explanation(convention, free, found, _median(comparison, convention, found))


def _is_constant(comparison: Comparison, explanation: Explanation, tried: tuple[Explanation, ...]) -> bool:
    """Whether constants fitted to three quarters of a run halve the median of the fourth, each of them and in each."""
    if not explanation.free:
        return True
    every = np.arange(len(comparison.stamps_ns))
    known = {(e.free, e.convention): e for e in tried}
    simpler = [known[key] for key in map(explanation.without, explanation.free) if key in known]
    for quarter in np.array_split(every, 4):
        others = written(comparison, explanation.convention).part(np.setdiff1d(every, quarter))
        fitted = fit(others, explanation.free, explanation.misalignment, smallest_step=1e-7)
        left = max(_median(comparison.part(quarter), explanation.convention, fitted), NEGLIGIBLE)
        for e in simpler:
            before = _median(comparison.part(quarter), e.convention, e.misalignment)
            # a filter that is worse off at first still converges: that quarter says nothing
            if before < 2.0 * left and not (quarter[0] == 0 and before >= e.median):
                return False
    return True


def _median(comparison: Comparison, convention: Convention, misalignment: Misalignment) -> float:
    left = written(comparison, convention).angles(misalignment)
    return float(np.median(left)) if left.size else np.inf


def _lag(comparison: Comparison, explanation: Explanation) -> tuple[float, float] | tuple[None, None]:
    """The lag and its standard error, s, beside heading and mounting where the motion tells them apart.

    Else beside what was found. It is told if it is named as a cause or halves the error, and three times its standard
    error; or if it is sure, eight times that, and about the same in each half of the run; or if it is none of these,
    and this is small beside a lag that would turn the body by the error that is left. Between them is what slow errors
    may feign.
    """
    ours = written(comparison, explanation.convention)
    ours = ours.part(spread(len(ours.stamps_ns), LAG_SAMPLES))
    if len(ours.stamps_ns) < FEWEST_SAMPLES:
        return None, None
    for free in (ALL_CONSTANTS, explanation.free | {LAG}):
        if separable(ours, free, explanation.misalignment) or free == explanation.free:
            return _told_lag(ours, free, explanation)
    return None, None


def _is_the_same_in_halves(comparison: Comparison, fitted: Misalignment) -> bool:
    """Whether each half of a run alone tells about the same lag, as it hardly does of what drifts feign."""
    for half in np.array_split(np.arange(len(comparison.stamps_ns)), 2):
        alone = fit(comparison.part(half), ALL_CONSTANTS, fitted)
        if abs(alone.lag_s - fitted.lag_s) > abs(fitted.lag_s) / 2.0:
            return False
    return True


def _told_lag(
    comparison: Comparison, free: frozenset[str], explanation: Explanation
) -> tuple[float, float] | tuple[None, None]:
    fitted = fit(comparison, free, explanation.misalignment)
    without = fit(comparison, free - {LAG}, replace(fitted, lag_s=0.0))
    before, left = (max(float(np.median(comparison.angles(m))), NEGLIGIBLE) for m in (without, fitted))
    named, lag_s = LAG in explanation.free, abs(fitted.lag_s)
    error = lag_standard_error(comparison, free, fitted)
    sure = free == ALL_CONSTANTS and lag_s >= SURE * error and _is_the_same_in_halves(comparison, fitted)
    explains = named or sure or (free == ALL_CONSTANTS and before >= 2.0 * left)
    if not explains:
        error = lag_standard_error(comparison, free, without)
    rate = float(np.sqrt(np.mean(np.sum(comparison.true_states(0.0)[1] ** 2, axis=-1))))
    if explains:
        raw = max(float(np.median(comparison.angles(Misalignment()))), NEGLIGIBLE)
        told = named or (SIGNIFICANT * error <= lag_s and lag_s * rate <= 2.0 * raw)
    else:
        told = lag_s <= SIGNIFICANT * error and 4.0 * error * rate <= before
    return (fitted.lag_s, error) if told and lag_s < AT_LIMIT * comparison.longest_lag_s else (None, None)
