"""The node's time, controlled from outside: services, /clock, the real-time factor, diagnostics, QoS."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import pytest
from simulator_process import SimulatorProcess

if find_spec("rclpy"):
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped
    from peer import Peer
    from rcl_interfaces.srv import DescribeParameters, GetParameters
    from rclpy.qos import ReliabilityPolicy
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import Imu
    from std_srvs.srv import Trigger
    from visualization_msgs.msg import MarkerArray

pytestmark = pytest.mark.ros

NS = 1_000_000_000
NODE = "/lie_rigid_body"
QOS = "qos_overrides./pose.publisher"


@pytest.fixture(scope="module", autouse=True)
def ros(isolated_ros: None) -> Iterator[None]:
    rclpy.init(args=[])
    yield
    rclpy.shutdown()


@pytest.fixture(scope="module")
def simulator() -> Iterator[SimulatorProcess]:
    given = ["rate:=50.0", "imu_rate:=70.0", "publish_clock:=true", f"{QOS}.reliability:=best_effort"]
    arguments = [argument for text in [*given, f"{QOS}.depth:=7"] for argument in ("-p", text)]
    with SimulatorProcess("--ros-args", *arguments) as running:
        yield running


@pytest.fixture(scope="module")
def peer(ros: None, simulator: SimulatorProcess) -> Iterator[Peer]:
    peer = Peer("controller")
    yield peer
    peer.node.destroy_node()


@pytest.fixture(autouse=True)
def playing(peer: Peer) -> Iterator[None]:
    yield
    peer.listen_no_more()
    assert peer.set_together(real_time_factor=1.0).successful
    assert call(peer, "resume").success


def call(peer: Peer, name: str) -> Trigger.Response:
    return peer.answer(Trigger, f"{NODE}/{name}", Trigger.Request())


def number(answer: Trigger.Response) -> int:
    assert answer.success, answer.message
    [found] = re.findall(r"\d+", answer.message)
    return int(found)


def stamps_ns(messages: list[Any]) -> list[int]:
    return [m.header.stamp.sec * NS + m.header.stamp.nanosec for m in messages]


def spin_for(peer: Peer, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(peer.node, timeout_sec=0.05)


def best_effort(peer: Peer, kind: type, topic: str) -> list[Any]:
    from rclpy.qos import QoSProfile

    return peer.listen(kind, topic, QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT))


def test_paused_time_goes_on_step_by_step(peer: Peer) -> None:
    poses = best_effort(peer, PoseStamped, "/pose")
    peer.spin_until(lambda: poses, "a pose")
    stood = number(call(peer, "pause"))
    spin_for(peer, 0.3)
    last = stamps_ns(poses)[-1]
    assert last <= stood < last + NS // 50
    assert number(call(peer, "pause")) == stood
    spin_for(peer, 0.3)
    assert stamps_ns(poses)[-1] == last
    steps = [number(call(peer, "step")) for _ in range(3)]
    assert steps == [last + k * NS // 50 for k in (1, 2, 3)]
    start = number(call(peer, "reset"))
    assert number(call(peer, "step")) == start == last + 4 * NS // 50
    peer.spin_until(lambda: stamps_ns(poses)[-1] == start, "the steps")
    assert call(peer, "resume").success
    peer.spin_until(lambda: stamps_ns(poses)[-1] > start + NS // 10, "more poses")
    assert {b - a for a, b in pairwise(stamps_ns(poses))} == {NS // 50}


def test_what_cannot_be_done_is_answered(peer: Peer) -> None:
    answer = call(peer, "step")
    assert (answer.success, "pause it" in answer.message) == (False, True)
    for name in ("resume", "resume", "pause", "pause"):
        assert call(peer, name).success


def test_the_clock_is_that_of_the_samples(peer: Peer) -> None:
    clocks, poses = peer.listen(Clock, "/clock"), best_effort(peer, PoseStamped, "/pose")
    imu = peer.listen(Imu, "/imu/data_raw")
    peer.spin_until(lambda: clocks and poses and imu, "all topics")
    for _ in range(4):
        number(call(peer, "reset"))
        spin_for(peer, 0.15)
    number(call(peer, "pause"))
    spin_for(peer, 0.5)
    times = [m.clock.sec * NS + m.clock.nanosec for m in clocks]
    assert all(0 < a < b for a, b in pairwise(times))
    carried = sorted({*stamps_ns(poses), *stamps_ns(imu)})
    since = max(times[0], stamps_ns(poses)[0], stamps_ns(imu)[0])
    assert [t for t in times if t >= since] == [t for t in carried if t >= since]


def simulated_seconds(peer: Peer, seconds: float) -> float:
    """How far simulated time goes in a time of the wall."""
    first, began = number(call(peer, "pause")), time.monotonic()
    assert call(peer, "resume").success
    time.sleep(seconds)
    last = number(call(peer, "pause"))
    took = time.monotonic() - began
    assert call(peer, "resume").success
    return (last - first) / NS * seconds / took


def test_the_factor_acts_at_once(peer: Peer) -> None:
    assert peer.set_together(real_time_factor=8).successful
    assert simulated_seconds(peer, 0.5) == pytest.approx(4.0, rel=0.3)
    assert peer.set_together(real_time_factor=0.25).successful
    assert simulated_seconds(peer, 0.5) == pytest.approx(0.125, rel=0.4)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"real_time_factor": -1.0}, "real_time_factor"),
        ({"real_time_factor": float("nan")}, "real_time_factor"),
        ({"real_time_factor": 20.0, "inertia": [1.0, 1.0, 3.0]}, "triangle"),
        ({"real_time_factor": 20.0, "imu_rate": -1.0}, "imu_rate"),
        ({"real_time_factor": 20.0, "paused": True}, "read-only"),
        ({"publish_clock": False}, "read-only"),
        ({"gyro_rate": "guessed"}, "instantaneous"),
    ],
)
def test_refused_changes_change_nothing(peer: Peer, changes: dict[str, Any], reason: str) -> None:
    def held() -> list[object]:
        request = GetParameters.Request(names=list(changes))
        return list(peer.answer(GetParameters, f"{NODE}/get_parameters", request).values)

    before = held()
    result = peer.set_together(**changes)
    assert (result.successful, reason in result.reason) == (False, True), result.reason
    assert held() == before
    if changes.get("real_time_factor") == 20.0:
        assert simulated_seconds(peer, 0.2) < 1.0


def test_new_parameters_are_described(peer: Peer) -> None:
    names = ["real_time_factor", "marker_rate", "imu_rate", "sensor_seed", "gyro_rate", "publish_clock"]
    request = DescribeParameters.Request(names=names)
    found = peer.answer(DescribeParameters, f"{NODE}/describe_parameters", request).descriptors
    factor, markers, imu, seed, gyro, clock = found
    assert all(descriptor.description for descriptor in found)
    assert [d.read_only for d in found] == [False, True, False, False, False, True]
    [limits] = factor.floating_point_range
    assert (limits.from_value, limits.to_value) == (0.0, 1e6)
    assert "at once" in factor.additional_constraints
    assert "fixed at the start" in markers.additional_constraints
    assert "fixed at the start" in clock.additional_constraints
    for descriptor in (imu, seed, gyro):
        assert "next ~/reset" in descriptor.additional_constraints
    assert len(seed.integer_range) == 1


def test_quality_of_service_can_be_overridden(peer: Peer) -> None:
    [pose] = peer.node.get_publishers_info_by_topic("/pose")
    [twist] = peer.node.get_publishers_info_by_topic("/twist")
    assert pose.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    assert twist.qos_profile.reliability == ReliabilityPolicy.RELIABLE
    request = GetParameters.Request(names=[f"{QOS}.depth", f"{QOS}.reliability"])
    depth, reliability = peer.answer(GetParameters, f"{NODE}/get_parameters", request).values
    assert (depth.integer_value, reliability.string_value) == (7, "best_effort")


def test_diagnostics_tell_the_rate_the_lateness_and_the_drift(peer: Peer) -> None:
    arrays = peer.listen(DiagnosticArray, "/diagnostics")
    peer.spin_until(lambda: len(arrays) >= 2, "diagnostics")
    [status] = arrays[-1].status
    values = {pair.key: pair.value for pair in status.values}
    assert (status.name, status.hardware_id) == (f"{NODE}: simulation", "lie_rigid_body")
    assert status.level in (b"\x00", b"\x01")
    assert float(values["samples per second"]) == pytest.approx(50.0, rel=0.2)
    assert float(values["samples per second of simulated time"]) == 50.0
    assert int(values["samples sent"]) > 0
    for key in ("lateness of the latest sample (ms)", "worst lateness so far (ms)"):
        assert 0.0 <= float(values[key]) < 60_000.0
    assert int(values["missed deadlines so far"]) >= int(values["missed deadlines in this interval"]) >= 0
    for key in ("energy", "momentum"):
        assert float(values[f"{key} drift since the last reset (relative)"]) < 1e-12
    assert abs(arrays[-1].header.stamp.sec - time.time()) < 60


def test_markers_come_to_who_looks(peer: Peer) -> None:
    pictures = peer.listen(MarkerArray, "/markers", 10)
    peer.spin_until(lambda: pictures, "a picture")
    assert [marker.ns for marker in pictures[0].markers] == ["body", "momentum", "angular velocity", "polhode"]


def test_standard_services_are_there_where_their_package_is(peer: Peer) -> None:
    names = {name for name, _ in peer.node.get_service_names_and_types_by_node("lie_rigid_body", "/")}
    assert {f"{NODE}/{name}" for name in ("reset", "pause", "resume", "step")} <= names
    assert (f"{NODE}/get_simulator_features" in names) == (find_spec("simulation_interfaces") is not None)
