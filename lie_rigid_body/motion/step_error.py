"""The truncation error of one step of a stepper of the moving chart, measured on a given motion.

At a short step the error of one step may lie below round-off. So it is measured at one in which a body turns by at
least ``PROBE_TURN``, a slender one by less. Its own turn sooner becomes too long for the order to tell the error. It is
measured from many states along the exact motion, against the Taylor flow, and scaled by its order.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.error_growth import PathFrame
from lie_rigid_body.motion.moving_chart import Method, MovingChart
from lie_rigid_body.motion.taylor_flow import flow

PROBE_TURN: Final = 1.0 / 16.0
"""Shortest rotation angle of the probe step, rad, of a body that is not slender."""

LONGEST_SPAN_NS: Final = 1e18
"""Longest probe step, ns, thirty years: a body that turns less in it has no truncation to speak of."""

SAFETY: Final = 4.0
"""Safety factor on the measured error, for states between those tried and for the terms of higher order."""


def step_error(
    body: RigidBody, states: State, stepper: Method, rate_bound: float, step: float, slenderness: float
) -> tuple[Array, Array]:
    """The truncation errors that steps of a given length make in a second, at each of K states.

    Parameters
    ----------
    body : RigidBody
    states : State
        Along the motion, of shapes (K, 4) and (K, 3).
    stepper : Method
    rate_bound : float
        Bound Ω > 0 of the body rate, rad/s.
    step : float
        h, s.
    slenderness : float
        Condition number ‖π‖/(I₁Ω): how many times larger a relative error of the momentum shows in the rate.

    Returns
    -------
    attitude : ndarray, shape (K,)
        rad/s
    momentum : ndarray, shape (3, K)
        Sizes of c, a and b of `error_growth`, 1/s.
    """
    turn = rate_bound * step
    span_ns = round(min(1e9 * max(turn, PROBE_TURN / slenderness) / rate_bound, LONGEST_SPAN_NS))
    if span_ns < 1:  # beyond what nanoseconds resolve: the Taylor terms that are left out, at their largest
        worst = rate_bound * turn**stepper.order / math.factorial(stepper.order + 1)
        return np.full(len(states), worst), np.full((3, len(states)), worst)
    span = 1e-9 * span_ns
    found = MovingChart(body, states, method=stepper.name, max_step=2.0 * span).at(span_ns)
    exact = flow(body, states, np.full(len(states), span), rate_bound)
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    changed = body.body_momentum(found) - body.body_momentum(exact)
    frame = PathFrame.of(body, exact, rate_bound)
    scale = SAFETY * (step / span) ** stepper.order / span
    return scale * so3.norm(quaternion.log(turned)), scale * frame.components(changed / frame.size)
