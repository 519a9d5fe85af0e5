"""The orientation that an IMU tells if it is an attitude and heading reference system (AHRS)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
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

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> OrientationModel | None:
        """The model of the parameters' values; None if the IMU tells no orientation."""
        if not values["imu_orientation"]:
            return None
        return cls(cast(float, values["imu_inclination_noise"]), cast(float, values["imu_heading_noise"]))

    @property
    def covariance(self) -> tuple[float, ...]:
        """Covariance of n, of small rotations about the fixed axes of the world, rad², row by row."""
        inclination, heading = self.inclination_noise**2, self.heading_noise**2
        return (inclination, 0.0, 0.0, 0.0, inclination, 0.0, 0.0, 0.0, heading)


class Orientation:
    """Orientations in order, the same to the bit in batches of any size.

    Parameters
    ----------
    model : OrientationModel
    seed : int
    """

    def __init__(self, model: OrientationModel, seed: int) -> None:
        self._sigma = np.array([model.inclination_noise, model.inclination_noise, model.heading_noise])
        self._noise = BlockBuffer(WhiteNoise(seed, NoiseSource.ORIENTATION_WHITE, 1.0))

    def signal(self, states: State) -> Signal:
        """The next orientations, world-from-body, scalar last, shape (N, 4)."""
        attitude, error = states.attitude_xyzw, np.zeros((len(states.attitude_xyzw), 3))
        if self._sigma.any():
            error = self._sigma * self._noise.take(len(attitude))
            attitude = quaternion.multiply(quaternion.exp(error), attitude)
        # half of an angle is what a component of a quaternion changes by at most
        return Signal(attitude, condition=lambda: Conditioning.of(1.0 + so3.norm(error), 0.5))

    def skip(self, count: int) -> None:
        """Leave out the next orientations."""
        self._noise.skip(count)
