"""Bags with estimates on a topic, written by `rosbags` and `mcap`, as filters of ROS 2 would."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.typesys import Stores, get_typestore

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
        "tf2_msgs/msg/TFMessage": lambda t, q: make(
            "tf2_msgs/msg/TFMessage",
            [transform(t, np.array([0.0, 0.0, 0.0, 1.0]), "map", "odometer"), transform(t, q, world, body)],
        ),
    }


def write(path: Path, kind: str, how: Make, topic: str, stamps: np.ndarray, attitudes: np.ndarray) -> Path:
    """A bag of one topic."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        add(writer, kind, how, topic, stamps, attitudes)
        writer.finish()
    return path


def add(writer: Writer, kind: str, how: Make, topic: str, stamps: np.ndarray, attitudes: np.ndarray) -> None:
    schema = writer.register_schema(kind, "ros2msg", b"")
    channel = writer.register_channel(topic, "cdr", schema)
    for stamp, attitude in zip(stamps.tolist(), attitudes, strict=True):
        writer.add_message(channel, stamp, bytes(STORE.serialize_cdr(how(stamp, attitude), kind)), stamp)


def beside(source: Path, path: Path, *topics: tuple[str, Make, str, np.ndarray, np.ndarray], without: str = "") -> Path:
    """A bag with all topics of another but one, and with topics of estimates."""
    with source.open("rb") as old, path.open("wb") as new:
        writer, channels = Writer(new), {}
        writer.start(profile="ros2")
        for schema, channel, message in make_reader(old).iter_messages():
            assert schema is not None
            if channel.topic in without.split():
                continue
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
        for topic in topics:
            add(writer, *topic)
        writer.finish()
    return path
