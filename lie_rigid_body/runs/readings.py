"""What the sensors of a run read, as arrays: from a simulation, from a bag, and back into samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.sensors import AttitudeSensorModel, ImuReadings
from lie_rigid_body.simulation import SensorSamples
from lie_rigid_body.wording import short_repr

if TYPE_CHECKING:
    from lie_rigid_body.recording.sensor_reader import SensorTrack


class ReadOnly:
    """A dataclass with views of its arrays that cannot be written: an estimate is scored by the stamps it got."""

    def __post_init__(self) -> None:
        for name, array in vars(self).items():
            if isinstance(array, np.ndarray):
                view = array.view()
                view.setflags(write=False)
                object.__setattr__(self, name, view)


@dataclass(frozen=True, eq=False)
class ImuArrays(ReadOnly):
    """What an IMU read, on the sensor's axes. All arrays are read only.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (M,)
        Stamps, ns.
    gyro : ndarray, shape (M, 3)
        Angular velocity, rad/s.
    specific_force : ndarray, shape (M, 3)
        Acceleration less gravitation, m/s².
    gyro_bias : ndarray, shape (M, 3), or None
        The true bias in each angular velocity, rad/s. None if a bag does not tell it.
    accelerometer_bias : ndarray, shape (M, 3), or None
        The true bias in each specific force, m/s². None if a bag does not tell it.
    arrival_ns : ndarray of int64, shape (M,)
        When each reading arrives, ns: by its latency after it is measured. Of a bag by another recorder, whose
        log times are of another clock, when it was measured.
    orientation_xyzw : ndarray, shape (M, 4), or None
        World-from-body, scalar last; None unless the parameter ``imu_orientation`` is true; the identity where
        it is not in the segment of a reading.
    """

    t_ns: Integers
    gyro: Array
    specific_force: Array
    gyro_bias: Array | None
    accelerometer_bias: Array | None
    arrival_ns: Integers
    orientation_xyzw: Array | None = None

    __repr__ = short_repr

    @classmethod
    def of_samples(cls, samples: SensorSamples[ImuReadings]) -> ImuArrays:
        """Those of a simulation."""
        readings = samples.readings
        return cls(
            samples.stamps_ns,
            readings.angular_velocity,
            readings.linear_acceleration,
            readings.gyro_bias,
            readings.accelerometer_bias,
            samples.times_ns,
            readings.orientation_xyzw,
        )

    @classmethod
    def of_tracks(cls, data: SensorTrack, bias: SensorTrack | None, *, oriented: bool) -> ImuArrays:
        """Those of the topics of a bag, which arrived at their log times.

        Whether any tells an orientation the readings say, or, where there are none, ``oriented``.
        """
        if len(data.numbers):
            oriented = bool((data.numbers[:, 4] != -1.0).any())
        return cls(
            data.stamps_ns,
            data.columns(13, 3),
            data.columns(25, 3),
            *_biases(data.stamps_ns, bias),
            data.log_times_ns,
            data.columns(0, 4) if oriented else None,
        )

    def samples(self, inside: Callable[[Integers], Booleans]) -> SensorSamples[ImuReadings]:
        """Those that arrive in a time, with their biases."""
        if self.gyro_bias is None or self.accelerometer_bias is None:
            raise InputError("the run does not tell the biases of its IMU, which a bag holds: record imu/bias as well")
        lost = int(np.isnan(self.gyro_bias + self.accelerometer_bias).any(axis=1).sum())
        if lost:
            raise InputError(
                f"the run does not tell the biases of {lost} of {len(self.t_ns)} readings of its IMU, which a bag "
                "holds: record all of imu/bias"
            )
        readings = ImuReadings(
            self.gyro, self.specific_force, self.gyro_bias, self.accelerometer_bias, self.orientation_xyzw
        )
        return _arriving(self.arrival_ns, self.t_ns, readings, inside)


@dataclass(frozen=True, eq=False)
class MagnetometerArrays(ReadOnly):
    """What a magnetometer read, on the sensor's axes. All arrays are read only.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (L,)
        Stamps, ns.
    field : ndarray, shape (L, 3)
        Magnetic field, T.
    arrival_ns : ndarray of int64, shape (L,)
        As of `ImuArrays`.
    """

    t_ns: Integers
    field: Array
    arrival_ns: Integers

    __repr__ = short_repr

    @classmethod
    def of_samples(cls, samples: SensorSamples[Array]) -> MagnetometerArrays:
        """Those of a simulation."""
        return cls(samples.stamps_ns, samples.readings, samples.times_ns)

    @classmethod
    def of_track(cls, track: SensorTrack) -> MagnetometerArrays:
        """Those of a bag's topic, as `ImuArrays.of_tracks`."""
        return cls(track.stamps_ns, track.columns(0, 3), track.log_times_ns)

    def samples(self, inside: Callable[[Integers], Booleans]) -> SensorSamples[Array]:
        """Those that arrive in a time."""
        return _arriving(self.arrival_ns, self.t_ns, self.field, inside)


