"""Samples: states, or readings of sensors, and their stamps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.mechanics import State
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
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

    __repr__ = short_repr

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


@dataclass(frozen=True)
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

    __repr__ = short_repr

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
