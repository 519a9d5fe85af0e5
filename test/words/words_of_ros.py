"""What the room `ros` says, as far as no node need run for it."""
# mypy: ignore-errors

from __future__ import annotations

import os
import sys
from types import SimpleNamespace
from unittest.mock import patch

from lie_rigid_body import LieRigidBodyError
from lie_rigid_body.ros import launching
from lie_rigid_body.ros.control.parameters import NodeParameters, descriptor
from lie_rigid_body.ros.control.services import StandardServices, offer_triggers
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.ros.node import SimulatorNode
from lie_rigid_body.ros.publishing.announcement import announcement, farewell
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import LOOK_NS, Lockstep
from lie_rigid_body.ros.timing.requests import Mailbox, StepRequest
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interruption import Interruption

NS = 10**9
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
SCENARIO = Scenario.from_parameters({"motion": "closed_form"})
ZERO = (0.0, 0.0, 0.0)
ENDED = SimpleNamespace(process_name="it-3", returncode=-6)


class DirectMailbox(Mailbox):
    """A mailbox of a run without a loop, which makes every call at once."""

    def request(self, function, *args, **kwargs):
        return function(*args, **kwargs)


def live(*, paused=False, mailbox=None):
    run = LiveRun(Simulation(SCENARIO, 0), [], mailbox or DirectMailbox(), Interruption(), paused=paused)
    run.latest = 0, SCENARIO.start()
    return run


def abandoned():
    request = StepRequest(0, 10)
    request.abandon("paused")
    return request


def closed():
    mailbox = Mailbox()
    mailbox.close()
    return live(mailbox=mailbox)


def standard(service, *, paused=False, stopped=False, **request):
    """Ask a standard service, and raise what it answers."""
    run = live(paused=paused)
    if stopped:
        run._begin(run.segment)
        run.stop(SCENARIO)
    response = SimpleNamespace(result=SimpleNamespace(), info=SimpleNamespace(category=SimpleNamespace()))
    answer = getattr(StandardServices(run, lambda: SCENARIO, "top"), service)(SimpleNamespace(**request), response)
    if answer.result.error_message:
        raise LieRigidBodyError(answer.result.error_message)


def go_to(state, *, paused=False, stopped=False):
    standard("set_simulation_state", paused=paused, stopped=stopped, state=SimpleNamespace(state=state))


def find(pattern, *tags):
    named = {"tags": SimpleNamespace(tags=tags), "bounds": SimpleNamespace(points=[])}
    standard("get_entities", filters=SimpleNamespace(filter=pattern, categories=[], **named))


def put(frame="", position=ZERO, attitude=(*ZERO, 1.0), linear=ZERO, angular=ZERO):
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


def triggered(service):
    """What a service of the node answers."""
    run = live(paused=True)
    handlers = {}
    run.step = lambda count: SimpleNamespace(wait=lambda: None)
    node = SimpleNamespace(create_service=lambda kind, name, handle, **given: handlers.update({name: handle}))
    offer_triggers(node, run, lambda: SCENARIO)
    response = handlers[f"~/{service}"](None, SimpleNamespace(success=False))
    return str(response.message)


def changed(name, kind):
    """A change of a parameter that cannot be."""
    node = SimpleNamespace()
    NodeParameters._read(node, SimpleNamespace(name=name, value=SimpleNamespace(type=kind)))


def constraints(name):
    """What ``ros2 param describe`` tells of a parameter beside its description."""
    return str(descriptor(BY_NAME[name]).additional_constraints)


def unanswered(others):
    """A filter that is silent, though so many other messages of it come."""
    lockstep = Lockstep("/imu/data", lambda: ("imu",), NS)
    lockstep.begin_segment(["imu"])
    lockstep.holds(0)
    lockstep.sent([("imu", NS)])
    for stamp in range(others):
        lockstep.hear(stamp)
    for steady in range(0, 3 * NS, LOOK_NS):
        lockstep.holds(steady)


def logged(failure):
    """What the node's log says when its recording has failed."""
    told = []
    log, diagnostics = SimpleNamespace(error=told.append), SimpleNamespace(report_failure=lambda reason: None)
    node = SimpleNamespace(get_logger=lambda: log, _diagnostics=diagnostics)
    SimulatorNode.report_failure(node, failure)
    return "".join(told)


def without(package, distribution=""):
    with patch.dict(sys.modules, {package: None}), patch.dict(os.environ, {"ROS_DISTRO": distribution}):
        require_ros()


def announced(bag="", **scenario):
    with patch("shutil.which", lambda name: None):
        return announcement(Scenario(**scenario), NAMES, 42, bag)


REFUSED = {
    LieRigidBodyError: [
        lambda: live().step(1),
        lambda: live(paused=True).step(0),
        lambda: live(paused=True).step(10**15),
        lambda: [run.step(3) for run in [live(paused=True)] * 2],
        lambda: abandoned().wait(),
        lambda: closed().ask(int),
        lambda: without("rclpy"),
        lambda: without("visualization_msgs", "lyrical"),
        lambda: launching.fail_unless_shut_down(ENDED, SimpleNamespace(is_shutdown=False)),
        lambda: unanswered(3),
        lambda: unanswered(0),
        lambda: changed("rate", 42),
        lambda: changed("stamped_twist", 1),
        lambda: standard("reset_simulation", scope=4),
        lambda: go_to(9),
        lambda: go_to(1),
        lambda: go_to(2, paused=True),
        lambda: go_to(2, stopped=True),
        lambda: standard("step_simulation", steps=1),
        lambda: find("", "x"),
        lambda: find("("),
        lambda: find("(a*)*b"),
        lambda: standard("get_entity_info", entity="robot"),
        lambda: put(frame="moon"),
        lambda: put(position=(2e9, 0.0, 0.0)),
        lambda: put(linear=(0.0, 2.0, 0.0)),
        lambda: put(angular=(0.0, 0.0, float("nan"))),
        lambda: put(attitude=(0.0, 0.0, 0.0, 2.0)),
    ],
}
SAID = [
    lambda: triggered("pause"),
    lambda: triggered("resume"),
    lambda: triggered("step"),
    lambda: triggered("reset"),
    lambda: announced(inertia=[1, 2, 2.5], rate=250, stamped_twist=False, world_frame="map"),
    lambda: announced("/tmp/a.mcap", motion="closed_form", imu_rate=10.0, gyro_temperature_drift=1e-6),
    lambda: announced(kicks=[1.0, 0.0, 0.0, 0.0], kick_period=3.0, translation="carried", sway_acceleration=[1, 2, 3]),
    lambda: announced(translation="carried", imu_rate=10.0, accelerometer_mode="free_fall"),
    lambda: farewell("/top", Punctuality()),
    lambda: farewell("/top", Punctuality(2, 1, 0, 3 * 10**6)),
    lambda: constraints("real_time_factor"),
    lambda: constraints("imu_rate"),
    lambda: constraints("marker_rate"),
    lambda: constraints("inertia"),
    lambda: constraints("kicks"),
    lambda: logged("a.mcap is lost"),
]
