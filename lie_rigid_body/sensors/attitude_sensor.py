"""Model of an attitude sensor, such as a star tracker: the whole attitude, worst about its boresight."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value, Vector, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class AttitudeSensorModel:
    """The model of an attitude sensor.

    ::

        q_k = A ⊗ exp(n_k),   n_k = σ_c ν_k + (σ_r − σ_c) b (b · ν_k)

    with A the attitude, b the boresight and ν standard normal: the error is a small rotation by n in the body frame, of
    σ_r about the boresight and σ_c about each axis across it.

    Parameters
    ----------
    rate : float
        Readings per second.
    seed : int
        Of the noise.
    boresight : tuple of float, length 3
        b, a unit vector in the body frame.
    cross_noise, roll_noise : float
        σ_c and σ_r, standard deviations, rad.
    delivery : Delivery or None
    """

    rate: float
    seed: int
    boresight: Vector
    cross_noise: float
    roll_noise: float
    delivery: Delivery | None = None

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> AttitudeSensorModel:
        """The model of the parameters' values, validated.

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
            Delivery.from_values("attitude_sensor", values),
        )

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """What may have faults."""
        return (self.delivery,)

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
    """A direction as a unit vector.

    Raises
    ------
    ParameterError
        If the numbers have none, or are too large or small to tell it.
    """
    numbers = vector(values, name)
    size = float(so3.norm(numbers))
    if not 1e-100 < size < 1e100:
        raise ParameterError(name, f"{list(numbers)} tells no direction: give for example [0.0, 0.0, 1.0]")
    return tuple(number / size for number in numbers)


class AttitudeSensor:
    """An attitude sensor: readings in order, the same to the bit in batches of any size.

    Parameters
    ----------
    model : AttitudeSensorModel
    """

    def __init__(self, model: AttitudeSensorModel) -> None:
        self._boresight = np.array(model.boresight)
        self._across, self._about = model.cross_noise, model.roll_noise - model.cross_noise
        self._noise = BlockBuffer(WhiteNoise(model.seed, NoiseSource.ATTITUDE_SENSOR_WHITE, 1.0))
        self._is_perfect = not (model.cross_noise or model.roll_noise)

    __copy__ = copy.deepcopy  # it goes on by itself

    def measure(self, times_ns: Integers, states: State) -> Array:
        """The next readings.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        states : State
            The body's states at those times.

        Returns
        -------
        ndarray, shape (N, 4)
            World-from-body, scalar last.
        """
        if self._is_perfect:
            return states.attitude_xyzw
        drawn, b = self._noise.take(len(times_ns)), self._boresight
        roll = drawn[:, 0] * b[0] + drawn[:, 1] * b[1] + drawn[:, 2] * b[2]
        error = self._across * drawn + self._about * roll[:, np.newaxis] * b
        return quaternion.multiply(states.attitude_xyzw, quaternion.exp(error))

    def skip(self, count: int) -> None:
        """Leave out the next readings."""
        self._noise.skip(count)
