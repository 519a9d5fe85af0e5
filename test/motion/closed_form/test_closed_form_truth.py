"""The closed form against proved enclosures of the true motion, in every regime, and against the 40-digit truth."""

from __future__ import annotations

import numpy as np
import pytest
from regimes import REGIMES, motion

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion
from reference import attitude_error, rate_error, truth_cases

CASES = truth_cases()
ATTITUDE_BOUND = 1.5e-15
RATE_BOUND = 1e-15
RADIANS = [1e-9, 0.3, 2.9, 25.0, 1e3, 1e6, 1e10]
"""Turns, rad, as far as 292 years last."""


def require_truth(inertia, attitude, rate, t_ns: list[int]) -> None:
    """Attitude, its sign on the double cover, and body rate lie within the bounds of the truth."""
    enclose = pytest.importorskip("lie_rigid_body.proof", reason="python-flint is not installed").enclose
    start = State(quaternion.normalize(attitude), rate)
    states = ClosedForm(RigidBody(inertia), start).at(t_ns)
    for t, attitude_xyzw, body_rate in zip(t_ns, states.attitude_xyzw, states.body_rate, strict=True):
        truth = enclose(inertia, start.attitude_xyzw, start.body_rate, t)
        assert truth.attitude_error(attitude_xyzw)[1] < ATTITUDE_BOUND, (inertia, rate, t)
        assert sum(x * y for x, y in zip(truth.attitude_xyzw, attitude_xyzw.tolist(), strict=True)) > 0
        size = max(float(np.linalg.norm(rate)), float(np.linalg.norm(body_rate)))
        assert truth.rate_error(body_rate)[1] <= RATE_BOUND * size, (inertia, rate, t)


@pytest.mark.parametrize("regime", REGIMES)
def test_the_closed_form_is_the_truth_to_round_off_in_every_regime(regime):
    for seed in range(8):
        drawn = motion(regime, seed)
        radians = [(-1) ** seed * RADIANS[(seed + k) % len(RADIANS)] for k in range(3)]
        require_truth(*drawn, [drawn.stamp(angle) for angle in radians])


@pytest.mark.slow
@pytest.mark.parametrize("regime", REGIMES)
def test_many_motions_of_each_regime_are_the_truth_at_every_time(regime):
    for seed in range(8, 40):
        drawn = motion(regime, seed)
        require_truth(*drawn, [drawn.stamp(sign * angle) for sign in (1, -1) for angle in RADIANS])


@pytest.mark.parametrize("size", [1e-30, 1e-100, 1e-162, 1e-300])
def test_the_flip_after_a_spin_about_the_middle_axis_comes_on_time(size: float):
    """Transverse rates grow as exp(t/√3)."""
    flip = -np.sqrt(3.0) * np.log(size)
    times = [round(1e9 * (flip + x)) for x in (-4.0, 0.0, 3.0)]
    require_truth([1.0, 2.0, 3.0], [0.1, -0.7, 0.3, -0.5], [size, 1.0, -size], times)


@pytest.mark.parametrize("name", CASES)
def test_the_closed_form_is_the_truth_at_40_digits(name: str):
    body, start, points = CASES[name]
    states = ClosedForm(body, start).at([point.t_ns for point in points])
    for point, attitude, rate in zip(points, states.attitude_xyzw, states.body_rate, strict=True):
        assert attitude_error(attitude, point.attitude_xyzw) < ATTITUDE_BOUND
        assert rate_error(rate, point.body_rate) < RATE_BOUND
