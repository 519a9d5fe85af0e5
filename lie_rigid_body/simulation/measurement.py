"""The measurement of one sensor in one segment: its readings in order, and when they arrive."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.motion import Motion
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.sensors.signal import Signal
from lie_rigid_body.simulation.samples import SensorSamples
from lie_rigid_body.simulation.segment import Arrivals, SampleClock, Segment


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
    arrivals : Arrivals or None
        None: every reading arrives at the time of its measurement, which is its stamp.
    walk_deviates : int
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
        delivery = self.model.delivery
        self.arrivals = None if delivery is None else Arrivals(self.clock, self.first, start_ns, delivery)
        self._instrument = SENSORS[name].make(self.model, scenario.body())
        self.walk_deviates = self._instrument.walk_deviates
        self._skip_to(self.first)

    def samples(self, measured_ns: Integers) -> SensorSamples:
        """The next readings, which are measured at some times, ns."""
        number, times = self.next, measured_ns - self._start_ns
        self.next += len(times)
        readings = self._instrument.measure(times, self._motion.at(times), number - self.first)
        return SensorSamples(*self._arrived(number, measured_ns), readings)

    def replay(self, count: int) -> tuple[Integers, Integers, dict[str, Signal]]:
        """When the next readings arrive, ns, and are measured, ns since the start, and their signals by array."""
        number, measured_ns = self.next, self.clock.stamps_ns(self.next, count)
        times = measured_ns - self._start_ns
        self.next += count
        signals = self._instrument.signals(times, self._motion.at(times), number - self.first)
        return self._arrived(number, measured_ns)[0], times, signals

    def _arrived(self, number: int, measured_ns: Integers) -> tuple[Integers, Integers, Booleans]:
        """Arrival times and stamps of readings, ns, and which of them are lost."""
        if self.arrivals is None:
            return measured_ns, measured_ns, np.zeros(len(measured_ns), dtype=np.bool_)
        return self.arrivals.of(number, measured_ns)

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
