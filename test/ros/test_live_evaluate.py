"""The live evaluator beside a real simulator and real estimators: what it says, publishes, and how it ends."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import Any

import numpy as np
import pytest
from simulator_process import DEADLINE, SimulatorProcess, assignments, eventually

from lie_rigid_body import Run, attitude_error, simulate
from lie_rigid_body.lie import quaternion
from lie_rigid_body.ros.evaluate import main
from lie_rigid_body.simulation import Segment
from ros_domains import own_domain

if find_spec("rclpy"):
    from diagnostic_msgs.msg import DiagnosticArray
    from geometry_msgs.msg import PoseStamped, Vector3Stamped
    from peer import LATCHED, Peer
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from rclpy.serialization import serialize_message
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import Imu
    from std_msgs.msg import String

    from lie_rigid_body.ros.following import Following
    from lie_rigid_body.ros.node import OF_EVERY_NODE

ESTIMATOR = Path(__file__).parents[2] / "examples" / "complementary_filter" / "complementary_filter_node.py"
BENCH = assignments(
    rate=20.0, imu_rate=20.0, magnetometer_rate=20.0, gyro_rate="integrated", accelerometer_mode="pivot_gravity"
)
"""So slow that a loaded machine loses nothing on the way through a filter in Python."""


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


@pytest.fixture(scope="module")
def domain(isolated_ros: None) -> Iterator[int]:
    """A domain in which a simulator and the filter of the examples run."""
    with (
        own_domain() as number,
        SimulatorProcess("--scenario", "tumbling_cubesat", *BENCH, domain=number),
        Process(number, str(ESTIMATOR)),
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
        assert (content["findings"], content["notes"]) == ([], [])
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
        assert content["notes"] == []
        assert finding["rms_deg_after"] < 1e-6, content
        assert len(content["broken"]) == 1
        told = [np.degrees([e.vector.x, e.vector.y, e.vector.z]) for e in errors]
        assert max(total for total, *_ in told) <= content["total_deg"]["max"] * (1.0 + 1e-9)
        assert all(total >= max(heading, inclination) - 1e-9 for total, heading, inclination in told)


@pytest.mark.ros
@pytest.mark.long
def test_attitudes_that_are_no_numbers_are_told_at_once_and_end_with_score_and_status_2(
    domain: int, others: Peer
) -> None:
    broken = others.node.create_publisher(PoseStamped, "/broken", 10)
    poses = others.listen(PoseStamped, "/pose")
    reports = others.listen(DiagnosticArray, "/diagnostics")
    sent = 0
    with evaluator(domain, "broken", "--json", "--max-rms", "1deg", estimate="/broken") as process:

        def told() -> bool:
            nonlocal sent
            for pose in poses[sent:]:
                pose.pose.orientation.w = float("nan") if sent % 5 == 4 else pose.pose.orientation.w
                broken.publish(pose)
                sent += 1
            return process.heard("not finite, or zero") and any(
                "not finite" in s.message for s in of("broken", reports)
            )

        others.spin_until(told, "a word about what is not finite")
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 2
    content = json.loads("\n".join(process.said))
    assert content["passed"] is True
    assert "estimates are not finite, or zero" in content["notes"][0]
    assert "evaluate: error: estimate: " in process.complained[-1]


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
    from lie_rigid_body.ros.publishing.scores import Confirmed

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
        peer.spin_until(lambda: estimate.get_subscription_count() == 1, "the evaluator")
        for stamp, attitude in zip(run.t_ns.tolist(), attitudes.tolist(), strict=True):
            estimate.publish(pose_of(stamp, attitude))
        peer.spin_until(lambda: len(errors) == 40, "every error")
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 0, process.complained
    content = json.loads("\n".join(process.said))
    assert content["truth"] == "scenario"
    assert [e.header.stamp.sec * 10**9 + e.header.stamp.nanosec for e in errors] == run.t_ns.tolist()
    heard = np.array([[e.vector.x, e.vector.y, e.vector.z] for e in errors])
    series = [content["series"][f"{name}_deg"] for name in ("total", "heading", "inclination")]
    np.testing.assert_allclose(np.degrees(heard), np.transpose(series), rtol=1e-9)
    np.testing.assert_allclose(heard, np.transpose(attitude_error(attitudes, run.truth.attitude_xyzw)), rtol=1e-9)
    np.testing.assert_allclose(heard[:, 0], np.linalg.norm(turns, axis=1), rtol=1e-9)
    assert content["total_deg"]["rms"] == pytest.approx(np.sqrt(np.mean(np.degrees(heard[:, 0]) ** 2)))


def turned_run(duration: float) -> tuple[Run, np.ndarray]:
    """A run at 20 Hz, and its attitudes in a world that is turned by 7.1°."""
    run = simulate("tumbling_cubesat", duration=duration, initial_body_rate=[0.4, 0.6, -0.3], rate=20.0)
    return run, quaternion.multiply(quaternion.exp(np.radians([3.0, -4.0, -5.0])), run.truth.attitude_xyzw)


@pytest.mark.ros
@pytest.mark.long
def test_a_message_that_cannot_be_read_costs_itself(domain: int) -> None:
    """The score is that of the others; a note counts those that were left out."""
    run, attitudes = turned_run(2.0)
    truth = ("--ros-args", "-r", "truth:=/strange/body/told", "--")
    with Peer("strange", domain) as peer, evaluator(domain, "strict", *truth, "--json", estimate="/odd") as process:
        errors = peer.listen(Vector3Stamped, "/strict/error")
        told = peer.node.create_publisher(String, "/strange/body/told", LATCHED)
        told.publish(String(data=Segment(run.scenario, 0, 0).to_json()))
        estimate = peer.node.create_publisher(PoseStamped, "/odd", 1000)
        peer.spin_until(lambda: estimate.get_subscription_count() == 1, "the evaluator")
        for number, (stamp, attitude) in enumerate(zip(run.t_ns.tolist(), attitudes.tolist(), strict=True)):
            estimate.publish(pose_of(stamp, attitude))
            if number in (0, 7, 20):
                wrong = pose_of(stamp, attitude)
                wrong.header.stamp.nanosec = 2**32 - 1
                estimate.publish(wrong)
                told.publish(String(data="no scenario" * 10_000 * number))
                told.publish(String(data="{}"))
        peer.spin_until(lambda: len(errors) == 40, "every error")
        peer.node.destroy_publisher(estimate)
        peer.spin_until(
            lambda: process.heard("waiting: nobody publishes /odd any more"), "a word about the filter's end"
        )
        process.process.send_signal(signal.SIGTERM)
        assert process.wait() == 0, process.complained
    content = json.loads("\n".join(process.said))
    assert content["samples"] == 40
    assert content["total_deg"]["max"] == pytest.approx(np.degrees(np.linalg.norm(np.radians([3.0, -4.0, -5.0]))))
    told_of = sorted(note[:26] for note in content["notes"][1:])  # in the order in which they came
    assert told_of == ["3 messages of /odd could n", "6 messages of /strange/bod"]


@pytest.mark.ros
@pytest.mark.long
@pytest.mark.parametrize("scenario", [True, False])
def test_hostile_messages_cost_themselves(domain: int, scenario: bool) -> None:
    """Wrong stamps, frames and attitudes on both topics, texts that are no scenario, and a second publisher."""
    run, attitudes = turned_run(3.0)
    name = f"of_{scenario}".lower()
    with (
        Peer("hostile", domain) as peer,
        Peer("second", domain) as second,
        evaluator(
            domain, name, "--json", "--ros-args", "-r", f"truth:=/{name}/node/truth", estimate="/hurt"
        ) as process,
    ):
        kind = String if scenario else PoseStamped
        truth = peer.node.create_publisher(kind, f"/{name}/node/truth", LATCHED if scenario else 1000)
        estimate = peer.node.create_publisher(PoseStamped, "/hurt", 1000)
        errors = peer.listen(Vector3Stamped, f"/{name}/error")
        # zero at the start
        peer.spin_until(lambda: estimate.get_subscription_count() == 1, "the evaluator")
        peer.spin_until(lambda: truth.get_subscription_count() == 1, "the evaluator")
        estimate.publish(pose_of(0, [0.0, 0.0, 0.0, 0.0]))
        if scenario:
            beside = second.node.create_publisher(String, f"/{name}/node/truth", LATCHED)
            for text in ("no JSON", "x" * 10_000_000, '{"inertia": [1, 1, 9]}', "[" * 50_000):
                truth.publish(String(data=text))
                beside.publish(String(data=text))
            truth.publish(String(data=Segment(run.scenario, 0, 0).to_json()))
        for number, (stamp, attitude) in enumerate(zip(run.t_ns.tolist(), attitudes.tolist(), strict=True)):
            topics = [estimate] if scenario else [truth, estimate]
            if number in (0, 30):
                for topic in topics:
                    topic.publish(pose_of(-(10**18), attitude))
                    topic.publish(pose_of(2**31 * 10**9 - 10**9, attitude))
                    elsewhere = pose_of(stamp, [0.0, 0.0, 0.0, 1.0])
                    elsewhere.header.frame_id = "elsewhere"
                    topic.publish(elsewhere)
            if not scenario:
                truth.publish(pose_of(stamp, run.truth.attitude_xyzw[number].tolist()))
            elif number == 30:
                # publishers have no order among them: the scenario is known by now
                peer.spin_until(lambda: errors, "an error")
                other = Segment(run.scenario, 0, 0).to_json().replace("0.6", "0.7")
                beside.publish(String(data=other))
                for start in (2**31 * 10**9 - 10**9, -(10**18)):
                    beside.publish(String(data=Segment(run.scenario, 0, start).to_json()))
            estimate.publish(pose_of(stamp, attitude))
        peer.spin_until(lambda: len(errors) >= (60 if scenario else 59), "every error")
        process.process.send_signal(signal.SIGTERM)
        status = process.wait()
    assert status == 2, process.complained
    content = json.loads("\n".join(process.said))
    assert content["samples"] == 60
    assert content["total_deg"]["max"] == pytest.approx(np.degrees(np.linalg.norm(np.radians([3.0, -4.0, -5.0]))))
    assert "gaps" not in [finding["code"] for finding in content["findings"]]
    assert content["truth"] == ("scenario" if scenario else "poses")
    assert len(process.complained) < 20  # each kind once


@pytest.mark.ros
@pytest.mark.long
def test_two_of_one_name_and_a_clock_that_jumps_back(domain: int) -> None:
    """Evaluators, and publishers, of one name each; /clock and the stamps go back by an hour for a while."""
    run, attitudes = turned_run(3.0)
    ros = ("--ros-args", "-r", "truth:=/twin/node/told", "-p", "use_sim_time:=true")
    with (
        Peer("twin", domain) as peer,
        Peer("twin", domain) as second,
        evaluator(domain, "twins", "--json", "--duration", "2.9", *ros, estimate="/twin/estimate") as one,
        evaluator(domain, "twins", "--json", "--duration", "2.9", *ros, estimate="/twin/estimate") as other,
    ):
        clock = second.node.create_publisher(Clock, "/clock", 10)
        peer.node.create_publisher(String, "/twin/node/told", LATCHED).publish(
            String(data=Segment(run.scenario, 0, 0).to_json())
        )
        errors = peer.listen(Vector3Stamped, "/twins/error")
        estimate = peer.node.create_publisher(PoseStamped, "/twin/estimate", 1000)
        peer.spin_until(lambda: estimate.get_subscription_count() == 2, "both evaluators")
        for number, (stamp, attitude) in enumerate(zip(run.t_ns.tolist(), attitudes.tolist(), strict=True)):
            behind = 3600 * 10**9 if 20 <= number < 30 else 0
            time = Clock()
            time.clock.sec, time.clock.nanosec = divmod(stamp - behind, 10**9)
            clock.publish(time)
            if behind:
                estimate.publish(pose_of(stamp - behind, attitude))
            if number == 30:
                peer.spin_until(lambda: len(errors) >= 40, "errors of both before the jump")
            estimate.publish(pose_of(stamp, attitude))
        peer.spin_until(lambda: None not in (one.process.poll(), other.process.poll()), "the end of both")
        assert [one.wait(), other.wait()] == [0, 0], [one.complained, other.complained]
    contents = [json.loads("\n".join(each.said)) for each in (one, other)]
    assert contents[0] == contents[1]
    assert contents[0]["samples"] > 55
    assert contents[0]["total_deg"]["max"] == pytest.approx(np.degrees(np.linalg.norm(np.radians([3.0, -4.0, -5.0]))))
    assert any("10 of 69 estimates were stamped before one that had come" in note for note in contents[0]["notes"])


def pose_of(stamp: int, attitude: list[float]) -> PoseStamped:
    pose = PoseStamped()
    pose.header.stamp.sec, pose.header.stamp.nanosec = divmod(stamp, 10**9)
    pose.header.frame_id = "world"
    q = pose.pose.orientation
    q.x, q.y, q.z, q.w = attitude
    return pose


def of(name: str, arrays: list[Any]) -> list[Any]:
    return [status for array in arrays for status in array.status if status.name == f"/{name}: attitude error"]


@pytest.mark.ros
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--ros-args -r estimate:=/twist", "topic /twist is of TwistStamped: give PoseStamped, "),
        ("--ros-args -r estimate:=/pose -r truth:=/twist", "topic /twist is of TwistStamped"),
        ("--ros-args -p max_rmse:=1deg", "parameter max_rmse is unknown: did you mean max_rms"),
        ("--ros-args -p max_rms:=1", "'1' is not an angle such as 1deg"),
        ("--ros-args -p covariance_axes:=map", "axes 'map' are unknown: give 'world' or 'body'"),
        ("--duration -1", "duration -1.0 is not a time from 1e-9 to 1e10 seconds: give for example 60.0"),
        ("--duration 1e300", "duration 1e+300 is not a time from 1e-9 to 1e10 seconds"),
        (
            "--wait 0.1 --ros-args -r estimate:=/nobody",
            "there is no topic /nobody: topics of types with attitudes are ",
        ),
        ("--truth a.mcap", "--truth goes only with a bag: remap the topic"),
        ("--topic pose:=/b", "--topic goes only with a bag: remap the topic, --ros-args -r truth:=TOPIC"),
        ("--report no/such/folder/a.html", "the folder no/such/folder does not exist: make it"),
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
    assert "interrupted: there is no topic /imu/data: topics of types with attitudes are none" in capfd.readouterr().err


def test_without_ros_it_says_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    assert main([]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "rclpy is not installed" in line


@pytest.mark.ros
def test_of_several_bodies_that_of_the_estimate_is_meant(peer: Peer) -> None:
    from lie_rigid_body import InputError, Scenario
    from lie_rigid_body.evaluation import Limits
    from lie_rigid_body.messages import encode_string
    from lie_rigid_body.runs.live_estimate import LiveEstimate

    for name in ("a", "b"):
        peer.node.create_publisher(String, f"/{name}/lie_rigid_body/scenario", 1)
        peer.node.create_publisher(PoseStamped, f"/{name}/pose", 1)
    for topic in ("/a/imu/data", "/imu/data"):
        peer.node.create_publisher(Imu, topic, 1)
    with Peer("evaluator") as other:  # a graph of its own
        following = Following(other.node, partial(LiveEstimate, limits=Limits()))
        eventually(lambda: len(following.published().keys() - {*OF_EVERY_NODE}) == 6, "all topics")
        assert (
            "topics of types with attitudes are /a/imu/data, /a/pose, /b/pose, /imu/data in domain"
            in following.silence()
        )
        following.estimate = "/a/imu/data"
        following.look()
        assert set(following._subscriptions) == {"/a/imu/data", "/a/lie_rigid_body/scenario", "/a/pose"}
        assert following.live is not None
        unoriented = Imu()
        unoriented.orientation_covariance[0] = -1.0
        following.live.hear_estimates([serialize_message(unoriented)])
        assert "nothing came on /a/lie_rigid_body/scenario, /a/pose" in following.silence()
        following.live.truth.hear_scenarios([encode_string(Segment(Scenario.from_parameters({}), 0, 0).to_json())])
        assert following.silence().startswith("topic /a/imu/data has no orientation")
        following.estimate, following.live = "/imu/data", None
        with pytest.raises(InputError):
            following.look()
