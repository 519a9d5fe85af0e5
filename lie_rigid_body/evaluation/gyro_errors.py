"""Errors that a gyro alone would make in an estimate: scale, mounting and bias that are constant.

An integrated gyro that reads (1 + E) ω + b gives the attitudes q₀ ⊗ Π exp((1 + E) θ_k + b h_k), with θ_k the true turn
from one sample to the next and h_k the time between. E, b and q₀ are fitted by Gauss–Newton to the estimate. What this
explains needs no other clock, however well one fits: 1 % of scale is nearly one of 1 %.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.alignment import RunComparison
from lie_rigid_body.evaluation.attitude_error import world_error
from lie_rigid_body.evaluation.attitudes import sizes, turns
from lie_rigid_body.evaluation.search import spread
from lie_rigid_body.lie import quaternion

SAMPLES: Final = 2000
"""Largest number of samples that errors are fitted to."""
ROUNDS: Final = 6
"""Number of steps of Gauss–Newton."""


def left_by_gyro_errors(comparison: RunComparison) -> float:
    """Median angle that the best constant errors of a gyro leave, rad.

    Parameters
    ----------
    comparison : RunComparison
        Of samples within the truth's times.
    """
    few = comparison.part(spread(len(comparison.stamps_ns), SAMPLES))
    true, given = few.truth.at(few.stamps_ns), few.estimate_xyzw
    true_turns = turns(true[:-1], true[1:])
    read = np.concatenate([true_turns, np.diff(few.stamps_ns)[:, np.newaxis] / 1e9], axis=1)
    errors, start, least = np.zeros((3, 4)), true[0], np.inf
    for _ in range(ROUNDS):
        predicted = _products(start, quaternion.exp(true_turns + read @ errors.T))
        missed = world_error(given, predicted)
        least = min(least, float(np.median(sizes(missed))))
        step = np.linalg.lstsq(_derivative(predicted, read), missed.ravel(), rcond=1e-10)[0]
        start = quaternion.multiply(quaternion.exp(step[:3]), start)
        errors = errors + step[3:].reshape(3, 4)
    return least


def _derivative(predicted: Array, read: Array) -> Array:
    """Derivative of the attitudes, on the world's axes, by the first one and the errors row by row, shape (3 N, 15)."""
    axes = quaternion.rotate(predicted[:-1, np.newaxis], np.eye(3))  # rows: the body's axes in the world
    steps = np.einsum("nij,nk->njik", axes, read).reshape(len(read), 3, 12)
    turned = np.concatenate([np.zeros((1, 3, 12)), np.cumsum(steps, axis=0)])
    first = np.broadcast_to(np.eye(3), (len(turned), 3, 3))
    return np.concatenate([first, turned], axis=-1).reshape(-1, 15)


def _products(start: Array, turns: Array) -> Array:
    """Products of the start with the first turns, shape (N + 1, 4); each round doubles the number of factors."""
    found, factors = np.concatenate([start[np.newaxis], turns]), 1
    while factors < len(found):
        found[factors:] = quaternion.multiply(found[:-factors], found[factors:])
        factors *= 2
    return quaternion.normalize(found)
