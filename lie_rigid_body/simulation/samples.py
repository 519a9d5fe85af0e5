"""Samples: states, or readings of sensors, and their stamps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.mechanics import State
from lie_rigid_body.sensors import ImuReadings
from lie_rigid_body.wording import short_repr

Q = TypeVar("Q")
"""Readings: an array of rows, or `ImuReadings`."""


@dataclass(frozen=True)
class Samples:
    """States and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        Of shapes (N, 4) and (N, 3).
    """

    stamps_ns: Integers
    states: State

    __repr__ = short_repr

    @property
    def times_ns(self) -> Integers:
        """When they are sent and logged, ns: at their stamps."""
        return self.stamps_ns

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, index: slice) -> Samples:
        return Samples(self.stamps_ns[index], self.states[index])

    def joined(self, later: Samples) -> Samples:
        """These samples followed by later ones."""
        attitude = np.concatenate([self.states.attitude_xyzw, later.states.attitude_xyzw])
        body_rate = np.concatenate([self.states.body_rate, later.states.body_rate])
        return Samples(np.concatenate([self.stamps_ns, later.stamps_ns]), State.trusted(attitude, body_rate))


@dataclass(frozen=True)
class SensorSamples(Generic[Q]):
    """Readings of a sensor.

    Parameters
    ----------
    times_ns : ndarray of int64, shape (N,)
        When they arrive, are sent and logged, ns.
    stamps_ns : ndarray of int64, shape (N,)
        What their headers say, ns: the sensor's own clock at the time of measurement.
    lost : ndarray of bool, shape (N,)
        Which of them never arrive.
    readings : Q
        Of the IMU `ImuReadings`; of the magnetometer the field on its axes, T, shape (N, 3); of the attitude sensor
        attitudes, scalar last, shape (N, 4); of the sun sensor directions in the body frame, shape (N, 3).
    """

    times_ns: Integers
    stamps_ns: Integers
    lost: Booleans
    readings: Q

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.times_ns)

    def __getitem__(self, index: slice | Booleans) -> SensorSamples[Q]:
        return SensorSamples(self.times_ns[index], self.stamps_ns[index], self.lost[index], _rows(self.readings, index))

    def joined(self, later: SensorSamples[Q]) -> SensorSamples[Q]:
        """These samples followed by later ones."""
        return SensorSamples(
            np.concatenate([self.times_ns, later.times_ns]),
            np.concatenate([self.stamps_ns, later.stamps_ns]),
            np.concatenate([self.lost, later.lost]),
            _concatenated(self.readings, later.readings),
        )

    def received(self) -> SensorSamples[Q]:
        """Those that arrive."""
        return self[~self.lost] if self.lost.any() else self


def _rows(readings: Any, index: slice | Booleans) -> Any:
    if isinstance(readings, np.ndarray):
        return readings[index]
    columns = vars(readings).items()
    some: dict[str, Any] = {name: None if column is None else column[index] for name, column in columns}
    return ImuReadings(**some)


def _concatenated(one: Any, other: Any) -> Any:
    if isinstance(one, np.ndarray):
        return np.concatenate([one, other])
    pairs = zip(vars(one).items(), vars(other).values(), strict=True)
    joined: dict[str, Any] = {n: None if a is None or b is None else np.concatenate([a, b]) for (n, a), b in pairs}
    return ImuReadings(**joined)
