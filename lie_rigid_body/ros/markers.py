"""``markers``: a picture of the body, its momentum, its angular velocity and the polhode."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.ros.pace import FOREVER
from lie_rigid_body.ros.punctuality import Punctuality
from lie_rigid_body.simulation import Segment

Array = NDArray[np.float64]

TOPIC: Final = "markers"
NS: Final = 1_000_000_000
LONGEST_SIDE: Final = 1.0
"""m; an inertia alone does not say how large the body is."""
THINNEST: Final = 0.02
"""m; a flat body has to be seen."""
ARROW: Final = 1.0
"""m, of the angular velocity and of the momentum at the start."""
TRAIL: Final = 600
"""Points of the polhode trail."""
BLUE: Final = ColorRGBA(r=0.35, g=0.55, b=0.85, a=0.6)
ORANGE: Final = ColorRGBA(r=0.95, g=0.55, b=0.1, a=1.0)
GREEN: Final = ColorRGBA(r=0.1, g=0.65, b=0.35, a=1.0)
PURPLE: Final = ColorRGBA(r=0.6, g=0.3, b=0.75, a=1.0)


class Markers:
    """An outlet that draws the body as a box, while somebody looks.

    Everything is in the world frame: the polhode, which belongs to the body, is turned with it.

    Parameters
    ----------
    node : Node
    rate : float
        Pictures per second of the steady clock.
    """

    def __init__(self, node: Node, rate: float) -> None:
        self._publisher = node.create_publisher(MarkerArray, TOPIC, QoSProfile(depth=10))
        self._interval_ns = round(NS / rate)
        self._due_ns = 0
        self._latest: tuple[int, State] | None = None
        self._trail: deque[list[float]] = deque(maxlen=TRAIL)

    def begin_segment(self, segment: Segment) -> None:
        """Take the body, and begin a new trail."""
        scenario = segment.scenario
        start, body = scenario.start(), scenario.body()
        self._frame, self._body = scenario.world_frame, body
        self._sides = box_sides(body)
        # the box lies along the principal axes
        self._box = quaternion.from_matrix(body.principal_axes)
        self._rate_scale = _scale(start.body_rate)
        self._momentum_scale = _scale(body.body_momentum(start))
        self._trail.clear()

    def write(self, batch: Batch) -> None:
        """Keep the latest state."""
        if len(batch.samples):
            self._latest = (int(batch.samples.stamps_ns[-1]), batch.samples.states[-1])

    def ready(self) -> bool:
        """There is always room."""
        return True

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Publish a picture when it is time."""
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
        box = self._marker(0, "body", Marker.CUBE, stamp_ns, BLUE)
        box.pose.orientation = _quaternion(quaternion.multiply(attitude, self._box))
        box.scale = _vector(self._sides)
        trail = self._marker(3, "polhode", Marker.LINE_STRIP, stamp_ns, PURPLE)
        trail.pose.orientation = _quaternion(attitude)
        trail.scale.x = 0.01
        trail.points = [_point(point) for point in self._trail]
        return MarkerArray(
            markers=[
                box,
                self._arrow(1, "momentum", stamp_ns, GREEN, momentum),
                self._arrow(2, "angular velocity", stamp_ns, ORANGE, rate),
                trail,
            ]
        )

    def _arrow(self, number: int, name: str, stamp_ns: int, color: ColorRGBA, tip: Array) -> Marker:
        arrow = self._marker(number, name, Marker.ARROW, stamp_ns, color)
        arrow.points = [Point(), _point(tip.tolist())]
        arrow.scale = Vector3(x=0.03, y=0.06, z=0.1)
        return arrow

    def _marker(self, number: int, name: str, kind: int, stamp_ns: int, color: ColorRGBA) -> Marker:
        marker = Marker(ns=name, id=number, type=kind, action=Marker.ADD, color=color)
        marker.header.frame_id = self._frame
        marker.header.stamp = Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS)
        return marker


def box_sides(body: RigidBody) -> Array:
    """The sides of a uniform box with these principal moments, m, the longest of them `LONGEST_SIDE`.

    Parameters
    ----------
    body : RigidBody

    Returns
    -------
    ndarray, shape (3,)
        Along the principal axes, none below `THINNEST`.

    Notes
    -----
    I₁ = m (b² + c²)/12 and its permutations give a² ∝ I₂ + I₃ − I₁.
    """
    moments = body.principal_moments / body.principal_moments.max()
    sides = np.sqrt(np.maximum(moments.sum() - 2.0 * moments, 0.0))
    visible: Array = np.maximum(LONGEST_SIDE * sides / sides.max(), THINNEST)
    return visible


def _scale(vector: Array) -> float:
    """What makes a vector as long as an arrow."""
    size = float(np.linalg.norm(vector))
    return ARROW / size if size else 0.0


def _point(values: list[float]) -> Point:
    return Point(x=values[0], y=values[1], z=values[2])


def _vector(values: Array) -> Vector3:
    return Vector3(x=float(values[0]), y=float(values[1]), z=float(values[2]))


def _quaternion(xyzw: Array) -> Quaternion:
    x, y, z, w = xyzw.tolist()
    return Quaternion(x=x, y=y, z=z, w=w)
