"""``python -m lie_rigid_body.ros.listen``: see the samples, or reset the motion, where there is no ros2 command."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_srvs.srv import Trigger

SHOWN_EVERY = 0.2
"""s between the lines on the screen, or less often when the samples come more slowly."""
LONGEST_WAIT = 5.0
"""s for the reset service to appear and to answer."""


def main(argv: Sequence[str] | None = None) -> int:
    """Print poses until Ctrl-C, or reset the motion.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0, or 1 when there is no answer.
    """
    parser = argparse.ArgumentParser(description="Print the poses that the node publishes, or reset its motion.")
    parser.add_argument("--pose", metavar="TOPIC", default="/pose")
    parser.add_argument("--reset", metavar="SERVICE", nargs="?", const="/lie_rigid_body/reset", help="reset, and end")
    given = parser.parse_args(argv)
    rclpy.init(args=[])
    node = rclpy.create_node("lie_rigid_body_listener")
    try:
        return reset(node, given.reset) if given.reset else listen(node, given.pose)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    finally:
        rclpy.try_shutdown()


def listen(node: Node, topic: str) -> int:
    """Print the poses of a topic, some of them, until interrupted."""
    shown = 0.0

    def show(pose: PoseStamped) -> None:
        nonlocal shown
        if time.monotonic() - shown < SHOWN_EVERY:
            return
        shown = time.monotonic()
        stamp, q = pose.header.stamp, pose.pose.orientation
        print(f"{stamp.sec}.{stamp.nanosec:09d} s  x {q.x:+.6f}  y {q.y:+.6f}  z {q.z:+.6f}  w {q.w:+.6f}", flush=True)

    node.create_subscription(PoseStamped, topic, show, QoSProfile(depth=10))
    rclpy.spin(node)
    return 0


def reset(node: Node, service: str) -> int:
    """Call a reset service, and print its answer."""
    client = node.create_client(Trigger, service)
    if not client.wait_for_service(LONGEST_WAIT):
        print(f"no service {service}: is the node running, in this ROS domain?", file=sys.stderr)
        return 1
    answer = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, answer, timeout_sec=LONGEST_WAIT)
    response = answer.result()
    if response is None:
        print(f"{service} does not answer", file=sys.stderr)
        return 1
    print(response.message)
    return 0 if response.success else 1


if __name__ == "__main__":
    sys.exit(main())
