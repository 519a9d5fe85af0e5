"""Explanations of what an estimate is off by: combinations of causes, and the best fits of them to a run."""

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
    Convention,
    Misalignment,
    RunComparison,
    columns,
    fit,
)
from lie_rigid_body.evaluation.search import (
    CONVENTIONS,
    FINE_SAMPLES,
    MOST_FINE_LAGS,
    MOST_LAGS,
    StartGrid,
    spread,
    written,
)
from lie_rigid_body.wording import short_repr

NEGLIGIBLE: Final = float(np.radians(1e-3))
"""Least median angle that needs an explanation, rad; smaller ones count as this."""

FEWEST_FITTED: Final = 12
"""Least number of samples that constants are fitted to, and that tell a lag."""

PRUNING_MARGIN: Final = 0.25
"""Margin above the grid's lowest cost, a mean sine of half angles, beyond which a convention is not fitted."""

TIE_FACTOR: Final = 1.25
"""Ratio of two medians up to which their explanations count as equally good."""

SAME_LAG: Final = 0.1
"""Least difference of two lags, as a share of the grid's spacing; nearer lags count as one."""

CONSTANT_SUBSETS: Final = tuple(frozenset(c) for k in range(4) for c in combinations((HEADING, MOUNTING, LAG), k))
"""Sets of constants that may be fitted, from none to all."""
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
        Of the angles that are left, rad, at least `NEGLIGIBLE`.
    """

    convention: Convention
    free: frozenset[str]
    misalignment: Misalignment
    median: float

    __repr__ = short_repr

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of the causes, in the order in which they are undone."""
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
        return len(self.causes) + simplicity + float(np.log2(self.median))

    @property
    def is_canonical(self) -> bool:
        """Whether the mounting is the smaller of two that do as well, with a forward-right-down body and without."""
        x, _, _, w = self.misalignment.mounting
        return not self.convention.ned_world or abs(x) <= abs(w)

    def is_part_of(self, other: Explanation) -> bool:
        """Whether each cause is one of another explanation's, with the same body axes."""
        same_body = self.convention.frd_body == other.convention.frd_body or not self.convention.ned_world
        return same_body and set(self.causes) <= set(other.causes)

    def without(self, cause: str) -> tuple[frozenset[str], Convention]:
        """Free constants and convention that are left when one cause is taken away."""
        return self.free - {cause}, Convention(
            self.convention.scalar_first and cause != "scalar_first",
            self.convention.inverted and cause != "inverted",
            self.convention.ned_world and cause != "ned_world",
            self.convention.frd_body and cause != "ned_world",
            self.convention.conjugated_last and cause not in {"scalar_first", "inverted"},
        )


def explanations(comparison: RunComparison, plain: Explanation) -> Iterator[Explanation]:
    """Explanations that may be the best, or as good."""
    grid = StartGrid.of(comparison)
    points = {convention: grid.best(convention, ALL_CONSTANTS) for convention in CONVENTIONS}
    limit = min(cost for cost, _ in points.values()) + PRUNING_MARGIN
    near = [convention for convention in CONVENTIONS if points[convention][0] <= limit]
    fine = grid if len(grid.lags_s) < MOST_LAGS else StartGrid.of(comparison, MOST_FINE_LAGS, FINE_SAMPLES)
    full = [explain(comparison, convention, ALL_CONSTANTS, points[convention][1]) for convention in near]
    lowest = min([plain, *full], key=lambda e: e.cost).cost
    full = [
        _nearest(comparison, fine, e.convention, e.free, e.misalignment) if _may_win(e, e.free, lowest) else e
        for e in full
    ]
    lowest = min([plain, *full], key=lambda e: e.cost).cost
    yield plain
    yield from full
    for most in sorted(full, key=lambda e: e.median):
        for free in CONSTANT_SUBSETS[:-1]:
            if _may_win(most, free, lowest):
                found = _nearest(comparison, fine, most.convention, free)
                lowest = min(lowest, found.cost)
                yield found


def _may_win(most: Explanation, free: frozenset[str], lowest: float) -> bool:
    """Whether fewer constants than those of an explanation may cost about the lowest.

    They cannot explain more, up to the difference between a median and what is minimised.
    """
    return replace(most, free=free, median=most.median / TIE_FACTOR).cost < lowest + 0.5


def _nearest(
    comparison: RunComparison,
    grid: StartGrid,
    convention: Convention,
    free: frozenset[str],
    *further: Misalignment,
) -> Explanation:
    """Explanation of the least lag among those by the same causes that leave about the least.

    A motion that nearly repeats, as that of a top does, has many lags about as good, each with constants of its own:
    fits begin at all of them that the grid tells, and at further ones, with few samples and few steps.
    """
    starts = [*further, *grid.starts(convention, free)]
    few = written(comparison.part(spread(len(comparison.stamps_ns), FINE_SAMPLES)), convention)
    rough = [fit(few, free, start, steps=4, smallest_step=1e-3) for start in starts] if len(starts) > 1 else starts
    left = [median_left(few, Convention(), m) for m in rough]
    least = min(left)
    best = rough[left.index(least)]
    as_good = [m for m, median in zip(rough, left, strict=True) if median <= TIE_FACTOR**2 * least]
    near = min(as_good, key=lambda m: abs(m.lag_s))
    found = explain(comparison, convention, free, best)
    if abs(near.lag_s - best.lag_s) < SAME_LAG * (grid.lags_s[1] - grid.lags_s[0]):
        return found
    other = explain(comparison, convention, free, near)
    return other if other.median <= TIE_FACTOR * found.median else found


def explain(
    comparison: RunComparison, convention: Convention, free: frozenset[str], start: Misalignment
) -> Explanation:
    """Fit a combination of causes to a run."""
    found = fit(written(comparison, convention), free, start, steps=12, smallest_step=1e-7)
    return Explanation(convention, free, found, median_left(comparison, convention, found))


def median_left(comparison: RunComparison, convention: Convention, misalignment: Misalignment) -> float:
    """Median of the angles that are left, rad, at least `NEGLIGIBLE`; infinite if the truth is known at no sample."""
    left = written(comparison, convention).angles(misalignment)
    return max(float(np.median(left)), NEGLIGIBLE) if left.size else np.inf
