"""Topics that RViz and Foxglove show: ``/tf``, the body's frame in the world, ``/tf_static``, and ``markers``.

The body is a box, its angular momentum and velocity are arrows, and the polhode since the latest kick is a line.
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
from lie_rigid_body.messages.batch import TF_TOPIC, Batch
from lie_rigid_body.ros.publishing.publisher import SamplePublisher
from lie_rigid_body.ros.session import latched, offered
from lie_rigid_body.ros.timing.sink import FOREVER, Periodic, Punctuality, Sink
from lie_rigid_body.simulation import Segment

TF: Final = TF_TOPIC
TF_STATIC: Final = "/tf_static"
TRANSFORMS_KEPT: Final = 100
MARKERS_TOPIC: Final = "markers"
ARROW: Final = 1.0
"""Length, m, of the arrows of the largest rate and momentum, right after the start or a kick of a segment."""
TRAIL: Final = 600
"""Most points of the polhode's line."""
BODY_COLOUR: Final = ColorRGBA(r=0.35, g=0.55, b=0.85, a=0.6)
RATE_COLOUR: Final = ColorRGBA(r=0.95, g=0.55, b=0.1, a=1.0)
MOMENTUM_COLOUR: Final = ColorRGBA(r=0.1, g=0.65, b=0.35, a=1.0)
POLHODE_COLOUR: Final = ColorRGBA(r=0.6, g=0.3, b=0.75, a=1.0)


class Transforms(Sink):
    """A sink that publishes each pose as a transform, and where the IMU is on the body, if tf2_msgs is installed.

    Parameters
    ----------
    node : Node
    sender : SamplePublisher
        What sends the transforms, each after the messages of its sample.
    """

    def __init__(self, node: Node, sender: SamplePublisher) -> None:
        from tf2_msgs.msg import TFMessage

        self._send = sender.send
        qos = QoSProfile(depth=TRANSFORMS_KEPT, reliability=ReliabilityPolicy.RELIABLE)
        self._publisher = offered(node, TFMessage, TF, qos)
        self._fixed = offered(node, TFMessage, TF_STATIC, latched(1))

    def begin_segment(self, segment: Segment) -> None:
        """Take the names of the frames, and publish where that of the IMU is in the body's, unless they are one."""
        scenario = segment.scenario
        self._resting = scenario.initial_position
        self._encoder = TransformEncoder(scenario.world_frame, scenario.body_frame)
        imu_frame = str(scenario.value("imu_frame"))
        if scenario.has_sensors and imu_frame != scenario.body_frame:
            pose = np.array([scenario.value("accelerometer_lever_arm")]), np.array([[0.0, 0.0, 0.0, 1.0]])
            mount = TransformEncoder(scenario.body_frame, imu_frame)
            self._fixed.publish(mount.encode(np.array([segment.start_ns]), *pose)[0])

    def write(self, batch: Batch) -> None:
        """Publish a transform for each sample."""
        samples = batch.samples
        resting = np.broadcast_to(self._resting, (len(samples), 3))
        position = resting if samples.centre is None else samples.centre.position
        transforms = self._encoder.encode(samples.stamps_ns, position, samples.states.attitude_xyzw)
        self._send((self._publisher, payload) for payload in transforms)


class Markers(Periodic):
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
        self.interval_ns = round(NS / rate)
        self._due_ns = 0
        self._trail: deque[list[float]] = deque(maxlen=TRAIL)

    def begin_segment(self, segment: Segment) -> None:
        """Take the body, and begin a new polhode."""
        scenario = segment.scenario
        starts = scenario.arc_starts()
        body = scenario.body()
        self._segment = segment
        self._frame = scenario.world_frame
        self._body = body
        self._rate_scale = _scale(starts.body_rate)
        self._momentum_scale = 0.0 if scenario.path() else _scale(body.body_momentum(starts))
        self._arc = 0
        self._trail.clear()

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Publish the markers of the latest state when it is time."""
        return super().tick(steady_ns, punctuality) if self.latest else FOREVER

    def act(self, steady_ns: int, punctuality: Punctuality) -> None:
        """Publish the markers of the latest state, if somebody looks."""
        assert self.latest is not None
        stamp_ns, state = self.latest
        scenario = self._segment.scenario
        elapsed_ns = stamp_ns - self._segment.start_ns
        arc = scenario.kick_schedule().arc(elapsed_ns)
        if arc != self._arc:  # a kick begins another polhode
            self._trail.clear()
            self._arc = arc
        self._trail.append((state.body_rate * self._rate_scale).tolist())
        if self._publisher.get_subscription_count():
            [position] = scenario.mass_centre().at(np.array([elapsed_ns])).position
            self._publisher.publish(self._picture(stamp_ns, state, position))

    def _picture(self, stamp_ns: int, state: State, position: Array) -> MarkerArray:
        centre = _message(Point, position)
        attitude = state.attitude_xyzw
        rate = quaternion.rotate(attitude, state.body_rate) * self._rate_scale
        momentum = self._body.angular_momentum(state) * self._momentum_scale
        # a box along the principal axes, m: an inertia alone does not determine the size of a body
        axes = quaternion.from_matrix(self._body.principal_axes)
        sides = box_sides(self._body.principal_moments)
        markers = (
            (
                "body",
                Marker.CUBE,
                BODY_COLOUR,
                {
                    "pose": Pose(
                        position=centre, orientation=_message(Quaternion, quaternion.multiply(attitude, axes))
                    ),
                    "scale": _message(Vector3, sides),
                },
            ),
            ("momentum", Marker.ARROW, MOMENTUM_COLOUR, _arrow(position, position + momentum)),
            ("angular velocity", Marker.ARROW, RATE_COLOUR, _arrow(position, position + rate)),
            (
                "polhode",
                Marker.LINE_STRIP,
                POLHODE_COLOUR,
                {
                    "pose": Pose(position=centre, orientation=_message(Quaternion, attitude)),
                    "scale": Vector3(x=0.01),
                    "points": [_message(Point, point) for point in self._trail],
                },
            ),
        )
        header = Header(frame_id=self._frame, stamp=Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS))
        return MarkerArray(
            markers=[
                Marker(header=header, ns=name, id=number, type=kind, action=Marker.ADD, color=colour, **fields)
                for number, (name, kind, colour, fields) in enumerate(markers)
            ]
        )


def _arrow(*ends: Array) -> dict[str, Any]:
    return {"points": [_message(Point, end) for end in ends], "scale": Vector3(x=0.03, y=0.06, z=0.1)}


def _scale(vectors: Array) -> float:
    """The factor that makes the largest of some vectors as long as an arrow; 0 where all are zero."""
    size = np.linalg.norm(vectors, axis=1).max()
    return ARROW / size if size else 0.0


def _message(kind: type, values: Iterable[float]) -> Any:
    """A message of the fields x, y, z and, for a quaternion, w."""
    return kind(**{name: float(value) for name, value in zip("xyzw", values, strict=False)})
