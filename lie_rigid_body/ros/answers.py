"""The answers of a filter in lock-step: who takes part, whether all of them hear, and the stamps of the estimates."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from threading import Thread
from typing import Any, Final

import rclpy
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.subscription import Subscription

from lie_rigid_body.foundation.errors import BagError, ParameterError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.messages.decoding import byte_order
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.recording.topic_messages import ATTITUDE_TYPES, wrong_type
from lie_rigid_body.ros.following import subscribe
from lie_rigid_body.ros.publishing.publisher import IMU_TOPIC
from lie_rigid_body.ros.session import destroying, listening, translated_errors
from lie_rigid_body.ros.timing.lockstep import LOOK_NS
from lie_rigid_body.sensors import SENSORS

QUIET_S: Final = 1.0
"""Time in which nothing may have changed before lock-step begins, s: what a node hears becomes known by and by."""


class Answers:
    """The topic on which a filter answers, and the nodes that take part.

    Parameters
    ----------
    node : Node
        The simulator's.
    publishers : mapping of str to Publisher
        Those of the readings among others, by the relative names of their topics; there may be more of them later.
    topic : str
        The filter's topic.
    nodes : sequence of str
        Names of the nodes that have to hear, beside the filter.

    Attributes
    ----------
    topic, message_type : str
        Full name of the filter's topic, and its type once it is there.
    missing : list of str
        Who was missing when `look` looked.
    hear : callable
        It is called with the stamp of each estimate, ns, and its message, in a thread of its own.

    Raises
    ------
    InputError
        If a name is none of ROS, the topic is one of the simulator's own, or there is no IMU.
    """

    def __init__(self, node: Node, publishers: Mapping[str, Publisher], topic: str, nodes: Sequence[str]) -> None:
        self._node = node
        self._publishers = publishers
        with translated_errors(f"lockstep_topic {topic!r}"):
            self.topic = node.resolve_topic_name(topic)
        with translated_errors(f"lockstep_nodes {', '.join(nodes)!r}"):
            self._nodes = [node.resolve_topic_name(name, only_expand=True) for name in nodes]
        if IMU_TOPIC not in publishers:
            raise ParameterError("lockstep_topic", f"{topic} can answer no reading without an IMU: give imu_rate")
        if self.topic in {publisher.topic_name for publisher in publishers.values()}:
            raise ParameterError("lockstep_topic", f"{topic} is a topic of this node itself: give that of a filter")
        self._imu = publishers[IMU_TOPIC].topic_name
        self.hear: Callable[[int, bytes], object] = lambda stamp_ns, payload: None
        self.message_type = ""
        self._subscription: Subscription | None = None
        self._thread: Thread | None = None
        self._closed = False
        self.missing: list[str] = []
        self._parts: Mapping[str, set[str]] = {}
        self._since = 0.0

    def look(self) -> Collection[str] | None:
        """Look for all who take part, and log who is missing.

        Returns
        -------
        collection of str, or None
            Names of the sensors that the filter hears; None as long as somebody is missing.

        Raises
        ------
        InputError
            If the topic is of a type that holds no attitude.
        """
        published = self._node.get_publishers_info_by_topic(self.topic)
        for info in published:
            self._listen(info.topic_type)
        asked = {
            topic: self._node.get_subscriptions_info_by_topic(topic)
            for topic in (self.topic, *(publisher.topic_name for publisher in self._publishers.values()))
        }
        hearers = {topic: _names(infos) for topic, infos in asked.items()}
        answering = [info for info in published if _names([info]) <= hearers[self._imu]]
        filters = _names(answering)
        parts = filters.union(self._nodes)
        missing = [*self._missing(len(answering), len(published), hearers), *self._unmatched(parts, asked)]
        present = {topic: parts & names for topic, names in hearers.items()}
        if (present, missing) != (self._parts, self.missing):
            if missing and missing != self.missing:
                self._node.get_logger().info(f"lock-step waits for {', '.join(missing)}")
            self._parts = present
            self.missing = missing
            self._since = time.monotonic()
        if missing or time.monotonic() < self._since + QUIET_S:
            return None
        [name] = filters
        topics = {topic: publisher.topic_name for topic, publisher in self._publishers.items()}
        heard = [s for s in SENSORS if any(name in hearers.get(topics.get(t.name, ""), ()) for t in SENSORS[s].topics)]
        self._node.get_logger().info(f"lock-step with {name}, which hears {listed(heard)} and answers on {self.topic}")
        return heard

    def _listen(self, kind: str) -> None:
        if kind not in ATTITUDE_TYPES:
            raise ParameterError("lockstep_topic", f"{self.topic} {wrong_type(kind)}")
        if self._subscription is None:
            self.message_type = kind
            ear = rclpy.create_node(
                f"_{self._node.get_name()}_answers",
                namespace=self._node.get_namespace(),
                context=self._node.context,
                use_global_arguments=False,
                start_parameter_services=False,
            )
            hear = partial(self._take, 8 if kind == TF_MESSAGE else 4)
            self._subscription = subscribe(ear, self.topic, kind, hear)
            self._thread = Thread(target=self._listen_on, args=(ear,), name="answers", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Listen no more; to be called before rclpy is shut down."""
        self._closed = True
        if self._thread is not None:
            self._thread.join()

    def _listen_on(self, ear: Node) -> None:
        """Take the answers by a node of their own: the executor of one with services takes a millisecond for each."""
        with destroying(ear), listening(ear) as spin:
            while not self._closed:
                spin(LOOK_NS / NS)

    def _take(self, offset: int, payload: bytes) -> None:
        """Hand on a message with its stamp, which stands behind so many bytes."""
        with suppress(BagError, struct.error):  # of a message without a stamp
            seconds, nanoseconds = struct.unpack_from(f"{byte_order(payload, 0)}iI", payload, offset)
            self.hear(seconds * NS + nanoseconds, payload)

    def _missing(self, answering: int, published: int, hearers: Mapping[str, set[str]]) -> Iterator[str]:
        if answering != 1:  # two nodes may have one name
            yield f"one node that publishes {self.topic} and hears {self._imu}, of which there are {answering}"
        elif self._subscription is None or self._subscription.get_publisher_count() < published:
            yield f"a match of {self.topic}"
        for name in self._nodes:
            if not any(name in names for names in hearers.values()):
                yield f"subscriptions of {name}"

    def _unmatched(self, parts: Collection[str], asked: Mapping[str, Sequence[Any]]) -> Iterator[str]:
        """Topics that somebody who takes part may not hear yet: the middleware counts its matches, and names none."""
        for publisher in self._publishers.values():
            topic = publisher.topic_name
            offered = publisher.qos_profile.durability
            fitting = [i for i in asked[topic] if i.qos_profile.durability in (offered, DurabilityPolicy.VOLATILE)]
            wanted = _names(asked[topic]).intersection(parts)
            if wanted and (wanted - _names(fitting) or publisher.get_subscription_count() < len(fitting)):
                yield f"a match of {topic}"


def _names(endpoints: Iterable[Any]) -> set[str]:
    """Full names of the nodes of endpoints."""
    return {f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in endpoints}
