"""Sensors that point: orientations, as of an AHRS or a star tracker, and a sun sensor, which reads a direction."""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.mechanics import State
from lie_rigid_body.sensors.noise import NoiseSource, WhiteNoise
from lie_rigid_body.sensors.parameters import Fields, Values, angle, not_negative, numbers
from lie_rigid_body.sensors.sensor import (
    AttitudeMeasurement,
    Field,
    Instrument,
    Sensor,
    SensorModel,
    Topic,
    VectorMeasurement,
)
from lie_rigid_body.sensors.signal import Signal, Signals


@short_dataclass
class OrientationModel:
    """The model of an orientation: exp(n_k) ⊗ A, with A the attitude and n_k a small rotation in the world frame.

    Parameters
    ----------
    inclination_noise : float
        Standard deviation of n about each horizontal axis of the world, rad.
    heading_noise : float
        Standard deviation of n about the vertical, z of the world, rad.
    """

    inclination_noise: float
    heading_noise: float

    @property
    def covariance(self) -> Vector:
        """Covariance of n, of small rotations about the fixed axes of the world, rad², row by row."""
        inclination = self.inclination_noise**2
        heading = self.heading_noise**2
        return (inclination, 0.0, 0.0, 0.0, inclination, 0.0, 0.0, 0.0, heading)

    def signal(self, states: State, noise: WhiteNoise, first: int) -> Signal:
        """The orientations that it tells, world-from-body, scalar last, shape (N, 4), from unit noise."""
        attitude = states.attitude_xyzw
        sigma = np.array([self.inclination_noise, self.inclination_noise, self.heading_noise])
        if sigma.any():
            error = sigma * noise.draw(first, len(attitude))
            attitude = quaternion.multiply(quaternion.exp(error), attitude)
        return Signal(attitude)


@short_dataclass
class AttitudeSensorModel(SensorModel):
    """The model of an attitude sensor, such as a star tracker: the whole attitude, worst about its boresight.

    ::

        q_k = A ⊗ exp(n_k),   n_k = σ_c ν_k + (σ_r − σ_c) b (b · ν_k)

    with A the attitude, b the boresight and ν standard normal. The error is a small rotation by n in the body frame, of
    σ_r about the boresight and σ_c about each axis across it.

    Parameters
    ----------
    rate, seed, delivery
        As of `SensorModel`.
    boresight : tuple of float, length 3
        b, a unit vector in the body frame.
    cross_boresight_noise, roll_noise : float
        σ_c and σ_r, standard deviations, rad.
    """

    boresight: Vector
    cross_boresight_noise: float
    roll_noise: float

    @classmethod
    def parts(cls, sensor: str, values: Values) -> Fields:
        """Fields that have no parameter of their name; see `SensorModel.from_values`."""
        return {"boresight": direction(values, "attitude_sensor_boresight")}

    @property
    def measurement_models(self) -> tuple[AttitudeMeasurement, ...]:
        """The attitude, worst about the boresight."""
        return (AttitudeMeasurement(self.boresight, self.roll_noise, self.cross_boresight_noise),)

    def covariance(self, attitude_xyzw: Array) -> Array:
        """Covariance of small rotations about the fixed axes of the world, rad², shape (N, 3, 3).

        It is that of A ⊗ exp(n) = exp(A n) ⊗ A. As a rotation leaves its own axis alone, A n is the same with the
        reading in place of A.

        Parameters
        ----------
        attitude_xyzw : ndarray, shape (N, 4)
            Readings.
        """
        across = self.cross_boresight_noise**2
        along = self.roll_noise**2
        sight = quaternion.rotate(attitude_xyzw, np.array(self.boresight))
        return across * np.eye(3) + (along - across) * (sight[:, :, np.newaxis] * sight[:, np.newaxis])


def direction(values: Values, name: str) -> Vector:
    """Make a unit vector of the numbers of a parameter.

    Raises
    ------
    ParameterError
        If the numbers are 0, or so large or small that they tell no direction.
    """
    components = values[name]
    size = float(vectors.norm(components))
    if not 1e-100 < size < 1e100:
        raise ParameterError(name, f"{list(components)} tells no direction: give for example [0.0, 0.0, 1.0]")
    return tuple(component / size for component in components)