@dataclass(frozen=True, eq=False)
class AttitudeSensorArrays(ReadOnly):
    """What an attitude sensor read. All arrays are read only.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (K,)
        Stamps, ns.
    attitude_xyzw : ndarray, shape (K, 4)
        World-from-body, scalar last.
    covariance : ndarray, shape (K, 3, 3)
        Of small rotations about the fixed axes of the world, rad².
    arrival_ns : ndarray of int64, shape (K,)
        As of `ImuArrays`.
    """

    t_ns: Integers
    attitude_xyzw: Array
    covariance: Array
    arrival_ns: Integers

    __repr__ = short_repr

    @classmethod
    def of_samples(cls, samples: SensorSamples[Array], model: AttitudeSensorModel) -> AttitudeSensorArrays:
        """Those of a simulation, with the covariance that the sensor's model tells."""
        return cls(samples.stamps_ns, samples.readings, model.covariance(samples.readings), samples.times_ns)

    @classmethod
    def of_track(cls, track: SensorTrack) -> AttitudeSensorArrays:
        """Those of a bag's topic, as `ImuArrays.of_tracks`."""
        covariance = track.numbers[:, 7:].reshape(-1, 6, 6)[:, 3:, 3:].copy()
        return cls(track.stamps_ns, track.columns(3, 4), covariance, track.log_times_ns)

    def samples(self, inside: Callable[[Integers], Booleans]) -> SensorSamples[Array]:
        """Those that arrive in a time."""
        return _arriving(self.arrival_ns, self.t_ns, self.attitude_xyzw, inside)


@dataclass(frozen=True, eq=False)
class SunSensorArrays(ReadOnly):
    """What a sun sensor read. All arrays are read only.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (J,)
        Stamps, ns.
    direction : ndarray, shape (J, 3)
        Unit vectors to the sun in the body frame.
    arrival_ns : ndarray of int64, shape (J,)
        As of `ImuArrays`.
    """

    t_ns: Integers
    direction: Array
    arrival_ns: Integers

    __repr__ = short_repr

    @classmethod
    def of_samples(cls, samples: SensorSamples[Array]) -> SunSensorArrays:
        """Those of a simulation."""
        return cls(samples.stamps_ns, samples.readings, samples.times_ns)

    @classmethod
    def of_track(cls, track: SensorTrack) -> SunSensorArrays:
        """Those of a bag's topic, as `ImuArrays.of_tracks`."""
        return cls(track.stamps_ns, track.columns(0, 3), track.log_times_ns)

    def samples(self, inside: Callable[[Integers], Booleans]) -> SensorSamples[Array]:
        """Those that arrive in a time."""
        return _arriving(self.arrival_ns, self.t_ns, self.direction, inside)


def _biases(t_ns: Integers, bias: SensorTrack | None) -> tuple[Array | None, Array | None]:
    """Biases of gyro and accelerometer at the stamps of readings."""
    if bias is None:
        return (None, None) if len(t_ns) else (np.empty((0, 3)), np.empty((0, 3)))
    vectors = bias.columns(13, 3), bias.columns(25, 3)
    if np.array_equal(bias.stamps_ns, t_ns):
        return vectors
    order = np.argsort(bias.stamps_ns, kind="stable")
    place = order[np.minimum(np.searchsorted(bias.stamps_ns[order], t_ns), len(order) - 1)]
    told = (bias.stamps_ns[place] == t_ns)[:, np.newaxis]
    gyro, accelerometer = (np.where(told, values[place], np.nan) for values in vectors)
    return gyro, accelerometer


def _arriving(
    arrival_ns: Integers, stamps_ns: Integers, readings: Any, inside: Callable[[Integers], Booleans]
) -> SensorSamples[Any]:
    whole = SensorSamples(arrival_ns, stamps_ns, np.zeros(len(stamps_ns), dtype=np.bool_), readings)
    return whole[inside(arrival_ns)]
