"""The sensors of a scenario."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, cast

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import Value, read_table, require_frame_name
from lie_rigid_body.sensors.fault_parameters import WINDOW_PARAMETERS, fault_switches
from lie_rigid_body.sensors.grades import GRADE, GRADES, graded
from lie_rigid_body.sensors.sensor import SensorModel
from lie_rigid_body.sensors.table import SENSORS
from lie_rigid_body.wording import listed, short_repr

SLOWEST_RATE: Final = 1e-6
"""Smallest sampling rate accepted, Hz."""


@dataclass(frozen=True)
class Sensors:
    """The sensors on the body. Build them with `from_parameters`, which validates.

    The model of each is an attribute as well, by its name in `SENSORS`; None where there is no such sensor.

    Parameters
    ----------
    models : tuple of (str, SensorModel)
        Those that there are, by name, in the order of `SENSORS`.
    """

    models: tuple[tuple[str, SensorModel], ...] = ()

    __repr__ = short_repr

    @classmethod
    def from_parameters(cls, given: Mapping[str, object] | None = None) -> Sensors:
        """The sensors of the given parameters, the rest at their defaults, validated as a whole.

        Parameters
        ----------
        given : mapping of str to object, optional
            Values of ``SENSORS.parameters``, as a YAML file or a ROS parameter gives them.

        Returns
        -------
        Sensors

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy; also for a sensor that is off.
        """
        return cls.from_values(read_table(SENSORS.parameters.values(), graded(given or {})))

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> Sensors:
        """The sensors of all their parameters, each in its own type; see `from_parameters`."""
        for name in frame_parameters(SENSORS) & set(values):
            require_frame_name(name, cast(str, values[name]))
        models = {name: sensor.model.from_values(values) for name, sensor in SENSORS.items()}  # refuse also what is off
        return cls(tuple((name, models[name]) for name, sensor in SENSORS.items() if _is_on(sensor.switch, values)))

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
        return any(faulty is not None for model in self.on.values() for faulty in model.faulty)


def frame_parameters(sensors: Iterable[str]) -> set[str]:
    """Names of the parameters that name the frames of some sensors' messages."""
    return {topic.frame for name in sensors for topic in SENSORS[name].topics}


def _is_on(name: str, values: Mapping[str, Value]) -> bool:
    rate = cast(float, values[name])
    if 0.0 < rate < SLOWEST_RATE:
        raise ParameterError(name, f"{rate:g} is below {SLOWEST_RATE:g} samples per second: give more, or 0 for none")
    return rate > 0.0


def without_effect(values: Mapping[str, Value]) -> str:
    """What is asked of sensors and faults that are off, in a sentence without a full stop; empty if nothing.

    A grade asks for nothing: it is that of whichever sensors there are.

    Parameters
    ----------
    values : mapping of str to value
        Every one of ``SENSORS.parameters``.
    """
    default = {name: parameter.default for name, parameter in SENSORS.parameters.items()}
    usual = {**default, **GRADES[str(values[GRADE])], GRADE: values[GRADE]}
    frames, faults = (
        frame_parameters(SENSORS),
        fault_switches(SENSORS.parameters.values()),
    )  # a frame may be that of several
    asked = [name for name, value in values.items() if value != usual[name] and name not in frames]
    sentences = []
    for switch, prefixes in [*_switches(), *faults.items()]:
        names = [name for name in asked if not values[switch] and name.startswith(prefixes)]
        asked = [name for name in asked if name not in names]  # those of a sensor that is off are not told twice
        if names:
            sentences.append(f"{_idle(names)}, as {switch} is {'false' if values[switch] is False else 0}")
    window = [parameter.name for parameter in WINDOW_PARAMETERS if parameter.name in asked]
    if window and not any(values[switch] for switch in faults):
        sentences.append(f"{_idle(window)}, as no fault that comes and goes is on")
    return f"{'; '.join(sentences)}: give what switches them on" if sentences else ""


def _switches() -> Iterable[tuple[str, tuple[str, ...]]]:
    """The parameters that switch sensors on, and parts of them, each with how the names of others begin."""
    for sensor in SENSORS.values():
        yield sensor.switch, sensor.prefixes or (f"{sensor.name}_",)
    for sensor in SENSORS.values():
        yield from sensor.switches.items()


def _idle(names: list[str]) -> str:
    return f"{listed(names)} {'have' if len(names) > 1 else 'has'} no effect"
