"""Readings of a run on the topics of their sensors, in lock-step with the filter that answers them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from itertools import groupby
from operator import attrgetter
from queue import Empty, SimpleQueue
from typing import Final

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from lie_rigid_body.estimates.programs import Answered, NodeEstimator, Reading
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.ros.answers import Answers
from lie_rigid_body.ros.publishing.publisher import CLOCK, DEPTH, clock_bytes
from lie_rigid_body.ros.session import message_class, own_node
from lie_rigid_body.ros.timing.lockstep import LOOK_NS, Lockstep
from lie_rigid_body.sensors import SENSORS

SILENCE_S: Final = 10.0
"""Longest wait for an answer, s; at most half of the time of a run."""


def answers_to(estimator: NodeEstimator, readings: Sequence[Reading], require_alive: Callable[[], None]) -> Answered:
    """Play readings to the filter of this domain.

    Parameters
    ----------
    estimator : NodeEstimator
        Of the filter.
    readings : sequence of Reading
    require_alive : callable
        Raises an error once the filter has ended.

    Raises
    ------
    LieRigidBodyError
        If no filter appears, or it leaves a reading without an answer.
    """
    with own_node("lie_rigid_body") as node:
        player = Player(node, estimator, readings, require_alive)
        with closing(player.answers):
            return player.played()


class Player:
    """The loop that publishes readings, each time after the clock, and takes their answers.

    Parameters
    ----------
    node : Node
    estimator : NodeEstimator
    readings : sequence of Reading
    require_alive : callable

    Attributes
    ----------
    answers : Answers
    """

    def __init__(
        self, node: Node, estimator: NodeEstimator, readings: Sequence[Reading], require_alive: Callable[[], None]
    ) -> None:
        self._readings = readings
        self._require_alive = require_alive
        self._longest_s = estimator.timeout_s / 2.0
        self._topics = {reading.sensor: SENSORS[reading.sensor].topics[0] for reading in readings}
        quality = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        self._publishers = {
            topic.name: node.create_publisher(message_class(topic.message_type), topic.name, quality)
            for topic in self._topics.values()
        }
        self._publishers[CLOCK] = node.create_publisher(Clock, CLOCK, quality)
        self._heard = SimpleQueue[tuple[int, bytes]]()
        self._payloads: list[bytes] = []
        self.answers = Answers(node, self._publishers, estimator.topic, [])
        self.answers.hear = lambda *answer: self._heard.put(answer)

    def played(self) -> Answered:
        """Play all, and return the answers."""
        heard = self._filter()
        lockstep = Lockstep(self.answers.topic, lambda: heard, round(min(SILENCE_S, self._longest_s) * NS))
        lockstep.begin_segment(self._topics)
        for arrival_ns, group in groupby(self._readings, key=attrgetter("arrival_ns")):
            readings = list(group)
            self._publishers[CLOCK].publish(clock_bytes(arrival_ns))
            for reading in readings:
                self._publishers[self._topics[reading.sensor].name].publish(reading.payload)
            lockstep.sent([(reading.sensor, reading.stamp_ns) for reading in readings])
            while lockstep.holds(time.monotonic_ns()):
                self._take(lockstep)
        while not self._heard.empty():
            self._take(lockstep)
        if not self._payloads:
            raise LieRigidBodyError(
                "is given no reading of the IMU with one of the same stamp of every other sensor: give them one rate"
            )
        return Answered(self.answers.topic, self.answers.message_type, self._payloads)

    def _filter(self) -> list[str]:
        """Names of the sensors that the filter hears, once it is there."""
        end = time.monotonic() + self._longest_s
        while (heard := self.answers.look()) is None:
            self._require_alive()
            if time.monotonic() > end:
                missing = ", ".join(self.answers.missing)
                raise LieRigidBodyError(
                    f"is not there after {self._longest_s:g} s: missing: {missing}: remap its topics"
                )
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
