"""Any body, start and time: the closed form against elliptic integrals of many digits, and against itself elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from closed_form_far_reference import far_reference, polhode_of
from closed_form_reference import attitude_error, rate_error
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp
from random_motions import ANGLES, RATES, SECOND_MOMENTS, TURNS, body_of, difference, fastest, growth, turned_body, unit

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion

ATTITUDE_BOUND = 2e-15
RATE_BOUND = 1e-15
STAMPS = st.integers(-(10**16), 10**16)
"""Up to 1e7 s, which are 5e7 rad at most; a motion 512 times as fast turns by 1e10 rad."""


def require_truth(second_moments, rate, attitude, body_turn, t_ns: int, factor: float) -> None:
    body, start = body_of(second_moments), State(unit(attitude), factor * np.array(rate))
    for seen in (body, turned_body(body, unit(body_turn))[0]):
        assume(np.any(np.cross(start.body_rate, seen.inertia @ start.body_rate)))
        exact = far_reference(seen.inertia, start.attitude_xyzw, start.body_rate, t_ns)
        state = ClosedForm(seen, start).at(t_ns)
        assert attitude_error(exact.attitude_xyzw, state.attitude_xyzw) < ATTITUDE_BOUND
        assert rate_error(exact.body_rate, state.body_rate) < RATE_BOUND


@pytest.mark.long
@settings(max_examples=8)
@given(SECOND_MOMENTS, RATES, TURNS, TURNS, STAMPS, st.sampled_from([1.0, 512.0]))
def test_any_motion_is_right_at_any_time(second_moments, rate, attitude, body_turn, t_ns: int, factor: float):
    require_truth(second_moments, rate, attitude, body_turn, t_ns, factor)


@pytest.mark.slow
@settings(max_examples=200)
@given(SECOND_MOMENTS, RATES, TURNS, TURNS, STAMPS, st.sampled_from([1.0, 512.0]))
def test_very_many_motions_are_right_at_any_time(second_moments, rate, attitude, body_turn, t_ns: int, factor: float):
    require_truth(second_moments, rate, attitude, body_turn, t_ns, factor)


@settings(max_examples=40)
@given(SECOND_MOMENTS, RATES, TURNS, TURNS, STAMPS)
def test_a_world_turned_beforehand_turns_every_attitude(second_moments, rate, attitude, world, t_ns: int):
    body, start = body_of(second_moments), State(unit(attitude), rate)
    state = ClosedForm(body, start).at(t_ns)
    seen = ClosedForm(body, State(quaternion.multiply(unit(world), start.attitude_xyzw), rate)).at(t_ns)
    expected = State.trusted(quaternion.multiply(unit(world), state.attitude_xyzw), state.body_rate)
    assert difference(seen, expected) <= 2e-15


@settings(max_examples=40)
@given(SECOND_MOMENTS, RATES, TURNS, TURNS, ANGLES, st.floats(1e-3, 1e3))
def test_the_frame_of_the_body_and_the_unit_of_inertia_do_not_matter(
    second_moments, rate, attitude, body_turn, angle: float, unit_of_inertia: float
):
    """But for the rounding of the tensor in them, which the ratio of the moments may enlarge."""
    body, start, turn = body_of(second_moments), State(unit(attitude), rate), unit(body_turn)
    frame, matrix = turned_body(body, turn)
    t_ns = round(1e9 * angle / fastest(body, start))
    moved = State(quaternion.multiply(start.attitude_xyzw, quaternion.conjugate(turn)), matrix @ start.body_rate)
    seen = ClosedForm(RigidBody(unit_of_inertia * frame.inertia), moved).at(t_ns)
    back = State.trusted(quaternion.multiply(seen.attitude_xyzw, turn), seen.body_rate @ matrix)
    rounding = 2e-15 * float(body.principal_moments[2] / body.principal_moments[0])
    assert difference(back, ClosedForm(body, start).at(t_ns)) <= rounding * (1.0 + growth(angle))


def half_way() -> float:
    """The largest rate about the first axis, rad/s, with 1 − m ≥ ½: beyond it the motion is hyperbolic."""
    low, high = 0.0, 1.0
    while np.nextafter(low, high) < high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 2 * complement(middle) >= 1 else (low, middle)
    return low


def complement(rate: float) -> mp.mpf:
    """1 − m"""
    with mp.workdps(60):
        return polhode_of(np.diag([1.0, 2.0, 3.0]), [rate, 1.0, 0.7]).m1


@pytest.mark.parametrize("t_ns", [10**9, -(10**16)])
def test_both_theta_functions_are_right_where_one_takes_over_from_the_other(t_ns: int):
    body, switch = RigidBody([1.0, 2.0, 3.0]), half_way()
    assert 2 * complement(switch) >= 1 > 2 * complement(np.nextafter(switch, 1.0))
    for rate in (switch, np.nextafter(switch, 1.0), switch - 1e-9, switch + 1e-9, switch - 1e-3, switch + 1e-3):
        start = State([0.5, 0.5, -0.5, 0.5], [rate, 1.0, 0.7])
        exact = far_reference(body.inertia, start.attitude_xyzw, start.body_rate, t_ns)
        state = ClosedForm(body, start).at(t_ns)
        assert attitude_error(exact.attitude_xyzw, state.attitude_xyzw) < ATTITUDE_BOUND
        assert rate_error(exact.body_rate, state.body_rate) < RATE_BOUND
