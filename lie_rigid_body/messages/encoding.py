"""Samples as the bytes of ROS 2 messages: poses, twists, readings of sensors, transforms and texts."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import lru_cache
from itertools import compress
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
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
from lie_rigid_body.sensors import Field, SensorModel, Topic
from lie_rigid_body.simulation import Samples, SensorSamples

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
        # position and linear velocity stay zero; the rotation's numbers follow them
        self._pose = Layout(header(scenario.world_frame), [0.0] * POSE_NUMBERS, [range(3, 7)])
        twist = ([0.0] * TWIST_NUMBERS, [range(3, 6)])
        stamped = scenario.stamped_twist
        self._twist = Layout(header(scenario.body_frame), *twist) if stamped else Layout(ENCAPSULATION, *twist, None)

    def poses(self, samples: Samples) -> Payloads:
        """Encode one geometry_msgs/PoseStamped for each sample, with the position 0."""
        return self._pose.encode(samples.stamps_ns, samples.states.attitude_xyzw)

    def twists(self, samples: Samples) -> Payloads:
        """Encode one geometry_msgs/TwistStamped or Twist for each sample, with the linear velocity 0."""
        return self._twist.encode(samples.stamps_ns, samples.states.body_rate)


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
        self.topic, self.frame = topic, scenario.frame(topic.frame)
        self.numbers, self.fields = fixed_numbers(topic, model), told_fields(topic, model)
        places = [numbers_of(topic, field) for field in self.fields]
        self._layout, self._widths = Layout(header(self.frame), self.numbers, places), list(map(len, places))

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
    places, numbers = definitions.places(topic.message_type), fixed_numbers(topic, model)
    is_told = [not f.covariance or numbers[places[f.covariance].start] != NOT_GIVEN for f in topic.fields]
    return tuple(compress(topic.fields, is_told))


def numbers_of(topic: Topic, field: Field) -> Sequence[int]:
    """Places of a field among the float64 numbers of a topic's messages."""
    place = definitions.places(topic.message_type)[field.place]
    return [place[i] for i in field.numbers] or place


class TransformEncoder:
    """Attitudes as tf2_msgs/TFMessage, each with one transform and no translation.

    Parameters
    ----------
    frame, child_frame : str
        Frame names: an attitude takes components in ``child_frame`` to those in ``frame``.
    """

    def __init__(self, frame: str, child_frame: str) -> None:
        head = ENCAPSULATION + _ONE_TRANSFORM + bytes(8) + text(frame)
        head = head.ljust(-(-len(head) // 4) * 4, b"\x00") + text(child_frame)
        self._layout = Layout(head, [0.0] * POSE_NUMBERS, [range(3, 7)], len(ENCAPSULATION + _ONE_TRANSFORM))

    def encode(self, stamps_ns: Integers, attitude_xyzw: Array) -> Payloads:
        """Encode one message for each sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        attitude_xyzw : ndarray, shape (N, 4)

        Returns
        -------
        Payloads
        """
        return self._layout.encode(stamps_ns, attitude_xyzw)


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
