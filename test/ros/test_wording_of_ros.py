"""What the room `ros` says when it refuses, as far as no node need run for it: value, limit and remedy, in one line."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import pytest

from lie_rigid_body import LieRigidBodyError
from lie_rigid_body.ros import launching
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.ros.listen import main as listen
from lie_rigid_body.ros.publishing.announcement import announcement, farewell
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import LOOK_NS, Lockstep
from lie_rigid_body.ros.timing.requests import Mailbox, StepRequest
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interruption import Interruption

if find_spec("rclpy"):
    from lie_rigid_body.ros.control.parameters import NodeParameters, descriptor
    from lie_rigid_body.ros.control.services import StandardServices, offer_triggers
    from lie_rigid_body.ros.node import SimulatorNode

PHRASES = {
    # launch files
    "no body": "does not begin with a name of its own: give NAME:SCENARIO",
    "no metres": "is not a number: give metres",
    "no argument": "{file} has no argument '{name}'",
    "no executable": "executable: that of {package} is not known: give executable:=NAME",
    "no remapping": "is not FROM:=TO: give for example imu:=imu/data_raw",
    # arguments of the simulator
    "one name": "{first} and {second} would both be {name}: give each a name of its own",
    "long name": "this node would have a name of {count} characters: at most 200 leave room for those of its services",
    "kept": "exists and is kept: give another name, or move it away",
    "depth": "depth {depth} is outside [1, 2147483647]: give for example 10",
    "for every node": "every ROS 2 node has it, and no scenario: give it to sim after --ros-args",
    "refused by ROS": "ROS refuses --ros-args {given}: ",
    "paused": "as it is how the node starts: call ~/pause or ~/resume",
    "made at the start": "as publishers are made at the start: start the node anew",
    # its environment
    "domain": "ROS_DOMAIN_ID {given} is above 232",
    "middleware": "RMW_IMPLEMENTATION '{given}' is not installed",
    "log folder": ": name a folder that can be written as ROS_LOG_DIR",
    "limited": "limited to {what} (ulimit -",
    "a switch": "{name} is '{given}': give 0 or 1",
    "peers": ": name machines that are known as ROS_STATIC_PEERS",
    "no keys": "ROS_SECURITY_KEYSTORE is empty",
    "bad keys": ": mend the keys in ROS_SECURITY_KEYSTORE",
    # lock-step
    "without an IMU": "lockstep_topic: {topic} can answer no reading without an IMU: give imu_rate",
    "own topic": "lockstep_topic: {topic} is a topic of this node itself: give that of a filter",
    "one filter": "waits for one node that publishes {topic} and hears {readings}, of which there are {count}",
    "subscriptions": "subscriptions of {node}",
    "lock-step": "lock-step with {filter}, which hears {sensors} and answers on {topic}",
    # a filter
    "no filter": "is not there after {seconds} s: missing: one node that publishes {topic} ",
    "ended": "ended with status {status}",
    "no answer": "no answer to {stamp} ns in {seconds} s",
    "other frames": "not of world to base_link",
    "no orientation": "has no orientation",
    # an evaluation
    "only with a bag": "--{option} goes only with a bag: remap the topic",
    "unknown parameter": "parameter {name} is unknown: did you mean {like}",
    "no topic": "there is no topic {topic}: topics of types with attitudes are ",
    "not finite": "are not finite",
    "silence": "nothing yet on {topic} in domain {domain}: is the node running?",
}
"""What refusals and lines on the terminal have in them, where other tests run a node or a launch file for it."""
NAMES = {
    "~": "/a/top",
    "pose": "/a/truth",
    "twist": "/a/twist",
    "~/scenario": "/a/top/scenario",
    "~/reset": "/a/top/reset",
    "imu/data_raw": "/a/imu",
    "imu/bias": "/a/bias",
    "~/faults": "/a/top/faults",
}
"""Full names of topics and services of a node, by their relative names."""
NS = 10**9
SCENARIO = Scenario.from_parameters({"motion": "closed_form"})
ENDED = SimpleNamespace(process_name="it-3", returncode=-6)


class DirectMailbox(Mailbox):
    """A mailbox of a run without a loop, which makes every call at once."""

    def request(self, function: Any, *args: Any, **kwargs: Any) -> Any:
        return function(*args, **kwargs)


def phrase(name: str, /, **values: object) -> str:
    """A phrase of the table with its values."""
    return PHRASES[name].format_map(values)


def live(*, paused: bool = False, mailbox: Mailbox | None = None) -> LiveRun:
    run = LiveRun(Simulation(SCENARIO, 0), [], mailbox or DirectMailbox(), Interruption(), paused=paused)
    run.latest = 0, SCENARIO.start()
    return run


def abandoned() -> StepRequest:
    request = StepRequest(0, 10)
    request.abandon("paused")
    return request


def closed() -> LiveRun:
    mailbox = Mailbox()
    mailbox.close()
    return live(mailbox=mailbox)


def standard(service: str, *, paused: bool = False, stopped: bool = False, **request: Any) -> None:
    """Ask a standard service, and raise what it answers."""
    run = live(paused=paused)
    if stopped:
        run._begin(run.segment)
        run.stop(SCENARIO)
    response = SimpleNamespace(result=SimpleNamespace(), info=SimpleNamespace(category=SimpleNamespace()))
    answer = getattr(StandardServices(run, lambda: SCENARIO, "top"), service)(SimpleNamespace(**request), response)
    if answer.result.error_message:
        raise LieRigidBodyError(answer.result.error_message)


def go_to(state: int, *, paused: bool = False, stopped: bool = False) -> None:
    standard("set_simulation_state", paused=paused, stopped=stopped, state=SimpleNamespace(state=state))


def find(pattern: str, *tags: str) -> None:
    named = {"tags": SimpleNamespace(tags=tags), "bounds": SimpleNamespace(points=[])}
    standard("get_entities", filters=SimpleNamespace(filter=pattern, categories=[], **named))


def put(
    frame: str = "",
    position: tuple[float, ...] = (0.0, 0.0, 0.0),
    attitude: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0),
    linear: tuple[float, ...] = (0.0, 0.0, 0.0),
    angular: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> None:
    """Ask for a state of the body."""
    fields = [
        SimpleNamespace(**dict(zip("xyzw", values, strict=False))) for values in (position, attitude, linear, angular)
    ]
    pose, twist = (
        SimpleNamespace(position=fields[0], orientation=fields[1]),
        SimpleNamespace(linear=fields[2], angular=fields[3]),
    )
    wanted = SimpleNamespace(header=SimpleNamespace(frame_id=frame), pose=pose, twist=twist)
    standard("set_entity_state", entity="top", state=wanted)


def triggered(service: str) -> str:
    """What a service of the node answers."""
    run: Any = live(paused=True)
    handlers: dict[str, Any] = {}
    run.step = lambda count: SimpleNamespace(wait=lambda: None)
    node: Any = SimpleNamespace(create_service=lambda kind, name, handle, **given: handlers.update({name: handle}))
    offer_triggers(node, run, lambda: SCENARIO)
    response: Any = handlers[f"~/{service}"](None, SimpleNamespace(success=False))
    return str(response.message)


def changed(name: str, kind: int) -> None:
    """A change of a parameter that cannot be."""
    node: Any = SimpleNamespace()
    NodeParameters._read(node, SimpleNamespace(name=name, value=SimpleNamespace(type=kind)))


def constraints(name: str) -> str:
    """What ``ros2 param describe`` tells of a parameter beside its description."""
    return str(descriptor(BY_NAME[name]).additional_constraints)


def unanswered(others: int) -> None:
    """A filter that is silent, though so many other messages of it come."""
    lockstep = Lockstep("/imu/data", lambda: ("imu",), NS)
    lockstep.begin_segment(["imu"])
    lockstep.holds(0)
    lockstep.sent([("imu", NS)])
    for stamp in range(others):
        lockstep.hear(stamp)
    for steady in range(0, 3 * NS, LOOK_NS):
        lockstep.holds(steady)


def logged(failure: str) -> str:
    """What the node's log says when its recording has failed."""
    told: list[str] = []
    log, diagnostics = SimpleNamespace(error=told.append), SimpleNamespace(report_failure=lambda reason: None)
    node: Any = SimpleNamespace(get_logger=lambda: log, _diagnostics=diagnostics)
    SimulatorNode.report_failure(node, failure)
    return "".join(told)


