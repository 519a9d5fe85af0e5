"""The standard simulator services without ROS between: features, resets, states of a simulation, steps, and the body.

The body is the one entity: found by filters, told and set in the world, or refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulator_process import DEADLINE
from standard_simulator import (
    ALREADY_THERE,
    EPOCH,
    FAILED,
    INCORRECT_TRANSITION,
    INVALID_POSE,
    NAME,
    NOT_FOUND,
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
    from standard_messages import RESPONSES, entity_filters, entity_state, feedback

    from lie_rigid_body.ros.control.services import StandardServices

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


@pytest.fixture
def paused() -> Iterator[Simulator]:
    with running(paused=True) as simulator:
        yield simulator


def test_features_are_those_that_are_served(paused: Simulator) -> None:
    """Numbers of simulation_interfaces/SimulatorFeatures."""
    features = paused.ask("get_simulator_features").features
    served = {"state getting": 10, "state setting": 11, "info": 12, "reset": 20, "reset of the state": 22}
    served |= {"get": 24, "set": 25, "pause": 26, "one step": 31, "steps": 32, "the action": 33, "categories": 8}
    assert set(features.features) == set(served.values())
    assert features.spawn_formats == []
    assert features.custom_info


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
        broken_services = StandardServices(simulator.live, broken, NAME)
        for service, request in (
            (broken_services.reset_simulation, SimpleNamespace(scope=0)),
            (broken_services.set_simulation_state, SimpleNamespace(state=SimpleNamespace(state=STOPPED))),
        ):
            answer = service(request, RESPONSES["reset_simulation"]()).result
            assert (answer.result, "rate" in answer.error_message) == (FAILED, True)
        assert simulator.live.state is RunState.PAUSED


def test_whatever_goes_wrong_is_answered(paused: Simulator) -> None:
    """Else whoever asked would wait for ever."""

    def broken() -> Scenario:
        raise ZeroDivisionError

    broken_services = StandardServices(paused.live, broken, NAME)
    answer = broken_services.reset_simulation(SimpleNamespace(scope=0), RESPONSES["reset_simulation"]()).result
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


def test_quitting_ends_the_run_and_later_calls_are_answered(paused: Simulator) -> None:
    assert paused.go_to(QUITTING) == OK
    assert paused.interruption.requested
    requests: dict[str, dict[str, object]] = {
        "reset_simulation": {"scope": 0},
        "step_simulation": {"steps": 1},
        "get_entity_state": {"entity": NAME},
        "set_entity_state": {"entity": NAME, "state": wanted()},
    }
    for service, request in requests.items():
        assert paused.code(service, **request) == FAILED, service


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


@pytest.mark.parametrize(
    ("pattern", "categories", "code", "found"),
    [
        ("", (), OK, [NAME]),
        ("lie_.*", (), OK, [NAME]),
        ("rigid", (), OK, [NAME]),
        ("^robot", (), OK, []),
        ("", (4,), OK, [NAME]),
        ("", (0, 4), OK, [NAME]),
        ("", (1, 2), OK, []),
        ("^robot", (4,), OK, []),
        ("(", (), FAILED, []),
        ("(x+x+)+y", (), FAILED, []),
    ],
)
def test_filters(paused: Simulator, pattern: str, categories: tuple[int, ...], code: int, found: list[str]) -> None:
    answer = paused.ask("get_entities", filters=entity_filters(pattern, categories))
    assert (answer.result.result, answer.entities) == (code, found)
    both = paused.services.get_entities_states(
        SimpleNamespace(filters=entity_filters(pattern, categories)), RESPONSES["get_entities_states"](), entity_state
    )
    assert (both.result.result, both.entities) == (code, found)
    alone = paused.ask("get_entity_state", entity=NAME).state
    assert both.states == [alone for _ in found]


@pytest.mark.parametrize("field", ["tags", "bounds"])
def test_filters_by_tags_and_bounds_are_unsupported(paused: Simulator, field: str) -> None:
    filters = entity_filters()
    if field == "tags":
        filters.tags.tags = ["x"]
    else:
        filters.bounds.points = [object()]
    assert paused.code("get_entities", filters=filters) == UNSUPPORTED


def test_what_the_body_is(paused: Simulator) -> None:
    answer = paused.ask("get_entity_info", entity=NAME)
    assert (answer.result.result, answer.info.category.category, answer.info.tags) == (OK, 4, [])
    moments = np.linalg.eigvalsh([[1.0, 0.1, -0.05], [0.1, 1.4, 0.2], [-0.05, 0.2, 1.9]])
    assert all(f"{moment:g}" in answer.info.description for moment in moments)


@pytest.mark.parametrize("service", ["get_entity_info", "get_entity_state", "set_entity_state"])
def test_other_entities_are_not_found(paused: Simulator, service: str) -> None:
    assert paused.code(service, entity="robot", state=wanted()) == NOT_FOUND
    assert len(paused.sink.segments) == 1


def quaternion(state: Any) -> np.ndarray:
    q = state.pose.orientation
    return np.array([q.x, q.y, q.z, q.w])


def xyz(vector: Any) -> np.ndarray:
    return np.array([vector.x, vector.y, vector.z])


def test_twist_and_acceleration_are_in_the_world(paused: Simulator) -> None:
    """Against the turn from pose to pose, whose logarithm knows nothing of body rates."""
    states = []
    for _ in range(3):
        assert paused.code("step_simulation", steps=1) == OK
        answer = paused.ask("get_entity_state", entity=NAME)
        assert (answer.result.result, answer.state.header.frame_id) == (OK, "map")
        states.append(answer.state)
    stamps = [s.header.stamp.sec * 10**9 + s.header.stamp.nanosec for s in states]
    assert stamps == [EPOCH + k * 10**6 for k in range(3)]
    first, middle, last = (Rotation.from_quat(quaternion(s)) for s in states)
    turn = (last * first.inv()).as_rotvec() / 2e-3
    omega = [xyz(s.twist.angular) for s in states]
    np.testing.assert_allclose(omega[1], turn, rtol=0, atol=1e-5)
    assert np.linalg.norm(omega[1] - middle.inv().apply(omega[1])) > 0.1
    np.testing.assert_allclose(xyz(states[1].acceleration.angular), (omega[2] - omega[0]) / 2e-3, rtol=0, atol=1e-5)


def centre(state: Any) -> np.ndarray:
    """Position, velocity and acceleration, shape (3, 3)."""
    return np.array([xyz(state.pose.position), xyz(state.twist.linear), xyz(state.acceleration.linear)])


def test_the_mass_centre_is_told_in_the_world_and_set_by_pose_and_twist() -> None:
    """Against parabolas, as a body is thrown; then one that is carried begins anew elsewhere."""
    away, speed = np.array([5.0, -1.0, 2.0]), np.array([0.5, 1.0, 3.0])
    with running(paused=True, translation="thrown", initial_velocity=[0.0, 2.0, 4.0], gravity=1.6) as thrown:
        assert thrown.code("step_simulation", steps=501) == OK
        told = centre(thrown.ask("get_entity_state", entity=NAME).state)
        np.testing.assert_allclose(told, [[0.0, 1.0, 1.8], [0.0, 2.0, 3.2], [0.0, 0.0, -1.6]], rtol=0, atol=1e-14)
        assert thrown.code("set_entity_state", entity=NAME, state=wanted([0, 0, 1], position=away, linear=speed)) == OK
        assert thrown.code("step_simulation", steps=1001) == OK
        told = centre(thrown.ask("get_entity_state", entity=NAME).state)
        np.testing.assert_allclose(told, [away + speed - [0, 0, 0.8], speed - [0, 0, 1.6], [0, 0, -1.6]], atol=1e-14)
        state = wanted(position=away)
        assert thrown.code("set_entity_state", entity=NAME, state=state, set_pose=True, set_twist=False) == OK
        assert thrown.code("step_simulation", steps=1) == OK
        velocity = centre(thrown.ask("get_entity_state", entity=NAME).state)[1]
        np.testing.assert_array_equal(velocity, told[1])  # a throw goes on
    with running(paused=True, translation="carried", sway_acceleration=[1.0, 0.0, 0.0]) as carried:
        assert carried.code("step_simulation", steps=701) == OK
        assert np.all(centre(carried.ask("get_entity_state", entity=NAME).state)[:, 0])
        assert carried.code("set_entity_state", entity=NAME, state=wanted(position=away, linear=speed)) == OK
        scenario = carried.sink.segments[-1].scenario
        assert (scenario.initial_position, scenario.initial_velocity) == (tuple(away), tuple(speed))


def test_the_state_on_a_path_is_told_and_not_set(paused: Simulator) -> None:
    knots = [number for k in range(5) for number in (0.1 * k, 0.0, 0.0, 0.0, 0.0, 0.0, np.sin(k * k), np.cos(k * k))]
    scenario = Scenario(motion="path", path_knots=knots, rate=1000.0)
    paused.live.ask(paused.live.reset, scenario)
    assert paused.code("set_entity_state", entity=NAME, state=wanted()) == FAILED
    path = scenario.path()
    assert path is not None
    told = paused.ask("get_entity_state", entity=NAME).state.acceleration.angular
    np.testing.assert_allclose(xyz(told), path.angular_acceleration(np.zeros(1, np.int64))[0], atol=1e-12)
    assert len(paused.sink.segments) == 2


@pytest.mark.parametrize("frame", ["", "map"])
@pytest.mark.parametrize("state", [PLAYING, PAUSED, STOPPED])
def test_a_state_is_set_and_the_world_twist_turned_into_the_body(paused: Simulator, frame: str, state: int) -> None:
    if state != PAUSED:
        assert paused.go_to(state) == OK
    attitude, angular = [0.5, 0.5, -0.5, 0.5], [0.3, -0.2, 1.7]
    before = len(paused.sink.segments)
    assert paused.code("set_entity_state", entity=NAME, state=wanted(angular, attitude, frame=frame)) == OK
    assert paused.state == state
    [segment] = paused.sink.segments[before:]
    start = segment.scenario.start()
    np.testing.assert_allclose(start.attitude_xyzw, attitude, rtol=0, atol=1e-15)
    np.testing.assert_allclose(start.body_rate, Rotation.from_quat(attitude).inv().apply(angular), rtol=0, atol=1e-15)
    if state != PLAYING:
        answer = paused.ask("get_entity_state", entity=NAME).state
        np.testing.assert_allclose(xyz(answer.twist.angular), angular, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ({"position": (0.0, 1.1e9, 0.0)}, INVALID_POSE),
        ({"position": (0.0, np.nan, 0.0)}, INVALID_POSE),
        ({"attitude": (0.0, 0.0, 0.0, 0.0)}, INVALID_POSE),
        ({"attitude": (0.0, 0.0, 0.0, 1.1)}, INVALID_POSE),
        ({"attitude": (0.0, np.nan, 0.0, 1.0)}, INVALID_POSE),
        ({"linear": (0.0, 0.0, 0.1)}, FAILED),
        ({"angular": (0.0, np.inf, 0.1)}, FAILED),
        ({"angular": (1e308, 1e308, 1e308)}, FAILED),
        ({"frame": "base_link"}, FAILED),
    ],
)
def test_a_state_that_cannot_be_is_refused(paused: Simulator, given: dict[str, Any], code: int) -> None:
    assert paused.code("set_entity_state", entity=NAME, state=wanted(**given)) == code
    assert len(paused.sink.segments) == 1


def test_only_what_is_asked_for_is_set(paused: Simulator) -> None:
    """Fields of later releases."""
    both = {"entity": NAME, "state": wanted([0.0, 0.0, 2.0], position=(1.0, 0.0, 0.0))}
    assert paused.code("set_entity_state", **both, set_pose=False, set_twist=True) == OK
    start = paused.sink.segments[-1].scenario.start()
    np.testing.assert_allclose(start.attitude_xyzw, SCENARIO.initial_attitude_xyzw, rtol=0, atol=1e-15)
    both["state"] = wanted([0.0, 0.0, 9.0], linear=(1.0, 0.0, 0.0))
    assert paused.code("set_entity_state", **both, set_pose=True, set_twist=False) == OK
    again = paused.sink.segments[-1].scenario.start()
    assert again.attitude_xyzw.tolist() == [0.0, 0.0, 0.0, 1.0]
    assert again.body_rate.tolist() == start.body_rate.tolist()
