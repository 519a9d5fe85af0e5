"""A segment, the torque-free motion between two resets, and the clocks of its samples and readings."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Booleans, Integers
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors.fault import TransportFaults, nanoseconds

SOFTWARE: Final = "lie_rigid_body"
"""Name of this software in the scenario message."""


@short_dataclass
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

    @cached_property
    def period_ns(self) -> Fraction:
        """Time between samples, ns, exact. It is kept, as reading the decimals of the rate costs more than a stamp."""
        return NS / Fraction(repr(self.rate))

    def stamp_ns(self, number: int) -> int:
        """The stamp of one sample, ns; extrapolated for negative numbers."""
        n = self.period_ns.numerator
        d = self.period_ns.denominator
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
        n = self.period_ns.numerator
        d = self.period_ns.denominator
        last = self.stamp_ns(first + count - 1)
        if count and last > MAX_EPOCH_NS:
            raise ParameterError(
                "epoch_ns",
                f"sample {first + count - 1} would be stamped {last} ns, beyond the last of ROS, {MAX_EPOCH_NS} "
                "ns: start earlier, or sample for a shorter time",
            )
        if not count:
            return np.empty(0, dtype=np.int64)
        # stamp k is the whole part of (rest + 2nk)/2d, and 2n = whole · 2d + step with step < 2d < 2⁶²
        before, rest = divmod(2 * first * n + d, 2 * d)
        whole, step = divmod(2 * n, 2 * d)
        k = np.arange(count, dtype=np.int64)
        quotients = ((float(step) * k + rest) / (2 * d)).astype(np.int64)  # by rounding one more or less, at times
        remainders = rest + step * k - 2 * d * quotients  # exact, as it is small: what overflows cancels
        wrong = (remainders >= 2 * d).astype(np.int64) - (remainders < 0)
        ties = remainders == 2 * d * wrong
        quotients += wrong + whole * k + before
        return np.asarray(quotients + self.epoch_ns - (ties & (quotients & 1 == 1)))

    def count_before(self, duration: Fraction) -> int:
        """Number of samples before a time after the epoch, s: of every k with k / rate < duration."""
        return -int(-(duration * Fraction(repr(self.rate))) // 1)

    def last_ns_before(self, duration: Fraction) -> int:
        """Last stamp, ns, that lies before a time after the epoch, s, which is rounded as stamps are."""
        count = self.count_before(duration)
        end = self.epoch_ns + math.ceil(duration * NS) - 1
        return min(max(end, self.stamp_ns(count - 1)), self.stamp_ns(count) - 1)


@short_dataclass
class Segment:
    """The torque-free motion between two resets, as a bag declares it.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with the epoch in force.
    first_sample : int
        Number of the sample that carries the initial state.
    start_ns : int
        Stamp of that sample, ns.
    """

    scenario: Scenario
    first_sample: int
    start_ns: int

    def to_json(self, topics: Mapping[str, str] | None = None) -> str:
        """The text of the latched scenario message: all parameters, ``first_sample`` and ``start_ns``.

        Parameters
        ----------
        topics : mapping of str to str, optional
            Full names of the topics of the body and of its sensors, by their relative names, as readers find them.
        """
        from lie_rigid_body import __version__

        return json.dumps(
            {
                "software": f"{SOFTWARE} {__version__}",
                **self.scenario.parameters(),
                "first_sample": self.first_sample,
                "start_ns": self.start_ns,
                **({"topics": dict(topics)} if topics else {}),
            }
        )

    @classmethod
    def from_json(cls, text: str) -> Segment:
        """The segment that a scenario message declares.

        Raises
        ------
        InputError
            If the text is not such a message, or its ``start_ns`` is not the stamp of its ``first_sample``.
        """
        try:
            content = json.loads(text, object_pairs_hook=_without_repeats)
            first = content.pop("first_sample")
            start = content.pop("start_ns")
        except (AttributeError, LookupError, RecursionError, TypeError, ValueError):
            raise InputError("the scenario message is not the JSON that lie_rigid_body writes") from None
        content.pop("software", None)
        content.pop("topics", None)
        for name, value in (("first_sample", first), ("start_ns", start)):
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_EPOCH_NS:
                raise InputError(
                    f"the scenario message gives {name} {value!r:.40}: it must be an integer from 0 to {MAX_EPOCH_NS}"
                )
        segment = cls(_scenario(json.dumps(content)), first, start)
        if segment.clock().stamp_ns(first) != start:
            raise InputError(
                f"the scenario message starts at {start} ns with sample {first}, which its epoch_ns and rate stamp "
                f"{segment.clock().stamp_ns(first)} ns: restore the bag"
            )
        return segment

    def clock(self) -> SampleClock:
        """The clock of the segment's stamps."""
        return SampleClock(self.scenario.epoch_ns, self.scenario.rate)


