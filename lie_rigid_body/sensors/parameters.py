"""The sensors of a scenario and the table of their parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, cast

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import Parameter, Value, read_table, require_frame_name
from lie_rigid_body.sensors.attitude_sensor import AttitudeSensorModel
from lie_rigid_body.sensors.fault_parameters import FAULT_PARAMETERS, FAULT_SWITCHES, WINDOW, not_negative
from lie_rigid_body.sensors.grades import GRADE, GRADES, PERFECT, graded
from lie_rigid_body.sensors.imu import ImuModel
from lie_rigid_body.sensors.magnetometer import MagnetometerModel
from lie_rigid_body.sensors.sun_sensor import SunSensorModel
from lie_rigid_body.wording import listed, short_repr

SLOWEST_RATE: Final = 1e-6
"""Smallest sampling rate accepted, Hz."""

_ONES: Final = (1.0, 1.0, 1.0)
_ZEROS: Final = (0.0, 0.0, 0.0)
_IDENTITY: Final = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
_CENTRAL_EUROPE: Final = (1.5e-6, 21.0e-6, -43.5e-6)
_FASTEST: Final = 1e9
_TURN: Final = math.pi
_LARGEST_SEED: Final = 2**63 - 1


def _array(name: str, default: tuple[float, ...], description: str) -> Parameter:
    return Parameter(name, "double_array", default, description, lengths=(len(default),))


def _triad(sensor: str, unit: str) -> tuple[Parameter, ...]:
    """The parameters that gyro and accelerometer share; ``unit`` is that of a reading."""
    name = sensor.capitalize()
    return (
        not_negative(f"{sensor}_noise_density", f"{name}: white noise, {unit}/√Hz; 0: none."),
        not_negative(f"{sensor}_bias_random_walk", f"{name}: random walk of the bias, {unit}/s/√Hz; 0: none."),
        not_negative(
            f"{sensor}_turn_on_bias",
            f"{name}: standard deviation of the bias at the start on each axis, drawn from the seed, {unit}; 0: none.",
        ),
        _array(f"{sensor}_scale_factor", _ONES, f"{name}: factor on each of its axes."),
        _array(
            f"{sensor}_misalignment",
            _ZEROS,
            f"{name}: rotation vector from the body's axes to its own, rad, of norm at most π.",
        ),
        not_negative(f"{sensor}_resolution", f"{name}: step of its readings, {unit}; 0: continuous."),
        not_negative(f"{sensor}_range", f"{name}: largest size of a reading on each axis, {unit}; 0: no limit."),
    )


_LATER: Final = (
    Parameter("imu_orientation", "bool", False, "Whether the IMU tells its orientation, as an AHRS does."),
    not_negative("imu_inclination_noise", "Its standard deviation about each horizontal axis, rad.", maximum=_TURN),
    not_negative("imu_heading_noise", "Its standard deviation about the vertical, rad.", maximum=_TURN),
    not_negative(
        "attitude_sensor_rate",
        "Readings of the attitude sensor per second, from 1e-6; 0: no such sensor.",
        maximum=_FASTEST,
    ),
    _array(
        "attitude_sensor_boresight", (0.0, 0.0, 1.0), "Attitude sensor: its boresight in the body frame, of any length."
    ),
    not_negative(
        "attitude_sensor_cross_boresight_noise",
        "Attitude sensor: standard deviation of a reading about each axis across the boresight, rad.",
        maximum=_TURN,
    ),
    not_negative(
        "attitude_sensor_roll_noise",
        "Attitude sensor: standard deviation of a reading about the boresight, rad.",
        maximum=_TURN,
    ),
    not_negative(
        "sun_sensor_rate", "Readings of the sun sensor per second, from 1e-6; 0: no such sensor.", maximum=_FASTEST
    ),
    _array("sun_direction", (1.0, 0.0, 0.0), "Direction of the sun in the world frame, of any length."),
    not_negative("sun_sensor_noise", "Sun sensor: standard deviation about each axis, rad.", maximum=_TURN),
    *FAULT_PARAMETERS,
)
"""Parameters that bags do not tell where they are at their defaults, so that those have the bytes they had without."""
QUIET: Final = frozenset({GRADE, *(parameter.name for parameter in _LATER)})
"""Names of the parameters that a scenario's text leaves out at their defaults."""

SENSOR_PARAMETERS: Final = (
    not_negative("imu_rate", "Samples of the IMU per second, from 1e-6; 0: no IMU.", maximum=_FASTEST),
    not_negative(
        "magnetometer_rate", "Samples of the magnetometer per second, from 1e-6; 0: no magnetometer.", maximum=_FASTEST
    ),
    Parameter("imu_frame", "string", "imu_link", "Name of the frame of the IMU and the magnetometer."),
    Parameter(
        "sensor_seed",
        "int",
        0,
        "Seed of all noise: the same seed gives the same bytes.",
        minimum=0,
        maximum=_LARGEST_SEED,
    ),
    Parameter(
        GRADE,
        "string",
        PERFECT,
        "Sets all errors of the sensors to those of data sheets of a grade; single ones override.",
        choices=tuple(GRADES),
    ),
    Parameter(
        "gyro_rate",
        "string",
        "instantaneous",
        "Gyro: the rate at the instant of a sample, or integrated: the mean turn over the interval that ends there.",
        choices=("instantaneous", "integrated"),
    ),
    *_triad("gyro", "rad/s"),
    Parameter(
        "accelerometer_mode",
        "string",
        "free_fall",
        "Accelerometer: free_fall reads no gravity, pivot_gravity that of a body held at its mass centre.",
        choices=("free_fall", "pivot_gravity"),
    ),
    not_negative("gravity", "Standard gravity, against z of the world frame, m/s².", default=9.80665, maximum=1e6),
    _array("accelerometer_lever_arm", _ZEROS, "From the mass centre to the accelerometer in the body frame, m."),
    *_triad("accelerometer", "m/s²"),
    _array("magnetic_field", _CENTRAL_EUROPE, "Magnetic field in the world frame, T; the default is east, north, up."),
    not_negative("magnetometer_noise_density", "Magnetometer: white noise, T/√Hz; 0: none."),
    _array("magnetometer_hard_iron", _ZEROS, "Magnetometer: field of the body's own magnets in the body frame, T."),
    _array("magnetometer_soft_iron", _IDENTITY, "Magnetometer: matrix of the body's soft iron, row by row."),
    not_negative("magnetometer_resolution", "Magnetometer: step of its readings, T; 0: continuous."),
    not_negative("magnetometer_range", "Magnetometer: largest size of a reading on each axis, T; 0: no limit."),
    *_LATER,
)
"""Every parameter of the sensors, in the order in which they are shown."""


