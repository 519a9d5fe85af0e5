"""The Taylor flow against the 40-digit truth: it must be a referee of its own."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import State
from lie_rigid_body.lie import so3
from lie_rigid_body.motion.taylor_flow import flow
from reference import attitude_error, rate_error, truth_cases

CASES = truth_cases()


@pytest.mark.parametrize("name", CASES)
def test_flow_reaches_the_truth(name):
    case = CASES[name]
    points = [p for p in case.points if p.t_ns <= 2_000_000_000]
    states = State.trusted(
        np.tile(case.start.attitude_xyzw, (len(points), 1)), np.tile(case.start.body_rate, (len(points), 1))
    )
    fastest = 1.3 * float(so3.norm(case.start.body_rate))
    ahead = flow(case.body, states, np.array([p.t_ns * 1e-9 for p in points]), fastest)
    for point, attitude, rate in zip(points, ahead.attitude_xyzw, ahead.body_rate, strict=True):
        assert attitude_error(attitude, point.attitude_xyzw) < 3e-14
        assert rate_error(rate, point.body_rate) < 5e-15


def test_a_body_at_rest_stays():
    case = CASES["asymmetric"]
    rest = State.trusted(np.array([[0, 0, 0, 1.0]]), np.zeros((1, 3)))
    ahead = flow(case.body, rest, np.array([5.0]), 0.0)
    np.testing.assert_array_equal(ahead.attitude_xyzw, [[0, 0, 0, 1.0]])
