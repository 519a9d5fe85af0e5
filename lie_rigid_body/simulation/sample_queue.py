"""A queue of samples: those of one clock in one segment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.simulation.measurement import Arrivals
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import Samples, SensorSamples

R = TypeVar("R", Samples, SensorSamples)


class SampleQueue(Generic[R]):
    """The samples of one clock from a segment's start on, computed ahead and taken in order.

    Parameters
    ----------
    clock : SampleClock
    first : int
        Number of the first sample to compute.
    compute : callable
        ``compute(stamps_ns)`` makes samples. Each stamp is asked for once, in rising order.
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
        self._clock, self._arrivals, self._next = clock, arrivals or clock, first
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

    def take(self, count: int) -> R:
        """The next ``count`` samples."""
        missing = count - len(self._ready)
        if missing > 0:
            try:
                stamps = self._clock.stamps_ns(self._next, max(missing, self._look_ahead))
            except ParameterError:
                # the stamps end before that, though perhaps not before the samples that are wanted
                stamps = self._clock.stamps_ns(self._next, missing)
            rows = self._compute(stamps)
            self._ready = self._ready.joined(rows) if len(self._ready) else rows
            self._next += len(stamps)
        taken, self._ready = self._ready[:count], self._ready[count:]
        return taken