def why_launch_ends(handle: Callable[[Any, Any], object], status: int) -> object:
    """The reason that launch, which PyPI does not have, is given when a part has ended."""
    stand_in = SimpleNamespace(Shutdown=lambda reason: reason)
    with patch.dict(sys.modules, {"launch": stand_in, "launch.actions": stand_in}):
        return handle(SimpleNamespace(process_name="it-3", returncode=status), SimpleNamespace(is_shutdown=False))


def without(package: str) -> None:
    with patch.dict(sys.modules, {package: None}):
        require_ros()


@pytest.mark.parametrize(
    ("act", "said"),
    [
        (
            lambda: live().step(1),
            "the run is playing: pause it before a step",
        ),
        (
            lambda: live(paused=True).step(0),
            "0 steps are none: ask for at least 1",
        ),
        (
            lambda: live(paused=True).step(10**15),
            "steps: 1000000000000000 lead to 9999999999999990000000 ns, beyond the last stamp "
            "2147483647000000000: give fewer",
        ),
        (
            lambda: [run.step(3) for run in [live(paused=True)] * 2],
            "0 of 3 steps are done: wait, or pause",
        ),
        (
            lambda: abandoned().wait(),
            "paused after 0 of 10 steps: ask for the rest again",
        ),
        (
            lambda: closed().ask(int),
            "the node is ending: start it again",
        ),
        (
            lambda: without("rclpy"),
            "rclpy is not installed: source /opt/ros/jazzy/setup.bash; without it, on Python 3.12, pip install "
            "'.[ros]'; or use what needs no ROS, 'record' and 'evaluate BAG'",
        ),
        (
            lambda: launching.require_known("/launch/sim.launch.py", ["rte:=1.0"], ["rate"]),
            "rte:=1.0: sim.launch.py has no argument 'rte': did you mean rate? --show-args lists those that it has",
        ),
        (
            lambda: launching.require_executables(("mine", "filter")),
            "filter of the package mine is not there: nothing was started; source its workspace, or apt install"
            " ros-jazzy-mine",
        ),
        (
            lambda: launching.fail_unless_shut_down(ENDED, SimpleNamespace(is_shutdown=False)),
            "it-3 ended with status -6: the rest is ended as well",
        ),
        (
            lambda: unanswered(3),
            "/imu/data: no answer to 1000000000 ns in 1 s; 3 others came, last 2 ns: let the filter "
            "answer each pair of readings, and not by a timer",
        ),
        (
            lambda: unanswered(0),
            "/imu/data: no answer to 1000000000 ns in 1 s; none came: let the filter "
            "answer each pair of readings, and not by a timer",
        ),
    ],
)
def test_a_refusal_in_one_line(act: Any, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "launch", "lie_rigid_body", "sim.launch.py"])
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    with pytest.raises(LieRigidBodyError) as caught:
        act()
    assert str(caught.value) == said


