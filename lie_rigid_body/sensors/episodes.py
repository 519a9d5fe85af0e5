"""Episodes: stretches of time in which a sensor has a fault."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import NS, Value
from lie_rigid_body.sensors.fault import stream
from lie_rigid_body.sensors.noise import Draws

SHORTEST_INTERVAL_S: Final = 1e-3
"""Shortest interval from one episode to the next, s."""
END_OF_TIME: Final = 2**62
"""A time since a start that no run reaches, ns."""


def nanoseconds(seconds: float) -> int:
    """Convert a time in s to the nearest integer of ns."""
    return round(seconds * NS)


@dataclass(frozen=True)
class Window:
    """Time in which faults come and go, ns since the segment's start; the end is not part of it."""

    begin_ns: int
    end_ns: int

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> Window:
        """Make the window of the parameters ``fault_begin`` and ``fault_end``.

        Raises
        ------
        ParameterError
            If it ends before it begins.
        """
        begin, end = (cast(float, values[name]) for name in ("fault_begin", "fault_end"))
        if 0.0 < end <= begin:
            raise ParameterError("fault_end", f"{end:g} s is not after fault_begin, {begin:g} s: give more, or 0")
        return cls(nanoseconds(begin), nanoseconds(end) if end else END_OF_TIME)

    def holds(self, times_ns: Integers) -> Booleans:
        """Tell of each time whether it is in the window, shape (N,)."""
        return np.asarray((times_ns >= self.begin_ns) & (times_ns < self.end_ns))


@dataclass(frozen=True)
class Episodes:
    """Episodes of one kind: one in each interval from the window's begin on, at a place in it that the seed decides.

    A long time has as many episodes as intervals, and no episode meets the next, whatever the seed. Where the duration
    is the interval, one begins as the other ends.

    Parameters
    ----------
    seed : int
    sensor, kind : str
        See `Fault`.
    window : Window
    interval_ns, duration_ns : int
    """

    seed: int
    sensor: str
    kind: str
    window: Window
    interval_ns: int
    duration_ns: int

    @classmethod
    def from_values(cls, values: Mapping[str, Value], sensor: str, kind: str, name: str = "") -> Episodes | None:
        """Make the episodes of the parameters that begin with ``sensor_kind``, or ``name``; None if the interval is 0.

        Raises
        ------
        ParameterError
            If the duration is longer than the interval, or the interval is too short.
        """
        name = name or f"{sensor}_{kind}"
        interval, duration = (cast(float, values[f"{name}_{what}"]) for what in ("interval", "duration"))
        if not interval:
            return None
        if interval < SHORTEST_INTERVAL_S:
            raise ParameterError(
                f"{name}_interval", f"{interval:g} s is below {SHORTEST_INTERVAL_S:g} s: give more, or 0 for none"
            )
        if not 0 < nanoseconds(duration) <= nanoseconds(interval):
            raise ParameterError(
                f"{name}_duration",
                f"{duration:g} s is not above 0 and at most {name}_interval, {interval:g} s: give a time between",
            )
        window = Window.from_values(values)
        return cls(cast(int, values["sensor_seed"]), sensor, kind, window, nanoseconds(interval), nanoseconds(duration))

    def draws(self, numbers: Integers) -> Array:
        """Three uniform numbers for each episode, shape (N, 3), which decide everything but its time."""
        return self._draws(numbers)[:, 1:]

    def _draws(self, numbers: Integers) -> Array:
        return Draws(self.seed, stream(self.sensor, self.kind)).of(numbers)

    def begins_ns(self, numbers: Integers) -> Integers:
        """Begin of each episode, ns since the segment's start, shape (N,)."""
        spare = self._draws(numbers)[:, 0] * (self.interval_ns - self.duration_ns)
        return self.window.begin_ns + numbers * self.interval_ns + spare.astype(np.int64)

    def at(self, times_ns: Integers) -> Integers:
        """Number of the episode at each time, shape (N,); -1: none."""
        numbers = (times_ns - self.window.begin_ns) // self.interval_ns
        found = np.full(len(times_ns), -1, dtype=np.int64)
        inside = np.flatnonzero(self.window.holds(times_ns))
        age = times_ns[inside] - self.begins_ns(numbers[inside])
        inside = inside[(age >= 0) & (age < self.duration_ns)]
        found[inside] = numbers[inside]
        return found

    def between(self, begin_ns: int, end_ns: int) -> Iterator[tuple[int, int, int]]:
        """Number, begin and end of each episode that begins in a stretch of time without its end, ns."""
        begin_ns, end_ns = max(begin_ns, self.window.begin_ns), min(end_ns, self.window.end_ns)
        if begin_ns >= end_ns:
            return
        low, high = ((time - self.window.begin_ns) // self.interval_ns for time in (begin_ns, end_ns - 1))
        numbers = np.arange(low, high + 1, dtype=np.int64)
        for number, begin in zip(numbers.tolist(), self.begins_ns(numbers).tolist(), strict=True):
            if begin_ns <= begin < end_ns:
                yield number, begin, min(begin + self.duration_ns, self.window.end_ns)
