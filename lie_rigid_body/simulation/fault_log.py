"""The faults of a simulation in the order in which they begin, across resets."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from operator import attrgetter
from typing import Final

from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.sensors import Fault, SensorModel
from lie_rigid_body.simulation.segment import SampleClock, Segment

_READINGS_AHEAD: Final = 64
"""Readings of the fastest sensor whose faults are sought at once, within a second: to seek for one takes as long."""
_BEGIN: Final = attrgetter("begin_ns")


class FaultLog:
    """The faults of the segments of a simulation, each told once."""

    def __init__(self) -> None:
        self._segments: list[_SegmentFaults] = []

    def follow(self, segment: Segment) -> None:
        """Begin with a segment, or continue with the next one."""
        for earlier in self._segments[-1:]:
            earlier.end_ns = segment.start_ns - 1
        self._segments.append(_SegmentFaults(segment))

    def take(self, until_ns: int) -> tuple[Fault, ...]:
        """Faults that begin up to a time, ns, and were not taken yet."""
        found = tuple(fault for faults in self._segments for fault in faults.take(min(until_ns, faults.end_ns)))
        self._segments = [faults for faults in self._segments if faults.end_ns > until_ns]
        return found


class _SegmentFaults:
    """The faults of one segment, found some time before they are taken."""

    def __init__(self, segment: Segment) -> None:
        self.end_ns = MAX_EPOCH_NS + 1
        self._segment, self._known_ns, self._ready = segment, segment.start_ns, list[Fault]()
        self._faulty = [sensor for sensor in segment.scenario.sensors.on.values() if sensor.faulty]
        fastest = max((sensor.rate for sensor in self._faulty), default=1.0)
        self._ahead_ns = min(int(_READINGS_AHEAD * NS / fastest), NS)  # of slow ones no sea of episodes

    def take(self, until_ns: int) -> list[Fault]:
        if self._faulty and until_ns >= self._known_ns:
            end_ns = min(until_ns + 1 + self._ahead_ns, MAX_EPOCH_NS + 1)
            new = [fault for sensor in self._faulty for fault in self._of(sensor, end_ns)]
            self._ready += sorted(new, key=_BEGIN)
            self._known_ns = end_ns
        count = bisect_right(self._ready, until_ns, key=_BEGIN)
        taken, self._ready = self._ready[:count], self._ready[count:]
        return taken

    def _of(self, sensor: SensorModel, end_ns: int) -> Iterator[Fault]:
        """Faults of a sensor from the time until which all are known to another, ns."""
        start_ns, begin_ns = self._segment.start_ns, self._known_ns
        clock = SampleClock(self._segment.scenario.epoch_ns, sensor.rate)
        first = clock.count_until(begin_ns - 1)
        times = clock.stamps_ns(first, clock.count_until(end_ns - 1) - first) - start_ns
        first -= clock.count_until(start_ns - 1)
        for faulty in sensor.faulty:
            for fault in faulty.faults(begin_ns - start_ns, end_ns - start_ns, first, times):
                yield fault.later(start_ns)
