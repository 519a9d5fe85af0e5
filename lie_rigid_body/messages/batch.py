"""Batches: the messages of the truth and of the sensors that are published or recorded together."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from operator import itemgetter
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.messages import PoseTwistEncoder, ReadingEncoder, encode_strings
from lie_rigid_body.messages.definitions import STRING
from lie_rigid_body.messages.layout import Payloads
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Sensors
from lie_rigid_body.sensors.fault import LONGEST_TEXT
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.simulation import Samples, Taken

POSE: Final = "pose"
TWIST: Final = "twist"
FAULTS: Final = "~/faults"


SENSOR_TOPICS: Final[Mapping[str, str]] = ChainMap({FAULTS: STRING}, SENSORS.topics)
"""Message types of the topics of all sensors, by their relative names; a view, as the table of sensors may grow.

Messages of equal times come in this order, after those of the truth.
"""


@short_dataclass(frozen=True)
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
        template, words = parts[0].payloads.template, np.concatenate([part.payloads.words for part in parts])
        return cls(parts[0].topic, np.concatenate([part.times_ns for part in parts]), Payloads(template, words))


@short_dataclass(frozen=True)
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
        parts, self._parts, self.message_count = self._parts, {}, 0
        order = dict.fromkeys((POSE, TWIST, *SENSOR_TOPICS, *parts))
        return [Messages.joined(parts[topic]) for topic in order if topic in parts]


def sensor_topics(sensors: Sensors) -> list[str]:
    """Relative names of the topics that the sensors of a scenario have."""
    topics = [topic.name for name in sensors.on for topic in SENSORS[name].topics]
    return [*topics, FAULTS] if sensors.have_faults else topics


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

    def encode(self, taken: Taken) -> Batch:
        """Encode samples and readings that were taken at once, with the frames of their own scenario."""
        if taken.scenario is not None and taken.scenario is not self._scenario:
            self._begin(taken.scenario)
        return Batch(taken.samples, tuple(self._topics(taken)))

    def _topics(self, taken: Taken) -> Iterator[Messages]:
        yield Messages(POSE, taken.samples.stamps_ns, self._truth.poses(taken.samples))
        yield Messages(TWIST, taken.samples.stamps_ns, self._truth.twists(taken.samples))
        for name, samples in taken.sensors.items():
            for encoder in self._sensors[name] if len(samples) else ():
                yield Messages(encoder.topic.name, samples.times_ns, encoder.encode(samples))
        if taken.faults:
            begins = np.array([fault.begin_ns for fault in taken.faults], dtype=np.int64)
            yield Messages(FAULTS, begins, encode_strings([fault.to_json() for fault in taken.faults], LONGEST_TEXT))
