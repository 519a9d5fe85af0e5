"""A sensor of a test's own, declared in one entry and registered: it senses where the ground is.

Run as a program, this file is the command line with that sensor.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.sensors import SENSORS, Field, Instrument, Sensor, SensorModel, Signal, Topic
from lie_rigid_body.sensors.noise import WhiteNoise
from lie_rigid_body.sensors.parameters import angle, not_negative
from lie_rigid_body.sensors.sensor import VectorMeasurement

NADIR = (0.0, 0.0, -1.0)
SOURCE = 200
"""Source of its random numbers, which no other has."""


@dataclass(frozen=True)
class HorizonModel(SensorModel):
    """exp(σ ν) Aᵀ (0, 0, −1)."""

    noise: float

    @property
    def measurement_models(self) -> tuple[VectorMeasurement, ...]:
        return (VectorMeasurement(NADIR, self.noise),)


class Horizon(Instrument):
    def __init__(self, model: HorizonModel, *carrier: object) -> None:
        self._noise = WhiteNoise(model.seed, SOURCE, model.noise)

    def signals(self, times_ns: Integers, states: State, first: int) -> dict[str, Signal]:
        nadir = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), np.array(NADIR))
        return {"nadir": Signal(quaternion.rotate(quaternion.exp(self._noise.draw(first, len(nadir))), nadir))}


HORIZON = Sensor(
    "horizon_sensor",
    "horizon sensor",
    HorizonModel,
    Horizon,
    (
        Topic(
            "horizon/nadir",
            "geometry_msgs/msg/Vector3Stamped",
            "horizon sensor frame",
            (Field("nadir", "vector", "", "horizon sensor"),),
        ),
    ),
    parameters=(
        not_negative("horizon_sensor_rate", "Readings of the horizon sensor per second; 0: no such sensor."),
        angle("horizon_sensor_noise", "Horizon sensor: standard deviation about each axis, rad."),
    ),
    streams={"horizon_sensor": 100},
    attribute="horizon",
)
SENSORS.register(HORIZON)

if __name__ == "__main__":
    from lie_rigid_body.__main__ import main

    sys.exit(main(sys.argv[1:]))
