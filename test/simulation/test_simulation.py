"""Simulations: samples, resets, and one motion for several."""

from __future__ import annotations

import copy
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from lie_rigid_body import InputError, ParameterError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import Motion
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import SampleClock, Segment, Simulation, motions_of
from lie_rigid_body.simulation.loop import LOOK_AHEAD, LastCall, MemoizedMotion

MOTIONS = [{"motion": "closed_form"}, {"motion": "moving_chart", "max_step": 0.01}]


def simulation(**parameters: object) -> Simulation:
    return Simulation(Scenario.from_parameters(parameters))


@pytest.mark.parametrize("rate", [100.0, 200.0, 1024.0, 37.0, 3.0, 0.3, 0.1, 59.94, 1e-6, 1e6])
def test_stamps_are_those_of_the_definition(rate):
    """Python rounds half to even, and so does the clock."""
    epoch = 1_234_567_890_123_456_789
    stamps = SampleClock(epoch, rate).stamps_ns(0, 300)
    assert stamps.tolist() == [epoch + round(k * 1_000_000_000 / Fraction(repr(rate))) for k in range(300)]
    if rate in (100.0, 200.0, 1024.0, 37.0, 3.0, 0.1):
        assert stamps.tolist() == [epoch + round(k * 1e9 / rate) for k in range(300)]


@given(st.integers(0, 10**12), st.sampled_from([3.0, 7.0, 48000.0, 0.7]))
def test_far_stamps_lose_no_nanosecond(k, rate):
    clock = SampleClock(0, rate)
    exact = k * 1_000_000_000 / Fraction(repr(rate))
    if exact <= MAX_EPOCH_NS:
        assert abs(int(clock.stamps_ns(k, 1)[0]) - exact) <= Fraction(1, 2)


@given(
    st.integers(0, MAX_EPOCH_NS // 2),
    st.sampled_from([3.0, 0.7, 333.3, 59.94, 1e-6, 1e9, 3e8, 0.1234567890123, 2e9 / 3.0]),
    st.integers(-10, 10**14),
    st.integers(0, 20),
)
def test_many_stamps_are_those_one_by_one(epoch, rate, first, count):
    clock = SampleClock(epoch, rate)
    one_by_one = [clock.stamp_ns(k) for k in range(first, first + count)]
    if not count or one_by_one[-1] <= MAX_EPOCH_NS:
        assert clock.stamps_ns(first, count).tolist() == one_by_one


def test_stamps_end_with_the_message_type():
    clock = SampleClock(MAX_EPOCH_NS - 10_000_000, 100.0)
    assert clock.stamps_ns(0, 2)[-1] == MAX_EPOCH_NS
    with pytest.raises(ParameterError) as refusal:
        clock.stamps_ns(0, 3)
    assert refusal.value.name == "epoch_ns"


@pytest.mark.parametrize(
    ("duration", "rate", "count"),
    [("1", 100.0, 100), ("1.1", 100.0, 110), ("1.101", 100.0, 111), ("0.001", 100.0, 1), ("10", 0.3, 3), ("1", 3.0, 3)],
)
def test_samples_before_a_time(duration, rate, count):
    clock = SampleClock(0, rate)
    assert clock.count_before(Fraction(duration)) == count


@pytest.mark.parametrize("parameters", MOTIONS)
def test_how_samples_are_taken_makes_no_difference(parameters):
    whole = simulation(**parameters, rate=59.94).take(200)
    other = simulation(**parameters, rate=59.94)
    parts = [other.take(n) for n in (1, 2, 0, LOOK_AHEAD - 1, LOOK_AHEAD, 1, 5)]
    parts.append(other.take(200 - other.next_sample))
    np.testing.assert_array_equal(whole.stamps_ns, np.concatenate([p.stamps_ns for p in parts]))
    np.testing.assert_array_equal(whole.states.attitude_xyzw, np.concatenate([p.states.attitude_xyzw for p in parts]))
    np.testing.assert_array_equal(whole.states.body_rate, np.concatenate([p.states.body_rate for p in parts]))


@pytest.mark.parametrize("parameters", MOTIONS)
def test_states_belong_to_their_stamps(parameters):
    run = simulation(**parameters, rate=59.94, epoch_ns=10**18 + 7)
    samples = run.take(50)
    exact = Scenario.from_parameters({"motion": "closed_form"}).make_motion().at(samples.stamps_ns - (10**18 + 7))
    np.testing.assert_allclose(samples.states.attitude_xyzw, exact.attitude_xyzw, rtol=0, atol=1e-9)


@pytest.mark.parametrize("parameters", MOTIONS)
def test_a_reset_returns_to_the_start_and_stamps_go_on(parameters):
    run = simulation(**parameters, rate=59.94)
    before = run.take(10)
    segment = run.reset(Scenario.from_parameters({**parameters, "rate": 59.94, "initial_body_rate": [0.0, 0.5, 0.1]}))
    after = run.take(3)
    whole = SampleClock(0, 59.94).stamps_ns(0, 13)
    np.testing.assert_array_equal(np.concatenate([before.stamps_ns, after.stamps_ns]), whole)
    assert (segment.first_sample, segment.start_ns) == (10, whole[10])
    np.testing.assert_allclose(after.states.attitude_xyzw[0], [0, 0, 0, 1], rtol=0, atol=2e-16)
    np.testing.assert_allclose(after.states.body_rate[0], [0.0, 0.5, 0.1], rtol=1e-15)


def test_another_rate_begins_at_the_next_stamp():
    run = simulation(rate=100.0)
    run.take(5)
    segment = run.reset(Scenario.from_parameters({"rate": 10.0}))
    assert (segment.first_sample, segment.start_ns) == (0, 50_000_000)
    assert run.take(3).stamps_ns.tolist() == [50_000_000, 150_000_000, 250_000_000]


def test_look_ahead_does_not_end_a_run_before_its_last_stamp():
    run = simulation(motion="closed_form", epoch_ns=MAX_EPOCH_NS - 20_000_000)
    assert run.take(3).stamps_ns[-1] == MAX_EPOCH_NS
    with pytest.raises(ParameterError) as refusal:
        run.take(1)
    assert refusal.value.name == "epoch_ns"


def test_a_segment_survives_its_json():
    run = simulation(rate=59.94, inertia=[1.0, 0.1, -0.05, 1.4, 0.2, 1.9], world_frame="wörld")
    run.take(7)
    segment = run.reset(run.segment.scenario)
    assert Segment.from_json(segment.to_json()) == segment


NO_NUMBERS = ['{"first_sample": 0}', '{"first_sample": -1, "start_ns": 0}', '{"first_sample": 0, "start_ns": 0.5}']


@pytest.mark.parametrize("text", ["", "[]", "{}", *NO_NUMBERS])
def test_other_texts_are_no_segment(text):
    with pytest.raises(InputError):
        Segment.from_json(text)


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
