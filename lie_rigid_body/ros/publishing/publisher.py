"""The topics of samples: truth, sensors, latched scenario and clock."""

from __future__ import annotations

import struct
import time
from collections import deque
from collections.abc import Iterable, Iterator
from typing import Final

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import FAULTS_TOPIC, POSE, SENSOR_TOPICS, TWIST, Batch, sensor_topics
from lie_rigid_body.messages.layout import ENCAPSULATION
from lie_rigid_body.ros.session import is_zenoh, latched, message_class, offered
from lie_rigid_body.ros.timing.sink import FOREVER, MAX_BATCH, Punctuality, Sink
from lie_rigid_body.sensors import Sensors
from lie_rigid_body.simulation import Segment

PRIVATE_SCENARIO: Final = "~/scenario"
IMU_TOPIC: Final = "imu/data_raw"
CLOCK: Final = "/clock"
DEPTH: Final = 4 * MAX_BATCH
"""Messages of a topic kept until reliable subscribers confirm them: no batch displaces the one before."""
CLOCK_DEPTH: Final = 6 * DEPTH
"""Messages of the clock kept: it has one for each time of the truth, of each sensor and of a fault."""
LAST_CONFIRMATION_NS: Final = 100_000_000
"""Longest wait on each topic for subscribers to confirm the last samples when the node ends, ns."""
LAST_SENDING_NS: Final = NS
"""Longest wait for room for the last samples when the node ends, ns."""
LATE_NS: Final = NS
"""Lateness of samples, ns, from which on a warning is logged."""
WARNING_INTERVAL_NS: Final = 10 * NS


class SamplePublisher(Sink):
    """A sink into topics: the truth, the sensors, the latched scenario and the clock.

    Parameters
    ----------
    node : Node
    stamped_twist : bool
        Whether the twist topic is a TwistStamped, or a bare Twist.
    sensors : Sensors
        Sensors whose topics exist from the start. A segment with other sensors adds their topics.
    clock : bool
        Whether to publish /clock: each stamp once, before the messages that carry it.
    keep_all : bool, optional
        Whether reliable subscribers set the pace: every message is kept until all of them have confirmed it, and
        `ready` says when there is room for more. Otherwise a subscriber that hangs loses messages, and delays nobody.
        So it is with rmw_zenoh, where such a history waits in `publish`, for ever and with all threads of Python.
    imu_last : bool, optional
        Whether a reading of the IMU follows all other messages of its time, as the bag has it before other sensors'.

    Attributes
    ----------
    publishers : dict of str to Publisher
        By the relative names of their topics.

    Raises
    ------
    InputError
        If ROS refuses a name.
    """

    def __init__(
        self,
        node: Node,
        *,
        stamped_twist: bool,
        sensors: Sensors,
        clock: bool,
        keep_all: bool = False,
        imu_last: bool = False,
    ) -> None:
        self._node = node
        self._imu_last = imu_last
        self._is_zenoh = is_zenoh()
        self._history = HistoryPolicy.KEEP_ALL if keep_all and not self._is_zenoh else HistoryPolicy.KEEP_LAST
        self._rest = deque[tuple[Publisher, bytes]]()
        self.publishers: dict[str, Publisher] = {}
        self._add(POSE, PoseStamped, self._quality())
        self._add(TWIST, TwistStamped if stamped_twist else Twist, self._quality())
        self._add(PRIVATE_SCENARIO, String, latched(1))
        if clock:
            self._add(CLOCK, Clock, self._quality(CLOCK_DEPTH))
        self._clock_ns = 0
        self._add_sensors(sensors)
        self._warned_ns = -WARNING_INTERVAL_NS

    def _quality(self, depth: int = DEPTH) -> QoSProfile:
        return QoSProfile(history=self._history, depth=depth, reliability=ReliabilityPolicy.RELIABLE)

    def _add_sensors(self, sensors: Sensors) -> None:
        for topic in sensor_topics(sensors):
            quality = latched(DEPTH) if topic == FAULTS_TOPIC else self._quality()
            self._add(topic, message_class(SENSOR_TOPICS[topic]), quality)

    def _add(self, topic: str, kind: type, quality: QoSProfile) -> None:
        """Create the publisher of a topic, unless there is one."""
        if topic not in self.publishers:
            self.publishers[topic] = offered(self._node, kind, topic, quality)

    def begin_segment(self, segment: Segment) -> None:
        """Publish the scenario."""
        self._add_sensors(segment.scenario.sensors)
        told = (POSE, TWIST, *sensor_topics(segment.scenario.sensors))
        names = {topic: self.publishers[topic].topic_name for topic in told}
        self.publishers[PRIVATE_SCENARIO].publish(encode_string(segment.to_json(names)))

    def write(self, batch: Batch) -> None:
        """Publish messages, oldest first."""
        self.send(self._in_order(batch))

    def send(self, messages: Iterable[tuple[Publisher, bytes]]) -> None:
        """Publish messages, oldest first. Those for which there is no room are kept, and sent by `ready`."""
        self._rest.extend(messages)
        self.ready()

    def ready(self) -> bool:
        """Send the messages that were kept; return whether there is room for more.

        There is none if a history keeps all, as asked for here or by the user, and stays full as long as the middleware
        waits. Fast DDS waits 100 ms.
        """
        while self._rest:
            publisher, payload = self._rest[0]
            try:
                publisher.publish(payload)
            except RuntimeError:
                if publisher.qos_profile.history is HistoryPolicy.KEEP_ALL and self._node.context.ok():
                    return False
                raise
            self._rest.popleft()
        return True

    def _in_order(self, batch: Batch) -> Iterator[tuple[Publisher, bytes]]:
        clock = self.publishers.get(CLOCK)
        messages = batch.in_order()
        if self._imu_last:
            messages = sorted(messages, key=lambda message: (message[0], message[1] == IMU_TOPIC))
        for stamp, topic, payload in messages:
            if clock is not None and stamp > self._clock_ns:
                self._clock_ns = stamp
                yield clock, clock_bytes(stamp)
            yield self.publishers[topic], payload

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Log a warning when the samples are late, at most one in ten seconds; return `FOREVER`, as no tick is due."""
        late = punctuality.lateness_ns
        if late > LATE_NS and steady_ns - self._warned_ns > WARNING_INTERVAL_NS:
            self._warned_ns = steady_ns
            self._node.get_logger().warning(f"{late / NS:.1f} s late, catching up; no sample is left out")
        return FOREVER

    def close(self) -> None:
        """Send the messages that were kept, and wait for subscribers to confirm the last ones.

        Only now: the wait holds up every thread of Python, and Fast DDS confirms within 3 s, when a heartbeat is due.
        """
        end = time.monotonic_ns() + LAST_SENDING_NS
        while not self.ready() and time.monotonic_ns() < end:
            pass  # the middleware waits in each attempt
        for topic, publisher in self.publishers.items():
            if topic not in (PRIVATE_SCENARIO, CLOCK):
                publisher.wait_for_all_acked(Duration(nanoseconds=LAST_CONFIRMATION_NS))
        if self._is_zenoh:  # which says at once that all is confirmed
            time.sleep(LAST_CONFIRMATION_NS / NS)


def clock_bytes(stamp_ns: int) -> bytes:
    """The bytes of a rosgraph_msgs/Clock."""
    return ENCAPSULATION + struct.pack("<iI", *divmod(stamp_ns, NS))
