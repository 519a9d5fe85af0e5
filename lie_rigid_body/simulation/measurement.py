"""The measurement of one sensor in one segment: its readings in order, and when they arrive."""

from __future__ import annotations

from lie_rigid_body.arrays import Integers
from lie_rigid_body.motion import Motion
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.sensors.signal import Signal
from lie_rigid_body.simulation.arrivals import Arrivals
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import SensorSamples
from lie_rigid_body.simulation.segment import Segment


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
    first, next : int
        Number of the segment's first reading, and of the one that comes next.
    """

    def __init__(self, segment: Segment, name: str, motion: Motion) -> None:
        scenario = segment.scenario
        self._start_ns, self._motion = segment.start_ns, motion
        self.model = scenario.sensors.on[name]
        self.clock = SampleClock(scenario.epoch_ns, self.model.rate)
        self.first = self.next = self.clock.count_until(segment.start_ns - 1)
        self.arrivals = Arrivals(self.clock, self.first, segment.start_ns, self.model.delivery)
        self._instrument = SENSORS[name].make(self.model, scenario, self._elapsed_ns(self.first - 1))

    @property
    def walks(self) -> bool:
        """Whether readings that are left out take time, as a bias walks through them."""
        return self._instrument.walks

    def samples(self, measured_ns: Integers) -> SensorSamples:
        """The next readings, which are measured at some times, ns."""
        times = measured_ns - self._start_ns
        self.next += len(times)
        return SensorSamples(*self.arrivals.of(measured_ns), self._instrument.measure(times, self._motion.at(times)))

    def replay(self, count: int) -> tuple[Integers, Integers, dict[str, Signal]]:
        """When the next readings arrive, ns, and are measured, ns since the start, and their signals by array."""
        measured = self.clock.stamps_ns(self.next, count)
        times = measured - self._start_ns
        self.next += count
        return self.arrivals.of(measured)[0], times, self._instrument.signals(times, self._motion.at(times))

    def begin_at(self, number: int) -> None:
        """Leave out the readings before one. What an axis that is stuck repeats in it is measured all the same."""
        if number > self.next:
            repeated = self._instrument.repeated(number - 1, self._elapsed_ns, self._number_before)
            for earlier in sorted({max(other, self.first) for other in repeated}):
                if earlier >= self.next:
                    self._skip_to(earlier)
                    self.replay(1)
        self._skip_to(number)

    def _skip_to(self, number: int) -> None:
        count, self.next = number - self.next, number
        if count:
            before_ns = self._elapsed_ns(number - 1)
            self._instrument.skip(count, before_ns, self._motion.at(before_ns))

    def _elapsed_ns(self, number: int) -> int:
        return self.clock.stamp_ns(number) - self._start_ns

    def _number_before(self, time_ns: int) -> int:
        return self.clock.count_until(self._start_ns + time_ns - 1) - 1
