"""The table of sensors and of their parameters, and the sensors of a scenario."""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Parameter, require_frame_name
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.sensors.fault import STREAMS
from lie_rigid_body.sensors.imu import IMU_SENSOR
from lie_rigid_body.sensors.magnetometer import MAGNETOMETER
from lie_rigid_body.sensors.parameters import GRADE, GRADES, PERFECT, WINDOW_PARAMETERS, Values, fault_switches, seed
from lie_rigid_body.sensors.pointing import ATTITUDE_SENSOR, SUN_SENSOR
from lie_rigid_body.sensors.sensor import Sensor, SensorModel

MIN_RATE: Final = 1e-6
"""Smallest sampling rate of a sensor, Hz."""
_SHARED: Final = (
    Parameter("imu_frame", "string", "imu_link", "Name of the frame of the IMU and the magnetometer."),
    seed("sensor_seed", "Seed of all noise: the same seed gives the same bytes."),
    Parameter(
        GRADE,
        "string",
        PERFECT,
        "Sets all errors of the sensors to those of data sheets of a grade; single ones override.",
        choices=tuple(GRADES),
    ),
    *WINDOW_PARAMETERS,
)
"""Parameters of several sensors."""


class SensorRegistry(dict[str, Sensor]):
    """Sensors by their names, in the order in which they are shown.

    Attributes
    ----------
    parameters : dict of str to Parameter
        Every parameter of the sensors by its name, in the order in which they are shown.
    topics : dict of str to str
        Message types of the topics of readings, by their relative names.
    """

    def __init__(self) -> None:
        super().__init__()
        self.parameters = {parameter.name: parameter for parameter in _SHARED}
        self.topics: dict[str, str] = {}

    def register(self, sensor: Sensor) -> None:
        """Add a sensor, behind all others, before rooms are imported that make tables of the sensors.

        Raises
        ------
        ValueError
            If another sensor has its number of random numbers, or the name of a parameter or a topic.
        """
        parameters = {parameter.name: parameter for parameter in sensor.all_parameters}
        topics = {topic.name: topic.message_type for topic in sensor.topics}
        pairs = ((parameters, self.parameters), (topics, self.topics), (sensor.streams.values(), STREAMS.values()))
        for own, taken in pairs:
            if both := set(own) & set(taken):
                raise ValueError(f"{sensor.name}: another sensor has {both.pop()} already")
        self[sensor.name] = sensor
        self.parameters.update(parameters)
        self.topics.update(topics)
        STREAMS.update(sensor.streams)


SENSORS: Final = SensorRegistry()
"""The sensors that there can be on a body."""
for _sensor in (IMU_SENSOR, MAGNETOMETER, ATTITUDE_SENSOR, SUN_SENSOR):
    SENSORS.register(_sensor)


@short_dataclass
class Sensors:
    """The sensors on the body. Build them with `from_values`, which validates.

    The model of each is an attribute as well, by its name in `SENSORS`; None where there is no such sensor.

    Parameters
    ----------
    models : tuple of (str, SensorModel)
        The sensors that there are, by name, in the order of `SENSORS`.
    """

    models: tuple[tuple[str, SensorModel], ...] = ()

    @classmethod
    def from_values(cls, values: Values) -> Sensors:
        """Make the sensors of all their parameters, each in its own type, validated as a whole.

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy; also for a sensor that is off.
        """
        for name in frame_parameters() & set(values):
            require_frame_name(name, values[name])
        # refuse also what is off
        models = [(name, sensor.model.from_values(name, values)) for name, sensor in SENSORS.items()]
        return cls(tuple((name, model) for name, model in models if _is_on(SENSORS[name].switch, values)))

    def __getattr__(self, name: str) -> Any:
        if name in SENSORS:
            return self.on.get(name)
        raise AttributeError(f"there is no sensor {name}")

    @property
    def on(self) -> dict[str, SensorModel]:
        """The sensors that there are, by name."""
        return dict(self.models)

    @property
    def off_parameters(self) -> set[str]:
        """Names of the parameters of the sensors that there are not."""
        return {p.name for name, sensor in SENSORS.items() if name not in self.on for p in sensor.all_parameters}

    @property
    def has_faults(self) -> bool:
        """Whether any fault is on."""
        return any(model.fault_models for model in self.on.values())


def frame_parameters() -> set[str]:
    """Names of the parameters that name the frames of messages of sensors."""
    return {topic.frame for sensor in SENSORS.values() for topic in sensor.topics}


def _is_on(name: str, values: Values) -> bool:
    rate: float = values[name]
    if 0.0 < rate < MIN_RATE:
        raise ParameterError(name, f"{rate:g} is below {MIN_RATE:g} samples per second: give more, or 0 for none")
    return rate > 0.0


def without_effect(values: Values) -> list[str]:
    """Sentences, each without a full stop, about what is asked of sensors and faults that are off.

    A grade asks for nothing: it is that of whichever sensors there are.

    Parameters
    ----------
    values : mapping of str to value
        Every one of ``SENSORS.parameters``.
    """
    every = SENSORS.parameters
    usual = {name: parameter.default for name, parameter in every.items()}
    usual |= {**GRADES[str(values[GRADE])], GRADE: values[GRADE]}
    of_world = {*frame_parameters(), "accelerometer_mode"}  # a scenario tells what world it is without a sensor as well
    asked = {name for name, value in values.items() if value != usual[name] and name not in of_world}
    faults = fault_switches(every.values())
    begins = {switch: own for sensor in SENSORS.values() for switch, own in sensor.switches.items()} | faults
    switched = {sensor.switch: [p.name for p in sensor.all_parameters] for sensor in SENSORS.values()}
    switched |= {switch: [name for name in every if name.startswith(own)] for switch, own in begins.items()}
    sentences = list[str]()
    for switch, names in switched.items():
        idle = [name for name in names if name in asked and not values[switch]]
        asked.difference_update(idle)  # those of a sensor that is off are not told twice
        if idle:
            sentences.append(_idle(idle, f"{switch} is {'false' if values[switch] is False else 0}"))
    window = [parameter.name for parameter in WINDOW_PARAMETERS if parameter.name in asked]
    if window and not any(values[switch] for switch in faults):
        sentences.append(_idle(window, "no fault that comes and goes is on"))
    return sentences


def _idle(names: list[str], why: str) -> str:
    more = f" and {len(names) - 1} more have" if len(names) > 1 else " has"
    return f"{names[0]}{more} no effect, as {why}: give what switches it on"
