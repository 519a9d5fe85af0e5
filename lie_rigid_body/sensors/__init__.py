"""Sensors on the body: gyro, accelerometer, magnetometer, attitude and sun, and how they differ from the truth.

In the order of a measurement:

- `sensor`: what a sensor is: model, instrument, readings, topics;
- `table`: all sensors and their parameters, and the sensors of a scenario, validated once;
- `parameters`: the parameters that several sensors have, and the errors of real sensors, from data sheets;
- `noise`: random numbers from the seed alone, the same in batches of any size;
- `signal`: what an instrument measures, and the converter that makes readings of it;
- `fault`: what goes wrong and when, also on the way of a sensor's readings;
- `triad`: the errors and the faults of three axes;
- `allan`: the densities of noise of readings at rest;
- `imu`, `magnetometer`, `pointing`: the sensors.
"""

from lie_rigid_body.sensors.fault import Fault, TransportFaults
from lie_rigid_body.sensors.imu import Imu, ImuModel
from lie_rigid_body.sensors.magnetometer import Magnetometer, MagnetometerModel
from lie_rigid_body.sensors.parameters import GRADE, GRADES, PERFECT, graded
from lie_rigid_body.sensors.pointing import AttitudeSensor, AttitudeSensorModel, SunSensor, SunSensorModel
from lie_rigid_body.sensors.sensor import Field, Instrument, Sensor, SensorModel, Topic
from lie_rigid_body.sensors.signal import Signal
from lie_rigid_body.sensors.table import SENSORS, Sensors, frame_parameters, without_effect

__all__ = [
    "GRADE",
    "GRADES",
    "PERFECT",
    "SENSORS",
    "AttitudeSensor",
    "AttitudeSensorModel",
    "Fault",
    "Field",
    "Imu",
    "ImuModel",
    "Instrument",
    "Magnetometer",
    "MagnetometerModel",
    "Sensor",
    "SensorModel",
    "Sensors",
    "Signal",
    "SunSensor",
    "SunSensorModel",
    "Topic",
    "TransportFaults",
    "frame_parameters",
    "graded",
    "without_effect",
]
