"""Exact conversion between sample numbers and stamps, integer ns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
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