@pytest.mark.ros
@pytest.mark.parametrize(
    ("act", "said"),
    [
        (
            lambda: changed("rate", 42),
            "rate: type 42 is none of rcl_interfaces/ParameterType: give 0 to 9",
        ),
        (
            lambda: changed("stamped_twist", 1),
            "stamped_twist: fixed at the start, as a topic keeps its type: start the node anew with it",
        ),
        (
            lambda: standard("reset_simulation", scope=4),
            "scope 4 leaves out the state, which is all that a reset changes: give SCOPE_STATE (2) or SCOPE_ALL (255)",
        ),
        (
            lambda: go_to(9),
            "state 9 is none of 0 stopped, 1 playing, 2 paused, 3 quit",
        ),
        (
            lambda: go_to(1),
            "the simulation is playing already",
        ),
        (
            lambda: go_to(2, paused=True),
            "the simulation is paused already",
        ),
        (
            lambda: go_to(2, stopped=True),
            "the simulation is stopped: play it before it can be paused",
        ),
        (
            lambda: standard("step_simulation", steps=1),
            "the run is playing: pause it before a step",
        ),
        (
            lambda: find("", "x"),
            "filters by tags and by bounds are unsupported: leave them out",
        ),
        (
            lambda: find("("),
            "filter '(' is no regular expression (missing ), unterminated subpattern at position 0): give another, "
            "or none",
        ),
        (
            lambda: standard("get_entity_info", entity="robot"),
            "there is no entity 'robot': the body is 'top'",
        ),
        (
            lambda: put(frame="moon"),
            "frame 'moon' is unknown: give pose and twist in 'world', or leave it empty",
        ),
        (
            lambda: put(position=(1.0, 0.0, 0.0)),
            "position [1.0, 0.0, 0.0] is not 0, where the mass centre stays: give 0",
        ),
        (
            lambda: put(linear=(0.0, 2.0, 0.0)),
            "linear velocity [0.0, 2.0, 0.0] is not 0: give 0, the mass centre stays",
        ),
        (
            lambda: put(angular=(0.0, 0.0, float("nan"))),
            "angular velocity [0.0, 0.0, nan] is not finite: give numbers",
        ),
        (
            lambda: put(attitude=(0.0, 0.0, 0.0, 2.0)),
            "attitude_xyzw: norm 2 is not 1 within 1e-06: divide the quaternion x y z w by its norm",
        ),
    ],
)
def test_a_refusal_of_a_standard_service_in_one_line(act: Any, said: str) -> None:
    with pytest.raises(LieRigidBodyError) as caught:
        act()
    assert str(caught.value) == said


