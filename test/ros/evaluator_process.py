"""The evaluator as its own process, what it publishes, and the poses that it hears."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from threading import Thread
from types import TracebackType
from typing import Any

from simulator_process import DEADLINE, assignments

if find_spec("rclpy"):
    from geometry_msgs.msg import PoseStamped


class Process:
    """A process whose lines are kept; leaving the context kills it if it still runs."""

    def __init__(self, domain: int, *command: str) -> None:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
        self.process = subprocess.Popen(
            [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
        )
        self.said: list[str] = []
        self.complained: list[str] = []
        streams = (self.process.stdout, self.said), (self.process.stderr, self.complained)
        self._readers = [Thread(target=self._read, args=pair, daemon=True) for pair in streams]
        for reader in self._readers:
            reader.start()

    @staticmethod
    def _read(stream: Any, lines: list[str]) -> None:
        for line in stream:
            lines.append(line.rstrip("\n"))

    def __enter__(self) -> Process:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.process.kill()
        self.wait()

    def wait(self) -> int:
        status = self.process.wait(DEADLINE)
        for reader in self._readers:
            reader.join(DEADLINE)
        return status

    def heard(self, word: str) -> bool:
        assert self.process.poll() is None, self.complained
        return any(word in line for line in self.complained)


def evaluator(domain: int, name: str, *arguments: str, estimate: str, **parameters: object) -> Process:
    ros = ["-r", f"__node:={name}", "-r", f"estimate:={estimate}", *assignments(**parameters)]
    return Process(domain, "-m", "lie_rigid_body", "evaluate", *arguments, "--ros-args", *ros)


def pose_of(stamp: int, attitude: list[float]) -> PoseStamped:
    pose = PoseStamped()
    pose.header.stamp.sec, pose.header.stamp.nanosec = divmod(stamp, 10**9)
    pose.header.frame_id = "world"
    q = pose.pose.orientation
    q.x, q.y, q.z, q.w = attitude
    return pose


def of(name: str, arrays: list[Any]) -> list[Any]:
    return [status for array in arrays for status in array.status if status.name == f"/{name}: attitude error"]
