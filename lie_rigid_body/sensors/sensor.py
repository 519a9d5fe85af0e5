"""What a sensor is: its model, the instrument that measures, its readings, its topics, and its entry in the table."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Protocol

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.parameters import Parameter, Value, Vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.fault_parameters import delivery_parameters
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class Readings:
    """Readings of a sensor, one row of each array for each reading.

    Parameters
    ----------
    arrays : mapping of str to ndarray, shape (N, ...)
        What was read, by the names that `Field.array` gives.
    """

    arrays: Mapping[str, Array]

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(next(iter(self.arrays.values())))

    def __getitem__(self, rows: slice | Booleans) -> Readings:
        return Readings({name: array[rows] for name, array in self.arrays.items()})

    def joined(self, later: Readings) -> Readings:
        """These readings followed by later ones of the same arrays."""
        return Readings({name: np.concatenate([array, later.arrays[name]]) for name, array in self.arrays.items()})


@dataclass(frozen=True)
class Signal:
    """One quantity of an instrument before its converter.

    Parameters
    ----------
    values : ndarray, shape (N, ...)
        In the unit of the reading.
    converter : Converter or None
        What makes readings of it; None: they are the same.
    """

    values: Array
    converter: Converter | None = None

    __repr__ = short_repr

    def read(self) -> Array:
        """The readings, of the shape of the values."""
        return self.values if self.converter is None else self.converter.read(self.values)


class Instrument(ABC):
    """A sensor at work: readings in order, the same to the bit in batches of any size."""

    __copy__ = copy.deepcopy  # it goes on by itself

    @abstractmethod
    def signals(self, times_ns: Integers, states: State) -> dict[str, Signal]:
        """The next readings before their converters, by the names of their arrays; see `measure`."""

    def measure(self, times_ns: Integers, states: State) -> Readings:
        """The next readings.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        states : State
            The body's states at those times, of shapes (N, 4) and (N, 3).

        Returns
        -------
        Readings

        Raises
        ------
        InputError
            If the instrument integrates over time and the times do not rise.
        """
        return Readings({name: signal.read() for name, signal in self.signals(times_ns, states).items()})

    @abstractmethod
    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; of an axis that is stuck the next ones are then not those of `measure`.

        Parameters
        ----------
        count : int
        before_ns : int
            Time of the last of them since the segment's start, ns.
        before : State
            The body's state at that time. Only an instrument that integrates over time looks at it.
        """


@dataclass(frozen=True)
class VectorAid:
    """A vector known in the world that a sensor reads in the body frame: it tells of the attitude.

    Parameters
    ----------
    reference : tuple of float, length 3
        The vector in the world frame, in any unit.
    noise : float
        Standard deviation of a reading on each axis, same unit.
    turn_on_bias : float
        Standard deviation of the bias at the start on each axis, same unit.
    bias_step : float
        Standard deviation of the bias' change from one reading to the next on each axis, same unit.
    """

    reference: Vector
    noise: float
    turn_on_bias: float = 0.0
    bias_step: float = 0.0

    __repr__ = short_repr

    @property
    def is_exact(self) -> bool:
        """Whether there is no noise."""
        return not self.noise


@dataclass(frozen=True)
class AttitudeAid:
    """An attitude that a sensor reads, worst about one axis of the body.

    Parameters
    ----------
    axis : tuple of float, length 3
        A unit vector in the body frame.
    about, across : float
        Standard deviations of a small rotation about that axis and about each one across it, rad.
    """

    axis: Vector
    about: float
    across: float

    __repr__ = short_repr

    @property
    def is_exact(self) -> bool:
        """Whether a rotation about some axis has no noise."""
        return not (self.about and self.across)


@dataclass(frozen=True)
class SensorModel(ABC):
    """A sensor as its parameters describe it; each kind adds what is particular to it.

    Parameters
    ----------
    rate : float
        Readings per second.
    seed : int
        Seed of its noise.
    delivery : Delivery or None
        What goes wrong on the way of its readings; None: nothing does.
    """

    rate: float
    seed: int
    _: KW_ONLY
    delivery: Delivery | None = None

    __repr__ = short_repr

    @classmethod
    @abstractmethod
    def from_values(cls, values: Mapping[str, Value]) -> SensorModel:
        """The model of the parameters' values, validated.

        Raises
        ------
        ParameterError
            If a value is invalid.
        """

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """What may have faults."""
        return (self.delivery,)

    @property
    def aids(self) -> tuple[VectorAid | AttitudeAid, ...]:
        """What its readings tell of the attitude, for the error that no estimator can avoid."""
        return ()

    def refusal(self, fastest: float) -> ParameterError | None:
        """The error of a body whose rate reaches ``fastest``, rad/s, if the sensor cannot follow it."""
        return None


