"""The measurement of one sensor in one segment: its readings in order, and when they arrive."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.motion import Motion
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.sensors import SENSORS, Delivery
from lie_rigid_body.sensors.signal import Signal
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import SensorSamples
from lie_rigid_body.simulation.segment import Segment


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
        self._clock, self._first = clock, first
        self._start_ns, self._delivery = start_ns, delivery

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

    def of(self, number: int, measured_ns: Integers) -> tuple[Integers, Integers, Booleans]:
        """Arrival times and stamps, ns, of the readings from one number on, and which of them are lost."""
        delivery = self._delivery
        if delivery is None or not len(measured_ns):
            return measured_ns, measured_ns, np.zeros(len(measured_ns), dtype=np.bool_)
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


class Measurement:
    """The readings of one sensor in one segment, each of which is computed once, in order.

    Parameters
    ----------
    segment : Segment
    name : str
        The sensor's, in `SENSORS`.
    motion : Motion
        What the sensor feels. To begin at a later reading it has to be exact.

    Attributes
    ----------
    model : SensorModel
    clock : SampleClock
        Of the measurements.
    arrivals : Arrivals
    walks : bool
        See `Instrument`.
    first, next : int
        Number of the segment's first reading, and of the one that comes next.
    """

    def __init__(self, segment: Segment, name: str, motion: Motion) -> None:
        scenario, start_ns = segment.scenario, segment.start_ns
        self._scenario, self._start_ns, self._motion = scenario, start_ns, motion
        self.model = scenario.sensors.on[name]
        self.clock = SampleClock(scenario.epoch_ns, self.model.rate)
        self.first = self.clock.count_until(start_ns - 1)
        self.arrivals = Arrivals(self.clock, self.first, start_ns, self.model.delivery)
        self._instrument = SENSORS[name].make(self.model, scenario.body())
        self.walks = self._instrument.walks
        self._skip_to(self.first)

    def samples(self, measured_ns: Integers) -> SensorSamples:
        """The next readings, which are measured at some times, ns."""
        number, times = self.next, measured_ns - self._start_ns
        self.next += len(times)
        readings = self._instrument.measure(times, self._motion.at(times), number - self.first)
        return SensorSamples(*self.arrivals.of(number, measured_ns), readings)

    def replay(self, count: int) -> tuple[Integers, Integers, dict[str, Signal]]:
        """When the next readings arrive, ns, and are measured, ns since the start, and their signals by array."""
        number, measured_ns = self.next, self.clock.stamps_ns(self.next, count)
        times = measured_ns - self._start_ns
        self.next += count
        signals = self._instrument.signals(times, self._motion.at(times), number - self.first)
        return self.arrivals.of(number, measured_ns)[0], times, signals

    def begin_at(self, number: int) -> None:
        """Leave out the readings before one. What an axis that is stuck repeats in it is measured all the same."""
        if number > self.next:
            parts = [faulty.repeated(number - 1, self._elapsed_ns, self._number_before) for faulty in self.model.faulty]
            for earlier in sorted({max(self.first, repeated) for part in parts for repeated in part}):
                if earlier >= self.next:
                    self._skip_to(earlier)
                    self.replay(1)
            self._skip_to(number)

    def _skip_to(self, number: int) -> None:
        self.next, before_ns = number, self._elapsed_ns(number - 1)
        self._instrument.begin_after(before_ns, lambda: self._scenario.exact_motion().at(before_ns))

    def _elapsed_ns(self, number: int) -> int:
        return self.clock.stamp_ns(number) - self._start_ns

    def _number_before(self, time_ns: int) -> int:
        return self.clock.count_until(self._start_ns + time_ns - 1) - 1
