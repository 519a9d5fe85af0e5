"""The evaluator as its own process, what it publishes, and the poses that it hears."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from simulator_process import Process, assignments

if find_spec("rclpy"):
    from geometry_msgs.msg import PoseStamped


def evaluator(domain: int, name: str, *arguments: str, estimate: str, **parameters: object) -> Process:
    ros = ["-r", f"__node:={name}", "-r", f"estimate:={estimate}", *assignments(**parameters)]
    return Process("-m", "lie_rigid_body", "evaluate", *arguments, "--ros-args", *ros, domain=domain)


def pose_of(stamp: int, attitude: list[float]) -> PoseStamped:
    pose = PoseStamped()
    pose.header.stamp.sec, pose.header.stamp.nanosec = divmod(stamp, 10**9)
    pose.header.frame_id = "world"
    q = pose.pose.orientation
    q.x, q.y, q.z, q.w = attitude
    return pose


def of(name: str, arrays: list[Any]) -> list[Any]:
    return [status for array in arrays for status in array.status if status.name == f"/{name}: attitude error"]
