"""Steps by the standard service and by its action: all that were asked for, while paused, until canceled."""

from __future__ import annotations

from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, cast

import pytest
from simulator_process import DEADLINE
from standard_simulator import EPOCH, FAILED, OK, PAUSED, PLAYING, SCENARIO, STOPPED, Simulator

if find_spec("rclpy"):
    from standard_messages import RESPONSES, feedback

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


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
