"""Sensors on the body: gyro, accelerometer and magnetometer, and how their readings differ from the truth.

In the order of a measurement:

- `parameters`: the table of parameters, and the sensors of a scenario made of them, validated once;
- `grades`: the errors of real sensors, from data sheets;
- `gyro_rate`, `specific_force`: the true quantities that gyro and accelerometer measure;
- `noise`: random numbers from the seed alone, the same in batches of any size;
- `triad`, `quantisation`: the errors of a sensor, its range and its resolution;
- `imu`, `magnetometer`: the two sensors.
"""

from lie_rigid_body.sensors.grades import GRADE, GRADES, PERFECT, graded
from lie_rigid_body.sensors.imu import Imu, ImuModel, ImuReadings
from lie_rigid_body.sensors.magnetometer import Magnetometer, MagnetometerModel
from lie_rigid_body.sensors.parameters import SENSOR_PARAMETERS, Sensors

__all__ = [
    "GRADE",
    "GRADES",
    "PERFECT",
    "SENSOR_PARAMETERS",
    "Imu",
    "ImuModel",
    "ImuReadings",
    "Magnetometer",
    "MagnetometerModel",
    "Sensors",
    "graded",
]
