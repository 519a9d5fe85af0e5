"""The standard simulator services without ROS between: features, resets, states of a simulation, and steps."""

from __future__ import annotations

from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, cast

import pytest
from simulator_process import DEADLINE
from standard_simulator import (
    ALREADY_THERE,
    EPOCH,
    FAILED,
    INCORRECT_TRANSITION,
    NAME,
    OK,
    PAUSED,
    PLAYING,
    QUITTING,
    SCENARIO,
    STOPPED,
    UNSUPPORTED,
    Simulator,
    running,
    wanted,
)

from lie_rigid_body.ros.timing.live_run import RunState
from lie_rigid_body.scenario import Scenario

if find_spec("rclpy"):
    from standard_messages import FEATURE_OF, RESPONSES, feedback

    from lie_rigid_body.ros.control.services import StandardServices, snake_case

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


def test_names_are_in_snake_case() -> None:
    assert snake_case("GetSimulatorFeatures") == "get_simulator_features"


def test_features_are_those_that_are_served(paused: Simulator) -> None:
    """Numbers of simulation_interfaces/SimulatorFeatures."""
    features = paused.ask("get_simulator_features").features
    served = {"state getting": 10, "state setting": 11, "info": 12, "reset": 20, "reset of the state": 22}
    served |= {"get": 24, "set": 25, "pause": 26, "one step": 31, "steps": 32, "the action": 33, "categories": 8}
    assert set(features.features) == set(served.values())
    assert features.spawn_formats == []
    assert features.custom_info


def test_every_standard_service_is_offered_or_declared_unsupported(paused: Simulator) -> None:
    features = set(paused.ask("get_simulator_features").features.features)
    offered = {name for name in FEATURE_OF if hasattr(paused.services, name)}
    assert offered == set(RESPONSES)
    assert offered == {name for name, feature in FEATURE_OF.items() if feature is None or feature in features}


@pytest.mark.parametrize(
    ("scope", "code"), [(0, OK), (1, UNSUPPORTED), (2, OK), (3, OK), (4, UNSUPPORTED), (5, UNSUPPORTED), (255, OK)]
)
def test_a_reset_needs_the_state_in_its_scope(paused: Simulator, scope: int, code: int) -> None:
    assert paused.code("reset_simulation", scope=scope) == code
    assert len(paused.sink.segments) == (2 if code == OK else 1)


def test_a_parameter_that_makes_no_scenario_is_answered() -> None:
    def broken() -> Scenario:
        return Scenario.from_parameters({"rate": -1.0})

    with running(paused=True) as simulator:
        services = StandardServices(simulator.live, broken, NAME)
        for service, request in (
            (services.reset_simulation, SimpleNamespace(scope=0)),
            (services.set_simulation_state, SimpleNamespace(state=SimpleNamespace(state=STOPPED))),
        ):
            answer = service(request, RESPONSES["reset_simulation"]()).result
            assert (answer.result, "rate" in answer.error_message) == (FAILED, True)
        assert simulator.live.state is RunState.PAUSED


def test_whatever_goes_wrong_is_answered(paused: Simulator) -> None:
    """Else whoever asked would wait for ever."""

    def broken() -> Scenario:
        raise ZeroDivisionError

    services = StandardServices(paused.live, broken, NAME)
    answer = services.reset_simulation(SimpleNamespace(scope=0), RESPONSES["reset_simulation"]()).result
    assert (answer.result, answer.error_message) == (FAILED, "ZeroDivisionError")


@pytest.mark.parametrize(
    ("before", "to", "code", "after"),
    [
        (PLAYING, PLAYING, ALREADY_THERE, PLAYING),
        (PLAYING, PAUSED, OK, PAUSED),
        (PLAYING, STOPPED, OK, STOPPED),
        (PAUSED, PAUSED, ALREADY_THERE, PAUSED),
        (PAUSED, PLAYING, OK, PLAYING),
        (PAUSED, STOPPED, OK, STOPPED),
        (STOPPED, STOPPED, ALREADY_THERE, STOPPED),
        (STOPPED, PLAYING, OK, PLAYING),
        (STOPPED, PAUSED, INCORRECT_TRANSITION, STOPPED),
        (PLAYING, 4, UNSUPPORTED, PLAYING),
        (PAUSED, 255, UNSUPPORTED, PAUSED),
    ],
)
def test_transitions(paused: Simulator, before: int, to: int, code: int, after: int) -> None:
    if before != PAUSED:
        assert paused.go_to(before) == OK
    assert (paused.state, paused.go_to(to), paused.state) == (before, code, after)


