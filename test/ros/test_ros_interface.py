"""What other nodes see and may do: parameters, services, names and the latched scenario."""

from __future__ import annotations

import json
import math
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from simulator_process import DEADLINE, SimulatorProcess, assignments

from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS
from lie_rigid_body.sensors import GRADES
from lie_rigid_body.simulation import Segment
from said import numbers

if find_spec("rclpy"):
    from geometry_msgs.msg import PoseStamped, Twist
    from peer import LATCHED, NODE, Peer
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterType, ParameterValue
    from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
    from rclpy.parameter import Parameter
    from rclpy.qos import QoSProfile, ReliabilityPolicy
    from std_msgs.msg import String
    from std_srvs.srv import Trigger

pytestmark = pytest.mark.ros


def test_late_joiner_gets_the_scenario(observer: Peer) -> None:
    for _ in range(2):
        messages = observer.listen(String, "/lie_rigid_body/scenario", LATCHED)
        observer.spin_until(partial(bool, messages), "the latched scenario")
        segment = Segment.from_json(messages[0].data)
        assert segment.scenario.inertia == (1.0, 2.0, 2.5)
        assert abs(segment.scenario.epoch_ns - time.time_ns()) < 600e9


def test_every_parameter_is_described(observer: Peer) -> None:
    listed = observer.wait_for(observer.parameters().list_parameters([], 0)).result.names
    names = [parameter.name for parameter in PARAMETERS]
    assert set(names) <= set(listed)
    described = dict(
        zip(names, observer.wait_for(observer.parameters().describe_parameters(names)).descriptors, strict=True)
    )
    assert [name for name in names if not described[name].description] == []
    [rate] = described["rate"].floating_point_range
    assert (rate.from_value, rate.to_value) == (1e-6, 1e9)
    [factor] = described["real_time_factor"].floating_point_range
    assert (factor.from_value, factor.to_value) == (0.0, 1e6)
    assert len(described["max_step"].floating_point_range) == 1
    assert len(described["epoch_ns"].integer_range) == 1
    fixed = {"path_file", "path_interval", "path_knots"}
    fixed |= {"stamped_twist", "epoch_ns", "record_path", "publish_clock", "paused", "publish_tf", "marker_rate"}
    fixed |= {"sensor_grade", "imu_orientation", "lockstep_topic", "lockstep_nodes", "lockstep_timeout"}
    assert {name for name in names if described[name].read_only} == fixed
    assert "closed_form" in described["motion"].additional_constraints
    assert "rad/s" in described["initial_body_rate"].description


def test_integers_stand_for_doubles(observer: Peer) -> None:
    assert observer.values("inertia") == [pytest.approx([1.0, 2.0, 2.5])]
    assert observer.set_together(rate=50, inertia=[2, 3, 4]).successful
    inertia, rate = observer.values("inertia", "rate")
    assert (list(inertia), rate) == ([2.0, 3.0, 4.0], 50.0)
    assert isinstance(rate, float)


def test_kicks_may_become_more_and_none(observer: Peer) -> None:
    """rclpy takes an empty list for one of bytes, whoever sends it."""
    [described] = observer.wait_for(observer.parameters().describe_parameters(["kicks"])).descriptors
    assert described.type == ParameterType.PARAMETER_DOUBLE_ARRAY
    one, two = [0.5, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0, 1.5, 1.0, -2.0, 3.0]
    scenarios = observer.listen(String, "/lie_rigid_body/scenario", LATCHED)
    for number, kicks in enumerate(([], one, two, [], one, []), 2):
        [result] = observer.wait_for(observer.parameters().set_parameters([Parameter("kicks", value=kicks)])).results
        assert result.successful, result.reason
        assert list(observer.values("kicks")[0]) == kicks
        assert observer.call("reset").success
        observer.spin_until(lambda count=number: len(scenarios) >= count, "the new scenario")  # type: ignore[misc]
        assert list(Segment.from_json(scenarios[-1].data).scenario.kicks) == kicks
    if shutil.which("ros2"):  # which takes an empty list for one of truth values
        for given in ("[]", str(two), "[]"):
            done = subprocess.run(
                ["ros2", "param", "set", NODE, "kicks", given], capture_output=True, timeout=DEADLINE, check=False
            )
            assert (done.returncode, list(observer.values("kicks")[0])) == (0, json.loads(given))


