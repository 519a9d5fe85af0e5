"""The node's time, controlled from outside: services, /clock, the real-time factor, diagnostics."""

from __future__ import annotations

import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import pytest

if find_spec("rclpy"):
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped
    from peer import NODE, Peer
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import Imu, MagneticField
    from visualization_msgs.msg import MarkerArray

pytestmark = pytest.mark.ros

NS = 1_000_000_000
PERIOD = NS // 25
SLOWEST = 1e-6
"""A factor with which a sample takes hours."""


@pytest.fixture(autouse=True)
def playing(observer: Peer) -> Iterator[None]:
    yield
    assert observer.set_together(real_time_factor=1.0).successful
    assert observer.call("resume").success


def stamps_ns(messages: list[Any]) -> list[int]:
    return [m.header.stamp.sec * NS + m.header.stamp.nanosec for m in messages]


def test_what_cannot_be_done_is_answered(observer: Peer) -> None:
    answer = observer.call("step")
    assert not answer.success
    for name in ("resume", "resume", "pause", "pause"):
        assert observer.call(name).success


@pytest.mark.slow
def test_the_clock_is_that_of_the_samples(observer: Peer) -> None:
    clocks, poses = observer.listen(Clock, "/clock"), observer.listen(PoseStamped, "/pose")
    imu, field = observer.listen(Imu, "/imu/data_raw"), observer.listen(MagneticField, "/imu/mag")

    def times() -> list[int]:
        return [m.clock.sec * NS + m.clock.nanosec for m in clocks]

    observer.spin_until(lambda: clocks and poses and imu and field, "all topics")
    for _ in range(4):
        observer.stamp("reset")
        before = len(poses)

        def more(count: int = before + 5) -> bool:
            return len(poses) > count

        observer.spin_until(more, "more poses")
    stood = observer.stamp("pause")
    rates = {25: poses, 40: imu, 10: field}
    observer.spin_until(lambda: all(stamps_ns(m)[-1] > stood - NS // r for r, m in rates.items()), "the last samples")
    carried = sorted({stamp for messages in rates.values() for stamp in stamps_ns(messages)})
    observer.spin_until(lambda: times()[-1] >= carried[-1], "the last time")
    assert all(0 < a < b for a, b in pairwise(times()))
    since = max(times()[0], *(stamps_ns(messages)[0] for messages in rates.values()))
    assert [t for t in times() if t >= since] == [t for t in carried if t >= since]


def test_the_factor_acts_at_once(observer: Peer) -> None:
    """Slowed down, time all but stands still; at its own speed again, the next sample comes long before its hours."""
    assert observer.set_together(real_time_factor=SLOWEST).successful
    first, began = observer.stamp("pause"), time.monotonic_ns()
    assert observer.call("resume").success
    time.sleep(0.05)
    assert 0 <= observer.stamp("pause") - first <= SLOWEST * (time.monotonic_ns() - began) + 1
    assert observer.call("resume").success
    poses = observer.listen(PoseStamped, "/pose")
    assert observer.set_together(real_time_factor=1).successful
    observer.spin_until(lambda: poses, "the next sample")


def test_diagnostics_are_sent(observer: Peer) -> None:
    arrays = observer.listen(DiagnosticArray, "/diagnostics")
    observer.spin_until(lambda: arrays, "diagnostics")
    assert [status.name for status in arrays[0].status] == [f"{NODE}: simulation"]
    assert abs(arrays[0].header.stamp.sec - time.time()) < 600


def test_markers_come_to_who_looks(observer: Peer) -> None:
    pictures = observer.listen(MarkerArray, "/markers", 10)
    observer.spin_until(lambda: pictures, "a picture")
    assert [marker.ns for marker in pictures[0].markers] == ["body", "momentum", "angular velocity", "polhode"]
