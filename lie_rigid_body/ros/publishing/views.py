"""Topics that RViz and Foxglove show: ``/tf``, the body's frame in the world, and ``markers``.

The body is a box, its angular momentum and velocity are arrows, and the polhode is a line.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.messages import TransformEncoder
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.session import offered
from lie_rigid_body.ros.timing.sink import FOREVER, Punctuality, Sink
from lie_rigid_body.simulation import Segment

TF: Final = "/tf"
TRANSFORMS_KEPT: Final = 100
MARKERS_TOPIC: Final = "markers"
ARROW: Final = 1.0
"""Length of the arrows at the start of a segment, m."""
TRAIL: Final = 600
"""Most points of the polhode's line."""
BODY_COLOUR: Final = ColorRGBA(r=0.35, g=0.55, b=0.85, a=0.6)
RATE_COLOUR: Final = ColorRGBA(r=0.95, g=0.55, b=0.1, a=1.0)
MOMENTUM_COLOUR: Final = ColorRGBA(r=0.1, g=0.65, b=0.35, a=1.0)
POLHODE_COLOUR: Final = ColorRGBA(r=0.6, g=0.3, b=0.75, a=1.0)


class Transforms(Sink):
    """A sink that publishes each attitude as a transform, if tf2_msgs is installed.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        from tf2_msgs.msg import TFMessage

        qos = QoSProfile(depth=TRANSFORMS_KEPT, reliability=ReliabilityPolicy.RELIABLE)
        self._publisher = offered(node, TFMessage, TF, qos)

    def begin_segment(self, segment: Segment) -> None:
        """Take the names of the frames."""
        self._encoder = TransformEncoder(segment.scenario.world_frame, segment.scenario.body_frame)

    def write(self, batch: Batch) -> None:
        """Publish a transform for each sample."""
        for payload in self._encoder.encode(batch.samples.stamps_ns, batch.samples.states.attitude_xyzw):
            self._publisher.publish(payload)


class Markers(Sink):
    """A sink that publishes markers while somebody subscribes to them.

    Everything is in the world frame: the polhode, a curve in the body, is turned with the body.

    Parameters
    ----------
    node : Node
    rate : float
        Marker arrays per second of the steady clock.
    """

    def __init__(self, node: Node, rate: float) -> None:
        self._publisher = node.create_publisher(MarkerArray, MARKERS_TOPIC, QoSProfile(depth=10))
        self._interval_ns = round(NS / rate)
        self._due_ns = 0
        self._latest: tuple[int, State] | None = None
        self._trail: deque[list[float]] = deque(maxlen=TRAIL)

    def begin_segment(self, segment: Segment) -> None:
        """Take the body, and begin a new polhode."""
        scenario = segment.scenario
        start = scenario.start()
        body = scenario.body()
        self._frame = scenario.world_frame
        self._body = body
        self._rate_scale = _scale(start.body_rate)
        self._momentum_scale = 0.0 if scenario.path() else _scale(body.body_momentum(start))
        self._trail.clear()

    def write(self, batch: Batch) -> None:
        """Keep the latest state."""
        if len(batch.samples):
            self._latest = (int(batch.samples.stamps_ns[-1]), batch.samples.states[-1])

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Publish the markers of the latest state when it is time."""
        if self._latest is None:
            return FOREVER
        if steady_ns >= self._due_ns:
            stamp_ns, state = self._latest
            self._trail.append((state.body_rate * self._rate_scale).tolist())
            if self._publisher.get_subscription_count():
                self._publisher.publish(self._picture(stamp_ns, state))
            self._due_ns = steady_ns + self._interval_ns
        return self._due_ns - steady_ns

    def _picture(self, stamp_ns: int, state: State) -> MarkerArray:
        attitude = state.attitude_xyzw
        rate = quaternion.rotate(attitude, state.body_rate) * self._rate_scale
        momentum = self._body.angular_momentum(state) * self._momentum_scale
        # a box along the principal axes, m: an inertia alone does not determine the size of a body
        axes = quaternion.from_matrix(self._body.principal_axes)
        sides = box_sides(self._body.principal_moments)
        body = self._marker(
            0,
            "body",
            Marker.CUBE,
            stamp_ns,
            BODY_COLOUR,
            pose=Pose(orientation=_message(Quaternion, quaternion.multiply(attitude, axes))),
            scale=_message(Vector3, sides),
        )
        polhode = self._marker(
            3,
            "polhode",
            Marker.LINE_STRIP,
            stamp_ns,
            POLHODE_COLOUR,
            pose=Pose(orientation=_message(Quaternion, attitude)),
            scale=Vector3(x=0.01),
            points=[_message(Point, point) for point in self._trail],
        )
        arrows = (
            self._arrow(1, "momentum", stamp_ns, MOMENTUM_COLOUR, momentum),
            self._arrow(2, "angular velocity", stamp_ns, RATE_COLOUR, rate),
        )
        return MarkerArray(markers=[body, *arrows, polhode])

    def _arrow(self, number: int, name: str, stamp_ns: int, color: ColorRGBA, tip: Array) -> Marker:
        ends = [Point(), _message(Point, tip)]
        widths = Vector3(x=0.03, y=0.06, z=0.1)
        return self._marker(number, name, Marker.ARROW, stamp_ns, color, points=ends, scale=widths)

    def _marker(self, number: int, name: str, kind: int, stamp_ns: int, color: ColorRGBA, **fields: Any) -> Marker:
        header = Header(frame_id=self._frame, stamp=Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS))
        return Marker(header=header, ns=name, id=number, type=kind, action=Marker.ADD, color=color, **fields)


def _scale(vector: Array) -> float:
    """The factor that makes a vector as long as an arrow; 0 for the zero vector."""
    size = float(np.linalg.norm(vector))
    return ARROW / size if size else 0.0


def _message(kind: type, values: Iterable[float]) -> Any:
    """A message of the fields x, y, z and, for a quaternion, w."""
    return kind(**{name: float(value) for name, value in zip("xyzw", values, strict=False)})
