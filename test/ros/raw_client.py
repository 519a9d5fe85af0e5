"""A client of the node, in a process of its own: keeps the bytes of every message, and writes them when it is told to.

Usage: raw_client.py OUT NAMESPACE TOPIC...

OUT.ready appears when every topic has its publisher; a file OUT.stop asks it to end as soon as nothing more comes.
"""

from __future__ import annotations

import pickle
import sys
import time
from pathlib import Path

import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, MagneticField

TYPES = {
    "pose": PoseStamped,
    "twist": TwistStamped,
    "imu/data_raw": Imu,
    "imu/bias": Imu,
    "imu/mag": MagneticField,
    "/clock": Clock,
}
LONGEST_LIFE = 150.0
SILENCE = 3.5
"""s; DDS asks after what was lost every 3 s."""
DEPTH = 400_000
"""More than ever comes: a Python client is slower than the node."""


def main(out: str, namespace: str, *topics: str) -> None:
    rclpy.init(args=[])
    node = rclpy.create_node("raw_client")
    seen: dict[str, list[bytes]] = {topic: [] for topic in topics}
    qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
    subscriptions = [
        node.create_subscription(
            TYPES[topic], topic if topic[0] == "/" else f"{namespace}/{topic}", seen[topic].append, qos, raw=True
        )
        for topic in topics
    ]
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    end, heard, count, ready = time.monotonic() + LONGEST_LIFE, time.monotonic(), 0, False
    while not (Path(f"{out}.stop").exists() and time.monotonic() - heard > SILENCE):
        assert time.monotonic() < end, {topic: len(messages) for topic, messages in seen.items()}
        if not ready and all(subscription.get_publisher_count() for subscription in subscriptions):
            ready = True
            Path(f"{out}.ready").touch()
        until = time.monotonic() + 0.2
        while time.monotonic() < until:
            executor.spin_once(timeout_sec=0.1)
        now = sum(len(messages) for messages in seen.values())
        if now > count:
            count, heard = now, time.monotonic()
    Path(out).write_bytes(pickle.dumps(seen))
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
