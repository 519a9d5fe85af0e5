"""Model of a sun sensor: the direction of the sun in the body frame. Nothing eclipses it, and it sees all around."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value, Vector
from lie_rigid_body.sensors.attitude_sensor import direction
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.sensors.parameters import angle, not_negative, numbers
from lie_rigid_body.sensors.sensor import Carrier, Field, Instrument, Sensor, SensorModel, Topic, VectorAid
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class SunSensorModel(SensorModel):
    """The model of a sun sensor: exp(n_k) Aᵀ s, with A the attitude, s the sun's direction and n_k = σ ν_k.

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

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> SunSensorModel:
        """Make the model of the parameters' values, and validate it.

        Raises
        ------
        ParameterError
        """
        return cls(
            cast(float, values["sun_sensor_rate"]),
            cast(int, values["sensor_seed"]),
            direction(values, "sun_direction"),
            cast(float, values["sun_sensor_noise"]),
            delivery=Delivery.from_values("sun_sensor", values),
        )

    @property
    def aids(self) -> tuple[VectorAid, ...]:
        """The direction of the sun."""
        return (VectorAid(self.sun, self.noise),)


class SunSensor(Instrument):
    """A sun sensor at work: unit vectors to the sun in the body frame.

    Parameters
    ----------
    model : SunSensorModel
    """

    def __init__(self, model: SunSensorModel) -> None:
        self._sun = np.array(model.sun)
        self._noise = BlockBuffer(WhiteNoise(model.seed, NoiseSource.SUN_SENSOR_WHITE, model.noise))
        self._is_perfect = not model.noise

    def signals(self, times_ns: Integers, states: State) -> dict[str, Signal]:
        """The next readings; see `Instrument.measure`."""
        sun = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self._sun)
        if self._is_perfect:
            return {"direction": Signal(sun)}
        error = self._noise.take(len(sun))
        signal = Signal(quaternion.rotate(quaternion.exp(error), sun))
        return {"direction": replace(signal, condition=lambda: Conditioning.of(1.0 + so3.norm(error), 1.0))}

    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; see `Instrument.skip`."""
        self._noise.skip(count)


def _made(model: SunSensorModel, carrier: Carrier, before_ns: int) -> SunSensor:
    return SunSensor(model)


SUN_SENSOR: Final = Sensor(
    "sun_sensor",
    "sun sensor",
    SunSensorModel,
    _made,
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
    attribute="sun",
)
"""The sun sensor in the table of sensors."""