class _ExactMotion(Protocol):
    def at(self, t_ns: int) -> State:
        """The state at a time since the start, ns."""
        ...


class Carrier(Protocol):
    """What carries a sensor: a body and its motion, as a `Scenario` has them."""

    def body(self) -> RigidBody:
        """The body."""
        ...

    def start(self) -> State:
        """The state at the start."""
        ...

    def exact_motion(self) -> _ExactMotion:
        """The exact motion from the start, at times before it as well."""
        ...


@dataclass(frozen=True)
class Field:
    """A field of a sensor's message that differs from reading to reading.

    Parameters
    ----------
    array : str
        Name of the array of the readings, and of `Run`, that it holds.
    place : str
        Where it is in the message: names of ROS with dots between them, such as ``pose.pose.orientation``.
    unit : str
        Unit of its numbers; empty for quaternions and unit vectors.
    quantity : str
        What the certificate calls it.
    covariance : str
        The field that tells its covariance. Where that begins with −1, the message does not tell this field (REP-145).
        Empty: it always does.
    numbers : tuple of int
        Which of the field's float64 numbers it has; empty: all.
    shape : tuple of int
        Shape of a row of the array, where that is no vector.
    """

    array: str
    place: str
    unit: str
    quantity: str
    covariance: str = ""
    numbers: tuple[int, ...] = ()
    shape: tuple[int, ...] = ()

    __repr__ = short_repr


def diagonal(variance: float) -> tuple[float, ...]:
    """The covariance of three independent components of a variance, row by row."""
    return (variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance)


def _nothing(model: Any) -> Mapping[str, tuple[float, ...]]:
    return {}


@dataclass(frozen=True)
class Topic:
    """A topic of a sensor: messages of a std_msgs/Header and float64 numbers.

    Parameters
    ----------
    name : str
        Its relative name.
    message_type : str
        Such as ``sensor_msgs/msg/Imu``.
    title : str
        What the certificate calls its fields that are the same in every message.
    fields : tuple of Field
        Those that differ.
    frame : str
        Name of the parameter that names the frame of its headers.
    fixed : callable
        ``fixed(model)`` gives the numbers of fields that are the same in every message, by their places; others are 0.
    """

    name: str
    message_type: str
    title: str
    fields: tuple[Field, ...]
    frame: str = "body_frame"
    fixed: Callable[[Any], Mapping[str, tuple[float, ...]]] = _nothing

    __repr__ = short_repr


@dataclass(frozen=True)
class Sensor:
    """An entry of the table of sensors: all that is particular to one.

    Parameters
    ----------
    name : str
        Its name: that of its parameters begins so, and ``NAME_rate`` switches it on.
    title : str
        What tables and sentences call it.
    model : type of SensorModel
    make : callable
        ``make(model, carrier, before_ns)`` gives the `Instrument` of a segment. Its first reading comes one interval
        after ``before_ns``, ns since the start, which may be negative.
    topics : tuple of Topic
        The first one has the readings; others tell more of them, at the same stamps.
    parameters : tuple of Parameter
        Those that the text of a scenario leaves out at their defaults, so that it is the same as without the sensor.
    told : tuple of Parameter
        Those that it always tells.
    faults : tuple of Parameter
        Those of its faults, beside the delivery's.
    parts : tuple of str
        Parts of it that have faults of their own. The order is part of the keys of the random numbers.
    attribute : str
        Its name in `Run`; empty: ``name``.
    prefixes : tuple of str
        How the names of the parameters begin that have no effect without it; empty: ``NAME_``.
    switches : mapping of str to tuple of str
        Further parameters that switch something on, and how the names of those begin that have no effect without.
    """

    name: str
    title: str
    model: type[SensorModel]
    make: Callable[[Any, Carrier, int], Instrument]
    topics: tuple[Topic, ...]
    parameters: tuple[Parameter, ...] = ()
    told: tuple[Parameter, ...] = ()
    faults: tuple[Parameter, ...] = ()
    parts: tuple[str, ...] = ()
    attribute: str = ""
    prefixes: tuple[str, ...] = ()
    switches: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    __repr__ = short_repr

    @property
    def switch(self) -> str:
        """Name of the parameter that switches it on."""
        return f"{self.name}_rate"

    @property
    def key(self) -> str:
        """Its name in `Run`."""
        return self.attribute or self.name

    @property
    def all_faults(self) -> tuple[Parameter, ...]:
        """The parameters of its delivery and of its other faults."""
        return (*delivery_parameters(self.name, self.title), *self.faults)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters that are its own."""
        return tuple(parameter.name for parameter in (*self.told, *self.parameters, *self.all_faults))