@lru_cache(maxsize=1)
def _scenario(parameters: str) -> Scenario:
    """Read a scenario from a JSON object. The last one is kept: most resets repeat it, and to read it takes long."""
    return Scenario.from_parameters(json.loads(parameters))


def _without_repeats(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Make an object of names and values, and refuse a name given twice: some readers would take its first value."""
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError("a name is given twice")
    return content


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
    delivery : TransportFaults or None
        Faults on the way; without any a reading arrives when it is measured.
    """

    def __init__(self, clock: SampleClock, first: int, start_ns: int, delivery: TransportFaults | None) -> None:
        self._clock = clock
        self._first = first
        self._start_ns = start_ns
        self._delivery = delivery
        self._latency_ns = nanoseconds(delivery.latency) if delivery else 0
        self._jitter_ns = nanoseconds(delivery.latency_jitter) if delivery else 0

    def stamp_ns(self, number: int) -> int:
        """Time at which one reading arrives, ns."""
        return int(self._latest(number, np.array([self._clock.stamp_ns(number)]))[0])

    def count_until(self, stamp_ns: int) -> int:
        """Number of readings of the clock, from number 0 on, that arrive at or before a time, ns."""
        at_most = self._clock.count_until(stamp_ns - self._latency_ns)
        at_least = self._clock.count_until(stamp_ns - self._latency_ns - self._jitter_ns)
        at_least = max(at_least, min(self._first, at_most))
        if at_least == at_most or stamp_ns > MAX_EPOCH_NS:
            return at_most
        between = self._latest(at_least, self._clock.stamps_ns(at_least, at_most - at_least))
        return at_least + int(np.searchsorted(between, stamp_ns, side="right"))

    def of(self, number: int, measured_ns: Integers) -> tuple[Integers, Integers, Booleans]:
        """Arrival times and stamps, ns, of the readings from one number on, and which of them are lost."""
        if self._delivery is None:
            return measured_ns, measured_ns, np.zeros(len(measured_ns), dtype=np.bool_)
        stamps = self._delivery.stamps_ns(measured_ns, self._clock.epoch_ns)
        numbers = number - self._first + np.arange(len(measured_ns))
        lost = self._delivery.lost(numbers, measured_ns - self._start_ns)
        return self._latest(number, measured_ns), stamps, lost

    def _latest(self, number: int, measured_ns: Integers) -> Integers:
        """Arrival times of the readings from one number on, ns: no reading overtakes an earlier one."""
        if self._delivery is None:
            return measured_ns
        before = number
        if self._jitter_ns and len(measured_ns):
            # of those measured more than the jitter ago none can be late enough to hold up another
            since = self._clock.count_until(int(measured_ns[0]) - self._jitter_ns - 1)
            before = min(max(self._first, since), number)
        times = np.concatenate([self._clock.stamps_ns(before, number - before), measured_ns])
        delays = self._delivery.delays_ns(before - self._first, len(times))
        return np.maximum.accumulate(times + delays)[number - before :]
