"""A client of the node, in a process of its own, which keeps the bytes of every message.

Usage: raw_client.py OUT TOPIC...

It prints "heard" when every topic has had a message. A line of its input, the last stamp (ns) of each topic as JSON,
asks it to write what it has when these stamps have come, and to end.
"""

from __future__ import annotations

import json
import pickle
import struct
import sys
import time
from pathlib import Path
from threading import Thread

import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

TYPES = {"pose": PoseStamped, "twist": TwistStamped}
LONGEST_LIFE = 1200.0
DEPTH = 400_000
"""More than ever comes: a Python client is slower than the node."""
SILENCE = 0.2
"""s in which a message that comes too often would show."""


def stamp_ns(payload: bytes) -> int:
    """Stamps come first in all of these messages, after four bytes of encapsulation."""
    sec, nanosec = struct.unpack_from("<iI", payload, 4)
    return int(sec) * 10**9 + int(nanosec)


def main(out: str, *topics: str) -> None:
    rclpy.init(args=[])
    node = rclpy.create_node("raw_client")
    seen: dict[str, list[bytes]] = {topic: [] for topic in topics}
    qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE)
    for topic in topics:
        node.create_subscription(TYPES[topic], topic, seen[topic].append, qos, raw=True)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    last: dict[str, int] = {}
    Thread(target=lambda: last.update(json.loads(sys.stdin.readline())), daemon=True).start()
    end, heard = time.monotonic() + LONGEST_LIFE, False
    while not last or any(not seen[topic] or stamp_ns(seen[topic][-1]) < last[topic] for topic in topics):
        assert time.monotonic() < end, (last, {topic: len(messages) for topic, messages in seen.items()})
        executor.spin_once(timeout_sec=0.05)
        if not heard and all(seen.values()):
            heard = True
            print("heard", flush=True)
    end = time.monotonic() + SILENCE
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
    Path(out).write_bytes(pickle.dumps(seen))
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
