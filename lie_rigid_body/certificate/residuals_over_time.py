"""The residuals of a bag over time, in memory that does not grow with its length."""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers

INTERVALS: Final = 400
"""Most intervals of time of which the largest residual is kept."""


class Watch(Protocol):
    """What is told of residuals as they are held against their limits."""

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next."""


class ResidualsOverTime(Watch):
    """The largest residual of each law in each interval of time; a `Watch` for ``certify``."""

    def __init__(self) -> None:
        self.laws: dict[str, LawOverTime] = {}

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next."""
        if len(stamps_ns):
            self.laws.setdefault(name, LawOverTime(unit, int(stamps_ns[0]))).add(residuals, limits, stamps_ns)


class LawOverTime:
    """The largest residual and the largest limit of one law in each of `INTERVALS` equal intervals of time at most.

    An interval is twice as long as before when the time that all cover is over.

    Parameters
    ----------
    unit : str
    start_ns : int
        Stamp at which the first interval begins.
    """

    def __init__(self, unit: str, start_ns: int) -> None:
        self.unit, self._start_ns, self._length_ns = unit, start_ns, 1
        self._residuals = np.full(INTERVALS, -np.inf)
        self._limits = np.full(INTERVALS, -np.inf)
        self._broken = np.zeros(INTERVALS, dtype=bool)

    def add(self, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take residuals, not negative, NaN for broken; those before the first interval count as its own."""
        while (int(stamps_ns.max()) - self._start_ns) // self._length_ns >= INTERVALS:
            self._double()
        at = np.maximum(0, (stamps_ns - self._start_ns) // self._length_ns)
        limits = np.broadcast_to(np.asarray(limits, dtype=np.float64), residuals.shape)
        for kept, new in (
            (self._residuals, np.where(np.isnan(residuals), np.inf, residuals)),
            (self._limits, limits),
            (self._broken, ~(residuals <= limits)),
        ):
            np.maximum.at(kept, at, new)

    def _double(self) -> None:
        self._length_ns *= 2
        for kept in (self._residuals, self._limits, self._broken):
            half = kept.reshape(-1, 2).max(axis=1)
            kept[: INTERVALS // 2] = half
            kept[INTERVALS // 2 :] = False if kept.dtype == bool else -np.inf

    def series(self, origin_ns: int) -> tuple[Array, Array, Array, Booleans]:
        """Middles of the intervals that have a residual, s since a stamp, residuals, limits, and which are broken."""
        found = np.flatnonzero(self._residuals >= 0.0)
        middles = np.asarray((self._start_ns - origin_ns + (found + 0.5) * self._length_ns) * 1e-9, dtype=np.float64)
        return middles, self._residuals[found], self._limits[found], self._broken[found]
