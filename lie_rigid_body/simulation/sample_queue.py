"""Queues of samples: of one clock in one segment, and of a sensor across segments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.simulation.arrivals import Arrivals
from lie_rigid_body.simulation.sample_clock import SampleClock


class Rows(Protocol):
    """A batch of samples that can be sliced and concatenated."""

    @property
    def times_ns(self) -> Integers:
        """Times at which the samples are sent, ns, shape (N,)."""
        ...

    def __len__(self) -> int: ...

    def __getitem__(self: R, index: slice) -> R: ...

    def joined(self: R, later: R) -> R:
        """Join these samples and later ones."""
        ...


R = TypeVar("R", bound=Rows)


class SampleQueue(Generic[R]):
    """The samples of one clock from a segment's start on, computed ahead and taken in order.

    Parameters
    ----------
    clock : SampleClock
    first : int
        Number of the first sample to compute.
    compute : callable
        ``compute(stamps_ns)`` makes samples. Each stamp is asked for once, in rising order.
    look_ahead : int, optional
        Samples to compute at once when fewer are wanted.
    arrivals : Arrivals, optional
        When the samples are sent; by default at their stamps.
    """

    def __init__(
        self,
        clock: SampleClock,
        first: int,
        compute: Callable[[Integers], R],
        look_ahead: int = 0,
        arrivals: Arrivals | None = None,
    ) -> None:
        self._clock = clock
        self._arrivals = arrivals or clock
        self._next = first
        self._compute = compute
        self._look_ahead = look_ahead
        self._ready = compute(np.empty(0, dtype=np.int64))

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
        count = int(np.searchsorted(self._ready.times_ns, stamp_ns, side="right")) if len(self._ready) else 0
        if count < len(self._ready):
            return count
        return count + max(0, self._arrivals.count_until(stamp_ns) - self._next)

    def take(self, count: int) -> R:
        """The next ``count`` samples."""
        missing = count - len(self._ready)
        if missing > 0:
            self._fill(missing)
        taken, self._ready = self._ready[:count], self._ready[count:]
        return taken

    def _fill(self, missing: int) -> None:
        try:
            stamps = self._clock.stamps_ns(self._next, max(missing, self._look_ahead))
        except ParameterError:
            # the stamps end before that, though perhaps not before the samples that are wanted
            stamps = self._clock.stamps_ns(self._next, missing)
        rows = self._compute(stamps)
        self._ready = self._ready.joined(rows) if len(self._ready) else rows
        self._next += len(stamps)


class SensorQueue(Generic[R]):
    """Readings of a sensor across resets: one queue per segment.

    Readings left over when a segment ends come before the readings of the next one, and are computed only when taken.
    Readings that were to arrive after the end are lost.

    Parameters
    ----------
    queue : SampleQueue
        Queue of the first segment.
    """

    def __init__(self, queue: SampleQueue[R]) -> None:
        self._ending: list[tuple[SampleQueue[R], int]] = []
        self._last = queue

    def follow(self, queue: SampleQueue[R], start_ns: int) -> None:
        """Continue with the queue of a new segment at ``start_ns``, which lies after all readings taken."""
        ending = [*self._ending, (self._last, start_ns - 1)]
        self._ending = [(old, end_ns) for old, end_ns in ending if old.count_until(end_ns)]
        self._last = queue

    def stamp_ns(self, ahead: int) -> int:
        """Time at which the sample behind ``ahead`` others is sent, ns."""
        for queue, end_ns in self._ending:
            left = queue.count_until(end_ns)
            if ahead < left:
                return queue.stamp_ns(ahead)
            ahead -= left
        return self._last.stamp_ns(ahead)

    def count_until(self, stamp_ns: int) -> int:
        """Number of samples that were not yet taken and are sent at or before a time, ns."""
        ending = sum(queue.count_until(min(stamp_ns, end_ns)) for queue, end_ns in self._ending)
        return ending + self._last.count_until(stamp_ns)

    def take(self, count: int) -> R:
        """The next ``count`` samples, all of one segment."""
        if not self._ending:
            return self._last.take(count)
        queue, end_ns = self._ending[0]
        taken = queue.take(count)
        if not queue.count_until(end_ns):
            self._ending.pop(0)
        return taken
