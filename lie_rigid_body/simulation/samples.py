"""Samples, states or readings of sensors with their stamps, and queues of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.mechanics import State
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.simulation.segment import Arrivals, SampleClock


@short_dataclass(frozen=True)
class Samples:
    """States and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        States of N instants.
    """

    stamps_ns: Integers
    states: State

    @property
    def times_ns(self) -> Integers:
        """Times at which the samples are sent and logged, ns: their stamps."""
        return self.stamps_ns

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, index: slice) -> Samples:
        return Samples(self.stamps_ns[index], self.states[index])

    def joined(self, later: Samples) -> Samples:
        """Join these samples and later ones."""
        attitude = np.concatenate([self.states.attitude_xyzw, later.states.attitude_xyzw])
        body_rate = np.concatenate([self.states.body_rate, later.states.body_rate])
        return Samples(np.concatenate([self.stamps_ns, later.stamps_ns]), State.trusted(attitude, body_rate))


@short_dataclass(frozen=True)
class SensorSamples:
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

    def __len__(self) -> int:
        return len(self.times_ns)

    def __getitem__(self, rows: slice | Booleans) -> SensorSamples:
        arrays = {name: array[rows] for name, array in self.arrays.items()}
        return SensorSamples(self.times_ns[rows], self.stamps_ns[rows], self.lost[rows], arrays)

    def joined(self, later: SensorSamples) -> SensorSamples:
        """Join these samples and later ones."""
        return SensorSamples(
            np.concatenate([self.times_ns, later.times_ns]),
            np.concatenate([self.stamps_ns, later.stamps_ns]),
            np.concatenate([self.lost, later.lost]),
            {name: np.concatenate([array, later.arrays[name]]) for name, array in self.arrays.items()},
        )

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
