"""Clocks of samples: exact conversion between numbers and stamps, integer ns, and when readings arrive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.sensors import Delivery
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class SampleClock:
    """Stamps by sample number: ``epoch_ns + round(k · 1e9 / rate)``, in exact arithmetic.

    Parameters
    ----------
    epoch_ns : int
        Stamp of sample 0, ns.
    rate : float
        Samples per second, taken as its shortest decimal.
    """

    epoch_ns: int
    rate: float

    __repr__ = short_repr

    @cached_property
    def period_ns(self) -> Fraction:
        """Time between samples, ns, exact. It is kept, as reading the decimals of the rate costs more than a stamp."""
        return NS / Fraction(repr(self.rate))

    def stamp_ns(self, number: int) -> int:
        """The stamp of one sample, ns; extrapolated for negative numbers."""
        n, d = self.period_ns.numerator, self.period_ns.denominator
        quotient, remainder = divmod(2 * number * n + d, 2 * d)
        return self.epoch_ns + quotient - (remainder == 0 and quotient % 2 == 1)  # ties to even

    def count_until(self, stamp_ns: int) -> int:
        """Number of samples from number 0 on whose stamps are at or before a time, ns; 0 or more."""
        period = self.period_ns
        # the last k with k n/d < elapsed + 1/2, or equal to it, which rounds to even
        last = (2 * (stamp_ns - self.epoch_ns) + 1) * period.denominator // (2 * period.numerator)
        return max(0, last if self.stamp_ns(last) > stamp_ns else last + 1)

    def stamps_ns(self, first: int, count: int) -> Integers:
        """The stamps of ``count`` samples from number ``first``.

        Returns
        -------
        ndarray of int64, shape (count,)
        """
        n, d, last = self.period_ns.numerator, self.period_ns.denominator, self.stamp_ns(first + count - 1)
        if count and last > MAX_EPOCH_NS:
            raise ParameterError(
                "epoch_ns",
                f"sample {first + count - 1} would be stamped {last} ns, beyond the last of ROS, {MAX_EPOCH_NS} "
                "ns: start earlier, or sample for a shorter time",
            )
        if not count or 2 * (d + count * n) > MAX_EPOCH_NS or self.stamp_ns(first) < 0:
            return np.array([self.stamp_ns(k) for k in range(first, first + count)], dtype=np.int64)
        # as `stamp_ns`, but for what comes before the first, which may be beyond int64
        before, rest = divmod(2 * first * n + d, 2 * d)
        halves = rest + 2 * n * np.arange(count, dtype=np.int64)
        quotients = halves // (2 * d)
        ties = halves == quotients * (2 * d)
        quotients += self.epoch_ns + before
        quotients -= ties & (quotients - self.epoch_ns & 1 == 1)
        return quotients

    def count_before(self, duration: Fraction) -> int:
        """Number of samples before a time after the epoch, s: of every k with k / rate < duration."""
        return -int(-(duration * Fraction(repr(self.rate))) // 1)

    def last_ns_before(self, duration: Fraction) -> int:
        """Last stamp, ns, that lies before a time after the epoch, s, which is rounded as stamps are."""
        count = self.count_before(duration)
        end = self.epoch_ns + math.ceil(duration * NS) - 1
        return min(max(end, self.stamp_ns(count - 1)), self.stamp_ns(count) - 1)


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
    delivery : Delivery
        Faults on the way.
    """

    def __init__(self, clock: SampleClock, first: int, start_ns: int, delivery: Delivery) -> None:
        self._clock, self._first = clock, first
        self._start_ns, self._delivery = start_ns, delivery

    def stamp_ns(self, number: int) -> int:
        """Time at which one reading arrives, ns."""
        return int(self._latest(number, np.array([self._clock.stamp_ns(number)]))[0])

    def count_until(self, stamp_ns: int) -> int:
        """Number of readings of the clock, from number 0 on, that arrive at or before a time, ns."""
        at_most = self._clock.count_until(stamp_ns - self._delivery.latency_ns)
        at_least = self._clock.count_until(stamp_ns - self._delivery.latency_ns - self._delivery.jitter_ns)
        at_least = max(at_least, min(self._first, at_most))
        if at_least == at_most or stamp_ns > MAX_EPOCH_NS:
            return at_most
        between = self._latest(at_least, self._clock.stamps_ns(at_least, at_most - at_least))
        return at_least + int(np.searchsorted(between, stamp_ns, side="right"))

    def of(self, number: int, measured_ns: Integers) -> tuple[Integers, Integers, Booleans]:
        """Arrival times and stamps, ns, of the readings from one number on, and which of them are lost."""
        stamps = self._delivery.stamps_ns(measured_ns, self._clock.epoch_ns)
        lost = self._delivery.lost(number - self._first, measured_ns - self._start_ns)
        return self._latest(number, measured_ns), stamps, lost

    def _latest(self, number: int, measured_ns: Integers) -> Integers:
        """Arrival times of the readings from one number on, ns: no reading overtakes an earlier one."""
        before = number
        if self._delivery.jitter_ns and len(measured_ns):
            # of those measured more than the jitter ago none can be late enough to hold up another
            since = self._clock.count_until(int(measured_ns[0]) - self._delivery.jitter_ns - 1)
            before = min(max(self._first, since), number)
        times = np.concatenate([self._clock.stamps_ns(before, number - before), measured_ns])
        delays = self._delivery.delays_ns(before - self._first, len(times))
        return np.maximum.accumulate(times + delays)[number - before :]
