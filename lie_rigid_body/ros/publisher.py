"""The topics of a live run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Final

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from lie_rigid_body.errors import InputError
from lie_rigid_body.recording.cdr import encode_string
from lie_rigid_body.ros.live_run import LARGEST_BURST, NS
from lie_rigid_body.ros.refusal import told
from lie_rigid_body.simulation import Samples, Segment

POSE: Final = "pose"
TWIST: Final = "twist"
SCENARIO: Final = "~/scenario"
KEPT: Final = 4 * LARGEST_BURST
"""Messages kept for reliable subscribers that have not confirmed them: a burst never overruns the one before."""
BURST_PATIENCE: Final = Duration(nanoseconds=10_000_000)
"""How long a full burst waits to be confirmed on each topic: one subscriber that hangs must not hold up the others."""
LAST_PATIENCE: Final = Duration(nanoseconds=100_000_000)
"""The same for the last samples of all."""
LATE_NS: Final = NS
WARNING_INTERVAL_NS: Final = 10 * NS
_NEVER: Final = 2**63


class SamplePublisher:
    """An outlet into topics: poses, twists and the latched scenario.

    Parameters
    ----------
    node : Node
    stamped_twist : bool
        The type of the twist topic.

    Raises
    ------
    InputError
        If remapping leaves two topics with one name, or a name that is taken by another type.
    """

    def __init__(self, node: Node, *, stamped_twist: bool) -> None:
        reliable = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.RELIABLE)
        latched = QoSProfile(
            depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
        )
        _require_distinct({topic: node.resolve_topic_name(topic) for topic in (POSE, TWIST, SCENARIO)})
        self._pose = _publisher(node, PoseStamped, POSE, reliable)
        self._twist = _publisher(node, TwistStamped if stamped_twist else Twist, TWIST, reliable)
        self._scenario = _publisher(node, String, SCENARIO, latched)
        self._logger = node.get_logger()
        self._warned_ns = -WARNING_INTERVAL_NS

    @property
    def topics(self) -> tuple[str, str, str]:
        """Full names of the pose, twist and scenario topics, as remapped."""
        return self._pose.topic_name, self._twist.topic_name, self._scenario.topic_name

    def begin_segment(self, segment: Segment) -> None:
        """Publish the scenario."""
        self._scenario.publish(encode_string(segment.to_json()))

    def write(self, samples: Samples, poses: Sequence[bytes], twists: Sequence[bytes]) -> None:
        """Publish samples, oldest first."""
        for pose, twist in zip(poses, twists, strict=True):
            self._pose.publish(pose)
            self._twist.publish(twist)
        if len(poses) == LARGEST_BURST:
            self._settle(BURST_PATIENCE)

    def tick(self, steady_ns: int, lateness_ns: int) -> int:
        """Say it when the samples are late, now and then."""
        if lateness_ns > LATE_NS and steady_ns - self._warned_ns > WARNING_INTERVAL_NS:
            self._warned_ns = steady_ns
            self._logger.warning(f"{lateness_ns / NS:.1f} s late, catching up; no sample is left out")
        return _NEVER

    def finish(self) -> None:
        """Let the last samples arrive."""
        self._settle(LAST_PATIENCE)

    def _settle(self, patience: Duration) -> None:
        for publisher in (self._pose, self._twist):
            publisher.wait_for_all_acked(patience)


def _require_distinct(full_names: Mapping[str, str]) -> None:
    for (one, its_name), (other, other_name) in combinations(full_names.items(), 2):
        if its_name == other_name:
            raise InputError(f"the topics {one} and {other} are both remapped to {its_name}: give each its own name")


def _publisher(node: Node, kind: type, topic: str, qos: QoSProfile) -> Publisher:
    with told(f"the topic {topic} as {node.resolve_topic_name(topic)}"):
        return node.create_publisher(kind, topic, qos)
