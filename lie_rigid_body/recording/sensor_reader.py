"""Reading the sensors of a run, and their faults, from a bag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.messages import numbers_of
from lie_rigid_body.messages.definitions import places
from lie_rigid_body.recording.track_decoding import TopicMessages
from lie_rigid_body.sensors import SENSORS, Fault, Field, Topic
from lie_rigid_body.wording import short_repr

SensorMessages: TypeAlias = TopicMessages
"""Messages of a sensor's topic; their values are the numbers of `varying_fields` one after the other."""


@dataclass(frozen=True)
class FaultMessages:
    """Messages of the topic of faults, in file order.

    Attributes
    ----------
    log_times_ns : ndarray of int64, shape (N,)
    texts : tuple of str
    """

    log_times_ns: Integers
    texts: tuple[str, ...]

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.texts)

    @classmethod
    def of(cls, found: Sequence[tuple[int, str]]) -> FaultMessages:
        """Make them of pairs of log time, ns, and text."""
        return cls(np.array([time for time, _ in found], dtype=np.int64), tuple(text for _, text in found))


def varying_fields(message_type: str) -> Booleans:
    """Mask of the float64 numbers of a type that differ between messages on any topic of a sensor, shape (K,)."""
    numbers = np.full(len(places(message_type)[""]), fill_value=False)
    for sensor in SENSORS.values():
        for topic in sensor.topics:
            if topic.message_type == message_type:
                for field in topic.fields:
                    numbers[list(numbers_of(topic, field))] = True
    return numbers


def value_columns(topic: Topic, field: Field) -> Integers:
    """Columns of a field among the values of the `SensorMessages` of a topic."""
    varying = np.flatnonzero(varying_fields(topic.message_type))
    return np.asarray(np.searchsorted(varying, numbers_of(topic, field)), dtype=np.int64)


def fixed_number(messages: SensorMessages, message_type: str, number: int) -> Array:
    """Float64 number of each message that is no value of it, shape (N,)."""
    place = int(np.count_nonzero(~varying_fields(message_type)[:number]))
    fixed = np.array([np.frombuffer(bits)[place] for _, bits in messages.kinds], dtype=np.float64)
    return np.asarray(fixed[messages.kind])


def no_messages(message_type: str) -> SensorMessages:
    """Messages of a topic of which there is none."""
    none, width = np.empty(0, dtype=np.int64), np.count_nonzero(varying_fields(message_type))
    return SensorMessages(none, none, np.empty((0, width)), (), none)


def recorded_faults(name: str, told: FaultMessages) -> tuple[Fault, ...]:
    """The faults that messages of a bag of that name tell of, in file order; repeats of a text count once.

    Raises
    ------
    BagError
        If a message tells of none.
    """
    try:
        return tuple(map(Fault.from_json, dict.fromkeys(told.texts)))
    except InputError as error:
        raise BagError(f"{name}: {error}") from None
