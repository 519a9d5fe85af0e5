"""The body as the one entity of the standard services: found by filters, told and set in the world, or refused."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulator_process import DEADLINE
from standard_simulator import (
    EPOCH,
    FAILED,
    INVALID_POSE,
    NAME,
    NOT_FOUND,
    OK,
    PAUSED,
    PLAYING,
    SCENARIO,
    STOPPED,
    UNSUPPORTED,
    Simulator,
    wanted,
)

from lie_rigid_body.ros.control import services
from sampled import sampled

if find_spec("rclpy"):
    from standard_messages import RESPONSES, entity_filters, entity_state

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


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


@pytest.mark.parametrize(
    "pattern", sampled(["((((.+)+)+)+)+x", "x" * 1_000_000, "a{99999999999999999999}", "(" * 900], every=4)
)
def test_what_no_regular_expression_may_do_is_answered(
    paused: Simulator, pattern: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It recurses, is endless, overflows or takes years; other requests are answered meanwhile."""
    monkeypatch.setattr(services, "PATTERN_S", 1)
    with ThreadPoolExecutor(1) as other:
        answer = other.submit(paused.ask, "get_entities", filters=entity_filters(pattern))
        assert paused.code("reset_simulation", scope=0) == OK
        found = answer.result(DEADLINE)
    assert (found.result.result, found.entities) == (FAILED, [])


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
    for state in states:
        still = (state.pose.position, state.twist.linear, state.acceleration.linear)
        assert [xyz(vector).any() for vector in still] == [False] * 3


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
        ({"position": (0.0, 1.0, 0.0)}, INVALID_POSE),
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