@pytest.mark.parametrize(
    ("changes", "wrong"),
    [
        ({"kicks": [1.0, 2.0]}, "kicks: "),
        ({"kicks": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]}, "kicks: kick 2 "),
        ({"kicks": [3.0, 0.0, 0.0, 0.0], "kick_period": 2.0}, "kick_period: 2 "),
        ({"translation": "flown"}, "translation: 'flown' "),
        ({"sway_band": [2.0, 1.0]}, "sway_band: "),
        ({"rate": -1.0}, "rate: -1 "),
        ({"inertia": [1.0, 1.0, 3.0]}, "inertia: "),
        ({"method": "rkmk4", "max_step": 10.0, "rate": 0.01}, "max_step: "),
        ({"world_frame": "/world"}, "world_frame: '/world' "),
        ({"stamped_twist": False}, "stamped_twist: "),
        ({"rte": 1.0}, "rte: "),
        ({"": 1.0}, "empty name: "),
        ({"\x1b[2J": 1.0}, r"\x1b[2J: "),
        ({"body_frame": "good", "inertia": [0.0, 1.0, 1.0]}, "inertia: "),
        ({"real_time_factor": -1.0}, "real_time_factor: "),
        ({"real_time_factor": math.nan}, "real_time_factor: "),
        ({"real_time_factor": 20.0, "inertia": [1.0, 1.0, 3.0]}, "inertia: "),
        ({"real_time_factor": 20.0, "imu_rate": -1.0}, "imu_rate: "),
        ({"real_time_factor": 20.0, "paused": True}, "paused: "),
        ({"publish_clock": False}, "publish_clock: "),
        ({"gyro_rate": "guessed"}, "gyro_rate: "),
    ],
)
def test_bad_change_is_refused_with_the_reason(observer: Peer, changes: dict[str, Any], wrong: str) -> None:
    known = [name for name in changes if name in BY_NAME]
    before = observer.values(*known)
    result = observer.set_together(**changes)
    assert not result.successful
    assert result.reason.startswith(wrong)
    assert observer.values(*known) == before


@pytest.mark.parametrize("kind", [0, 42])
def test_a_value_of_no_known_type_is_answered_and_its_neighbours_are_set(observer: Peer, kind: int) -> None:
    unknown = ParameterMessage(name="rate", value=ParameterValue(type=kind))
    known = ParameterMessage(name="sensor_seed", value=ParameterValue(type=2, integer_value=7))
    each = observer.answer(SetParameters, f"{NODE}/set_parameters", SetParameters.Request(parameters=[unknown, known]))
    assert [result.successful for result in each.results] == [False, True]
    assert each.results[0].reason.startswith(f"rate: type {kind} ")
    request = SetParametersAtomically.Request(parameters=[known, unknown])
    together = observer.answer(SetParametersAtomically, f"{NODE}/set_parameters_atomically", request).result
    assert (together.successful, together.reason) == (False, each.results[0].reason)


def test_what_every_node_has_can_be_set(observer: Peer) -> None:
    assert observer.set_together(use_sim_time=False).successful
    assert observer.set_together().successful


@pytest.mark.slow
def test_a_second_node_of_one_name_and_what_has_no_effect_are_warned_about() -> None:
    twin = ["--ros-args", "-r", "__ns:=/twin"]
    soon = "import sys; from lie_rigid_body.ros import node, sim; node.LOOK_INTERVAL = 0.5; node.LOOKS = 200; "
    command = (sys.executable, "-c", f"{soon} sys.exit(sim.main(sys.argv[1:]))", *twin, "-p", "gyro_range:=1.0")
    with (
        SimulatorProcess(*twin),
        subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as second,
    ):
        patience = threading.Timer(DEADLINE, second.kill)
        patience.start()
        try:
            assert second.stderr
            warned = ("gyro_range ", "another node is called /twin/lie_rigid_body")
            for warning in warned:
                assert any(warning in line for line in second.stderr), warning
            second.send_signal(signal.SIGINT)
            assert second.wait(DEADLINE) == 0
        finally:
            patience.cancel()
            second.kill()


@pytest.mark.slow
def test_at_its_end_the_node_says_how_much_it_sent() -> None:
    with SimulatorProcess("--ros-args", "-r", "__ns:=/brief") as simulator:
        assert simulator.end(signal.SIGINT) == 0
    assert simulator.said[-1].startswith("/brief/lie_rigid_body ")
    assert len(numbers(simulator.said[-1])) in (1, 3)  # how many, and of late ones how many and by how much


def test_change_takes_effect_at_the_reset_and_not_before(observer: Peer) -> None:
    scenarios = observer.listen(String, "/lie_rigid_body/scenario", LATCHED)
    poses = observer.listen(PoseStamped, "/pose")
    observer.spin_until(lambda: scenarios and poses, "the scenario and a pose")
    change = {"world_frame": "map", "initial_attitude_xyzw": [1.0, 0.0, 0.0, 0.0], "rate": 40.0}
    assert observer.set_together(**change).successful
    count = len(poses)
    observer.spin_until(lambda: len(poses) > count + 20, "more poses")
    assert {pose.header.frame_id for pose in poses} == {"world"}
    answer = observer.call("reset")
    assert answer.success
    observer.spin_until(lambda: len(scenarios) > 1 and poses[-1].header.frame_id == "map", "the new scenario")
    segment = Segment.from_json(scenarios[-1].data)
    assert str(segment.start_ns) in answer.message
    assert (segment.scenario.world_frame, segment.scenario.rate) == ("map", 40.0)
    observer.spin_until(lambda: len([p for p in poses if p.header.frame_id == "map"]) > 5, "poses of the new motion")
    stamps = [pose.header.stamp.sec * 10**9 + pose.header.stamp.nanosec for pose in poses]
    assert all(a < b for a, b in pairwise(stamps))
    first = poses[stamps.index(segment.start_ns)]
    assert first.header.frame_id == "map"
    assert first.pose.orientation.x == 1.0
    assert stamps[stamps.index(segment.start_ns) + 1] - segment.start_ns == 25_000_000


