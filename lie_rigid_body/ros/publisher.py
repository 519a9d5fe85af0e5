"""The topics of a live run."""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator, Mapping
from itertools import chain, combinations
from typing import Final

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, MagneticField
from std_msgs.msg import String

from lie_rigid_body.errors import InputError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import IMU_BIAS, IMU_DATA, MAG, POSE, TWIST, Batch, sensor_topics
from lie_rigid_body.messages.layout import ENCAPSULATION
from lie_rigid_body.ros.burst import LARGEST_BURST
from lie_rigid_body.ros.punctuality import Punctuality
from lie_rigid_body.ros.refusal import told
from lie_rigid_body.sensors import Sensors
from lie_rigid_body.simulation import Segment

SCENARIO: Final = "~/scenario"
CLOCK: Final = "/clock"
NS: Final = 1_000_000_000
KEPT: Final = 4 * LARGEST_BURST
"""Messages kept for reliable subscribers that have not confirmed them: a burst never overruns the one before."""
CLOCK_KEPT: Final = 3 * KEPT
"""The same for the clock, which ticks for the truth, for the IMU and for the magnetometer."""
BURST_PATIENCE_NS: Final = 10_000_000
"""How long a full burst waits to be confirmed on each topic: one subscriber that hangs must not hold up the others."""
LAST_PATIENCE_NS: Final = 100_000_000
"""The same for the last samples of all."""
LONGEST_GOODBYE_NS: Final = NS
"""For what is not even sent when the node ends."""
IN_TIME_NS: Final = 5_000_000
"""What is no later than this goes out at its own rate: only who catches up has to wait for subscribers."""
LATE_NS: Final = NS
WARNING_INTERVAL_NS: Final = 10 * NS
_NEVER: Final = 2**63
_SENSOR_TYPES: Final[Mapping[str, type]] = {IMU_DATA: Imu, IMU_BIAS: Imu, MAG: MagneticField}


