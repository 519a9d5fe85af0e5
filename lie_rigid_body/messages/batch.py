"""Samples as the bytes of ROS 2 messages, and batches of them: those that are published or recorded together."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import compress
from operator import itemgetter
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages import definitions
from lie_rigid_body.messages.layout import (
    ENCAPSULATION,
    POSE_NUMBERS,
    TWIST_NUMBERS,
    Layout,
    Payloads,
    Template,
    header,
    text,
)
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Field, SensorModel, Sensors, Topic
from lie_rigid_body.sensors.fault import MAX_FAULT_TEXT
from lie_rigid_body.simulation import Samples, SensorSamples, SimulationStep

POSE: Final = "pose"
TWIST: Final = "twist"
FAULTS_TOPIC: Final = "~/faults"
TF_TOPIC: Final = "/tf"
SENSOR_TOPICS: Final = {**SENSORS.topics, FAULTS_TOPIC: definitions.STRING}
"""Message types of the topics of all sensors, by their relative names.

Messages of equal times come in this order, after those of the truth.
"""
NOT_GIVEN: Final = -1.0
"""First number of a covariance where the message does not give the quantity (REP-145)."""
_ONE_TRANSFORM: Final = struct.pack("<I", 1)


class PoseTwistEncoder:
    """Samples of the truth as geometry_msgs/PoseStamped and TwistStamped or Twist.

    Parameters
    ----------
    scenario : Scenario
        Names the frames, and says whether twists are stamped.
    """

    def __init__(self, scenario: Scenario) -> None:
        rest = [*scenario.initial_position, *[0.0] * (POSE_NUMBERS - 3)]
        moved = [range(3)] if scenario.moves else []
        self._pose = Layout(header(scenario.world_frame), rest, [*moved, range(3, 7)])
        twist = ([0.0] * TWIST_NUMBERS, [*moved, range(3, 6)])
        stamped = scenario.stamped_twist
        self._twist = Layout(header(scenario.body_frame), *twist) if stamped else Layout(ENCAPSULATION, *twist, None)

    def poses(self, samples: Samples) -> Payloads:
        """Encode one geometry_msgs/PoseStamped for each sample."""
        position = [] if samples.centre is None else [samples.centre.position]
        return self._pose.encode(samples.stamps_ns, *position, samples.states.attitude_xyzw)

    def twists(self, samples: Samples) -> Payloads:
        """Encode one geometry_msgs/TwistStamped or Twist for each sample, on the body's axes."""
        velocity = [] if samples.centre is None else [samples.centre.body_velocity(samples.states)]
        return self._twist.encode(samples.stamps_ns, *velocity, samples.states.body_rate)


class ReadingEncoder:
    """Readings of a sensor as the messages of one of its topics.

    Parameters
    ----------
    topic : Topic
    model : SensorModel
    scenario : Scenario
        Names the frame.

    Attributes
    ----------
    topic : Topic
    frame : str
        Name of the frame of their headers.
    numbers : list of float
        The float64 numbers of a message, 0 in the fields that differ from reading to reading.
    fields : tuple of Field
        The fields of the topic that the sensor tells.
    """

    def __init__(self, topic: Topic, model: SensorModel, scenario: Scenario) -> None:
        self.topic = topic
        self.frame = str(scenario.value(topic.frame))
        self.numbers = fixed_numbers(topic, model)
        self.fields = told_fields(topic, model)
        places = [numbers_of(topic, field) for field in self.fields]
        self._layout = Layout(header(self.frame), self.numbers, places)
        self._widths = list(map(len, places))

    def encode(self, samples: SensorSamples) -> Payloads:
        """Encode one message for each reading."""
        pairs = zip(self.fields, self._widths, strict=True)
        return self._layout.encode(
            samples.stamps_ns, *(samples.arrays[f.array].reshape(-1, width) for f, width in pairs)
        )


def fixed_numbers(topic: Topic, model: SensorModel) -> list[float]:
    """float64 numbers of a topic's messages, 0 in the fields that differ from reading to reading."""
    places = definitions.places(topic.message_type)
    numbers = [0.0] * len(places[""])
    for name, values in (topic.fixed(model) if topic.fixed else {}).items():
        numbers[places[name].start : places[name].stop] = values
    return numbers


def told_fields(topic: Topic, model: SensorModel) -> tuple[Field, ...]:
    """Fields of a topic that a sensor tells: all but those whose covariance says that they are not given."""
    places = definitions.places(topic.message_type)
    numbers = fixed_numbers(topic, model)
    is_told = [not f.covariance or numbers[places[f.covariance].start] != NOT_GIVEN for f in topic.fields]
    return tuple(compress(topic.fields, is_told))


def numbers_of(topic: Topic, field: Field) -> Sequence[int]:
    """Places of a field among the float64 numbers of a topic's messages."""
    place = definitions.places(topic.message_type)[field.place]
    return [place[i] for i in field.numbers] or place