@pytest.mark.ros
@pytest.mark.parametrize(
    ("tell", "said"),
    [
        (lambda: triggered("pause"), "time stands still at -1 ns"),
        (lambda: triggered("resume"), "time goes on"),
        (lambda: triggered("step"), "sent the sample stamped 0 ns"),
        (lambda: triggered("reset"), "the sample stamped 0 ns begins the motion anew"),
        (lambda: farewell("/top", Punctuality()), "/top ends: 0 truth samples sent, none of them late"),
        (
            lambda: farewell("/top", Punctuality(2, 1, 0, 3 * 10**6)),
            "/top ends: 2 truth samples sent, 1 of them late, by up to 3 ms",
        ),
        (lambda: constraints("real_time_factor"), "a change takes effect at once"),
        (lambda: constraints("imu_rate"), "a change takes effect at the next ~/reset"),
        (lambda: constraints("marker_rate"), "fixed at the start"),
        (lambda: constraints("inertia"), "3 or 6 finite numbers; a change takes effect at the next ~/reset"),
        (lambda: logged("a.mcap is lost"), "a.mcap is lost; publishing goes on"),
        (lambda: why_launch_ends(launching.shut_down_if_failed, -6), "it-3 failed"),
        (lambda: why_launch_ends(launching.end_with_status, 0), "the evaluation is complete"),
    ],
)
def test_an_answer_in_one_line(tell: Callable[[], str], said: str) -> None:
    assert tell() == said


@pytest.mark.ros
@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("--reset /nobody", "no service /nobody in domain "),
        ("--scenario /nobody", "nothing on /nobody in domain "),
        ("--get rate --node /nobody", "no node /nobody in domain "),
    ],
)
def test_whom_nobody_answers_is_told_in_one_line(
    asked: str, said: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(import_module("lie_rigid_body.ros.client"), "LONGEST_SILENCE", 0.1)
    assert listen(asked.split()) == 2
    [line] = capfd.readouterr().err.splitlines()
    assert said in line
    assert line.endswith(": is the node running?")


ANNOUNCED = [
    "/a/top simulates a torque-free rigid body",
    "  body      asymmetric top, inertia 1 2 2.5 kg m²",
    "  start     body rate 0.01 1 0.01 rad/s, attitude 0 0 0 1 (x y z w)",
    "  motion    closed_form, the exact solution",
    "publishes 250 times a second, in ROS domain 42",
    "  /a/truth  PoseStamped in map",
    "  /a/twist  Twist in base_link",
    "  /a/top/scenario  the whole scenario, latched",
    "  /a/imu /a/bias  of the sensors",
    "records /tmp/a.mcap",
    "listen and reset from another terminal",
]
"""What a node says at its start, before the commands."""


def test_what_is_done_is_said_at_the_start() -> None:
    frame = {"stamped_twist": False, "world_frame": "map"}
    scenario = Scenario(inertia=[1, 2, 2.5], rate=250.0, motion="closed_form", imu_rate=10.0, **frame)
    said = announcement(scenario, NAMES, 42, "/tmp/a.mcap").splitlines()
    assert said[: len(ANNOUNCED)] == ANNOUNCED
    assert said[-1] == "Ctrl-C ends it."
