"""Faults on the way of a sensor's readings: they are lost, late, or stamped by a clock that is off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.sensors.fault import Episodes, Fault, Faulty, nanoseconds


@dataclass(frozen=True)
class Delivery(Faulty):
    """Faults on the way of a sensor's readings to whoever listens.

    A reading measured at t arrives at the largest of t + latency + jitter · u so far, with u uniform between 0 and 1:
    none overtakes another. It is stamped t + offset + skew · (t − epoch), what the sensor's clock shows at t.

    Parameters
    ----------
    sensor, seed, window
        See `Faulty`.
    dropout_probability : float
        Probability that a reading is lost, independent of the others.
    outage : Episodes or None
        Episodes in which every reading is lost.
    latency, latency_jitter : float
        Constant and largest random part of the delay, s.
    clock_offset : float
        Lead of the sensor's clock at the epoch, s.
    clock_skew : float
        Rate at which the clock gains, s/s.
    """

    dropout_probability: float
    outage: Episodes | None
    latency: float
    latency_jitter: float
    clock_offset: float
    clock_skew: float

    switches = ("dropout_probability", "outage_interval", "latency", "latency_jitter", "clock_offset", "clock_skew")
    kinds_of_episodes = ("outage",)

    @property
    def latency_ns(self) -> int:
        """Constant part of the delay, ns."""
        return nanoseconds(self.latency)

    @property
    def jitter_ns(self) -> int:
        """Largest random part of the delay, ns."""
        return nanoseconds(self.latency_jitter)

    @property
    def clock_offset_ns(self) -> int:
        """Lead of the sensor's clock at the epoch, ns."""
        return nanoseconds(self.clock_offset)

    @property
    def is_off(self) -> bool:
        """Whether the sensor's clock is wrong."""
        return bool(self.clock_offset_ns or self.clock_skew)

    def lost(self, numbers: Integers, times_ns: Integers) -> Booleans:
        """Tell which of some readings never arrive.

        Parameters
        ----------
        numbers : ndarray of int64, shape (N,)
            Their numbers, counted from 0 in the segment.
        times_ns : ndarray of int64, shape (N,)
            Times of their measurement since the segment's start, ns.
        """
        lost = self._dropped(numbers, times_ns)
        return lost if self.outage is None else lost | (self.outage.at(times_ns) >= 0)

    def _dropped(self, numbers: Integers, times_ns: Integers) -> Booleans:
        if not self.dropout_probability:
            return np.zeros(len(times_ns), dtype=np.bool_)
        drawn = self.draws("dropout").of(numbers)[:, 0]
        return np.asarray((drawn < self.dropout_probability) & self.window.holds(times_ns))

    def delays_ns(self, first: int, count: int) -> Integers:
        """Delays of some readings, ns: latency and jitter, by which alone one could overtake another."""
        drawn = self.draws("latency_jitter").following(first, count)[:, 0]
        return self.latency_ns + (drawn * self.jitter_ns).astype(np.int64)

    def stamps_ns(self, measured_ns: Integers, epoch_ns: int) -> Integers:
        """Stamps that the sensor's clock gives at some times, ns.

        Parameters
        ----------
        measured_ns : ndarray of int64, shape (N,)
        epoch_ns : int
            Time at which the clock is wrong by its offset alone, ns.

        Raises
        ------
        ParameterError
            If a stamp is negative, or beyond the last that ROS can tell.
        """
        stamps = np.asarray(measured_ns + self.error_ns(measured_ns, epoch_ns), dtype=np.int64)
        if len(stamps) and not 0 <= stamps.min() <= stamps.max() <= MAX_EPOCH_NS:
            worst = int(stamps[np.argmax((stamps < 0) | (stamps > MAX_EPOCH_NS))])
            raise ParameterError(
                f"{self.sensor}_clock_offset",
                f"a reading would be stamped {worst} ns, outside [0, {MAX_EPOCH_NS}]: give another epoch_ns",
            )
        return stamps

    def error_ns(self, measured_ns: Integers, epoch_ns: int) -> Integers:
        """Lead of the sensor's clock at some times, ns; see `stamps_ns`."""
        drift = np.rint(self.clock_skew * (measured_ns - epoch_ns)).astype(np.int64)
        return np.asarray(self.clock_offset_ns + drift)

    def measured_ns(self, stamps_ns: Integers, epoch_ns: int) -> Integers:
        """Times at which the sensor's clock shows some stamps, to 8 ns; see `stamps_ns`.

        With a skew of at most 0.01 and times below 2³¹ s, roundings to doubles made 6 ns at most in 600 000 stamps.
        """
        since = stamps_ns - self.clock_offset_ns - epoch_ns
        drift = np.rint(since * (self.clock_skew / (1.0 + self.clock_skew))).astype(np.int64)
        return np.asarray(epoch_ns + since - drift)

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> Iterator[Fault]:
        """Faults of the delivery in a stretch of time; see `Faulty`."""
        lasting = {
            "latency": self.latency_ns / 1e9,
            "latency_jitter": self.jitter_ns / 1e9,
            "clock_offset": self.clock_offset_ns / 1e9,
            "clock_skew": self.clock_skew,
        }
        for kind, size in lasting.items() if begin_ns <= 0 < end_ns else ():
            if size:
                yield Fault(kind, self.sensor, "", 0, None, size)
        for time in times_ns[self._dropped(first + np.arange(len(times_ns)), times_ns)].tolist():
            yield Fault("dropout", self.sensor, "", time, time)
        for _, begin, end in self.outage.between(begin_ns, end_ns) if self.outage else ():
            yield Fault("outage", self.sensor, "", begin, end)
