"""The live evaluator beside a real simulator and real estimators: what it says, publishes, and how it ends."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from evaluator_process import evaluator, of
from simulator_process import Process, SimulatorProcess, assignments, eventually

from lie_rigid_body.ros.evaluate import main
from lie_rigid_body.simulation import Segment
from ros_domains import own_domain
from said import numbers

if find_spec("rclpy"):
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped, Vector3Stamped
    from peer import Peer
    from rclpy.publisher import Publisher
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import Imu
    from std_msgs.msg import Header, String

    from lie_rigid_body.ros.following import Following

ESTIMATOR = Path(__file__).parents[2] / "examples" / "complementary_filter" / "complementary_filter_node.py"
BENCH = assignments(
    rate=20.0, imu_rate=20.0, magnetometer_rate=20.0, gyro_rate="integrated", accelerometer_mode="pivot_gravity"
)
"""So slow that a loaded machine loses nothing on the way through a filter in Python."""


@pytest.fixture(scope="module")
def domain(isolated_ros: None) -> Iterator[int]:
    """A domain in which a simulator and the filter of the examples run."""
    with (
        own_domain() as number,
        SimulatorProcess("--scenario", "tumbling_cubesat", *BENCH, domain=number),
        Process(str(ESTIMATOR), domain=number),
    ):
        yield number


@pytest.fixture
def others(domain: int) -> Iterator[Peer]:
    """A node that publishes the inverse of the truth, and may lose some."""
    with Peer("others", domain) as peer:
        lossy = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        inverse = peer.node.create_publisher(PoseStamped, "/inverse", lossy)

        def publish(pose: PoseStamped) -> None:
            q = pose.pose.orientation
            q.x, q.y, q.z = -q.x, -q.y, -q.z
            inverse.publish(pose)

        peer.node.create_subscription(PoseStamped, "/pose", publish, 1000)
        yield peer


@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.long
def test_a_good_estimator_and_a_mistaken_one(domain: int, others: Peer) -> None:
    with (
        evaluator(domain, "good", "--json", "--duration", "2", "--max-rms", "1deg", estimate="/imu/data") as good,
        evaluator(domain, "bad", "--json", estimate="/inverse", max_rms="1deg") as bad,
    ):
        errors = others.listen(Vector3Stamped, "/bad/error")
        reports = others.listen(DiagnosticArray, "/diagnostics")
        others.spin_until(lambda: good.process.poll() is not None, "an evaluator that ends by itself")
        assert good.wait() == 0, good.complained
        content = json.loads("\n".join(good.said))
        assert (content["topic"], content["type"]) == ("/imu/data", "sensor_msgs/msg/Imu")
        assert (content["bag"], content["truth"]) == (None, "poses and scenario")
        assert content["samples"] > 30
        assert (content["findings"], content["remarks"]) == ([], [])
        assert content["total_deg"]["max"] < 1e-6

        # a reset begins another scenario: the truth is still known
        others.spin_until(lambda: errors, "an error")
        assert others.call("reset").success
        seen = len(errors)
        # a cause is told when it is the same in all quarters of the samples, which takes some of them
        others.spin_until(lambda: len(errors) > seen + 200, "errors after the reset")
        limit = "above the limit of 1°"
        others.spin_until(lambda: any(limit in status.message for status in of("bad", reports)), "a report of it")
        bad.process.send_signal(signal.SIGTERM)
        others.spin_until(lambda: bad.process.poll() is not None, "its end")
        assert bad.wait() == 1, bad.complained
        content = json.loads("\n".join(bad.said))
        [finding] = [finding for finding in content["findings"] if finding["code"] == "inverted"]
        [note] = content["remarks"]
        assert numbers(note)[1:] == [1]  # reset
        assert finding["rms_deg_after"] < 1e-6, content
        assert len(content["broken"]) == 1
        told = [np.degrees([e.vector.x, e.vector.y, e.vector.z]) for e in errors]
        assert max(total for total, *_ in told) <= content["total_deg"]["max"] * (1.0 + 1e-9)
        assert all(total >= max(heading, inclination) - 1e-9 for total, heading, inclination in told)


@pytest.mark.ros
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--ros-args -r estimate:=/twist", "topic /twist "),
        ("--ros-args -r estimate:=/pose -r truth:=/twist", "topic /twist "),
        ("--wait 0.1 --ros-args -r estimate:=/nobody", "/nobody: "),
    ],
)
def test_unusable_input_is_status_2(
    arguments: str, said: str, domain: int, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    assert main(arguments.split()) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert said in err.splitlines()[-1]


@pytest.mark.ros
def test_interrupted_before_an_estimate_came(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Following, "look", lambda self: os.kill(os.getpid(), signal.SIGINT))
    assert main(["--ros-args", "-r", "estimate:=/imu/data"]) == 130
    assert "/imu/data" in capfd.readouterr().err


def test_without_ros_it_says_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main([]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "rclpy" in line


@pytest.mark.ros
def test_a_truth_that_appears_later_takes_the_place_of_another_body(peer: Peer) -> None:
    """Before it, the only truth is that of a body in another namespace. Where it is no nearer, nothing changes."""
    from lie_rigid_body import Scenario
    from lie_rigid_body.estimates.live_estimate import LiveEstimate
    from lie_rigid_body.evaluation import Limits
    from lie_rigid_body.messages import encode_string

    begin, body = partial(LiveEstimate, limits=Limits()), ("{}/lie_rigid_body/scenario", "{}/pose")

    def published(name: str) -> list[Publisher]:
        kinds = dict(zip(body, (String, PoseStamped), strict=True))
        made = [peer.node.create_publisher(kind, topic.format(name), 1) for topic, kind in kinds.items()]
        looked(lambda there: {topic.format(name) for topic in body} <= there)
        return made

    def looked(until: Callable[[set[str]], bool]) -> None:
        eventually(lambda: until({*own.published()}), "topics")
        for each in (own, rooted):
            each.look()

    def truth(following: Following) -> set[str]:
        return following._subscriptions.keys() - {following.estimate}

    def compared(following: Following) -> LiveEstimate:
        live = following.live
        assert live is not None
        assert not live.tally.count
        live.truth.hear_scenarios([encode_string(Segment(Scenario(), 0, 0).to_json())])
        live.hear_estimates([serialize_message(Imu(header=Header(stamp=Time(sec=s)))) for s in range(3)])
        live.judge()  # of what came before the last call
        assert live.judge() is not None
        return live

    with Peer("evaluator") as other:
        own, rooted = (Following(other.node, lambda seconds: None, begin) for _ in range(2))
        own.estimate, rooted.estimate = "/a/imu/data", "/imu/data"
        for following in (own, rooted):
            peer.node.create_publisher(Imu, following.estimate, 1)
        looked(lambda there: {own.estimate, rooted.estimate} <= there)
        published("/b")
        assert truth(own) == truth(rooted) == {topic.format("/b") for topic in body}
        compared(own)
        live = compared(rooted)
        made = published("/a")
        assert truth(own) == {topic.format("/a") for topic in body}
        assert truth(rooted) == {topic.format("/b") for topic in body}
        assert rooted.live is live
        live = compared(own)
        for publisher in made:
            peer.node.destroy_publisher(publisher)
        looked(lambda there: "/a/pose" not in there)
        assert truth(own) == {topic.format("/a") for topic in body}
        assert own.live is live