class TransformEncoder(Layout):
    """Poses as tf2_msgs/TFMessage, each with one transform, of a position, m, and an attitude.

    Parameters
    ----------
    frame, child_frame : str
        Frame names: an attitude takes components in ``child_frame`` to those in ``frame``, where its origin is at the
        position.
    """

    def __init__(self, frame: str, child_frame: str) -> None:
        head = ENCAPSULATION + _ONE_TRANSFORM + bytes(8) + text(frame)
        head = head.ljust(-(-len(head) // 4) * 4, b"\x00") + text(child_frame)
        super().__init__(head, [0.0] * POSE_NUMBERS, [range(3), range(3, 7)], len(ENCAPSULATION + _ONE_TRANSFORM))


def encode_string(value: str) -> bytes:
    """Encode a text as std_msgs/String."""
    return ENCAPSULATION + text(value)


def encode_strings(values: Sequence[str], length: int) -> Payloads:
    """Encode texts of ASCII as std_msgs/String, with blanks behind each, so that all have one length, characters."""
    data = b"".join(encode_string(value.ljust(length)) for value in values)
    rows = np.frombuffer(data, dtype=np.uint8).reshape(len(values), -1)
    template = _text_template(rows.shape[1])
    return Payloads(template, template.words(rows))


@lru_cache(maxsize=8)
def _text_template(size: int) -> Template:
    """A template of words all along, of which the last may share bytes with the one before."""
    return Template(bytes(size), [(0, size // 8), (size - 8, 1)])


@short_dataclass
class Messages:
    """Messages of one topic.

    Parameters
    ----------
    topic : str
        Relative name of the topic.
    times_ns : ndarray of int64, shape (N,)
        Time at which each is sent and logged, ns; its stamp may be another, where it is late or a clock is wrong.
    payloads : Payloads, N of them
    """

    topic: str
    times_ns: Integers
    payloads: Payloads

    def between(self, begin_ns: int, end_ns: int) -> Messages:
        """Those that are sent from one time on and before another one, ns."""
        inside = (self.times_ns >= begin_ns) & (self.times_ns < end_ns)
        return Messages(
            self.topic, self.times_ns[inside], Payloads(self.payloads.template, self.payloads.words[inside])
        )

    @classmethod
    def joined(cls, parts: Sequence[Messages]) -> Messages:
        """Join messages of one topic and one template."""
        if len(parts) == 1:
            return parts[0]
        template = parts[0].payloads.template
        words = np.concatenate([part.payloads.words for part in parts])
        return cls(parts[0].topic, np.concatenate([part.times_ns for part in parts]), Payloads(template, words))


@short_dataclass
class Batch:
    """The messages of what was taken from a simulation at once.

    Parameters
    ----------
    samples : Samples
    topics : tuple of Messages
        Those of every topic. Messages of equal times come in this order: the truth before sensors.
    """

    samples: Samples
    topics: tuple[Messages, ...]

    def in_order(self) -> list[tuple[int, str, bytes]]:
        """Time, topic and payload of every message; where times are equal, in the order of `topics`."""
        everything = [
            (stamp, messages.topic, payload)
            for messages in self.topics
            for stamp, payload in zip(messages.times_ns.tolist(), messages.payloads, strict=True)
        ]
        return sorted(everything, key=itemgetter(0))


class Gathering:
    """Messages of small batches that wait to be laid out together, as if they were messages of a larger batch.

    Attributes
    ----------
    message_count : int
        Number of messages that wait.
    """

    def __init__(self) -> None:
        self._parts: dict[str, list[Messages]] = {}
        self.message_count = 0

    @property
    def sample_count(self) -> int:
        """Number of samples of the truth that wait."""
        return sum(len(messages.payloads) for messages in self._parts.get(POSE, ()))

    def fits(self, topics: Sequence[Messages]) -> bool:
        """Whether messages have the templates of the messages of their topics that wait."""
        return all(
            parts[0].payloads.template is messages.payloads.template
            for messages in topics
            if (parts := self._parts.get(messages.topic))
        )

    def add(self, topics: Sequence[Messages]) -> None:
        """Take messages of the next batch, which fit."""
        for messages in topics:
            self._parts.setdefault(messages.topic, []).append(messages)
            self.message_count += len(messages.payloads)

    def take(self) -> list[Messages]:
        """Take all messages that wait, by topic, in the order in which messages of equal times come."""
        parts = self._parts
        self._parts = {}
        self.message_count = 0
        order = dict.fromkeys((POSE, TWIST, *SENSOR_TOPICS, *parts))
        return [Messages.joined(parts[topic]) for topic in order if topic in parts]


def sensor_topics(sensors: Sensors) -> list[str]:
    """Relative names of the topics that the sensors of a scenario have."""
    topics = [topic.name for name in sensors.on for topic in SENSORS[name].topics]
    return [*topics, FAULTS_TOPIC] if sensors.has_faults else topics


class BatchEncoder:
    """Samples and readings of a simulation as messages, for publishers or a bag.

    Parameters
    ----------
    scenario : Scenario
        Scenario of samples that do not tell their own.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._begin(scenario)

    def _begin(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._truth = PoseTwistEncoder(scenario)
        self._sensors = {
            name: [ReadingEncoder(topic, model, scenario) for topic in SENSORS[name].topics]
            for name, model in scenario.sensors.on.items()
        }

    def encode(self, taken: SimulationStep) -> Batch:
        """Encode samples and readings that were taken at once, with the frames of their own scenario."""
        if taken.scenario is not None and taken.scenario is not self._scenario:
            self._begin(taken.scenario)
        return Batch(taken.samples, tuple(self._topics(taken)))

    def _topics(self, taken: SimulationStep) -> Iterator[Messages]:
        yield Messages(POSE, taken.samples.stamps_ns, self._truth.poses(taken.samples))
        yield Messages(TWIST, taken.samples.stamps_ns, self._truth.twists(taken.samples))
        for name, samples in taken.sensors.items():
            for encoder in self._sensors[name] if len(samples) else ():
                yield Messages(encoder.topic.name, samples.times_ns, encoder.encode(samples))
        if taken.faults:
            begins = np.array([fault.begin_ns for fault in taken.faults], dtype=np.int64)
            yield Messages(
                FAULTS_TOPIC, begins, encode_strings([fault.to_json() for fault in taken.faults], MAX_FAULT_TEXT)
            )
