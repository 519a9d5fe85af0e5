"""Where a fit begins: the best of a grid of conventions, headings and lags."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.alignment import HEADING, LAG, MOUNTING, UP, Comparison, Convention, Misalignment
from lie_rigid_body.lie import quaternion

WORLDS: Final = ({}, {"ned_world": True}, {"ned_world": True, "frd_body": True})
CONVENTIONS: Final = tuple(
    Convention(scalar_first=first, inverted=inverse, **world)
    for first, inverse, world in product((False, True), (False, True), WORLDS)
)
"""Every convention that an estimate is tried in; the first is that of this package."""

HEADINGS: Final = np.linspace(-np.pi, np.pi, 18, endpoint=False)
LAG_TURN: Final = 0.5
"""Turn of the body from one lag of the grid to the next, rad: a fit converges from half of that."""
MOST_LAGS: Final = 61
SAMPLES: Final = 120
"""How many samples a point of the grid is judged by."""


def starts(comparison: Comparison, free: frozenset[str]) -> tuple[float, Misalignment]:
    """The best point of the grid for some free parameters.

    The mounting is not on the grid: for each heading and lag the best one is the eigenvector of the largest eigenvalue of
    Σ q qᵀ (F. L. Markley and others, Averaging Quaternions, J. Guidance, Control, and Dynamics 30 (2007) 1193, eq. 13).

    Parameters
    ----------
    comparison : Comparison
    free : frozenset of str

    Returns
    -------
    cost : float
        Mean of the sines of half of the remaining angles.
    start : Misalignment
    """
    few = comparison.part(spread(len(comparison.stamps_ns), SAMPLES))
    lags = lag_grid(few) if LAG in free else np.zeros(1)
    headings = HEADINGS if HEADING in free else np.zeros(1)
    truth = few.truth.at(np.stack([few.true_stamps(lag) for lag in lags]))
    turned = quaternion.multiply(quaternion.exp(-headings[:, np.newaxis] * UP)[:, np.newaxis], few.estimate_xyzw)
    # (lags, headings, samples, 4): what is left on the body's axes
    left = quaternion.multiply(quaternion.conjugate(truth)[:, np.newaxis], turned[np.newaxis])
    mounting = _mean(left) if MOUNTING in free else np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*left.shape[:2], 4))
    cosine = np.abs(np.einsum("lhna,lha->lhn", left, mounting))
    cost = np.mean(np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), axis=-1)
    i, j = np.unravel_index(np.argmin(cost), cost.shape)
    x, y, z, w = mounting[i, j].tolist()
    return float(cost[i, j]), Misalignment(float(headings[j]), (x, y, z, w), float(lags[i]))


def lag_grid(comparison: Comparison) -> Array:
    """Lags from the longest negative to the longest positive, with 0, not farther apart than the motion asks for."""
    rate = comparison.truth.body_rate(comparison.stamps_ns)
    fastest = float(np.sqrt(np.max(np.sum(rate**2, axis=-1))))
    half = int(np.ceil(comparison.longest_lag_s * fastest / LAG_TURN))
    half = min(max(half, 1), MOST_LAGS // 2)
    return np.linspace(-comparison.longest_lag_s, comparison.longest_lag_s, 2 * half + 1)


def spread(count: int, most: int) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """At most so many indices, evenly spread over all."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def written(comparison: Comparison, convention: Convention) -> Comparison:
    """The comparison with its estimates taken to be written in another convention."""
    return replace(comparison, estimate_xyzw=convention.undo(comparison.estimate_xyzw))


def _mean(quaternions: Array) -> Array:
    outer = np.einsum("lhna,lhnb->lhab", quaternions, quaternions)
    return np.asarray(np.linalg.eigh(outer)[1][..., -1])
