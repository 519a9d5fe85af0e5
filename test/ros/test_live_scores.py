"""The live evaluator beside publishers that a test steers: its score is that of what came, whatever comes beside it."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
import pytest
from evaluator_process import evaluator, of, pose_of

from lie_rigid_body import attitude_error, simulate
from lie_rigid_body.lie import quaternion
from lie_rigid_body.simulation import Segment

if find_spec("rclpy"):
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped, Vector3, Vector3Stamped
    from peer import LATCHED, Peer
    from sensor_msgs.msg import Imu
    from std_msgs.msg import String


@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.long
def test_findings_come_go_and_are_replaced_while_a_filter_runs(domain: int) -> None:
    """They are of the second half of the time so far, by the stamps, and made anew when that time has doubled."""
    run = simulate("tumbling_cubesat", duration=60.0, initial_body_rate=[0.4, 0.6, -0.3], motion="closed_form")
    truth = run.attitude()
    with Peer("changing", domain) as peer, evaluator(domain, "renewed", estimate="/changing/estimate") as process:
        reports = peer.listen(DiagnosticArray, "/diagnostics")
        peer.node.create_publisher(String, "/changing/lie_rigid_body/scenario", LATCHED).publish(
            String(data=Segment(run.scenario, 0, 0).to_json())
        )
        estimate = peer.node.create_publisher(PoseStamped, "/changing/estimate", 2000)
        peer.spin_until(lambda: estimate.get_subscription_count() == 1, "the evaluator")

        def say(begin_s: int, end_s: int, how: Callable[[np.ndarray], np.ndarray], found: str) -> None:
            stamps = np.arange(begin_s * 25, end_s * 25) * 40_000_000
            for stamp, attitude in zip(stamps.tolist(), how(stamps).tolist(), strict=True):
                estimate.publish(pose_of(stamp, attitude))

            def told() -> bool:
                latest = of("renewed", reports)[-1:]
                return [s.message.partition("; found: ")[2] for s in latest if "RMS" in s.message] == [found]

            peer.spin_until(told, f"the finding {found!r}")

        say(0, 6, lambda t: truth.at(t) * [-1.0, -1.0, -1.0, 1.0], "inverted")
        say(6, 20, truth.at, "")
        say(20, 60, lambda t: truth.at(t - 200_000_000), "lagging")
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 0, process.complained


@pytest.mark.ros
def test_a_small_offset_is_found_twice_before_it_is_told() -> None:
    """By samples of two times that do not overlap: a healthy filter errs slowly. A large one is told at once."""
    from lie_rigid_body.ros.evaluator import Confirmed

    run = simulate("tumbling_cubesat", duration=3.0, initial_body_rate=[0.4, 0.6, -0.3], motion="closed_form")
    scores = {
        size: run.score(quaternion.multiply(quaternion.exp(np.radians([0.0, 0.0, size])), run.truth.attitude_xyzw))
        for size in (0.0, 0.5, 5.0)
    }
    confirmed = Confirmed()
    told = {
        span: [finding.code for finding in confirmed.findings(scores[size], span)]
        for span, size in {5: 0.5, 7: 0.5, 10: 0.5, 12: 5.0, 20: 0.0, 21: 0.5, 40: 0.5, 81: 0.5}.items()
    }
    assert [span for span, codes in told.items() if codes == ["heading_offset"]] == [10, 12, 21, 81]
    assert [span for span, codes in told.items() if not codes] == [5, 7, 20, 40]


@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.long
def test_errors_are_those_of_the_score_by_a_scenario_of_another_name(domain: int) -> None:
    """``~/error`` is at the stamps of the estimate, rad; the truth is a remapped scenario, and no poses."""
    run = simulate("tumbling_cubesat", duration=2.0, initial_body_rate=[0.4, 0.6, -0.3], rate=20.0)
    turns = np.radians([3.0, -4.0, -5.0]) * np.linspace(0.1, 1.0, 40)[:, np.newaxis]
    attitudes = quaternion.multiply(quaternion.exp(turns), run.truth.attitude_xyzw)
    truth = ("--ros-args", "-r", "truth:=/elsewhere/body/told", "--")
    arguments = (*truth, "--json", "--series", "--max-rms", "90deg")
    with Peer("teller", domain) as peer, evaluator(domain, "held", *arguments, estimate="/held/estimate") as process:
        errors = peer.listen(Vector3Stamped, "/held/error")
        peer.node.create_publisher(String, "/elsewhere/body/told", LATCHED).publish(
            String(data=Segment(run.scenario, 0, 0).to_json())
        )
        estimate = peer.node.create_publisher(PoseStamped, "/held/estimate", 1000)
        bias = peer.node.create_publisher(Vector3Stamped, "/held/estimate/gyro_bias", 1000)
        true_bias = peer.node.create_publisher(Imu, "/elsewhere/imu/bias", 1000)
        all_of_them = (estimate, bias, true_bias)
        peer.spin_until(lambda: all(each.get_subscription_count() == 1 for each in all_of_them), "the evaluator")
        for pose in map(pose_of, run.t_ns.tolist(), attitudes.tolist()):
            bias.publish(Vector3Stamped(header=pose.header, vector=Vector3(x=0.3, y=0.4)))
            true_bias.publish(Imu(header=pose.header, angular_velocity=Vector3(x=0.2, y=0.2, z=0.2)))
            estimate.publish(pose)
        peer.spin_until(lambda: len(errors) == 40, "every error")
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 0, process.complained
    content = json.loads("\n".join(process.said))
    assert content["truth"] == "scenario"
    assert content["gyro_bias_rad_s"]["rms"] == pytest.approx(0.3)
    assert [e.header.stamp.sec * 10**9 + e.header.stamp.nanosec for e in errors] == run.t_ns.tolist()
    heard = np.array([[e.vector.x, e.vector.y, e.vector.z] for e in errors])
    series = [content["series"][f"{name}_deg"] for name in ("total", "heading", "inclination")]
    np.testing.assert_allclose(np.degrees(heard), np.transpose(series), rtol=1e-9)
    np.testing.assert_allclose(heard, np.transpose(attitude_error(attitudes, run.truth.attitude_xyzw)), rtol=1e-9)
    np.testing.assert_allclose(heard[:, 0], np.linalg.norm(turns, axis=1), rtol=1e-9)
    assert content["total_deg"]["rms"] == pytest.approx(np.sqrt(np.mean(np.degrees(heard[:, 0]) ** 2)))


@pytest.mark.slow
@pytest.mark.ros
@pytest.mark.long
def test_hostile_messages_cost_themselves(domain: int) -> None:
    """Wrong stamps, frames, attitudes and texts: each kind is told once; the rest is in process."""
    run = simulate("tumbling_cubesat", duration=3.0, initial_body_rate=[0.4, 0.6, -0.3], rate=20.0)
    turn = np.radians([3.0, -4.0, -5.0])
    attitudes = quaternion.multiply(quaternion.exp(turn), run.truth.attitude_xyzw)
    elsewhere = pose_of(0, [0.0, 0.0, 0.0, 1.0])
    elsewhere.header.frame_id = "elsewhere"
    wrong = [elsewhere, *(pose_of(at, attitudes[0].tolist()) for at in (-(10**18), 2**31 * 10**9 - 10**9))]
    remapped = ("--ros-args", "-r", "truth:=/told/node/truth")
    with (
        Peer("hostile", domain) as peer,
        evaluator(domain, "told", "--json", *remapped, estimate="/hurt") as process,
    ):
        truth = peer.node.create_publisher(String, "/told/node/truth", LATCHED)
        estimate = peer.node.create_publisher(PoseStamped, "/hurt", 1000)
        errors = peer.listen(Vector3Stamped, "/told/error")
        both = (truth, estimate)
        peer.spin_until(lambda: all(each.get_subscription_count() == 1 for each in both), "the evaluator")
        estimate.publish(pose_of(0, [0.0, 0.0, 0.0, 0.0]))
        own = Segment(run.scenario, 0, 0).to_json()
        for text in ("no JSON", "x" * 10_000_000, '{"inertia": [1, 1, 9]}', "[" * 50_000, own):
            truth.publish(String(data=text))
        for number, pose in enumerate(map(pose_of, run.t_ns.tolist(), attitudes.tolist())):
            for each in [*wrong * (number in (0, 30)), pose]:
                estimate.publish(each)
        peer.spin_until(lambda: len(errors) >= 60, "every error")
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 2, process.complained
    content = json.loads("\n".join(process.said))
    assert (content["samples"], content["truth"]) == (60, "scenario")
    assert content["total_deg"]["max"] == pytest.approx(np.degrees(np.linalg.norm(turn)))
    assert "gaps" not in [finding["code"] for finding in content["findings"]]
    assert len(process.complained) < 20
