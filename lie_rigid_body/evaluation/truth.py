"""The true attitude at any time: exact, as a function of time, or from samples."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import FARTHEST_NS, read_series
from lie_rigid_body.evaluation.attitudes import angles_between, geodesic, turns
from lie_rigid_body.wording import shown

GAP: Final = 2.5
"""Least distance of neighbouring stamps that is a gap, in median periods: two samples or more are missing."""
DIFFERENCE_NS: Final = 100_000
"""Half of the time between the attitudes of the central difference, ns."""


def period_ns(stamps_ns: Integers) -> int:
    """Median time between stamps, ns; 0 for a single one."""
    return int(np.median(np.diff(stamps_ns))) if len(stamps_ns) > 1 else 0


def in_order(stamps_ns: Integers, after_ns: int | None = None) -> Booleans:
    """Whether each stamp, ns, is before none that came earlier, and not before `after_ns`."""
    first = int(stamps_ns[0]) if after_ns is None and len(stamps_ns) else after_ns or 0
    return np.asarray(stamps_ns >= np.maximum.accumulate(np.concatenate([[first], stamps_ns]))[:-1])


@runtime_checkable
class HasTruth(Protocol):
    """Something that has a true attitude at any time, as a run has."""

    def attitude(self) -> Truth:
        """The true attitude."""
        ...


class Truth(ABC):
    """True attitude as a function of time.

    Attributes
    ----------
    first_ns, last_ns : int
        The times between which it is known.
    """

    first_ns: int
    last_ns: int

    @abstractmethod
    def at(self, stamps_ns: Integers) -> Array:
        """Unit quaternions world-from-body, scalar last, shape (..., 4), at stamps of any shape within its times."""

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Bound of the error of the truth itself at some stamps, rad, by interpolation; 0 if it is exact."""
        return 0.0

    def covers(self, stamps_ns: Integers) -> Booleans:
        """Whether the truth is known at each stamp."""
        return np.asarray((stamps_ns >= self.first_ns) & (stamps_ns <= self.last_ns))

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitude, shape (..., 4), and body rate, rad/s, shape (..., 3), by a central difference over 0.2 ms.

        Stamps outside of the truth's times, which a fit of a lag may try, have the state of the first or the last time.
        """
        stamps = np.clip(stamps_ns, self.first_ns, self.last_ns)
        before = np.maximum(stamps - DIFFERENCE_NS, self.first_ns)
        after = np.minimum(stamps + DIFFERENCE_NS, self.last_ns)
        earlier, now, later = self.at(np.stack([before, stamps, after]))
        return now, turns(earlier, later) / (np.maximum(after - before, 1) * 1e-9)[..., np.newaxis]


class ExactTruth(Truth):
    """A motion that is known at every instant.

    Parameters
    ----------
    attitude_xyzw : callable
        Takes stamps in ns, shape (N,), never decreasing, and gives quaternions of shape (N, 4).
    first_ns, last_ns : int
        The times between which it may be asked.

    Raises
    ------
    InputError
        If it ends before it begins, or a time is none that a message can have.
    """

    def __init__(self, attitude_xyzw: Callable[[Integers], Array], first_ns: int, last_ns: int) -> None:
        self.first_ns, self.last_ns = _time(first_ns), _time(last_ns)
        if last_ns < first_ns:
            raise InputError(f"truth: it ends at {last_ns} ns, before its begin at {first_ns} ns: exchange them")
        self._attitude = attitude_xyzw

    def at(self, stamps_ns: Integers) -> Array:
        """Values of the function, asked once and in order of time."""
        stamps, place = np.unique(stamps_ns, return_inverse=True)
        return np.asarray(self._attitude(stamps)[place.reshape(np.shape(stamps_ns))])


class SampledTruth(Truth):
    """Samples of the true attitude, on the geodesic from one to the next (slerp) between their stamps.

    At a sample's own stamp it is that sample to the bit. Between samples h apart the geodesic misses the motion by at
    most |ω̇| h²/8. `uncertainty` measures this: each sample is left out and interpolated from its two neighbours, 2h
    apart, and misses them by four times as much. Nothing is interpolated across a gap.

    Parameters
    ----------
    stamps_ns : array_like of int, shape (N,)
        Increasing.
    attitude_xyzw : array_like, shape (N, 4)
        World-from-body, scalar last.
    longest_gap_ns : int, optional
        Neighbours farther apart are not joined. By default 2.5 times the median period.

    Raises
    ------
    InputError
        If stamps are not increasing, or a quaternion is not finite or zero.
    """

    def __init__(self, stamps_ns: ArrayLike, attitude_xyzw: ArrayLike, longest_gap_ns: int | None = None) -> None:
        stamps, attitude = read_series("truth", stamps_ns, attitude_xyzw)
        if np.any(np.diff(stamps) == 0):
            raise InputError("truth: a stamp occurs twice: leave one of the two samples out")
        self._longest_gap = GAP * period_ns(stamps) if longest_gap_ns is None else longest_gap_ns
        self.first_ns, self.last_ns = int(stamps[0]), int(stamps[-1])
        if len(stamps) == 1:  # an interval, within whose ends the truth is not asked for
            stamps, attitude = stamps + np.arange(2), np.repeat(attitude, 2, axis=0)
        self._stamps, self._attitude = stamps, attitude
        around = stamps[2:] - stamps[:-2]
        middle = geodesic(attitude[:-2], attitude[2:], (stamps[1:-1] - stamps[:-2]) / around)
        misses = angles_between(middle, attitude[1:-1])[around <= 2 * self._longest_gap]
        self.uncertainty = float(misses.max(initial=0.0)) / 4.0

    def covers(self, stamps_ns: Integers) -> Booleans:
        """Whether a stamp is a sample's own, or between two that are joined."""
        i = self._interval(stamps_ns)
        joined = self._stamps[i + 1] - self._stamps[i] <= self._longest_gap
        return np.asarray(super().covers(stamps_ns) & (joined | np.isin(stamps_ns, self._stamps)))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Bound `uncertainty`, or 0 if every stamp is a sample's own."""
        return 0.0 if np.isin(stamps_ns, self._stamps).all() else self.uncertainty

    def at(self, stamps_ns: Integers) -> Array:
        """Attitudes at the samples, and on the geodesics between them."""
        i = self._interval(stamps_ns)
        fraction = (stamps_ns - self._stamps[i]) / (self._stamps[i + 1] - self._stamps[i])
        between = geodesic(self._attitude[i], self._attitude[i + 1], fraction)
        return np.where((fraction == 1.0)[..., np.newaxis], self._attitude[i + 1], between)

    def _interval(self, stamps_ns: Integers) -> Integers:
        return np.clip(np.searchsorted(self._stamps, stamps_ns, side="right") - 1, 0, len(self._stamps) - 2)


def _time(value: Any) -> int:
    if not isinstance(value, int | float | np.integer) or not abs(value) <= FARTHEST_NS:
        raise InputError(f"truth: the time {shown(value)} is not within 2**31 s of 0, as in ROS 2: give it in ns")
    return int(value)