def test_quitting_ends_the_run_and_later_calls_are_answered(playing: Simulator) -> None:
    assert playing.go_to(QUITTING) == OK
    assert playing.interruption.requested
    requests: dict[str, dict[str, object]] = {
        "reset_simulation": {"scope": 0},
        "step_simulation": {"steps": 1},
        "get_entity_state": {"entity": NAME},
        "set_entity_state": {"entity": NAME, "state": wanted()},
    }
    for service, request in requests.items():
        assert playing.code(service, **request) == FAILED, service


class Goal:
    """A goal of the action, as rclpy hands it over."""

    def __init__(self, steps: int, cancel_after: int | None = None) -> None:
        self.request = SimpleNamespace(steps=steps)
        self.ends: list[str] = []
        self.reports: list[tuple[int, int]] = []
        self._cancel_after = cancel_after

    @property
    def is_cancel_requested(self) -> bool:
        return self._cancel_after is not None and len(self.reports) >= self._cancel_after

    def publish_feedback(self, message: Any) -> None:
        self.reports.append((message.completed_steps, message.remaining_steps))

    def succeed(self) -> None:
        self.ends.append("succeed")

    def abort(self) -> None:
        self.ends.append("abort")

    def canceled(self) -> None:
        self.ends.append("canceled")


@pytest.mark.parametrize("steps", [1, 2, 700])
def test_steps_come_while_paused(paused: Simulator, steps: int) -> None:
    assert paused.code("step_simulation", steps=steps) == OK
    assert paused.sink.stamps == [EPOCH + k * 10**6 for k in range(steps)]
    assert paused.state == PAUSED


@pytest.mark.parametrize("state", [PLAYING, STOPPED])
def test_steps_fail_unless_paused(paused: Simulator, state: int) -> None:
    assert paused.go_to(state) == OK
    assert paused.code("step_simulation", steps=1) == FAILED
    goal = Goal(1)
    answer = paused.services.simulate_steps(cast(Any, goal), RESPONSES["simulate_steps"](), feedback)
    assert answer.result.result == FAILED
    assert goal.ends == ["abort"]


@pytest.mark.parametrize("steps", [0, 2**64 - 1])
def test_impossible_numbers_of_steps_fail(paused: Simulator, steps: int) -> None:
    assert paused.code("step_simulation", steps=steps) == FAILED
    assert paused.sink.stamps == []


def test_the_action_reports_and_succeeds(paused: Simulator) -> None:
    goal = Goal(600)
    answer = paused.services.simulate_steps(cast(Any, goal), RESPONSES["simulate_steps"](), feedback)
    assert (answer.result.result, goal.ends, goal.reports[-1]) == (OK, ["succeed"], (600, 0))
    assert [completed + remaining for completed, remaining in goal.reports] == [600] * len(goal.reports)
    assert len(paused.sink.stamps) == 600


def test_the_action_can_be_canceled(paused: Simulator) -> None:
    goal = Goal(10**9, cancel_after=1)
    answer = paused.services.simulate_steps(cast(Any, goal), RESPONSES["simulate_steps"](), feedback)
    assert (answer.result.result, goal.ends) == (FAILED, ["canceled"])
    count = len(paused.sink.stamps)
    assert f"{count} of {10**9}" in answer.result.error_message
    assert paused.state == PAUSED
    assert paused.code("step_simulation", steps=1) == OK
    assert paused.sink.stamps == [EPOCH + k * 10**6 for k in range(count + 1)]


def test_a_cancel_that_comes_too_late_stops_nobody_else(paused: Simulator) -> None:
    """Time passes again, or another asks for steps, between its end and the cancel."""
    live = paused.live
    over = live.ask(live.step, 1)
    assert over.wait(DEADLINE)
    under_way = live.ask(live.step, 10**9)
    live.ask(live.cancel, over)
    assert not under_way.wait(0.01)
    assert paused.go_to(PLAYING) == OK
    live.ask(live.cancel, under_way)
    assert paused.state == PLAYING


def test_the_action_says_what_broke_it_off(paused: Simulator) -> None:
    goal = Goal(10**9)
    goal.publish_feedback = lambda message: paused.live.ask(paused.live.reset, SCENARIO)  # type: ignore[method-assign,assignment]
    answer = paused.services.simulate_steps(cast(Any, goal), RESPONSES["simulate_steps"](), feedback)
    assert (answer.result.result, goal.ends) == (FAILED, ["abort"])
