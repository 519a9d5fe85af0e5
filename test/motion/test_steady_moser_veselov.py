"""Steady rotations repeat the rounding of each of their steps: it must not add up."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.lie import quaternion
from sampled import sampled

DURATION_NS = 10**15
"""Four million steps of ¼ rad."""
ROTATIONS = {
    "first axis": ([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]),
    "second axis": ([1.0, 2.0, 3.0], [0.0, 1.0, 0.0]),
    "third axis": ([1.0, 2.0, 3.0], [0.0, 0.0, 1.0]),
    "spherical top": ([1.0, 1.0, 1.0], [0.3, 0.5, 0.7]),
    "oblate top": ([1.0, 1.0, 2.0], [0.3, 0.5, 0.7]),
    "prolate top": ([1.0, 2.0, 2.0], [0.3, 0.5, 0.7]),
}


@pytest.mark.long
@pytest.mark.parametrize("name", sampled(ROTATIONS, every=5))
def test_the_error_of_each_step_does_not_add_up(name: str) -> None:
    """The limit of a certificate is 1e-12 rad; the error of a step is below 1e-19 rad."""
    moments, rate = ROTATIONS[name]
    body = RigidBody(moments)
    start = State([0.1, 0.2, 0.3, np.sqrt(0.86)], rate)
    stepped = MovingChart(body, start, method="dmv20").at(DURATION_NS)
    exact = ClosedForm(body, start).at(DURATION_NS)
    between = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), stepped.attitude_xyzw)
    assert np.linalg.norm(quaternion.log(between)) < 1e-13