class SamplePublisher:
    """An outlet into topics: the truth, the sensors, the latched scenario and the clock.

    Parameters
    ----------
    node : Node
    stamped_twist : bool
        The type of the twist topic.
    sensors : Sensors
        Those whose topics are there from the start. A segment with others adds theirs.
    clock : bool
        Whether to publish /clock: each stamp once, before what carries it.
    unhurried : bool, optional
        Whether reliable subscribers set the pace: every message is kept until they have all confirmed it, and `ready`
        tells when there is room for more. Without it a subscriber that hangs loses messages, and delays nobody.

    Raises
    ------
    InputError
        If remapping leaves two topics with one name, or a name that is taken by another type.
    """

    def __init__(
        self, node: Node, *, stamped_twist: bool, sensors: Sensors, clock: bool, unhurried: bool = False
    ) -> None:
        self._node = node
        self._history = HistoryPolicy.KEEP_ALL if unhurried else HistoryPolicy.KEEP_LAST
        self._rest: Iterator[tuple[Publisher, bytes]] = iter(())
        self._blocked: tuple[Publisher, bytes] | None = None
        self._logger = node.get_logger()
        _require_distinct({topic: node.resolve_topic_name(topic) for topic in (POSE, TWIST, SCENARIO, *_SENSOR_TYPES)})
        latched = QoSProfile(
            depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        types = {POSE: PoseStamped, TWIST: TwistStamped if stamped_twist else Twist}
        self._publishers = {topic: self._publisher(kind, topic) for topic, kind in types.items()}
        self._scenario = _publisher(node, String, SCENARIO, latched)
        self._clock = self._publisher(Clock, CLOCK, CLOCK_KEPT) if clock else None
        self._clock_ns = 0
        self._add_sensors(sensors)
        self._unsettled = 0
        self._is_limited = True
        self._warned_ns = -WARNING_INTERVAL_NS

    def follow(self, factor: float) -> None:
        """Take a real-time factor; 0: there is none."""
        self._is_limited = factor > 0.0

    def _publisher(self, kind: type, topic: str, depth: int = KEPT) -> Publisher:
        qos = QoSProfile(history=self._history, depth=depth, reliability=ReliabilityPolicy.RELIABLE)
        return _publisher(self._node, kind, topic, qos)

    def _add_sensors(self, sensors: Sensors) -> None:
        for topic in sensor_topics(sensors):
            if topic not in self._publishers:
                self._publishers[topic] = self._publisher(_SENSOR_TYPES[topic], topic)

    @property
    def topics(self) -> tuple[str, str, str]:
        """Full names of the pose, twist and scenario topics, as remapped."""
        return self._publishers[POSE].topic_name, self._publishers[TWIST].topic_name, self._scenario.topic_name

    @property
    def sensor_topics(self) -> dict[str, str]:
        """Full names of the sensors' topics, as remapped, by their relative names; also of sensors that are off."""
        return {topic: self._node.resolve_topic_name(topic) for topic in _SENSOR_TYPES}

    def begin_segment(self, segment: Segment) -> None:
        """Publish the scenario."""
        self._add_sensors(segment.scenario.sensors)
        self._scenario.publish(encode_string(segment.to_json()))

    def write(self, batch: Batch) -> None:
        """Publish messages, oldest first; those for which there is no room wait for `ready`."""
        messages = self._in_order(batch)
        self._rest = messages if self.ready() else chain(self._rest, messages)
        self._send_rest()
        self._unsettled += max(len(batch.samples), *(len(messages.payloads) for messages in batch.sensors), 0)
        if self._unsettled >= LARGEST_BURST and self._history is HistoryPolicy.KEEP_LAST:
            self._settle(BURST_PATIENCE_NS)

    def ready(self) -> bool:
        """Send what waits; return whether there is room for more."""
        return self._send_rest()

    def _in_order(self, batch: Batch) -> Iterator[tuple[Publisher, bytes]]:
        publishers, clock = self._publishers, self._clock
        for stamp, topic, payload in batch.in_order():
            if clock is not None and stamp > self._clock_ns:
                self._clock_ns = stamp
                yield clock, _clock(stamp)
            yield publishers[topic], payload

    def _send_rest(self) -> bool:
        if self._blocked is not None:
            if not self._send(*self._blocked):
                return False
            self._blocked = None
        for message in self._rest:
            if not self._send(*message):
                self._blocked = message
                return False
        return True

    def _send(self, publisher: Publisher, payload: bytes) -> bool:
        """Publish, unless a history that keeps all is full even after a moment (100 ms in Fast DDS)."""
        try:
            publisher.publish(payload)
        except RuntimeError:
            if self._history is HistoryPolicy.KEEP_ALL and self._node.context.ok():
                return False
            raise
        return True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Say it when the samples are late, now and then."""
        late = punctuality.lateness_ns
        if late < IN_TIME_NS and self._is_limited:
            self._unsettled = 0
        if late > LATE_NS and steady_ns - self._warned_ns > WARNING_INTERVAL_NS:
            self._warned_ns = steady_ns
            self._logger.warning(f"{late / NS:.1f} s late, catching up; no sample is left out")
        return _NEVER

    def finish(self) -> None:
        """Let the last samples arrive."""
        end = time.monotonic_ns() + LONGEST_GOODBYE_NS
        while not self.ready() and time.monotonic_ns() < end:
            pass  # each attempt takes its moment
        self._settle(LAST_PATIENCE_NS)

    def _settle(self, patience_ns: int) -> None:
        self._unsettled = 0
        end = time.monotonic_ns() + len(self._publishers) * patience_ns
        for publisher in self._publishers.values():
            left = min(patience_ns, max(0, end - time.monotonic_ns()))
            publisher.wait_for_all_acked(Duration(nanoseconds=left))


def _clock(stamp_ns: int) -> bytes:
    """A rosgraph_msgs/Clock."""
    return ENCAPSULATION + struct.pack("<iI", *divmod(stamp_ns, NS))


def _require_distinct(full_names: Mapping[str, str]) -> None:
    for (one, its_name), (other, other_name) in combinations(full_names.items(), 2):
        if its_name == other_name:
            raise InputError(f"the topics {one} and {other} are both remapped to {its_name}: give each its own name")


def _publisher(node: Node, kind: type, topic: str, qos: QoSProfile) -> Publisher:
    with told(f"the topic {topic} as {node.resolve_topic_name(topic)}"):
        return node.create_publisher(
            kind, topic, qos, qos_overriding_options=QoSOverridingOptions.with_default_policies()
        )
