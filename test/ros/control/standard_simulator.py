"""A run that the standard simulator services are asked about without ROS between, and their numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from threading import Thread
from types import SimpleNamespace
from typing import Any

from fake_time import KeepingSink

from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.requests import Mailbox
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interruption import Interruption

if find_spec("rclpy"):
    from standard_messages import RESPONSES, entity_state

    from lie_rigid_body.ros.control.services import StandardServices

UNSUPPORTED, OK, NOT_FOUND, FAILED = 0, 1, 2, 4
INVALID_POSE = ALREADY_THERE = 101
INCORRECT_TRANSITION = 103
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
NAME = "lie_rigid_body"
EPOCH = 10**18
BODY = {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "world_frame": "map"}
START = {"initial_body_rate": [0.7, -1.3, 0.4], "initial_attitude_xyzw": [0.5, -0.5, 0.5, 0.5]}
SCENARIO = Scenario.from_parameters({"motion": "closed_form", "rate": 1000.0, **BODY, **START})


class Simulator:
    """A run in a thread of its own, and the services in front of it."""

    def __init__(self, interruption: Interruption, mailbox: Mailbox, scenario: Scenario, *, paused: bool) -> None:
        self.interruption = interruption
        self.sink = KeepingSink(interruption, 2**63)
        self.live = LiveRun(Simulation(scenario, EPOCH), [self.sink], mailbox, interruption, paused=paused)
        self.services = StandardServices(self.live, lambda: scenario, NAME)

    def ask(self, service: str, **request: Any) -> Any:
        return getattr(self.services, service)(SimpleNamespace(**request), RESPONSES[service]())

    def code(self, service: str, **request: Any) -> int:
        answer = self.ask(service, **request).result
        assert (answer.error_message == "") == (answer.result == OK)
        return int(answer.result)

    def go_to(self, state: int) -> int:
        return self.code("set_simulation_state", state=SimpleNamespace(state=state))

    @property
    def state(self) -> int:
        answer = self.ask("get_simulation_state")
        assert answer.result.result == OK
        return int(answer.state.state)


@contextmanager
def running(*, paused: bool, **given: object) -> Iterator[Simulator]:
    interruption, mailbox = Interruption(), Mailbox()
    scenario = Scenario.from_parameters({**SCENARIO.parameters(), **given})
    simulator = Simulator(interruption, mailbox, scenario, paused=paused)
    thread = Thread(target=simulator.live.run, daemon=True)
    thread.start()
    simulator.live.ask(lambda: None)  # it has begun
    try:
        yield simulator
    finally:
        if thread.is_alive() and not interruption.requested:
            simulator.live.ask(simulator.live.quit)
        thread.join(10.0)
        assert not thread.is_alive()


def wanted(
    angular: object = (0.0, 0.0, 0.0),
    attitude: object = (0.0, 0.0, 0.0, 1.0),
    position: object = (0.0, 0.0, 0.0),
    linear: object = (0.0, 0.0, 0.0),
    frame: str = "",
) -> Any:
    state = entity_state()
    state.header.frame_id = frame
    fields = (state.pose.position, state.pose.orientation, state.twist.linear, state.twist.angular)
    for field, values in zip(fields, (position, attitude, linear, angular), strict=True):
        for name, value in zip("xyzw", values, strict=False):  # type: ignore[call-overload]
            setattr(field, name, float(value))
    return state
