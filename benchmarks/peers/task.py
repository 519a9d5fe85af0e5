"""What every contender is asked for: the attitude of one free body at given times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

INERTIA: Final = np.array([0.6, 0.8, 1.0])
"""Principal moments, kg m²: a fast asymmetric top, far from every steady rotation."""

RATE: Final = np.array([3.0, 0.5, -0.9])
"""Body rate at the start, rad/s; the body momentum is then 1.8, 0.4, −0.9 kg m²/s."""

ATTITUDE: Final = np.array([0.0, 0.0, 0.0, 1.0])
"""Attitude at the start, xyzw."""

NS: Final = 1_000_000_000
GOLDEN: Final = (5**0.5 - 1) / 2


@dataclass(frozen=True, eq=False)
class Task:
    """The instants at which attitudes are asked for, and those of them that are held against the truth.

    Attributes
    ----------
    name : str
    title : str
        For tables and pictures.
    times_ns : ndarray of int64, shape (N,)
        Nanoseconds since the start, rising.
    judged : ndarray of int64, shape (M,)
        Which of them have a truth.
    """

    name: str
    title: str
    times_ns: NDArray[np.int64]
    judged: NDArray[np.int64]

    @property
    def span(self) -> float:
        """Simulated time, s."""
        return float(self.times_ns[-1]) / NS

    @property
    def judged_ns(self) -> list[int]:
        """The instants that have a truth, ns."""
        return [int(t) for t in self.times_ns[self.judged]]

    @property
    def smallest_interval(self) -> float:
        """A fixed step cannot be longer than this, s."""
        return float(np.diff(self.times_ns, prepend=0).min()) / NS


def _all_judged(name: str, title: str, seconds: NDArray[np.float64]) -> Task:
    times = np.unique(np.rint(seconds).astype(np.int64)) * NS
    return Task(name, title, times, np.arange(len(times)))


def _stream() -> Task:
    """Judged at instants scattered by the golden ratio, so that no regular grid of knots meets them all."""
    times = np.arange(1, 10_001, dtype=np.int64) * (NS // 1000)
    scattered = np.unique((np.arange(1, 51) * GOLDEN % 1.0 * len(times)).astype(np.int64))
    return Task("stream", "1000 attitudes a second, for 10 s", times, scattered)


SHORT: Final = _all_judged("short", "the attitude after 1, 2, … 10 s", np.arange(1.0, 11.0))
LONG: Final = _all_judged("long", "the attitude at 28 instants up to 1000 s", np.geomspace(1.0, 1000.0, 31))
STREAM: Final = _stream()
WARM_UP: Final = Task("warm-up", "two attitudes", np.array([NS, 2 * NS]), np.arange(2))
"""So that nobody's compilation is timed."""

TASKS: Final = (SHORT, STREAM, LONG)
