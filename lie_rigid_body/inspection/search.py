"""Search among gyros, turns and delays: how well each makes a vector constant in the world."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import product
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.inspection.rule import (
    DELAYS_S,
    GYROS,
    HOPELESS,
    LENGTHS_S,
    MIN_SHARE_LEFT,
    RIGHT,
    Gyro,
)
from lie_rigid_body.inspection.world import Vector, World, fit_turns

KEPT_WORLDS: Final = 6
"""Number of worlds that are kept: each takes 200 bytes a reading of the gyro."""
MIN_MOVE_S: Final = 0.001
"""Least distance of a delay between those of the scan, s, that is tried."""


class Worlds:
    """Worlds of the readings of a gyro, each integrated once while it is needed.

    Parameters
    ----------
    t_s : ndarray, shape (N,)
    rate : ndarray, shape (N, 3)
        Readings of the gyro as they are.
    """

    def __init__(self, t_s: Array, rate: Array) -> None:
        self.of = lru_cache(KEPT_WORLDS)(lambda gyro: World.of_rate(t_s, gyro.multiplier * rate))


class Misfits:
    """Misfits of one vector under the hypotheses that were tried.

    Attributes
    ----------
    vector : Vector
    length_s : float
        Length of the windows that tell most about this vector, s.
    """

    def __init__(self, vector: Vector, worlds: Worlds) -> None:
        self.vector = vector
        self.length_s = LENGTHS_S[0]
        self._worlds = worlds
        self._found: dict[tuple[Gyro, float], dict[float, Array]] = {}
        self._shares: dict[tuple[Gyro, float, float], float] = {}
        self._usual: dict[float, float] = {}

    def add(self, gyro: Gyro, delay_s: float = 0.0) -> None:
        """Try all turns with one gyro and one delay, s."""
        if (gyro, delay_s) not in self._found:
            blocks = self.vector.blocks(self._worlds.of(gyro), delay_s)
            self._found[gyro, delay_s] = {
                length: fit_turns(blocks.windows(length).gram()[0], self.vector.offset_cost).told
                for length in LENGTHS_S
                if blocks.has(length)
            }

    def screen(self) -> None:
        """Store how well a usual hypothesis fits, in windows of each length: the median of the first ones."""
        first = [self._found[gyro, 0.0] for gyro in GYROS]
        self._usual = {length: float(np.median([found[length] for found in first])) for length in first[0]}

    @property
    def lengths_s(self) -> tuple[float, ...]:
        """Lengths of windows, s, of which there are enough."""
        return tuple(self._usual)

    def contrast(self, gyro: Gyro) -> float:
        """How much better than a usual hypothesis a gyro fits at best."""
        found = [
            (length, misfit) for (each, _), by in self._found.items() if each == gyro for length, misfit in by.items()
        ]
        return max((self._usual[length] / float(misfit.min()) for length, misfit in found), default=1.0)

    def choose_length(self) -> None:
        """Choose the windows in which the best hypothesis stands out most, if they leave much of the vector."""
        bests = []
        for length, usual in self._usual.items():
            found = {key: float(by[length].min()) for key, by in self._found.items() if length in by}
            key = min(found, key=lambda key: found[key])
            bests.append((usual / found[key], length, key))
        bests.sort(reverse=True)
        told = [best for best in bests if self._share_left(*best[2], best[1]) > MIN_SHARE_LEFT]
        self.length_s = (told or bests)[0][1]

    def _share_left(self, gyro: Gyro, delay_s: float, length_s: float) -> float:
        """RMS of the window means under the best turn of a hypothesis, as a share of the vector."""
        key = (gyro, delay_s, length_s)
        if key not in self._shares:
            windows = self.vector.blocks(self._worlds.of(gyro), delay_s).windows(length_s)
            fit = fit_turns(windows.gram()[0], self.vector.offset_cost)
            best = int(fit.misfit.argmin())
            vectors = windows.vectors(best, fit.constants[best, 3:])
            self._shares[key] = float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
        return self._shares[key]

    @property
    def _chosen(self) -> dict[tuple[Gyro, float], Array]:
        """Misfits in the windows that tell most."""
        return {key: by[self.length_s] for key, by in self._found.items() if self.length_s in by}

    def by_delay(self, gyro: Gyro) -> tuple[Array, Array]:
        """Delays that were tried with a gyro, s, rising, shape (D,), and misfits of the turns, shape (D, 24)."""
        found = {delay: misfits for (each, delay), misfits in self._chosen.items() if each == gyro}
        delays = np.sort(list(found))
        return delays, np.array([found[delay] for delay in delays]).reshape(-1, 24)

    def best(self) -> tuple[Gyro, float, int]:
        """Gyro, delay, s, and turn of the least misfit."""
        found = self._chosen
        gyro, delay = min(found, key=lambda key: float(found[key].min()))
        return gyro, delay, int(found[gyro, delay].argmin())

    @property
    def least(self) -> float:
        """Least misfit of all."""
        return min(float(misfits.min()) for misfits in self._chosen.values())

    def scan(self, gyro: Gyro) -> None:
        """Try all delays with a gyro, and twice one between those tried: the vertex of a parabola of the square."""
        for delay in DELAYS_S:
            self.add(gyro, delay)
        self.choose_length()
        for _ in range(2):
            delays, misfits = self.by_delay(gyro)
            place = vertex(delays, misfits[:, misfits.min(axis=0).argmin()] ** 2)
            if place is not None and np.abs(delays - place).min() > MIN_MOVE_S:
                self.add(gyro, place)


def vertex(places: Array, values: Array) -> float | None:
    """Vertex of the parabola through the least value and its neighbours, to 0.1 ms; None at an end."""
    i = int(values.argmin())
    if not 0 < i < len(places) - 1:
        return None
    bend, slope, _ = np.polyfit(places[i - 1 : i + 2] - places[i], values[i - 1 : i + 2], 2)
    return round(float(places[i] - slope / 2.0 / bend), 4) if bend > 0.0 else None


def search(found: Sequence[Misfits], more: Iterable[Gyro] = ()) -> None:
    """Try every gyro without delay, and the likely ones with all delays.

    Parameters
    ----------
    found : sequence of Misfits
        Of each vector.
    more : iterable of Gyro
        Gyros that are tried with all delays, beside those of `GYROS`.
    """
    extra = tuple(more)
    for gyro, each in product((*GYROS, *extra), found):
        each.add(gyro)
    for each in found:
        each.screen()
    best = dict.fromkeys(found, 0.0)
    for gyro in extra or _likely(found):
        hopeless = all(each.contrast(gyro) < best[each] / HOPELESS for each in found)
        if hopeless and gyro != RIGHT and not extra:
            continue
        for each in found:
            each.scan(gyro)
            best[each] = max(best[each], each.contrast(gyro))
    for each in found:
        each.choose_length()


def _likely(found: Sequence[Misfits]) -> tuple[Gyro, ...]:
    """The two gyros that fit best all vectors, and each, and the right one."""
    contrasts = np.log([[each.contrast(gyro) for gyro in GYROS] for each in found])
    orders = np.argsort(-np.vstack([contrasts.sum(axis=0), contrasts]), axis=1, kind="stable")
    return tuple(dict.fromkeys([*(GYROS[i] for i in orders[:, :2].ravel()), RIGHT]))