_SWITCHES: Final[dict[str, tuple[str, ...]]] = {
    "imu_rate": ("imu_", "gyro_", "accelerometer_"),
    "magnetometer_rate": ("magnetometer_", "magnetic_disturbance_"),
    "attitude_sensor_rate": ("attitude_sensor_",),
    "sun_sensor_rate": ("sun_sensor_",),
    "imu_orientation": ("imu_inclination_", "imu_heading_"),
    **{switch: (begin,) for switch, begin in FAULT_SWITCHES.items()},
}
"""How the names of the parameters begin that only have an effect where another is above 0, or true."""
_SHARED: Final = ("imu_frame",)
"""Names that begin so, and mean other sensors as well."""


def without_effect(values: Mapping[str, Value]) -> str:
    """What is asked of sensors and faults that are off, in a sentence without a full stop; empty if nothing.

    A grade asks for nothing: it is that of whichever sensors there are.

    Parameters
    ----------
    values : mapping of str to value
        Every one of ``SENSOR_PARAMETERS``.
    """
    usual = {**{p.name: p.default for p in SENSOR_PARAMETERS}, **GRADES[str(values[GRADE])], GRADE: values[GRADE]}
    asked = [name for name, value in values.items() if value != usual[name] and name not in _SHARED]
    sentences = []
    for switch in (switch for switch in _SWITCHES if not values[switch]):
        names = [name for name in asked if name.startswith(_SWITCHES[switch])]
        asked = [name for name in asked if name not in names]  # those of a sensor that is off are not told twice
        if names:
            sentences.append(f"{_idle(names)}, as {switch} is {'false' if values[switch] is False else 0}")
    window = [name for name in asked if name in WINDOW]
    if window and not any(values[switch] for switch in FAULT_SWITCHES):
        sentences.append(f"{_idle(window)}, as no fault that comes and goes is on")
    return f"{'; '.join(sentences)}: give what switches them on" if sentences else ""


def _idle(names: list[str]) -> str:
    return f"{listed(names)} {'have' if len(names) > 1 else 'has'} no effect"


SensorModel: TypeAlias = ImuModel | MagnetometerModel | AttitudeSensorModel | SunSensorModel


@dataclass(frozen=True)
class Sensors:
    """The sensors on the body. Build them with `from_parameters`, which validates.

    Parameters
    ----------
    imu : ImuModel or None
    magnetometer : MagnetometerModel or None
    attitude_sensor : AttitudeSensorModel or None
    sun_sensor : SunSensorModel or None
        None: there is none.
    """

    imu: ImuModel | None = None
    magnetometer: MagnetometerModel | None = None
    attitude_sensor: AttitudeSensorModel | None = None
    sun_sensor: SunSensorModel | None = None

    __repr__ = short_repr

    @classmethod
    def from_parameters(cls, given: Mapping[str, object] | None = None) -> Sensors:
        """The sensors of the given parameters, the rest at their defaults, validated as a whole.

        Parameters
        ----------
        given : mapping of str to object, optional
            Values of ``SENSOR_PARAMETERS``, as a YAML file or a ROS parameter gives them.

        Returns
        -------
        Sensors

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy; also for a sensor that is off.
        """
        return cls.from_values(read_table(SENSOR_PARAMETERS, graded(given or {})))

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> Sensors:
        """The sensors of all their parameters, each in its own type; see `from_parameters`."""
        require_frame_name("imu_frame", cast(str, values["imu_frame"]))
        models = {name: make(values) for name, make in _MODELS.items()}  # also of those that are off, to refuse them
        return cls(**{name: model for name, model in models.items() if _is_on(f"{name}_rate", values)})

    @property
    def on(self) -> dict[str, SensorModel]:
        """The sensors that there are, by name."""
        return {name: model for name in _MODELS if (model := getattr(self, name)) is not None}

    @property
    def have_faults(self) -> bool:
        """Whether any fault is on."""
        return any(faulty is not None for model in self.on.values() for faulty in model.faulty)


_MODELS: Final[dict[str, Callable[[Mapping[str, Value]], Any]]] = {
    "imu": ImuModel.from_values,
    "magnetometer": MagnetometerModel.from_values,
    "attitude_sensor": AttitudeSensorModel.from_values,
    "sun_sensor": SunSensorModel.from_values,
}


def _is_on(name: str, values: Mapping[str, Value]) -> bool:
    rate = cast(float, values[name])
    if 0.0 < rate < SLOWEST_RATE:
        raise ParameterError(name, f"{rate:g} is below {SLOWEST_RATE:g} samples per second: give more, or 0 for none")
    return rate > 0.0
