"""Samples, states or readings of sensors with their stamps; queues of them, and the measurement of one sensor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.stamped import Stamped
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import Motion
from lie_rigid_body.motion.mass_centre import MassCentre
from lie_rigid_body.sensors import SENSORS, Signal
from lie_rigid_body.simulation.segment import Arrivals, SampleClock, Segment


@short_dataclass
class Samples(Stamped):
    """States and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        States of N instants.
    centre : MassCentre or None
        The mass centre at these instants; None: it rests where the scenario says.
    """

    stamps_ns: Integers
    states: State
    centre: MassCentre | None = None

    @property
    def times_ns(self) -> Integers:
        """Times at which the samples are sent and logged, ns: their stamps."""
        return self.stamps_ns


@short_dataclass
class SensorSamples(Stamped):
    """Readings of a sensor with their times.

    Parameters
    ----------
    times_ns : ndarray of int64, shape (N,)
        Times at which they arrive, are sent and logged, ns.
    stamps_ns : ndarray of int64, shape (N,)
        Stamps of their headers, ns: what the sensor's own clock shows at the time of measurement.
    lost : ndarray of bool, shape (N,)
        Which of them never arrive.
    arrays : mapping of str to ndarray, shape (N, ...)
        The readings, by the names of `Field.array`.
    """

    times_ns: Integers
    stamps_ns: Integers
    lost: Booleans
    arrays: Mapping[str, Array]

    def received(self) -> SensorSamples:
        """Leave out the readings that never arrive."""
        return self[~self.lost] if self.lost.any() else self


R = TypeVar("R", Samples, SensorSamples)


class SampleQueue(Generic[R]):
    """The samples of one clock from a segment's start on, computed ahead and taken in order.

    Parameters
    ----------
    clock : SampleClock
    first : int
        Number of the first sample to compute.
    compute : callable
        ``compute(stamps_ns)`` makes samples. Each stamp is asked for once, in rising order, unless a ParameterError
        says that there is none.
    look_ahead : int
        Samples to compute at once when fewer are wanted.
    arrivals : Arrivals, optional
        When the samples are sent; by default at their stamps.
    """

    def __init__(
        self,
        clock: SampleClock,
        first: int,
        compute: Callable[[Integers], R],
        look_ahead: int,
        arrivals: Arrivals | None = None,
    ) -> None:
        self._clock = clock
        self._arrivals = arrivals or clock
        self._next = first
        self._compute: Callable[[Integers], R] = compute
        self._look_ahead = look_ahead
        self._ready: R = compute(np.empty(0, dtype=np.int64))

    @property
    def next_sample(self) -> int:
        """Number of the next sample, on the queue's own clock."""
        return self._next - len(self._ready)

    def stamp_ns(self, ahead: int) -> int:
        """Time at which the sample behind ``ahead`` others is sent, ns."""
        kept = len(self._ready)
        return int(self._ready.times_ns[ahead]) if ahead < kept else self._arrivals.stamp_ns(self._next + ahead - kept)

    def count_until(self, stamp_ns: int) -> int:
        """Number of samples that were not yet taken and are sent at or before a time, ns."""
        count = int(np.searchsorted(self._ready.times_ns, stamp_ns, side="right"))
        if count < len(self._ready):
            return count
        return count + max(0, self._arrivals.count_until(stamp_ns) - self._next)

    def prepare(self, count: int) -> None:
        """Compute what is missing of the next ``count`` samples, which stay."""
        missing = count - len(self._ready)
        if missing > 0:
            try:
                rows = self._compute(self._clock.stamps_ns(self._next, max(missing, self._look_ahead)))
            except ParameterError:
                # the stamps end before that, though perhaps not before the samples that are wanted
                rows = self._compute(self._clock.stamps_ns(self._next, missing))
            self._ready = self._ready.joined([self._ready, rows]) if len(self._ready) else rows
            self._next += len(rows)

    def take(self, count: int) -> R:
        """The next ``count`` samples."""
        self.prepare(count)
        taken = self._ready[:count]
        self._ready = self._ready[count:]
        return taken


class Measurement:
    """The readings of one sensor in one segment, each of which is computed once, in order.

    Parameters
    ----------
    segment : Segment
    name : str
        The sensor's, in `SENSORS`.
    motion : Motion
        What the sensor feels.

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
        start_ns = segment.start_ns
        self._start_ns = start_ns
        self._motion = motion
        self.model = scenario.sensors.on[name]
        self.clock = SampleClock(scenario.epoch_ns, self.model.rate)
        self.first = self.clock.count_until(start_ns - 1)
        self.arrivals = Arrivals(self.clock, self.first, start_ns, self.model.delivery)
        self._instrument = SENSORS[name].make(self.model, scenario.carrier())
        before_ns = self.clock.stamp_ns(self.first - 1) - start_ns
        self._instrument.begin_after(before_ns, lambda: scenario.exact_motion().at(before_ns))
        self.next = self.first

    def samples(self, measured_ns: Integers) -> SensorSamples:
        """The next readings, which are measured at some times, ns."""
        number = self.next
        times = measured_ns - self._start_ns
        arrived = self.arrivals.of(number, measured_ns)  # first, as it may be refused
        self.next += len(times)
        readings = self._instrument.measure(times, self._motion.at(times), number - self.first)
        return SensorSamples(*arrived, readings)

    def replay(self, count: int) -> tuple[Integers, Booleans, dict[str, Signal]]:
        """When the next readings arrive, ns, which of them are lost, and their signals by array."""
        number = self.next
        measured_ns = self.clock.stamps_ns(self.next, count)
        times = measured_ns - self._start_ns
        self.next += count
        signals = self._instrument.signals(times, self._motion.at(times), number - self.first)
        arrived_ns, _, lost = self.arrivals.of(number, measured_ns)
        return arrived_ns, lost, signals
