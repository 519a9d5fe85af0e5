"""The moving chart against the 40-digit truth: accuracy, order of convergence, and its contract as a motion."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, InputError, MovingChart, RigidBody, State
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.motion import METHODS
from reference import attitude_error, truth_cases

CASES = truth_cases()
GENERIC = ("asymmetric", "dzhanibekov_1e-2", "oblate_symmetric", "prolate_symmetric", "products_of_inertia")


@pytest.mark.parametrize("name", GENERIC)
@pytest.mark.parametrize("method", ["rkmk1", "rkmk2", "rkmk4", "dmv2", "dmv4", "dmv6", "dmv8", "dmv10"])
def test_order_is_the_slope_of_the_log_errors(name, method):
    """From ⅛ rad a step on, or from near ¼ rad where errors are soon lost in round-off."""
    case, order = CASES[name], METHODS[method].order
    t_ns = 1_000_000_000_000 if order > 6 else 1_234_567_891
    truth = next(p for p in case.points if p.t_ns == t_ns)
    turn = float(vectors.norm(case.start.body_rate))
    exponents = np.arange(2, 3, 0.2) if order > 6 else np.arange(3, 7)
    steps = 2.0**-exponents / turn / 1.25  # a turn may be somewhat faster than at the start
    errors = []
    for step in steps:
        state = MovingChart(case.body, case.start, method=method, max_step=step).at(truth.t_ns)
        errors.append(attitude_error(state.attitude_xyzw, truth.attitude_xyzw))
    # the span is divided into equal steps, so the step really used is a little smaller than the one asked for
    used = 1e-9 * t_ns / np.ceil(1e-9 * t_ns / steps)
    slope = np.polyfit(np.log(used), np.log(errors), 1)[0]
    assert abs(slope - order) < max(0.25, 0.04 * order)


def test_spherical_body_turns_uniformly():
    body, start = RigidBody([2.0, 2.0, 2.0]), State([0, 0, 0, 1], [0.3, 0.5, 1.1])
    for method in ("rkmk1", "rkmk2", "rkmk4", "dmv8", "dmv10", "dmv20"):
        state = MovingChart(body, start, method=method, max_step=0.01).at(1_000_000_000)
        np.testing.assert_allclose(state.attitude_xyzw, quaternion.exp(start.body_rate), rtol=0, atol=1e-14)
        np.testing.assert_allclose(state.body_rate, start.body_rate, rtol=1e-15)


def test_attitude_passes_many_turns_without_a_seam():
    """Where one chart would be singular (a turn of 2π) the moving one goes on: the path on S³ has no jump."""
    case = CASES["asymmetric"]
    states = MovingChart(case.body, case.start, max_step=0.01).at(np.arange(0, 20_000_000_000, 10_000_000))
    q = states.attitude_xyzw
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=0, atol=4e-16)
    assert np.min(np.sum(q[1:] * q[:-1], axis=1)) > 0.999
    assert q[:, 3].min() < -0.9  # it did go round


def test_calls_continue_one_another_bit_for_bit():
    case = CASES["products_of_inertia"]
    times = np.cumsum(np.random.default_rng(3).integers(0, 20_000_000, size=50))
    whole = MovingChart(case.body, case.start).at(times)
    chart = MovingChart(case.body, case.start)
    parts = [chart.at(times[:7]), chart.at(times[7:8]), chart.at(times[8:])]
    np.testing.assert_array_equal(whole.attitude_xyzw, np.concatenate([p.attitude_xyzw for p in parts]))
    np.testing.assert_array_equal(whole.body_rate, np.concatenate([p.body_rate for p in parts]))


def test_start_is_returned_as_given_and_shapes_follow_the_times():
    case = CASES["products_of_inertia"]
    chart = MovingChart(case.body, case.start)
    at_start = chart.at(0)
    np.testing.assert_array_equal(at_start.attitude_xyzw, case.start.attitude_xyzw)
    np.testing.assert_array_equal(at_start.body_rate, case.start.body_rate)
    assert chart.at([5]).attitude_xyzw.shape == (1, 4)
    assert chart.at([]).body_rate.shape == (0, 3)


@pytest.mark.parametrize("rate", [1e4, 1e6, 1e150, 1e300])
@pytest.mark.parametrize("method", [name for name, method in METHODS.items() if method.max_turn > 1.0])
def test_a_step_too_long_says_how_far_it_goes(method, rate):
    motion = MovingChart(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0.1 * rate, rate, 0]), method=method)
    with pytest.raises(InputError) as caught:
        motion.at(10**9)
    assert f"{1e-3 * rate * np.sqrt(1.01):.3g}" in str(caught.value).split()


@pytest.mark.parametrize("rate", [1e4, 1e6])
def test_the_step_that_is_advised_serves(rate):
    body, start = RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0.1 * rate, rate, 0])
    with pytest.raises(InputError) as caught:
        MovingChart(body, start, method="rkmk4").at(10**9)
    step = float(str(caught.value).split()[-2])
    reached = MovingChart(body, start, method="rkmk4", max_step=step).at(round(1e10 / rate))
    exact = ClosedForm(body, start).at(round(1e10 / rate))
    np.testing.assert_allclose(reached.body_rate, exact.body_rate, rtol=0, atol=1e-6 * rate)


def test_steps_are_as_short_as_the_samples_are_near_however_long_the_largest_may_be() -> None:
    """At a radian a second a step of 10 s would be too long; that to the next of many samples is not."""
    t_ns = np.arange(1, 2001) * 5_000_000
    body, start = RigidBody([1.0, 2.0, 2.5]), State([0.0, 0.0, 0.0, 1.0], [0.3, 1.0, 0.2])
    long, short = (MovingChart(body, start, method="rkmk4", max_step=step) for step in (10.0, 0.005))
    np.testing.assert_array_equal(long.at(t_ns).attitude_xyzw, short.at(t_ns).attitude_xyzw)
    with pytest.raises(InputError):
        long.at(t_ns[-1:] + 10**10)
