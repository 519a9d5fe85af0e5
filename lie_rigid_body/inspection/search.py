"""Search among gyros, turns and delays: how well each makes a vector constant in the world."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import nlargest
from itertools import chain, product
from typing import NamedTuple

import numpy as np

from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.inspection.minimum import Minimum, minimum
from lie_rigid_body.inspection.rule import (
    CHUNKS,
    DELAY_STEP_S,
    DELAYS_S,
    EXCLUDED,
    GYROS,
    MAX_NEWTON_STEPS,
    MIN_SHARE_LEFT,
    RIGHT,
)
from lie_rigid_body.inspection.world import Vector, gram
from lie_rigid_body.lie.vectors import norm


@dataclass(eq=False)
class Misfits(Vector):
    """Misfits of one vector under the hypotheses that were tried."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._chosen = 0
        self._found: defaultdict[float, dict[float, Array]] = defaultdict(dict)

    @property
    def length_s(self) -> float:
        """Length of the windows, s, in which the best hypothesis stands out most."""
        return self.lengths_s[self._chosen]

    def add(self, gyro: float, delay_s: float = 0.0) -> None:
        """Try all turns with one gyro and one delay, s, in windows of each length."""
        windows = self.windows(gyro, delay_s, *self.lengths_s)
        self._found[gyro][delay_s] = np.array([self.fit(gram(each)).misfit for each in windows])

    @cached_property
    def _usual(self) -> Array:
        """How well a usual hypothesis fits, in windows of each length: the median of the first ones."""
        return np.median([self._found[gyro][0.0] for gyro in GYROS], axis=(0, 2))

    def contrast(self, gyro: float) -> float:
        """How much better than a usual hypothesis a gyro fits at best."""
        every = [misfits.min(axis=1) for misfits in self._found[gyro].values()]
        return np.max(self._usual / every)

    def best(self, *gyros: float) -> tuple[float, Fitting]:
        """Least misfit in windows of the chosen length, with some gyros or with all, and where it is."""
        tried = [(gyro, delay_s) for gyro in gyros or self._found for delay_s in self._found[gyro]]
        gyro, delay_s = min(tried, key=lambda one: self._found[one[0]][one[1]][self._chosen].min())
        misfits = self._found[gyro][delay_s][self._chosen]
        return misfits.min(), Fitting(self, gyro, int(misfits.argmin()), delay_s)

    def choose_length(self) -> None:
        """Choose the windows in which the best hypothesis stands out most, if they leave much of the vector."""

        def merit(chosen: int) -> tuple[bool, float]:
            self._chosen = chosen
            least, best = self.best()
            (windows,) = self.windows(best.gyro, best.delay_s, self.length_s)
            column = self.fit(gram(windows)).column[best.turn]
            left = rms(norm(windows[..., :12] @ column[:12]))
            return left > MIN_SHARE_LEFT, self._usual[chosen] / least

        self._chosen = max(range(len(self.lengths_s)), key=merit)

    def by_delay(self, gyro: float) -> tuple[Array, Array]:
        """Delays that were tried with a gyro, s, rising, shape (D,), and misfits of the turns, shape (D, 24)."""
        delays, misfits = zip(*sorted(self._found[gyro].items()), strict=True)
        return np.array(delays), np.array(misfits)[:, self._chosen]

    @property
    def plain(self) -> float:
        """Misfit without a repair."""
        return float(self._found[RIGHT][0.0][self._chosen, 0])

    def turns(self, gyro: float) -> Integers:
        """Turns that are not excluded with a gyro."""
        return np.flatnonzero(self.by_delay(gyro)[1].min(axis=0) <= EXCLUDED * self.best()[0])

    def scan(self, gyro: float) -> None:
        """Try all delays with a gyro, and one near the best of them, where the misfit of its turn is least."""
        for delay in DELAYS_S:
            self.add(gyro, delay)
        self.choose_length()
        self.add(gyro, self.best(gyro)[1].fit_delay(self.length_s, DELAY_STEP_S).place)


class Fitting(NamedTuple):
    """One vector under one hypothesis.

    Attributes
    ----------
    misfits : Misfits
    gyro : float
        Its multiplier.
    turn : int
        Index in `TURNS`.
    delay_s : float
    ratio : float
        Misfit over the least one of this vector.
    """

    misfits: Misfits
    gyro: float
    turn: int
    delay_s: float
    ratio: float = 1.0

    def squares(self, length_s: float) -> Array:
        """Squared misfits of the chunks, with the constants that fit all of them, shape (chunks,)."""
        (windows,) = self.misfits.windows(self.gyro, self.delay_s, length_s)
        grams = gram(windows, CHUNKS)
        column: Array = self.misfits.fit(grams).column[self.turn]
        return grams @ column @ column

    def fit_delay(self, length_s: float, step_s: float, moves: int = MAX_NEWTON_STEPS) -> Minimum:
        """Fit the delay in windows of one length, from its own value on."""
        return minimum(lambda delay_s: self._replace(delay_s=delay_s).squares(length_s), self.delay_s, step_s, moves)


def search(found: Sequence[Misfits]) -> None:
    """Try every gyro of `GYROS` without delay, and the likely ones with all delays."""
    for gyro, each in product(GYROS, found):
        each.add(gyro)
    scan(found, _likely(found))


def scan(found: Sequence[Misfits], gyros: Iterable[float]) -> None:
    """Try gyros with all delays, after those of `GYROS`."""
    for gyro, each in product(gyros, found):
        each.scan(gyro)
    for each in found:
        each.choose_length()


def _likely(found: Sequence[Misfits]) -> Iterable[float]:
    """The two gyros that fit best all vectors, and each, and the right one."""
    best = [
        nlargest(2, GYROS, key=lambda gyro: np.prod([each.contrast(gyro) for each in group]))
        for group in (found, *([each] for each in found))
    ]
    return dict.fromkeys([*chain(*best), RIGHT])
