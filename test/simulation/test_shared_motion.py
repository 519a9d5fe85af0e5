"""Who shares a motion has the bits of a motion of their own, whatever the others ask for."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import Motion
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import motions_of
from lie_rigid_body.simulation.loop import LastCall, MemoizedMotion

PERIOD_NS = 10_000_000
KINDS = ("moving_chart", "closed_form")


def scenario(kind: str, **parameters: object) -> Scenario:
    """With a stepper that errs so much that other steps give other bits."""
    return Scenario.from_parameters({"motion": kind, "method": "rkmk2", "max_step": 0.004, **parameters})


def bits(states: State) -> bytes:
    return states.attitude_xyzw.tobytes() + states.body_rate.tobytes()


class Counted:
    """A motion that notes the calls of it and of its copies."""

    def __init__(self, motion: Motion, calls: list[int]) -> None:
        self.motion, self.calls = motion, calls

    def __copy__(self) -> Counted:
        return Counted(copy.copy(self.motion), self.calls)

    def at(self, t_ns: ArrayLike) -> State:
        self.calls.append(np.size(t_ns))
        return self.motion.at(t_ns)


class User:
    """Who asks for some samples after the other, and checks them against a motion of their own."""

    def __init__(self, shared: MemoizedMotion, own: Motion) -> None:
        self.shared, self.own, self.next = shared, own, 0

    def ask(self, count: int) -> None:
        times = PERIOD_NS * np.arange(self.next, self.next + count)
        assert bits(self.shared.at(times)) == bits(self.own.at(times))
        self.next += count


def users(kind: str, count: int, calls: list[int]) -> list[User]:
    start, latest = scenario(kind).make_motion(), LastCall()
    return [User(MemoizedMotion(Counted(start, calls), latest), scenario(kind).make_motion()) for _ in range(count)]


@pytest.mark.parametrize("kind", KINDS)
@given(turns=st.lists(st.tuples(st.integers(0, 2), st.sampled_from([0, 1, 2, 5])), max_size=12))
@example(turns=[(0, 5), (1, 5), (0, 5), (2, 5), (1, 2), (1, 5), (2, 1), (2, 5), (0, 5)])
@settings(max_examples=20)
def test_everyone_has_the_bits_of_an_own_motion(kind: str, turns: list[tuple[int, int]]) -> None:
    three = users(kind, 3, [])
    for who, count in turns:
        three[who].ask(count)


@pytest.mark.parametrize("kind", KINDS)
def test_what_all_ask_for_is_computed_once_also_after_a_copy(kind: str) -> None:
    calls: list[int] = []
    three = users(kind, 3, calls)
    for count in (0, 64, 3, 500):
        for user in three:
            user.ask(count)
    assert calls == [0, 64, 3, 500]
    copied = copy.deepcopy(three)
    for user in (*three, *copied):
        user.ask(7)
    assert calls == [0, 64, 3, 500, 7]
    assert copied[0].shared._motion.calls == calls  # type: ignore[attr-defined]


def test_only_those_of_one_clock_share() -> None:
    sensors = {"imu_rate": 100.0, "magnetometer_rate": 30.0, "sun_sensor_rate": 30.0}
    motion = motions_of(scenario("moving_chart", rate=100.0, **sensors))
    times = PERIOD_NS * np.arange(20)
    truth, imu, magnetometer, sun = (motion().at(times) for _ in range(4))
    assert truth is imu
    assert magnetometer is sun
    assert truth is not magnetometer
