"""Symmetries of the motion that its steppers keep, each for any body and start."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_motions import (
    ANGLES,
    AXIS_TURNS,
    RATES,
    SECOND_MOMENTS,
    TURNS,
    body_of,
    difference,
    fastest,
    growth,
    turned_body,
    unit,
)

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.motion import METHODS

TURN_OF_A_STEP = 0.1
ROUND_OFF = 3e-15
"""Of a state that is right to round-off, twice."""

EVERY_METHOD = pytest.mark.parametrize("method", METHODS)
REVERSIBLE = pytest.mark.parametrize("method", [name for name in METHODS if name.startswith("dmv")])
A_FEW = settings(max_examples=5)


class Course:
    """A motion, a time at which it has turned by some angle, and steps for it."""

    def __init__(self, second_moments, rate, attitude, angle: float) -> None:
        self.body, self.start = body_of(second_moments), State(unit(attitude), rate)
        self.fastest = fastest(self.body, self.start)
        # divisible by 8, so that a motion 8 times as fast has a time of as many steps
        self.t_ns = 8 * max(round(angle / self.fastest / 8e-9), 1)
        self.step = TURN_OF_A_STEP / self.fastest
        self.angle = angle

    def at(self, t_ns: int, method: str = "dmv20") -> State:
        return MovingChart(self.body, self.start, method=method, max_step=self.step).at(t_ns)

    def bound(self, method: str) -> float:
        """Runge–Kutta steps round the momentum of each step, and what is rounded grows; Moser–Veselov steps do not."""
        steps = np.ceil(self.angle / TURN_OF_A_STEP) + 1.0
        return ROUND_OFF if method.startswith("dmv") else ROUND_OFF + 1e-15 * steps * growth(self.angle)


COURSES = st.builds(Course, SECOND_MOMENTS, RATES, TURNS, ANGLES)


@EVERY_METHOD
@A_FEW
@given(course=COURSES, turn=AXIS_TURNS)
def test_the_naming_of_the_body_axes_does_not_matter(method: str, course: Course, turn):
    matrix = np.rint(so3.exp(quaternion.log(turn)))
    body = RigidBody(matrix @ course.body.inertia @ matrix.T)
    attitude = quaternion.multiply(course.start.attitude_xyzw, quaternion.conjugate(turn))
    start = State(attitude, matrix @ course.start.body_rate)
    seen = MovingChart(body, start, method=method, max_step=course.step).at(course.t_ns)
    back = State.trusted(quaternion.multiply(seen.attitude_xyzw, turn), seen.body_rate @ matrix)
    assert difference(back, course.at(course.t_ns, method)) <= course.bound(method)


@EVERY_METHOD
@A_FEW
@given(course=COURSES, power=st.integers(-60, 60), times=st.integers(-3, 3))
def test_the_units_of_inertia_and_time_do_not_matter(method: str, course: Course, power: int, times: int):
    body = RigidBody(course.body.inertia * 2.0**power)
    start = State(course.start.attitude_xyzw, course.start.body_rate * 2.0**times)
    t_ns = course.t_ns // 2**times if times >= 0 else course.t_ns * 2**-times
    seen = MovingChart(body, start, method=method, max_step=course.step / 2.0**times).at(t_ns)
    as_slow = State.trusted(seen.attitude_xyzw, seen.body_rate / 2.0**times)
    assert difference(as_slow, course.at(course.t_ns, method)) <= course.bound(method)


@EVERY_METHOD
@A_FEW
@given(course=COURSES, world=TURNS)
def test_a_world_turned_beforehand_turns_every_attitude(method: str, course: Course, world):
    start = State(quaternion.multiply(unit(world), course.start.attitude_xyzw), course.start.body_rate)
    seen = MovingChart(course.body, start, method=method, max_step=course.step).at(course.t_ns)
    states = course.at(course.t_ns, method)
    expected = State.trusted(quaternion.multiply(unit(world), states.attitude_xyzw), states.body_rate)
    assert difference(seen, expected) <= course.bound(method)


@REVERSIBLE
@A_FEW
@given(course=COURSES)
def test_steps_of_every_order_go_back_the_way_they_came(method: str, course: Course):
    """From the end with the rate reversed, but for what the rounding of the end to doubles becomes."""
    end = course.at(course.t_ns, method)
    back = MovingChart(course.body, State(end.attitude_xyzw, -end.body_rate), method=method, max_step=course.step)
    state = back.at(course.t_ns)
    returned = State.trusted(state.attitude_xyzw, -state.body_rate)
    assert difference(returned, course.start) <= 4e-15 * (1.0 + growth(course.angle))


@given(course=COURSES, body_turn=TURNS)
def test_any_frame_of_the_body_sees_the_same_motion(course: Course, body_turn):
    """But for the rounding of the tensor in it, which the ratio of the moments may enlarge."""
    turn = unit(body_turn)
    body, matrix = turned_body(course.body, turn)
    attitude = quaternion.multiply(course.start.attitude_xyzw, quaternion.conjugate(turn))
    start = State(attitude, matrix @ course.start.body_rate)
    seen = MovingChart(body, start, max_step=course.step).at(course.t_ns)
    back = State.trusted(quaternion.multiply(seen.attitude_xyzw, turn), seen.body_rate @ matrix)
    moments = course.body.principal_moments
    rounding = 2e-15 * float(moments[2] / moments[0])
    assert difference(back, course.at(course.t_ns)) <= rounding * (1.0 + growth(course.angle))


@given(course=COURSES, share=st.floats(0.0, 1.0), step=st.floats(0.01, 2.0))
def test_going_on_from_any_state_on_the_way_is_the_same_motion(course: Course, share: float, step: float):
    """Motion by s and then t is motion by s + t, with steps of any length."""
    s, whole = int(share * course.t_ns), course.at(course.t_ns)
    one = MovingChart(course.body, course.start, max_step=step / course.fastest).at([s, course.t_ns])
    assert difference(one[1], whole) <= ROUND_OFF
    onward = MovingChart(course.body, one[0], max_step=step / course.fastest).at(course.t_ns - s)
    assert difference(onward, whole) <= 4e-15 * (1.0 + growth(course.angle))


@given(course=COURSES, body_turn=TURNS)
def test_steps_and_closed_form_are_the_same_motion(course: Course, body_turn):
    """Two derivations that share no formula; what steps round, to 1e-18, grows."""
    bound = ROUND_OFF + 1e-17 * growth(course.angle)
    times = np.linspace(0.0, course.t_ns, 4).astype(np.int64)
    for body in (course.body, turned_body(course.body, unit(body_turn))[0]):
        stepped = MovingChart(body, course.start, max_step=course.step).at(times)
        assert difference(stepped, ClosedForm(body, course.start).at(times)) <= bound
