"""Every regime against Taylor series of 45 digits, lift included."""

from __future__ import annotations

import numpy as np
import pytest
from closed_form_far_reference import decimal, digits_for, far_reference, far_time, polhode_of
from closed_form_reference import attitude_error, multiply, rate_error, reference
from mpmath import mp, mpf
from regimes import ATTITUDES, FLAT, REGIMES, beside_the_separatrix, steady, with_products

from lie_rigid_body import ClosedForm, RigidBody, State

ATTITUDE_BOUND = 2e-15
RATE_BOUND = 1e-15


def check(inertia, rate, attitude, sign: int, angles: list[float]) -> None:
    body, start = RigidBody(inertia), State(attitude / np.linalg.norm(attitude), rate)
    speed = float(np.max(np.abs(rate))) or 1.0
    t_ns = [max(min(round(sign * angle / speed * 1e9), 2**63 - 1), -(2**63)) for angle in angles]
    truth = reference(body.inertia, start.attitude_xyzw, start.body_rate, t_ns)
    states = ClosedForm(body, start).at(t_ns)
    for exact, q, w in zip(truth, states.attitude_xyzw, states.body_rate, strict=True):
        assert attitude_error(exact.attitude_xyzw, q) < ATTITUDE_BOUND, (inertia, rate, t_ns)
        assert rate_error(exact.body_rate, w) < RATE_BOUND, (inertia, rate, t_ns)


@pytest.mark.long
@pytest.mark.parametrize("regime", REGIMES)
def test_each_regime_is_the_solution_of_the_equations_of_motion(regime):
    for i, (inertia, rate) in enumerate(list(regime())[:: 4 if regime in (steady, with_products) else 14]):
        check(inertia, rate, ATTITUDES[i % 3], (-1) ** i, [2.9])


@pytest.mark.slow
@pytest.mark.parametrize("regime", REGIMES)
def test_each_regime_is_the_solution_of_the_equations_of_motion_for_many_turns(regime):
    for i, (inertia, rate) in enumerate(regime()):
        check(inertia, rate, ATTITUDES[i % 3], (-1) ** (i // 2), [1e-9, 0.3, 8.0, 25.0])


def check_far(inertia, rate, attitude, sign: int) -> None:
    """At |ω|t of 1e10 rad, in some 1e7 s: 1024 times as fast a motion has exactly the same shape."""
    body = RigidBody(inertia)
    factor = 1024.0 if np.max(np.abs(rate)) < 100.0 else 1.0
    start = State(attitude / np.linalg.norm(attitude), factor * np.array(rate))
    t_ns = sign * far_time(body.inertia, start.body_rate, 1e10, 2.5)
    exact = far_reference(body.inertia, start.attitude_xyzw, start.body_rate, t_ns)
    state = ClosedForm(body, start).at(t_ns)
    assert attitude_error(exact.attitude_xyzw, state.attitude_xyzw) < ATTITUDE_BOUND, (inertia, rate, t_ns)
    assert rate_error(exact.body_rate, state.body_rate) < RATE_BOUND, (inertia, rate, t_ns)


FAR_REGIMES = [regime for regime in REGIMES if regime is not steady]


@pytest.mark.long
@pytest.mark.parametrize("regime", FAR_REGIMES)
def test_each_regime_is_right_after_ten_thousand_million_radians(regime):
    cases = [case for case in regime() if is_quick(*case)]
    for i, (inertia, rate) in enumerate(cases[:: 3 if len(cases) < 12 else 11]):
        check_far(inertia, rate, ATTITUDES[i % 3], (-1) ** i)


@pytest.mark.slow
@pytest.mark.parametrize("regime", FAR_REGIMES)
def test_every_case_of_each_regime_is_right_after_ten_thousand_million_radians(regime):
    for i, (inertia, rate) in enumerate(regime()):
        check_far(inertia, rate, ATTITUDES[i % 3], (-1) ** (i // 2))


def is_quick(inertia, rate) -> bool:
    """Whether the reference takes no many digits and no many steps."""
    body = RigidBody(inertia)
    digits = digits_for(body.inertia, rate)
    with mp.workdps(digits):
        return digits < 400 and polhode_of(body.inertia, rate).m1 != 0


@pytest.mark.parametrize(("inertia", "rate"), list(beside_the_separatrix()))
def test_the_cases_beside_the_separatrix_are_as_near_to_it_as_they_say(inertia, rate):
    body, size = RigidBody(inertia), float(np.sort(np.abs(rate))[1])
    with mp.workdps(200):
        assert 0.5 < polhode_of(body.inertia, rate).m1 / mpf(size) ** 2 < 3.0


@pytest.mark.parametrize("t_ns", [10**16, -(10**16), 12345678901234567])
def test_a_steady_rotation_is_right_after_ten_thousand_million_radians(t_ns: int):
    for inertia, rate in steady():
        body, start = RigidBody(inertia), State(ATTITUDES[2], np.array(rate) * 1000.0)
        with mp.workdps(60):
            axis, speed = [mpf(float(x)) for x in start.body_rate], mp.sqrt(sum(mpf(x) ** 2 for x in start.body_rate))
            half = speed * t_ns / 10**9 / 2
            turn = [*(x / (speed or 1) * mp.sin(half) for x in axis), mp.cos(half)]
            exact = multiply([decimal(mpf(x)) for x in start.attitude_xyzw], [decimal(x) for x in turn])
        state = ClosedForm(body, start).at(t_ns)
        assert attitude_error(exact, state.attitude_xyzw) < ATTITUDE_BOUND
        np.testing.assert_array_equal(state.body_rate, start.body_rate)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-30, 1e-100, 1e-150, 1e-162, 1e-300])
def test_the_flip_after_a_spin_about_the_middle_axis_comes_on_time(size: float):
    # transverse rates grow as exp(t/√3); much later the reference's 45 digits no longer tell how near the axis it came
    check(FLAT, [size, 1.0, -size], ATTITUDES[1], 1, [-np.sqrt(3.0) * np.log(size) + x for x in (-4.0, 0.0, 3.0)])
