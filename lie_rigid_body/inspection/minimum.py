"""Minimum of a squared misfit along one constant, with its standard error.

It comes from the scatter between successive chunks of the log. With the curvature H of the squared misfit and the slope
g of each chunk, σ = √Σ(g − ḡ)² / H.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    INDEPENDENT_STEPS,
    MAX_NEWTON_STEPS,
    MIN_MISFIT,
    MIN_UNSEEN_S,
    SIGMAS,
    UNSEEN_SHARE,
)


class Minimum(NamedTuple):
    """Constant, such as a delay, s, at which the squared misfit is least.

    Attributes
    ----------
    place, sigma : float
        The constant and its standard error.
    level : float
        Misfit there, not below `MIN_MISFIT`.
    width : float
        Distance at which the squared misfit grows by as much as it is there, by its curvature.
    """

    place: float
    sigma: float
    level: float
    width: float

    def unseen(self, limit: float) -> float:
        """Size of the constant up to which it is no mistake, at least a limit, or not seen in this log.

        At `UNSEEN_SHARE` of the misfit over the slope the misfit grows by `MIN_GAIN`.
        """
        return max(limit, SIGMAS * self.sigma, UNSEEN_SHARE * self.width)

    @property
    def error(self) -> float:
        """Standard error, with that of a misfit that all chunks have in common."""
        return float(np.hypot(self.sigma, self.width / np.sqrt(INDEPENDENT_STEPS)))

    def is_like(self, other: Minimum) -> bool:
        """Whether two delays are one of the gyro, as far as the log sees."""
        return abs(self.place - other.place) < max(self.unseen(MIN_UNSEEN_S), other.unseen(MIN_UNSEEN_S))


def minimum(squares: Callable[[float], Array], place: float, step: float, moves: int = MAX_NEWTON_STEPS) -> Minimum:
    """Minimum of the squared misfits of chunks, by Newton's method from their values a step before and behind.

    Parameters
    ----------
    squares : callable
        Squared misfits of the chunks, shape (chunks,), at a place.
    place, step : float
    moves : int
        Largest number of moves, each of one step at most.
    """
    for _ in range(moves):
        before, here, after = (squares(place + side * step) for side in (-1, 0, 1))
        slopes = (after - before) / 2.0
        second = np.sum(after + before - 2.0 * here)
        level = np.sqrt(max(here.sum(), MIN_MISFIT**2))
        if second <= 0.0:
            return Minimum(place, np.inf, level, np.inf)
        move = -slopes.sum() / second
        place += step * np.clip(move, -1.0, 1.0)
        if abs(move) < 1.0:
            break
    sigma = np.linalg.norm(slopes - slopes.mean()) / second * step
    return Minimum(place, sigma, level, level * step / np.sqrt(second / 2.0))
