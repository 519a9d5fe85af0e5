"""Sensors in general: model, instrument that measures, readings, topics, and entry in the table."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, field, is_dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Names, Vector
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.sensors.fault import FaultModel, TransportFaults
from lie_rigid_body.sensors.parameters import Fields, Parameters, Values, delivery_parameters, values_of
from lie_rigid_body.sensors.signal import Signals

if TYPE_CHECKING:
    from typing_extensions import Self

MAX_HELD_UP: Final = 100_000
"""Largest number of readings that a jitter of the latency may hold up: all are looked at to tell when one arrives."""
BLOCK: Final = 16_384
"""Readings that are measured at once: the signals of more would fill the caches of a processor."""


@short_dataclass
class Carrier:
    """Carrier of sensors: a body, and its acceleration.

    Parameters
    ----------
    body : RigidBody
    acceleration : callable or None
        Acceleration of its mass centre in the world frame, m/s², shape (N, 3), at N times, ns, where something other
        than gravitation makes it; None: nothing does.
    angular_acceleration : callable or None
        Angular acceleration in the body frame, rad/s², shape (N, 3), at N times, ns, of a body that is led along a
        path; None: that of Euler's equations.
    falls : bool
        Whether nothing holds it against gravitation.
    """

    body: RigidBody
    acceleration: Callable[[Integers], Array] | None = None
    angular_acceleration: Callable[[Integers], Array] | None = None
    falls: bool = False


class Instrument(ABC):
    """A sensor at work in one segment: readings in order, the same to the bit in batches of any size."""

    __copy__ = copy.deepcopy  # it goes on by itself

    @abstractmethod
    def signals(self, times_ns: Integers, states: State, first: int) -> Signals:
        """Readings before their converters, by the names of their arrays; see `measure`."""

    def begin_after(self, before_ns: int, state: Callable[[], State]) -> None:  # noqa: B027 (most have nothing to do)
        """Begin with the reading one interval after a time, the first one of a segment.

        Parameters
        ----------
        before_ns : int
            That time since the segment's start, ns; it may be negative.
        state : callable
            Gives the exact state of the body then; most instruments do not look at it.
        """

    def measure(self, times_ns: Integers, states: State, first: int = 0) -> dict[str, Array]:
        """Readings that follow each other, by the names of `Field.array`, one row of each array for each reading.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        states : State
            The body's states at those times, of shapes (N, 4) and (N, 3).
        first : int, optional
            Number of the first of them, counted from 0 in the segment: the one behind the last that was measured.

        Returns
        -------
        dict of str to ndarray, shape (N, ...)
        """
        blocks = [slice(begin, begin + BLOCK) for begin in range(0, max(1, len(times_ns)), BLOCK)]
        signals = (self.signals(times_ns[rows], states[rows], first + rows.start) for rows in blocks)
        parts = [{name: signal.read() for name, signal in of_block.items()} for of_block in signals]
        return parts[0] if len(parts) == 1 else {n: np.concatenate([part[n] for part in parts]) for n in parts[0]}


@short_dataclass
class VectorMeasurement:
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
    linear_errors : ndarray, shape (c, 3, 3)
        Errors of scale, mounting and iron; see `lie_rigid_body.sensors.triad.linear_errors`.
    """

    reference: Vector
    noise: float
    turn_on_bias: float = 0.0
    bias_step: float = 0.0
    linear_errors: Array = field(default_factory=lambda: np.zeros((0, 3, 3)), compare=False)

    @property
    def is_exact(self) -> bool:
        """Whether there is no noise."""
        return not self.noise


@short_dataclass
class AttitudeMeasurement:
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

    @property
    def is_exact(self) -> bool:
        """Whether a rotation about some axis has no noise."""
        return not (self.about and self.across)


@short_dataclass
class SensorModel:
    """A sensor as its parameters describe it; each kind adds what is particular to it.

    Parameters
    ----------
    rate : float
        Readings per second.
    seed : int
        Seed of its noise.
    delivery : TransportFaults or None
        Faults on the way of its readings; None: there are none.
    """

    rate: float
    seed: int
    _: KW_ONLY
    delivery: TransportFaults | None = None

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> Self:
        """Make the model of the parameters' values, and validate it.

        Parameters
        ----------
        sensor : str
            Name of the sensor, with which the names of its parameters begin.
        values : mapping of str to value

        Raises
        ------
        ParameterError
            If a value is invalid, or a jitter holds up more than `MAX_HELD_UP` readings.
        """
        own = values_of(cls, sensor, values)
        parts = cls.parts(sensor, values)
        delivery = TransportFaults.from_values(sensor, values)
        jitter = delivery.latency_jitter if delivery else 0.0
        if own["rate"] * jitter > MAX_HELD_UP:
            raise ParameterError(
                f"{sensor}_latency_jitter",
                f"{jitter:g} s holds up more than {MAX_HELD_UP} readings: give at most {MAX_HELD_UP / own['rate']:g} s",
            )
        return cls(seed=values["sensor_seed"], delivery=delivery, **{**own, **parts})

    @classmethod
    def parts(cls, sensor: str, values: Values) -> Fields:
        """Fields that have no parameter of their name, by their names; see `from_values`."""
        return {}

    @property
    def fault_models(self) -> list[FaultModel]:
        """Parts of the model that have faults."""
        return list(_fault_models_in(self))

    @property
    def measurement_models(self) -> tuple[VectorMeasurement | AttitudeMeasurement, ...]:
        """Vectors and attitudes that its readings tell, from which the smallest error of an estimator follows."""
        return ()

    def refusal(self, fastest: float) -> ParameterError | None:
        """The error of a body whose rate reaches ``fastest``, rad/s, if the sensor cannot follow it."""
        return None


