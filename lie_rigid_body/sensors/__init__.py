"""Sensors on the body: what a gyro, an accelerometer and a magnetometer would read of the truth.

A table of contents, in the order of a measurement

- `sensor_parameters`, `sensors`: the parameters, and the frozen models made of them, validated once;
- `gyro_rate`, `specific_force`: the truth that gyro and accelerometer are after;
- `noise`: random numbers from the seed alone, the same in batches of any size;
- `triad`, `converter`: the errors of a sensor, its range and its resolution;
- `imu`, `magnetometer`: the sensors at work.
"""

from lie_rigid_body.sensors.imu import Imu, ImuModel, ImuReadings
from lie_rigid_body.sensors.magnetometer import Magnetometer, MagnetometerModel
from lie_rigid_body.sensors.sensor_parameters import SENSOR_PARAMETERS
from lie_rigid_body.sensors.sensors import Sensors

__all__ = [
    "SENSOR_PARAMETERS",
    "Imu",
    "ImuModel",
    "ImuReadings",
    "Magnetometer",
    "MagnetometerModel",
    "Sensors",
]
