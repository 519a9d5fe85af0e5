"""Arrival times of the readings of a sensor, by the numbers of the readings."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.sensors import Delivery
from lie_rigid_body.simulation.sample_clock import SampleClock


class Arrivals:
    """The times at which readings arrive, and their stamps. A lost reading has the time at which it would have arrived.

    Parameters
    ----------
    clock : SampleClock
        Clock of the measurements.
    first : int
        Number of the segment's first reading.
    start_ns : int
        The segment's start, ns.
    delivery : Delivery or None
        Faults on the way; None: every reading arrives at the time of its measurement, which is its stamp.
    """

    def __init__(self, clock: SampleClock, first: int, start_ns: int, delivery: Delivery | None) -> None:
        self._clock = clock
        self._first = first
        self._start_ns = start_ns
        self._delivery = delivery

    def stamp_ns(self, number: int) -> int:
        """Time at which one reading arrives, ns."""
        if self._delivery is None:
            return self._clock.stamp_ns(number)
        return int(self._latest(number, np.array([self._clock.stamp_ns(number)]))[0])

    def count_until(self, stamp_ns: int) -> int:
        """Number of readings of the clock, from number 0 on, that arrive at or before a time, ns."""
        if self._delivery is None:
            return self._clock.count_until(stamp_ns)
        at_most = self._clock.count_until(stamp_ns - self._delivery.latency_ns)
        at_least = self._clock.count_until(stamp_ns - self._delivery.latency_ns - self._delivery.jitter_ns)
        at_least = max(at_least, min(self._first, at_most))
        if at_least == at_most or stamp_ns > MAX_EPOCH_NS:
            return at_most
        between = self._latest(at_least, self._clock.stamps_ns(at_least, at_most - at_least))
        return at_least + int(np.searchsorted(between, stamp_ns, side="right"))

    def of(self, measured_ns: Integers) -> tuple[Integers, Integers, Booleans]:
        """Arrival times and stamps, ns, of readings that follow each other, and which of them are lost."""
        delivery = self._delivery
        if delivery is None or not len(measured_ns):
            return measured_ns, measured_ns, np.zeros(len(measured_ns), dtype=np.bool_)
        number = self._clock.count_until(int(measured_ns[0])) - 1
        stamps = delivery.stamps_ns(measured_ns, self._clock.epoch_ns)
        lost = delivery.lost(number - self._first, measured_ns - self._start_ns)
        return self._latest(number, measured_ns), stamps, lost

    def _latest(self, number: int, measured_ns: Integers) -> Integers:
        """Arrival times of the readings from one number on, ns: no reading overtakes an earlier one."""
        assert self._delivery is not None
        # of those measured more than the jitter ago none can be late enough to hold up another
        since = int(measured_ns[0]) - self._delivery.jitter_ns if len(measured_ns) else 0
        before = max(self._first, self._clock.count_until(since - 1)) if self._delivery.jitter_ns else number
        before = min(before, number)
        times = np.concatenate([self._clock.stamps_ns(before, number - before), measured_ns])
        delays = self._delivery.delays_ns(before - self._first, len(times))
        return np.maximum.accumulate(times + delays)[number - before :]