def _fault_models_in(part: object) -> Iterator[FaultModel]:
    for value in vars(part).values():
        if isinstance(value, FaultModel):
            yield value
        elif is_dataclass(value):
            yield from _fault_models_in(value)


@short_dataclass
class Field:
    """A field of a sensor's message that differs from reading to reading.

    Parameters
    ----------
    array : str
        Name of the array with its values, in `SensorSamples` and in `Run`.
    place : str
        Name of the field in the message, with dots between its parts, such as ``pose.pose.orientation``.
    unit : str
        Unit of its numbers; empty for quaternions and unit vectors.
    quantity : str
        Name of the quantity, by which the certificate calls its law.
    covariance : str
        Name of the field with its covariance. Where that begins with −1, the message does not tell this field
        (REP-145). Empty: every message tells it.
    numbers : tuple of int
        Numbers of the message's field that belong to it; empty: all.
    shape : tuple of int
        Shape of a row of the array; empty: a vector.
    """

    array: str
    place: str
    unit: str
    quantity: str
    covariance: str = ""
    numbers: tuple[int, ...] = ()
    shape: tuple[int, ...] = ()


def diagonal(variance: float) -> Vector:
    """Covariance, row by row, of three independent components of one variance."""
    return (variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance)


FixedFields: TypeAlias = Mapping[str, Vector]
"""Fields that are the same in every message, their numbers by their names."""


@short_dataclass
class Topic:
    """A topic of a sensor: messages of a std_msgs/Header and float64 numbers.

    Parameters
    ----------
    name : str
        Relative name of the topic.
    message_type : str
        Name of the type in ROS, such as ``sensor_msgs/msg/Imu``.
    title : str
        Name of the certificate's law of the frame, and of the fields that are the same in every message.
    fields : tuple of Field
        Fields that differ from message to message.
    frame : str
        Name of the parameter whose value is the frame of the headers.
    fixed : callable or None
        ``fixed(model)`` gives the fields that are the same in every message and not 0, their numbers by their names;
        None: there are none.
    """

    name: str
    message_type: str
    title: str
    fields: tuple[Field, ...]
    frame: str = "body_frame"
    fixed: Callable[[Any], FixedFields] | None = None


@short_dataclass
class Sensor:
    """An entry of the table of sensors: everything particular to one sensor.

    Parameters
    ----------
    name : str
        Name, with which the names of its parameters begin. The parameter ``NAME_rate`` switches it on.
    title : str
        Name of the sensor in tables and sentences.
    model : type of SensorModel
    make : callable
        ``make(model, carrier)`` gives the `Instrument` of a segment on a `Carrier`.
    topics : tuple of Topic
        Topics of its messages. The first one has the readings; others tell more of them, at the same stamps.
    parameters : tuple of Parameter
        Its parameters, without those of faults.
    streams : mapping of str to int
        Numbers in the keys of the random numbers of faults: of the sensor, and of each part of it that has faults of
        its own. They are its own for ever.
    faults : tuple of Parameter
        Parameters of its faults, without those of the delivery, which every sensor has.
    attribute : str
        Name of its readings in `Run`; empty: ``name``.
    switches : mapping of str to tuple of str
        Further parameters that switch something on, with the begins of names of parameters that have no effect without.
    """

    name: str
    title: str
    model: type[SensorModel]
    make: Callable[[Any, Carrier], Instrument]
    topics: tuple[Topic, ...]
    parameters: Parameters
    streams: Mapping[str, int]
    faults: Parameters = ()
    attribute: str = ""
    switches: Mapping[str, Names] = field(default_factory=dict)

    @property
    def switch(self) -> str:
        """Name of the parameter that switches it on."""
        return f"{self.name}_rate"

    @property
    def key(self) -> str:
        """Name of its readings in `Run`."""
        return self.attribute or self.name

    @property
    def all_parameters(self) -> Parameters:
        """Every parameter of this sensor alone: its own, and those of its delivery and of its other faults."""
        return (*self.parameters, *delivery_parameters(self.name, self.title), *self.faults)
