"""A client of the node, in a process of its own: receives every sample, calls ~/reset on the way, writes what it saw.

Usage: stream_client.py OUT.npz NAMESPACE SAMPLES RESET_AFTER        (0: no reset)

OUT.npz.receiving appears when a hundred samples have come.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String
from std_srvs.srv import Trigger

DEADLINE = 110.0


def stamp_ns(message: PoseStamped | TwistStamped) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def main(out: str, namespace: str, samples: str, reset_after: str) -> None:
    rclpy.init(args=[])
    node = rclpy.create_node("client")
    reliable = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
    latched = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    poses: list[PoseStamped] = []
    twists: list[TwistStamped] = []
    scenarios: list[str] = []
    reset = node.create_client(Trigger, f"{namespace}/lie_rigid_body/reset")
    assert reset.wait_for_service(DEADLINE)

    def keep(message: String) -> None:
        scenarios.append(message.data)

    node.create_subscription(String, f"{namespace}/lie_rigid_body/scenario", keep, latched)
    node.create_subscription(PoseStamped, f"{namespace}/pose", poses.append, reliable)
    node.create_subscription(TwistStamped, f"{namespace}/twist", twists.append, reliable)
    answers: list[Any] = []
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    end = time.monotonic() + DEADLINE
    while min(len(poses), len(twists)) < int(samples) or any(not answer.done() for answer in answers):
        assert time.monotonic() < end, f"{len(poses)} poses and {len(twists)} twists of {samples} in {DEADLINE:g} s"
        if min(len(poses), len(twists)) >= 100:
            Path(f"{out}.receiving").touch()
        if int(reset_after) and not answers and min(len(poses), len(twists)) >= int(reset_after):
            answers.append(reset.call_async(Trigger.Request()))
        executor.spin_once(timeout_sec=1.0)
    np.savez(
        out,
        pose_stamps_ns=[stamp_ns(m) for m in poses],
        twist_stamps_ns=[stamp_ns(m) for m in twists],
        attitudes_xyzw=[[q.x, q.y, q.z, q.w] for q in (m.pose.orientation for m in poses)],
        positions=[[p.x, p.y, p.z] for p in (m.pose.position for m in poses)],
        body_rates=[[w.x, w.y, w.z] for w in (m.twist.angular for m in twists)],
        frames=[poses[0].header.frame_id, twists[0].header.frame_id],
        scenarios=scenarios,
        answers=[f"{answer.result().success} {answer.result().message}" for answer in answers],
    )
    rclpy.try_shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
