"""The table of sensors, and of their parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Final

from lie_rigid_body.parameters import Parameter
from lie_rigid_body.sensors.attitude_sensor import ATTITUDE_SENSOR
from lie_rigid_body.sensors.fault_parameters import WINDOW_PARAMETERS
from lie_rigid_body.sensors.grades import GRADE, GRADES, PERFECT
from lie_rigid_body.sensors.imu import IMU
from lie_rigid_body.sensors.magnetometer import MAGNETOMETER
from lie_rigid_body.sensors.sensor import Sensor
from lie_rigid_body.sensors.sun_sensor import SUN_SENSOR

_SHARED: Final = (
    Parameter("imu_frame", "string", "imu_link", "Name of the frame of the IMU and the magnetometer."),
    Parameter(
        "sensor_seed",
        "int",
        0,
        "Seed of all noise: the same seed gives the same bytes.",
        minimum=0,
        maximum=2**63 - 1,
    ),
    Parameter(
        GRADE,
        "string",
        PERFECT,
        "Sets all errors of the sensors to those of data sheets of a grade; single ones override.",
        choices=tuple(GRADES),
    ),
)
"""Parameters of several sensors."""


class SensorTable(Mapping[str, Sensor]):
    """Sensors by their names.

    Parameters
    ----------
    *sensors : Sensor

    Attributes
    ----------
    parameters : dict of str to Parameter
        Every parameter of the sensors by its name, in the order in which they are shown.
    quiet : frozenset of str
        Names of those that the text of a scenario leaves out at their defaults: they came later than bags did.
    parts : tuple of str
        What can have faults. The order is part of the keys of the random numbers.
    """

    def __init__(self, *sensors: Sensor) -> None:
        self._sensors: dict[str, Sensor] = {}
        self.parameters: dict[str, Parameter] = {}
        self._set(sensors)

    def _set(self, sensors: tuple[Sensor, ...]) -> None:
        self._sensors = {sensor.name: sensor for sensor in sensors}
        told = [parameter for sensor in sensors for parameter in sensor.told]
        rates = {sensor.switch for sensor in sensors}
        later = [parameter for sensor in sensors for parameter in sensor.parameters]
        faults = [parameter for sensor in sensors for parameter in sensor.all_faults]
        quiet = (*later, *WINDOW_PARAMETERS, *faults)
        first = [parameter for parameter in told if parameter.name in rates]
        everything = (*first, *_SHARED, *(p for p in told if p.name not in rates), *quiet)
        self.parameters.clear()  # others have views of it
        self.parameters.update({parameter.name: parameter for parameter in everything})
        self.quiet = frozenset({GRADE, *(parameter.name for parameter in quiet)})
        self.parts = tuple(part for sensor in sensors for part in (sensor.name, *sensor.parts))

    def __getitem__(self, name: str) -> Sensor:
        return self._sensors[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sensors)

    def __len__(self) -> int:
        return len(self._sensors)

    @contextmanager
    def including(self, sensor: Sensor) -> Iterator[None]:
        """Have one more sensor for a while, behind all others; for the tests of a new one."""
        before = tuple(self.values())
        self._set((*before, sensor))
        try:
            yield
        finally:
            self._set(before)


SENSORS: Final = SensorTable(IMU, MAGNETOMETER, ATTITUDE_SENSOR, SUN_SENSOR)
"""All sensors, in the order in which they are shown."""
