"""The faults of a simulation in the order in which they begin, across resets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.sensors import Fault, SensorModel
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.segment import Segment

_READINGS_AHEAD: Final = 64
"""Readings of the fastest sensor whose faults are sought at once, within a second: to seek for one takes as long."""


class FaultLog:
    """The faults of the segments of a simulation, each told once.

    Parameters
    ----------
    segment : Segment
        The first segment.
    """

    def __init__(self, segment: Segment) -> None:
        self._ending: list[tuple[_SegmentFaults, int]] = []
        self._last = _SegmentFaults(segment)

    def follow(self, segment: Segment) -> None:
        """Continue with a new segment."""
        self._ending.append((self._last, segment.start_ns - 1))
        self._last = _SegmentFaults(segment)

    def take(self, until_ns: int) -> tuple[Fault, ...]:
        """Faults that begin up to a time, ns, and were not taken yet."""
        found: list[Fault] = []
        while self._ending:
            faults, end_ns = self._ending[0]
            found += faults.take(min(until_ns, end_ns))
            if until_ns < end_ns:
                return tuple(found)
            self._ending.pop(0)
        return (*found, *self._last.take(until_ns))


class _SegmentFaults:
    """The faults of one segment, found some time before they are taken."""

    def __init__(self, segment: Segment) -> None:
        sensors = segment.scenario.sensors.on.values()
        self._segment = segment
        self._faulty = [sensor for sensor in sensors if any(faulty is not None for faulty in sensor.faulty)]
        self._known_ns = segment.start_ns
        fastest = max((sensor.rate for sensor in self._faulty), default=0.0)
        self._ahead_ns = (
            min(int(_READINGS_AHEAD * NS / fastest), NS) if fastest else 0
        )  # of slow ones no sea of episodes
        self._ready: list[Fault] = []

    def take(self, until_ns: int) -> list[Fault]:
        if self._faulty and until_ns >= self._known_ns:
            end_ns = min(until_ns + 1 + self._ahead_ns, MAX_EPOCH_NS + 1)
            new = [fault for sensor in self._faulty for fault in self._of(sensor, end_ns)]
            self._ready += sorted(new, key=lambda fault: fault.begin_ns)
            self._known_ns = end_ns
        count = sum(1 for _ in _until(self._ready, until_ns))
        taken, self._ready = self._ready[:count], self._ready[count:]
        return taken

    def _of(self, sensor: SensorModel, end_ns: int) -> Iterator[Fault]:
        """Faults of a sensor from the time until which all are known to another, ns."""
        start_ns, begin_ns = self._segment.start_ns, self._known_ns
        clock = SampleClock(self._segment.scenario.epoch_ns, sensor.rate)
        before = clock.count_until(start_ns - 1)
        first = clock.count_until(begin_ns - 1)
        times = clock.stamps_ns(first, clock.count_until(end_ns - 1) - first) - start_ns
        for faulty in sensor.faulty:
            if faulty is not None:
                found = faulty.faults(begin_ns - start_ns, end_ns - start_ns, first - before, times)
                yield from (fault.later(start_ns) for fault in found)


def _until(faults: list[Fault], until_ns: int) -> Iterator[Fault]:
    for fault in faults:
        if fault.begin_ns > until_ns:
            return
        yield fault
