"""Readings of a run on the topics of their sensors, in lock-step with the filter that answers them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from itertools import groupby
from operator import attrgetter
from queue import Empty, SimpleQueue
from typing import Final

import rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.parameters import NS
from lie_rigid_body.ros.answers import Answers
from lie_rigid_body.ros.publishing.publisher import CLOCK, DEPTH, clock_bytes, message_class
from lie_rigid_body.ros.session import destroying, initialised, translated_errors
from lie_rigid_body.ros.timing.lockstep import LOOK_NS, Lockstep
from lie_rigid_body.runs.node import Answered, Play, Reading
from lie_rigid_body.sensors import SENSORS

SILENCE_S: Final = 10.0
"""Longest wait for an answer, s; at most half of the time of a run."""
FIRST_S: Final = 1.0
"""Longest wait for the answer to the first reading, s, by which some filters only begin."""


class ReadingPublisher:
    """The publishers of sensors, and of the clock.

    Parameters
    ----------
    node : Node
    sensors : iterable of str
        Names of the sensors.

    Attributes
    ----------
    sensor_topics : dict of str to str
        Full names of the topics of all sensors by their relative names.
    publishers : dict of str to Publisher
        Publishers by the full names of their topics.
    """

    def __init__(self, node: Node, sensors: Iterable[str]) -> None:
        quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        topics = {name: SENSORS[name].topics[0] for name in sensors}
        self._of_sensor: dict[str, Publisher] = {
            name: node.create_publisher(message_class(topic.message_type), topic.name, quality)
            for name, topic in topics.items()
        }
        self._clock = node.create_publisher(Clock, CLOCK, quality)
        self.sensor_topics = {name: node.resolve_topic_name(name) for name in SENSORS.topics}
        self.publishers = {each.topic_name: each for each in (*self._of_sensor.values(), self._clock)}

    def send(self, arrival_ns: int, readings: Iterable[Reading]) -> None:
        """Publish the time, and the readings that arrive then."""
        self._clock.publish(clock_bytes(arrival_ns))
        for reading in readings:
            self._of_sensor[reading.sensor].publish(reading.payload)


def answers_to(play: Play, require_alive: Callable[[], None]) -> Answered:
    """Play readings to the filter of this domain.

    Parameters
    ----------
    play : Play
    require_alive : callable
        Raises an error once the filter has ended.

    Raises
    ------
    LieRigidBodyError
        If no filter appears, or it leaves a reading without an answer.
    """
    with initialised([]):
        with translated_errors("a node"):
            node = rclpy.create_node("lie_rigid_body", start_parameter_services=False)
        with destroying(node):
            publisher = ReadingPublisher(node, dict.fromkeys(reading.sensor for reading in play.readings))
            answers = Answers(node, publisher, play.node.topic, [])
            try:
                return Player(play, publisher, answers, require_alive).played()
            finally:
                answers.close()


class Player:
    """The loop that publishes readings and takes their answers.

    Parameters
    ----------
    play : Play
    publisher : ReadingPublisher
    answers : Answers
    require_alive : callable
    """

    def __init__(
        self, play: Play, publisher: ReadingPublisher, answers: Answers, require_alive: Callable[[], None]
    ) -> None:
        self._play, self._publisher, self._answers, self._require_alive = play, publisher, answers, require_alive
        self._longest_s = play.node.timeout_s / 2.0
        self._heard = SimpleQueue[tuple[int, bytes]]()
        self._payloads: list[bytes] = []
        answers.tell(lambda *answer: self._heard.put(answer))

    def played(self) -> Answered:
        """Play all, and return the answers."""
        heard = self._filter()
        patience_ns = round(min(SILENCE_S, self._longest_s) * NS)
        lockstep = Lockstep(self._answers.topic, lambda: heard, patience_ns)
        lockstep.begin_segment({reading.sensor for reading in self._play.readings})
        begun = time.monotonic()
        for arrival_ns, group in groupby(self._play.readings, key=attrgetter("arrival_ns")):
            readings = list(group)
            self._publisher.send(arrival_ns, readings)
            lockstep.sent([(reading.sensor, reading.stamp_ns) for reading in readings])
            while lockstep.holds(time.monotonic_ns()):
                self._take(lockstep)
                if not self._payloads and time.monotonic() > begun + FIRST_S:
                    lockstep.give_up()
                    begun = float("inf")
        while not self._heard.empty():
            self._take(lockstep)
        if not self._payloads:
            raise LieRigidBodyError("is given no reading of the IMU with one of the same stamp of every other sensor")
        return Answered(self._answers.topic, self._answers.message_type, self._payloads)

    def _filter(self) -> list[str]:
        """Names of the sensors that the filter hears, once it is there."""
        end = time.monotonic() + self._longest_s
        while (heard := self._answers.look()) is None:
            self._require_alive()
            if time.monotonic() > end:
                missing = ", ".join(self._answers.missing)
                raise LieRigidBodyError(f"is not there after {self._longest_s:g} s: missing is {missing}")
            time.sleep(LOOK_NS / NS)
        return list(heard)

    def _take(self, lockstep: Lockstep) -> None:
        """Take an answer, if there is one soon."""
        try:
            stamp_ns, payload = self._heard.get(timeout=LOOK_NS / NS)
        except Empty:
            self._require_alive()
            return
        self._payloads.append(payload)
        lockstep.hear(stamp_ns)
