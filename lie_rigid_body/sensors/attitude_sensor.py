"""Model of an attitude sensor, such as a star tracker: the whole attitude, worst about its boresight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value, Vector, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.sensors.parameters import angle, not_negative, numbers
from lie_rigid_body.sensors.sensor import AttitudeAid, Carrier, Field, Instrument, Sensor, SensorModel, Topic
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class AttitudeSensorModel(SensorModel):
    """The model of an attitude sensor.

    ::

        q_k = A ⊗ exp(n_k),   n_k = σ_c ν_k + (σ_r − σ_c) b (b · ν_k)

    with A the attitude, b the boresight and ν standard normal: the error is a small rotation by n in the body frame, of
    σ_r about the boresight and σ_c about each axis across it.

    Parameters
    ----------
    rate, seed, delivery
        As of `SensorModel`.
    boresight : tuple of float, length 3
        b, a unit vector in the body frame.
    cross_noise, roll_noise : float
        σ_c and σ_r, standard deviations, rad.
    """

    boresight: Vector
    cross_noise: float
    roll_noise: float

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> AttitudeSensorModel:
        """Make the model of the parameters' values, and validate it.

        Raises
        ------
        ParameterError
        """
        return cls(
            cast(float, values["attitude_sensor_rate"]),
            cast(int, values["sensor_seed"]),
            direction(values, "attitude_sensor_boresight"),
            cast(float, values["attitude_sensor_cross_boresight_noise"]),
            cast(float, values["attitude_sensor_roll_noise"]),
            delivery=Delivery.from_values("attitude_sensor", values),
        )

    @property
    def aids(self) -> tuple[AttitudeAid, ...]:
        """The attitude, worst about the boresight."""
        return (AttitudeAid(self.boresight, self.roll_noise, self.cross_noise),)

    def covariance(self, attitude_xyzw: Array) -> Array:
        """Covariance of small rotations about the fixed axes of the world, rad², shape (N, 3, 3).

        It is that of A ⊗ exp(n) = exp(A n) ⊗ A. As a rotation leaves its own axis alone, A n is the same with the
        reading in place of A.

        Parameters
        ----------
        attitude_xyzw : ndarray, shape (N, 4)
            Readings.
        """
        across, along = self.cross_noise**2, self.roll_noise**2
        sight = quaternion.rotate(attitude_xyzw, np.array(self.boresight))
        return np.asarray(across * np.eye(3) + (along - across) * (sight[:, :, np.newaxis] * sight[:, np.newaxis]))


def direction(values: Mapping[str, Value], name: str) -> Vector:
    """Make a unit vector of the numbers of a parameter.

    Raises
    ------
    ParameterError
        If the numbers are 0, or so large or small that they tell no direction.
    """
    components = vector(values, name)
    size = float(so3.norm(components))
    if not 1e-100 < size < 1e100:
        raise ParameterError(name, f"{list(components)} tells no direction: give for example [0.0, 0.0, 1.0]")
    return tuple(component / size for component in components)


_OF_QUATERNION: Final = 0.5
"""Change of a component of a quaternion per rad of a rotation, at most."""


class AttitudeSensor(Instrument):
    """An attitude sensor at work: attitudes, scalar last, and their covariances, rad².

    Parameters
    ----------
    model : AttitudeSensorModel
    """

    def __init__(self, model: AttitudeSensorModel) -> None:
        self._model, self._boresight = model, np.array(model.boresight)
        self._across, self._about = model.cross_noise, model.roll_noise - model.cross_noise
        self._noise = BlockBuffer(WhiteNoise(model.seed, NoiseSource.ATTITUDE_SENSOR_WHITE, 1.0))
        self._is_perfect = not (model.cross_noise or model.roll_noise)

    def signals(self, times_ns: Integers, states: State) -> dict[str, Signal]:
        """The next readings; see `Instrument.measure`."""
        attitude, error = states.attitude_xyzw, np.zeros((len(times_ns), 3))
        if not self._is_perfect:
            error = self._error(len(times_ns))
            attitude = quaternion.multiply(attitude, quaternion.exp(error))

        def conditioning() -> Conditioning:
            return Conditioning.of(1.0 + so3.norm(error), _OF_QUATERNION)

        def of_covariance() -> Conditioning:
            # the boresight turns by twice what a quaternion errs by, and stands in the covariance twice
            changed = 4.0 * abs(self._model.roll_noise**2 - self._model.cross_noise**2)
            turned, size = conditioning(), self._model.cross_noise**2 + self._model.roll_noise**2
            return Conditioning(changed * turned.numbers + size * np.array([1.0, 0.0, 0.0])[:, np.newaxis, np.newaxis])

        covariance = Signal(self._model.covariance(attitude), condition=of_covariance)
        return {"attitude_xyzw": Signal(attitude, condition=conditioning), "covariance": covariance}

    def _error(self, count: int) -> Array:
        """The small rotations of the next readings, in the body frame, rad, shape (N, 3)."""
        drawn, b = self._noise.take(count), self._boresight
        roll = drawn[:, 0] * b[0] + drawn[:, 1] * b[1] + drawn[:, 2] * b[2]
        return np.asarray(self._across * drawn + self._about * roll[:, np.newaxis] * b)

    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; see `Instrument.skip`."""
        self._noise.skip(count)


def _made(model: AttitudeSensorModel, carrier: Carrier, before_ns: int) -> AttitudeSensor:
    return AttitudeSensor(model)


_ROTATION: Final = tuple(6 * row + column for row in (3, 4, 5) for column in (3, 4, 5))
"""Numbers of a pose's covariance that belong to the rotation; the position is known exactly."""
ATTITUDE_SENSOR: Final = Sensor(
    "attitude_sensor",
    "attitude sensor",
    AttitudeSensorModel,
    _made,
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
)
"""The attitude sensor in the table of sensors."""
