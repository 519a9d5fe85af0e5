"""``/tf``: the body's frame in the world, for RViz and Foxglove."""

from __future__ import annotations

from typing import Final

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

from lie_rigid_body.messages import TransformEncoder
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.timing.sink import Sink
from lie_rigid_body.simulation import Segment

TF: Final = "/tf"
TRANSFORMS_KEPT: Final = 100


class Transforms(Sink):
    """A sink that publishes each attitude as a transform, if tf2_msgs is installed.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        from tf2_msgs.msg import TFMessage

        qos = QoSProfile(depth=TRANSFORMS_KEPT, reliability=ReliabilityPolicy.RELIABLE)
        options = QoSOverridingOptions.with_default_policies()
        self._publisher = node.create_publisher(TFMessage, TF, qos, qos_overriding_options=options)

    def begin_segment(self, segment: Segment) -> None:
        """Take the names of the frames."""
        self._encoder = TransformEncoder(segment.scenario.world_frame, segment.scenario.body_frame)

    def write(self, batch: Batch) -> None:
        """Publish a transform for each sample."""
        for payload in self._encoder.encode(batch.samples.stamps_ns, batch.samples.states.attitude_xyzw):
            self._publisher.publish(payload)
