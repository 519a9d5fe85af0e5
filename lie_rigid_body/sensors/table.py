"""The table of sensors and of their parameters, and the sensors of a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, cast

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Parameter, Value, require_frame_name
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.sensors.fault import PARTS
from lie_rigid_body.sensors.imu import IMU_SENSOR
from lie_rigid_body.sensors.magnetometer import MAGNETOMETER
from lie_rigid_body.sensors.parameters import GRADE, GRADES, PERFECT, WINDOW_PARAMETERS, fault_switches
from lie_rigid_body.sensors.pointing import ATTITUDE_SENSOR, SUN_SENSOR
from lie_rigid_body.sensors.sensor import Sensor, SensorModel

SLOWEST_RATE: Final = 1e-6
"""Smallest sampling rate of a sensor, Hz."""
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


class SensorTable(dict[str, Sensor]):
    """Sensors by their names, in the order in which they are shown.

    Parameters
    ----------
    *sensors : Sensor

    Attributes
    ----------
    parameters : dict of str to Parameter
        Every parameter of the sensors by its name, in the order in which they are shown.
    topics : dict of str to str
        Message types of the topics of readings, by their relative names.
    quiet : frozenset of str
        Names of the parameters that the text of a scenario leaves out at their defaults: they came later than bags did.
    """

    def __init__(self, *sensors: Sensor) -> None:
        super().__init__({sensor.name: sensor for sensor in sensors})
        told = [parameter for sensor in sensors for parameter in sensor.told]
        rates = [parameter for parameter in told if any(parameter.name == sensor.switch for sensor in sensors)]
        quiet = [
            *(parameter for sensor in sensors for parameter in sensor.parameters),
            *WINDOW_PARAMETERS,
            *(fault for sensor in sensors for fault in sensor.all_faults),
        ]
        PARTS[:] = [part for sensor in sensors for part in (sensor.name, *sensor.parts)]
        self.quiet = frozenset({GRADE, *(parameter.name for parameter in quiet)})
        self.parameters = {parameter.name: parameter for parameter in (*rates, *_SHARED, *told, *quiet)}
        self.topics = {topic.name: topic.message_type for sensor in sensors for topic in sensor.topics}


SENSORS: Final = SensorTable(IMU_SENSOR, MAGNETOMETER, ATTITUDE_SENSOR, SUN_SENSOR)
"""The sensors that there can be on a body."""


@short_dataclass(frozen=True)
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
    def from_values(cls, values: Mapping[str, Value]) -> Sensors:
        """Make the sensors of all their parameters, each in its own type, validated as a whole.

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy; also for a sensor that is off.
        """
        for name in frame_parameters() & set(values):
            require_frame_name(name, cast(str, values[name]))
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
    def have_faults(self) -> bool:
        """Whether any fault is on."""
        return any(model.faulty for model in self.on.values())


def frame_parameters() -> set[str]:
    """Names of the parameters that name the frames of messages of sensors."""
    return {topic.frame for sensor in SENSORS.values() for topic in sensor.topics}


def _is_on(name: str, values: Mapping[str, Value]) -> bool:
    rate = cast(float, values[name])
    if 0.0 < rate < SLOWEST_RATE:
        raise ParameterError(name, f"{rate:g} is below {SLOWEST_RATE:g} samples per second: give more, or 0 for none")
    return rate > 0.0


def without_effect(values: Mapping[str, Value]) -> list[str]:
    """Sentences, each without a full stop, about what is asked of sensors and faults that are off.

    A grade asks for nothing: it is that of whichever sensors there are.

    Parameters
    ----------
    values : mapping of str to value
        Every one of ``SENSORS.parameters``.
    """
    default = {name: parameter.default for name, parameter in SENSORS.parameters.items()}
    usual = {**default, **GRADES[str(values[GRADE])], GRADE: values[GRADE]}
    faults = fault_switches(SENSORS.parameters.values())
    switches = {sensor.switch: sensor.prefixes or (f"{sensor.name}_",) for sensor in SENSORS.values()}
    for sensor in SENSORS.values():
        switches |= sensor.switches
    asked = [name for name, value in values.items() if value != usual[name] and name not in frame_parameters()]
    sentences = list[str]()
    for switch, prefixes in {**switches, **faults}.items():
        names = [name for name in asked if not values[switch] and name.startswith(prefixes)]
        asked = [name for name in asked if name not in names]  # those of a sensor that is off are not told twice
        if names:
            sentences.append(_idle(names, f"{switch} is {'false' if values[switch] is False else 0}"))
    window = [parameter.name for parameter in WINDOW_PARAMETERS if parameter.name in asked]
    if window and not any(values[switch] for switch in faults):
        sentences.append(_idle(window, "no fault that comes and goes is on"))
    return sentences


def _idle(names: list[str], why: str) -> str:
    more = f" and {len(names) - 1} more have" if len(names) > 1 else " has"
    return f"{names[0]}{more} no effect, as {why}: give what switches it on"
