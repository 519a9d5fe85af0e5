"""Sensors on the body: gyro, accelerometer, magnetometer, attitude and sun, and how they differ from the truth.

In the order of a measurement:

- `sensor`: what a sensor is: model, instrument, readings, topics;
- `table`: all sensors and their parameters, and the sensors of a scenario, validated once;
- `parameters`: the parameters that several sensors have;
- `grades`: the errors of real sensors, from data sheets;
- `gyro_rate`, `specific_force`: the true quantities that gyro and accelerometer measure;
- `noise`: random numbers from the seed alone, the same in batches of any size;
- `triad`, `quantisation`: the errors of a sensor, its range and its resolution;
- `fault`, `episodes`: what goes wrong and when;
- `triad_faults`, `magnetic_disturbance`, `delivery`: with a sensor's axes, around it, and on the way of its readings;
- `imu` and its `orientation`, `magnetometer`, `attitude_sensor`, `sun_sensor`: the sensors.
"""

from lie_rigid_body.sensors.attitude_sensor import AttitudeSensor, AttitudeSensorModel
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Fault
from lie_rigid_body.sensors.grades import GRADE, GRADES, PERFECT, graded
from lie_rigid_body.sensors.imu import Imu, ImuModel
from lie_rigid_body.sensors.magnetometer import Magnetometer, MagnetometerModel
from lie_rigid_body.sensors.sensor import Carrier, Field, Instrument, Readings, Sensor, SensorModel, Topic
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.sensors.sun_sensor import SunSensor, SunSensorModel
from lie_rigid_body.sensors.table import SENSORS, Sensors, frame_parameters, without_effect

__all__ = [
    "GRADE",
    "GRADES",
    "PERFECT",
    "SENSORS",
    "AttitudeSensor",
    "AttitudeSensorModel",
    "Carrier",
    "Conditioning",
    "Delivery",
    "Fault",
    "Field",
    "Imu",
    "ImuModel",
    "Instrument",
    "Magnetometer",
    "MagnetometerModel",
    "Readings",
    "Sensor",
    "SensorModel",
    "Sensors",
    "Signal",
    "SunSensor",
    "SunSensorModel",
    "Topic",
    "frame_parameters",
    "graded",
    "without_effect",
]
