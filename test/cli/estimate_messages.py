"""Bags with estimates on a topic, written by `rosbags` and `mcap`, as filters of ROS 2 would."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from foreign_bags import Message, bag_of, messages_of

STORE = get_typestore(Stores.ROS2_JAZZY)
NS = 10**9

Make = Callable[[int, np.ndarray], Any]
"""A message of a stamp, ns, and an attitude, scalar last."""


def make(name: str, *fields: Any) -> Any:
    return STORE.types[name](*fields)


def header(stamp: int, frame: str) -> Any:
    return make("std_msgs/msg/Header", make("builtin_interfaces/msg/Time", *divmod(stamp, NS)), frame)


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0, kind: str = "Vector3") -> Any:
    return make(f"geometry_msgs/msg/{kind}", x, y, z)


def quaternion(q: np.ndarray) -> Any:
    return make("geometry_msgs/msg/Quaternion", *(float(v) for v in q))


def pose(q: np.ndarray) -> Any:
    return make("geometry_msgs/msg/Pose", vector(1.0, 2.0, 3.0, "Point"), quaternion(q))


def with_covariance(q: np.ndarray, P: np.ndarray) -> Any:
    full = np.zeros((6, 6))
    full[:3, :3], full[3:, 3:] = np.diag([7.0, 8.0, 9.0]), P
    return make("geometry_msgs/msg/PoseWithCovariance", pose(q), full.ravel())


def messages(P: np.ndarray, world: str = "world", body: str = "base_link", sensor: str = "imu_link") -> dict[str, Make]:
    """How each type is made, by its name."""
    none = np.zeros(9)
    still = make(
        "geometry_msgs/msg/TwistWithCovariance", make("geometry_msgs/msg/Twist", vector(), vector()), np.zeros(36)
    )

    def transform(stamp: int, q: np.ndarray, frame: str, child: str) -> Any:
        turned = make("geometry_msgs/msg/Transform", vector(4.0), quaternion(q))
        return make("geometry_msgs/msg/TransformStamped", header(stamp, frame), child, turned)

    return {
        "geometry_msgs/msg/PoseStamped": lambda t, q: make("geometry_msgs/msg/PoseStamped", header(t, world), pose(q)),
        "geometry_msgs/msg/PoseWithCovarianceStamped": lambda t, q: make(
            "geometry_msgs/msg/PoseWithCovarianceStamped", header(t, world), with_covariance(q, P)
        ),
        "geometry_msgs/msg/QuaternionStamped": lambda t, q: make(
            "geometry_msgs/msg/QuaternionStamped", header(t, world), quaternion(q)
        ),
        "sensor_msgs/msg/Imu": lambda t, q: make(
            "sensor_msgs/msg/Imu", header(t, sensor), quaternion(q), P.ravel().copy(), vector(), none, vector(), none
        ),
        "nav_msgs/msg/Odometry": lambda t, q: make(
            "nav_msgs/msg/Odometry", header(t, world), body, with_covariance(q, P), still
        ),
        "geometry_msgs/msg/TransformStamped": lambda t, q: transform(t, q, world, body),
        "tf2_msgs/msg/TFMessage": lambda t, q: make(
            "tf2_msgs/msg/TFMessage",
            [transform(t, np.array([0.0, 0.0, 0.0, 1.0]), "map", "odometer"), transform(t, q, world, body)],
        ),
    }


def told(
    kind: str,
    how: Make,
    topic: str,
    stamps: np.ndarray,
    attitudes: np.ndarray,
    log_times: np.ndarray | None = None,
) -> list[Message]:
    """Messages of a topic, logged at their stamps unless log times are given."""
    rows = zip((stamps if log_times is None else log_times).tolist(), stamps.tolist(), attitudes, strict=True)
    return [Message(topic, kind, b"", at, at, bytes(STORE.serialize_cdr(how(t, q), kind))) for at, t, q in rows]


def beside(source: Path, path: Path, *topics: tuple[Any, ...], without: str = "") -> Path:
    """A bag with all topics of another but one, and with topics of estimates."""
    kept = [message for message in messages_of(source) if message.topic not in without.split()]
    empty = [(topic, kind) for kind, _, topic, stamps, *_ in topics if not len(stamps)]
    path.write_bytes(bag_of([*kept, *(message for each in topics for message in told(*each))], topics=empty))
    return path
