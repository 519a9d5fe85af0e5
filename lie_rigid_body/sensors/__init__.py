"""Sensors on the body: gyro, accelerometer, magnetometer, attitude and sun, and how they differ from the truth.

In the order of a measurement:

- `parameters`: the table of parameters, and the sensors of a scenario made of them, validated once;
- `grades`: the errors of real sensors, from data sheets;
- `gyro_rate`, `specific_force`: the true quantities that gyro and accelerometer measure;
- `noise`: random numbers from the seed alone, the same in batches of any size;
- `triad`, `quantisation`: the errors of a sensor, its range and its resolution;
- `fault`, `episodes`, `fault_parameters`: what goes wrong and when, and the parameters of that;
- `triad_faults`, `magnetic_disturbance`, `delivery`: with a sensor's axes, around it, and on the way of its readings;
- `imu` and its `orientation`, `magnetometer`, `attitude_sensor`, `sun_sensor`: the sensors.
"""

from lie_rigid_body.sensors.attitude_sensor import AttitudeSensor, AttitudeSensorModel
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Fault
from lie_rigid_body.sensors.grades import GRADE, GRADES, PERFECT, graded
from lie_rigid_body.sensors.imu import Imu, ImuModel, ImuReadings
from lie_rigid_body.sensors.magnetometer import Magnetometer, MagnetometerModel
from lie_rigid_body.sensors.parameters import QUIET, SENSOR_PARAMETERS, SensorModel, Sensors, without_effect
from lie_rigid_body.sensors.sun_sensor import SunSensor, SunSensorModel

__all__ = [
    "GRADE",
    "GRADES",
    "PERFECT",
    "QUIET",
    "SENSOR_PARAMETERS",
    "AttitudeSensor",
    "AttitudeSensorModel",
    "Delivery",
    "Fault",
    "Imu",
    "ImuModel",
    "ImuReadings",
    "Magnetometer",
    "MagnetometerModel",
    "SensorModel",
    "Sensors",
    "SunSensor",
    "SunSensorModel",
    "graded",
    "without_effect",
]