class AttitudeSensor(Instrument):
    """An attitude sensor at work: attitudes, scalar last, and their covariances, rad².

    Parameters
    ----------
    model : AttitudeSensorModel
    carrier : Carrier, optional
        What it is fixed to, at which it does not look.
    """

    def __init__(self, model: AttitudeSensorModel, carrier: object = None) -> None:
        self._model = model
        self._boresight = np.array(model.boresight)
        self._noise = WhiteNoise(model.seed, NoiseSource.ATTITUDE_SENSOR_WHITE, 1.0)

    def signals(self, times_ns: Integers, states: State, first: int) -> Signals:
        """Readings; see `Instrument.measure`."""
        attitude = states.attitude_xyzw
        across = self._model.cross_boresight_noise
        about = self._model.roll_noise
        if across or about:
            drawn = self._noise.draw(first, len(times_ns))
            b = self._boresight
            roll = drawn[:, 0] * b[0] + drawn[:, 1] * b[1] + drawn[:, 2] * b[2]
            error = across * drawn + (about - across) * roll[:, np.newaxis] * b
            attitude = quaternion.multiply(attitude, quaternion.exp(error))

        return {"attitude_xyzw": Signal(attitude), "covariance": Signal(self._model.covariance(attitude))}


@short_dataclass
class SunSensorModel(SensorModel):
    """The model of a sun sensor: exp(n_k) Aᵀ s, with A the attitude, s the sun's direction and n_k = σ ν_k.

    Nothing eclipses the sun, and the sensor sees all around.

    Parameters
    ----------
    rate, seed, delivery
        As of `SensorModel`.
    sun : tuple of float, length 3
        s, a unit vector in the world frame.
    noise : float
        σ, standard deviation of the small rotation about each axis, rad; a rotation about the sun does not show.
    """

    sun: Vector
    noise: float

    @classmethod
    def parts(cls, sensor: str, values: Values) -> Fields:
        """Fields that have no parameter of their name; see `SensorModel.from_values`."""
        return {"sun": direction(values, "sun_direction")}

    @property
    def measurement_models(self) -> tuple[VectorMeasurement, ...]:
        """The direction of the sun."""
        return (VectorMeasurement(self.sun, self.noise),)


class SunSensor(Instrument):
    """A sun sensor at work: unit vectors to the sun in the body frame.

    Parameters
    ----------
    model : SunSensorModel
    carrier : Carrier, optional
        What it is fixed to, at which it does not look.
    """

    def __init__(self, model: SunSensorModel, carrier: object = None) -> None:
        self._sun = np.array(model.sun)
        self._noise = WhiteNoise(model.seed, NoiseSource.SUN_SENSOR_WHITE, model.noise)

    def signals(self, times_ns: Integers, states: State, first: int) -> Signals:
        """Readings; see `Instrument.measure`."""
        sun = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self._sun)
        if not self._noise.sigma:
            return {"direction": Signal(sun)}
        error = self._noise.draw(first, len(sun))
        return {"direction": Signal(quaternion.rotate(quaternion.exp(error), sun))}


_ROTATION: Final = tuple(6 * row + column for row in (3, 4, 5) for column in (3, 4, 5))
"""Numbers of a pose's covariance that belong to the rotation; the position is known exactly."""
ATTITUDE_SENSOR: Final = Sensor(
    "attitude_sensor",
    "attitude sensor",
    AttitudeSensorModel,
    AttitudeSensor,
    (
        Topic(
            "attitude/pose",
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            "attitude sensor frame and position",
            (
                Field("attitude_xyzw", "pose.pose.orientation", "", "attitude sensor"),
                Field(
                    "covariance",
                    "pose.covariance",
                    "rad²",
                    "attitude sensor covariance",
                    numbers=_ROTATION,
                    shape=(3, 3),
                ),
            ),
            "world_frame",
        ),
    ),
    parameters=(
        not_negative(
            "attitude_sensor_rate", "Readings of the attitude sensor per second, from 1e-6; 0: no such sensor."
        ),
        numbers(
            "attitude_sensor_boresight",
            (0.0, 0.0, 1.0),
            "Attitude sensor: its boresight in the body frame, of any length.",
        ),
        angle(
            "attitude_sensor_cross_boresight_noise",
            "Attitude sensor: standard deviation of a reading about each axis across the boresight, rad.",
        ),
        angle(
            "attitude_sensor_roll_noise",
            "Attitude sensor: standard deviation of a reading about the boresight, rad.",
        ),
    ),
    streams={"attitude_sensor": 5},
)
"""The attitude sensor in the table of sensors."""
SUN_SENSOR: Final = Sensor(
    "sun_sensor",
    "sun sensor",
    SunSensorModel,
    SunSensor,
    (
        Topic(
            "sun/direction",
            "geometry_msgs/msg/Vector3Stamped",
            "sun sensor frame",
            (Field("direction", "vector", "", "sun sensor"),),
        ),
    ),
    parameters=(
        not_negative("sun_sensor_rate", "Readings of the sun sensor per second, from 1e-6; 0: no such sensor."),
        numbers("sun_direction", (1.0, 0.0, 0.0), "Direction of the sun in the world frame, of any length."),
        angle("sun_sensor_noise", "Sun sensor: standard deviation about each axis, rad."),
    ),
    streams={"sun_sensor": 6},
    attribute="sun",
)
"""The sun sensor in the table of sensors."""
