"""Model of a sun sensor: the direction of the sun in the body frame. Nothing eclipses it, and it sees all around."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value, Vector
from lie_rigid_body.sensors.attitude_sensor import direction
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class SunSensorModel:
    """The model of a sun sensor: exp(n_k) Aᵀ s, with A the attitude, s the sun's direction and n_k = σ ν_k.

    Parameters
    ----------
    rate : float
        Readings per second.
    seed : int
        Of the noise.
    sun : tuple of float, length 3
        s, a unit vector in the world frame.
    noise : float
        σ, standard deviation of the small rotation about each axis, rad; that about the sun itself shows nowhere.
    delivery : Delivery or None
    """

    rate: float
    seed: int
    sun: Vector
    noise: float
    delivery: Delivery | None = None

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> SunSensorModel:
        """The model of the parameters' values, validated.

        Raises
        ------
        ParameterError
        """
        return cls(
            cast(float, values["sun_sensor_rate"]),
            cast(int, values["sensor_seed"]),
            direction(values, "sun_direction"),
            cast(float, values["sun_sensor_noise"]),
            Delivery.from_values("sun_sensor", values),
        )

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """What may have faults."""
        return (self.delivery,)


class SunSensor:
    """A sun sensor: readings in order, the same to the bit in batches of any size.

    Parameters
    ----------
    model : SunSensorModel
    """

    def __init__(self, model: SunSensorModel) -> None:
        self._sun = np.array(model.sun)
        self._noise = BlockBuffer(WhiteNoise(model.seed, NoiseSource.SUN_SENSOR_WHITE, model.noise))
        self._is_perfect = not model.noise

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
        ndarray, shape (N, 3)
            Unit vectors in the body frame.
        """
        sun = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self._sun)
        if self._is_perfect:
            return sun
        return quaternion.rotate(quaternion.exp(self._noise.take(len(sun))), sun)

    def skip(self, count: int) -> None:
        """Leave out the next readings."""
        self._noise.skip(count)
