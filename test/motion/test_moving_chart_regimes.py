"""The Moser–Veselov steps in every regime, up to their largest length, and at every time of the reference file."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest
from random_motions import difference
from regimes import REGIMES, motion

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.lie import vectors
from lie_rigid_body.motion import METHODS
from reference import TruthPoint, attitude_error, rate_error, truth_cases
from sampled import sampled

CASES = truth_cases()
EVERY_CASE = pytest.mark.parametrize("name", CASES)
needs_numba = pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed: so many steps take minutes")
AS_LONG_AS_ALLOWED = 1e300
"""s: the steps are then the largest that the stepper takes, a turn of ¼ rad."""


@pytest.mark.parametrize("regime", REGIMES)
def test_each_regime_is_followed_to_round_off(regime):
    for seed in range(10):
        drawn = motion(regime, seed)
        times = [drawn.stamp(radians) for radians in (0.01, 0.3, 2.9)]
        stepped = MovingChart(drawn.body, drawn.start, max_step=AS_LONG_AS_ALLOWED).at(times)
        assert difference(stepped, ClosedForm(drawn.body, drawn.start).at(times)) < 2e-15, seed


@pytest.mark.parametrize("size", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-16, 1e-30])
def test_a_spin_about_the_middle_axis_flips_on_time(size: float):
    """The flip with these transverse rates is as exact as their 16 digits."""
    body, start = RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], [size, 1.0, size])
    first = -np.sqrt(3.0) * np.log(size)  # they grow as exp(t/√3)
    times = (1e9 * (first + np.arange(-2.0, 3.0))).astype(np.int64)
    stepped, exact = MovingChart(body, start, max_step=0.02).at(times), ClosedForm(body, start).at(times)
    assert np.abs(exact.body_rate[:, 1]).min() < 0.9
    assert difference(stepped, exact) < 3e-15


@EVERY_CASE
@pytest.mark.parametrize("method", METHODS)
def test_every_order_follows_the_truth_as_closely_as_it_says(method: str, name: str):
    """An order p makes, for each radian, an error of order (|ω|h)ᵖ, with a coefficient below 1 for these methods."""
    case, turn_of_a_step = CASES[name], 1.0 / 16.0
    points = [point for point in case.points if point.t_ns <= 10**10]
    speed = 1.25 * float(vectors.norm(case.start.body_rate))  # a turn may be somewhat faster than at the start
    chart = MovingChart(case.body, case.start, method=method, max_step=turn_of_a_step / speed)
    states = chart.at([point.t_ns for point in points])
    for point, attitude, rate in zip(points, states.attitude_xyzw, states.body_rate, strict=True):
        radians = 1e-9 * point.t_ns * speed
        bound = radians * turn_of_a_step ** METHODS[method].order + 2e-15 + 1e-15 * radians
        assert attitude_error(attitude, point.attitude_xyzw) < bound
        assert rate_error(rate, point.body_rate) < bound


def require_truth(name: str, max_step: float, points: list[TruthPoint], bound: float) -> None:
    case = CASES[name]
    states = MovingChart(case.body, case.start, max_step=max_step).at([point.t_ns for point in points])
    for point, attitude, rate in zip(points, states.attitude_xyzw, states.body_rate, strict=True):
        assert attitude_error(attitude, point.attitude_xyzw) < bound
        assert rate_error(rate, point.body_rate) < bound


@EVERY_CASE
def test_the_largest_steps_keep_the_truth_as_well(name: str):
    """Up to 1e3 s, and 1e5 s where steps are compiled. Near the separatrix what they round grows by 1e6 in a flip."""
    limit = 10**15 if MovingChart(CASES["asymmetric"].body, CASES["asymmetric"].start).compile() else 10**13
    points = [point for point in CASES[name].points if point.t_ns < limit]
    require_truth(name, AS_LONG_AS_ALLOWED, points, 2e-10 if name == "dzhanibekov_1e-6" else 2e-12)


@EVERY_CASE
def test_truth_is_kept_for_a_thousand_seconds(name: str):
    require_truth(name, 0.02, [point for point in CASES[name].points if point.t_ns <= 10**12], 1e-14)


@pytest.mark.slow
@needs_numba
@pytest.mark.parametrize("name", ["asymmetric"])
def test_the_truth_is_kept_at_every_time(name: str):
    """Up to 1e7 s, in some 1e8 steps."""
    require_truth(name, 0.1, CASES[name].points, 1e-10)


DURATION_NS = 10**15
"""Four million steps of ¼ rad, each of which repeats the rounding of the one before: it must not add up."""
ROTATIONS = {
    "first axis": ([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]),
    "second axis": ([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]),
    "third axis": ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]),
    "spherical top": ([1.0, 1.0, 1.0], [0.3, 0.5, 0.7]),
    "oblate top": ([1.0, 1.0, 2.0], [0.3, 0.5, 0.7]),
    "prolate top": ([1.0, 2.0, 2.0], [0.3, 0.5, 0.7]),
}


@pytest.mark.slow
@pytest.mark.long
@needs_numba
@pytest.mark.parametrize("name", sampled(ROTATIONS, every=5))
def test_the_error_of_each_step_does_not_add_up(name: str) -> None:
    """The limit of a certificate is 1e-12 rad; the error of a step is below 1e-19 rad."""
    moments, rate = ROTATIONS[name]
    body = RigidBody(moments)
    start = State([0.1, 0.2, 0.3, np.sqrt(0.86)], rate)
    stepped = MovingChart(body, start, method="dmv20").at(DURATION_NS)
    exact = ClosedForm(body, start).at(DURATION_NS)
    assert difference(stepped, exact) < 5e-14
