"""Samples: states, or readings of sensors, and their stamps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.mechanics import State
from lie_rigid_body.sensors import ImuReadings
from lie_rigid_body.wording import short_repr


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
class ImuSamples:
    """Readings of an IMU, and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    readings : ImuReadings, N of them
    """

    stamps_ns: Integers
    readings: ImuReadings

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, index: slice) -> ImuSamples:
        return ImuSamples(self.stamps_ns[index], ImuReadings(*(column[index] for column in _columns(self.readings))))

    def joined(self, later: ImuSamples) -> ImuSamples:
        """These samples followed by later ones."""
        pairs = zip(_columns(self.readings), _columns(later.readings), strict=True)
        readings = ImuReadings(*(np.concatenate(pair) for pair in pairs))
        return ImuSamples(np.concatenate([self.stamps_ns, later.stamps_ns]), readings)


def _columns(readings: ImuReadings) -> tuple[Array, Array, Array, Array]:
    return (
        readings.angular_velocity,
        readings.linear_acceleration,
        readings.gyro_bias,
        readings.accelerometer_bias,
    )


@dataclass(frozen=True)
class MagnetometerSamples:
    """Readings of a magnetometer, and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    magnetic_field : ndarray, shape (N, 3)
        On the sensor's axes, T.
    """

    stamps_ns: Integers
    magnetic_field: Array

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, index: slice) -> MagnetometerSamples:
        return MagnetometerSamples(self.stamps_ns[index], self.magnetic_field[index])

    def joined(self, later: MagnetometerSamples) -> MagnetometerSamples:
        """These samples followed by later ones."""
        field = np.concatenate([self.magnetic_field, later.magnetic_field])
        return MagnetometerSamples(np.concatenate([self.stamps_ns, later.stamps_ns]), field)
