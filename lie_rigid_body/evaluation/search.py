"""Grid of conventions, headings and lags, the best points of which are where fits begin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.alignment import HEADING, LAG, MOUNTING, UP, Convention, Misalignment, RunComparison
from lie_rigid_body.evaluation.attitudes import mean
from lie_rigid_body.lie import quaternion

WORLDS: Final[tuple[dict[str, bool], ...]] = ({}, {"ned_world": True}, {"ned_world": True, "frd_body": True})
CONVENTIONS: Final = tuple(
    Convention(scalar_first=first, inverted=inverse, **world)
    for first, inverse, world in product((False, True), (False, True), WORLDS)
)
"""Conventions in which an estimate is read; the first is that of this package."""
ALONE: Final = (*CONVENTIONS, *(Convention(True, True, **world, conjugated_last=True) for world in WORLDS))
"""Conventions that are tried without constants, where they must explain nearly all."""

HEADINGS: Final = np.linspace(-np.pi, np.pi, 18, endpoint=False)
"""Heading offsets of the grid, rad."""
LAG_TURN: Final = 0.5
"""Turn of the body from one lag of the grid to the next, rad: a fit converges from half of that."""
MOST_LAGS: Final = 61
"""Largest number of lags on the grid that tells which conventions to fit."""
MOST_FINE_LAGS: Final = 181
"""Largest number of lags on the grid that tells where fits begin: ±1 s of a body with 45 rad/s."""
MOST_STARTS: Final = 32
"""Largest number of starts of one fit."""
MARGIN: Final = LAG_TURN / 4.0
"""Margin of cost, a mean sine of half angles, above the lowest within which fits begin: half a step of the lag."""
IDENTITY: Final = np.array([0.0, 0.0, 0.0, 1.0])
"""Quaternion of no rotation, scalar last."""
GRID_SAMPLES: Final = 120
"""Largest number of samples by which a point of the grid is judged."""
FINE_SAMPLES: Final = 60
"""Largest number of samples by which the grid with more lags, and the first steps from its points, are judged."""


@dataclass(frozen=True)
class StartGrid:
    """Some samples of an estimate with the truth at each lag of a grid.

    Attributes
    ----------
    estimate_xyzw : ndarray, shape (n, 4)
        As given.
    lags_s : ndarray, shape (L,)
        From the longest negative to the longest positive.
    truth_xyzw : ndarray, shape (L, n, 4)
    """

    estimate_xyzw: Array
    lags_s: Array
    truth_xyzw: Array

    @classmethod
    def of(cls, comparison: RunComparison, most_lags: int = MOST_LAGS, most_samples: int = GRID_SAMPLES) -> StartGrid:
        """Make the grid of the lags that a comparison allows, as dense as the motion asks for, at most so many."""
        few = comparison.part(spread(len(comparison.stamps_ns), most_samples))
        half = min(max(int(np.ceil(few.longest_lag_s * few.fastest() / LAG_TURN)), 1), most_lags // 2)
        lags = np.linspace(-few.longest_lag_s, few.longest_lag_s, 2 * half + 1)
        return cls(few.estimate_xyzw, lags, few.truth.at(np.stack([few.true_stamps(lag) for lag in lags])))

    def best(self, convention: Convention, free: frozenset[str]) -> tuple[float, Misalignment]:
        """Best point of the grid for a convention and some free constants.

        Parameters
        ----------
        convention : Convention
        free : frozenset of str

        Returns
        -------
        cost : float
            Mean of the sines of half of the remaining angles.
        start : Misalignment
        """
        cost, points = self._by_lag(convention, free)
        i = int(np.argmin(cost))
        return float(cost[i]), points(i)

    def starts(self, convention: Convention, free: frozenset[str]) -> list[Misalignment]:
        """Points at the minima of the cost over the lag that are hardly above the lowest, the lowest first."""
        cost, points = self._by_lag(convention, free)
        around = np.concatenate([[np.inf], cost, [np.inf]])
        lowest = np.flatnonzero((cost <= around[:-2]) & (cost <= around[2:]) & (cost <= cost.min() + MARGIN))
        return [points(int(i)) for i in lowest[np.argsort(cost[lowest], kind="stable")][:MOST_STARTS]]

    def _by_lag(self, convention: Convention, free: frozenset[str]) -> tuple[Array, Callable[[int], Misalignment]]:
        """Least cost at each lag, shape (L,) or (1,), and the point of the grid where it is.

        The mounting is not on the grid: for each heading and lag the best one is the mean of what is left.
        """
        middle = len(self.lags_s) // 2
        chosen = slice(None) if LAG in free else slice(middle, middle + 1)
        headings = HEADINGS if HEADING in free else np.zeros(1)
        back = quaternion.exp(-headings[:, np.newaxis] * UP)[:, np.newaxis]
        turned = quaternion.multiply(back, convention.undo(self.estimate_xyzw))
        # (lags, headings, samples, 4): what is left on the body's axes
        left = quaternion.multiply(quaternion.conjugate(self.truth_xyzw[chosen])[:, np.newaxis], turned)
        mounting = mean(left) if MOUNTING in free else np.broadcast_to(IDENTITY, (*left.shape[:2], 4))
        cosine = np.einsum("lhna,lha->lhn", left, mounting)
        cost = np.mean(np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), axis=-1)
        best = np.argmin(cost, axis=1)

        def point(i: int) -> Misalignment:
            x, y, z, w = mounting[i, best[i]].tolist()
            return Misalignment(float(headings[best[i]]), (x, y, z, w), float(self.lags_s[chosen][i]))

        return np.min(cost, axis=1), point


def spread(count: int, most: int) -> Integers:
    """Indices of at most so many samples, evenly spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def written(comparison: RunComparison, convention: Convention) -> RunComparison:
    """Comparison with its estimates read in another convention."""
    return replace(comparison, estimate_xyzw=convention.undo(comparison.estimate_xyzw))