@pytest.mark.slow
def test_announced_commands_work(full_node: SimulatorProcess) -> None:
    """Without the ros2 command line they are our own; with it, they are not ours to test."""
    listen, reset = (
        line.strip() for line in full_node.said if "--pose" in line or "--reset" in line or "ros2 " in line
    )
    if "ros2 " in listen:
        pytest.skip("the ros2 command line is installed, and announced")
    done = subprocess.run(["env", *shlex.split(reset)], capture_output=True, text=True, timeout=DEADLINE, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert numbers(done.stdout)
    with subprocess.Popen(["env", *shlex.split(listen)], stdout=subprocess.PIPE, text=True) as listener:
        assert listener.stdout is not None
        line = listener.stdout.readline()
        listener.send_signal(signal.SIGINT)
        assert listener.wait(DEADLINE) == 0
    assert re.match(r"\d+\.\d{9} s  x [-+]\d\.\d{6}  y ", line)


def test_names_types_and_qualities_of_service_are_the_users(observer: Peer, full_node: SimulatorProcess) -> None:
    qos = "qos_overrides./a/truth.publisher"
    arguments = ["--ros-args", "-r", "__ns:=/a", "-r", "__node:=top", "-r", "pose:=truth"]
    arguments += assignments(**{"stamped_twist": "false", f"{qos}.reliability": "best_effort", f"{qos}.depth": 7})
    poses = observer.listen(PoseStamped, "/a/truth", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
    twists = observer.listen(Twist, "/a/twist")
    scenarios = observer.listen(String, "/a/top/scenario", LATCHED)
    with SimulatorProcess(*arguments, domain=full_node.domain) as other:
        observer.spin_until(lambda: poses and twists and scenarios, "renamed topics")
        assert observer.answer(Trigger, "/a/top/reset", Trigger.Request()).success
        assert any("/a/truth" in line for line in other.said)
        assert any("/a/top" in line for line in other.said)
        [truth] = observer.publishers("/a/truth")
        [twist] = observer.publishers("/a/twist")
        asked = GetParameters.Request(names=[f"{qos}.depth", f"{qos}.reliability"])
        depth, reliability = observer.answer(GetParameters, "/a/top/get_parameters", asked).values
    qualities = truth.qos_profile.reliability, twist.qos_profile.reliability
    assert qualities == (ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE)
    assert (depth.integer_value, reliability.string_value) == (7, "best_effort")
    assert twists[0].angular.y == pytest.approx(1.0, abs=0.1)
    assert not Segment.from_json(scenarios[0].data).scenario.stamped_twist


@pytest.mark.slow
def test_own_options_give_way_to_ros_arguments_and_later_files(
    observer: Peer, full_node: SimulatorProcess, tmp_path: Path
) -> None:
    file = tmp_path / "p.yaml"
    for_all, for_one = "rate: 20.0, body_frame: from_file", "rate: 21.0"
    file.write_text(f"/**: {{ros__parameters: {{{for_all}}}}}\ntop: {{ros__parameters: {{{for_one}}}}}\n")
    own = ["--scenario", "dzhanibekov", "--params-file", str(file), "-p", "world_frame:=own"]
    graded = ["-p", "imu_rate:=10.0", "-p", "sensor_grade:=mems"]
    single = ["-p", "gyro_turn_on_bias:=0.125"]
    arguments = [*own, *single, "--ros-args", "-r", "__node:=top", "-p", "world_frame:=ros", *graded]
    with SimulatorProcess(*arguments, domain=full_node.domain):
        scenarios = observer.listen(String, "/top/scenario", LATCHED)
        observer.spin_until(lambda: scenarios, "the scenario")
    scenario = Segment.from_json(scenarios[0].data).scenario
    assert (scenario.world_frame, scenario.body_frame, scenario.rate) == ("ros", "from_file", 21.0)
    values = scenario.parameters()
    assert (values["sensor_grade"], values["gyro_turn_on_bias"]) == ("mems", 0.125)
    assert values["gyro_noise_density"] == GRADES["mems"]["gyro_noise_density"]
