"""The truncation error of one step of a stepper of the moving chart, measured on a given motion.

At a short step the error of one step may lie below round-off. So it is measured at one in which a body turns by at
least ``PROBE_TURN``, a slender one by less, since its own turn sooner becomes too long for the order to tell the error.
It is measured from many states along the exact motion, against the Taylor flow, and scaled by its order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
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


@dataclass(frozen=True)
class StepError:
    """Truncation errors that a stepper makes in a second at each of K states.

    Parameters
    ----------
    attitude : ndarray, shape (K,)
        rad/s
    components : ndarray, shape (3, K)
        Momentum in the body, relative to its norm, along the axes of `PathFrame`, 1/s.
    rate : ndarray, shape (K,)
        Body rate, rad/s².
    momentum : ndarray, shape (K,)
        Spatial momentum, relative to its norm, 1/s.
    energy : ndarray, shape (K,)
        Kinetic energy, relative, 1/s.
    """

    attitude: Array
    components: Array
    rate: Array
    momentum: Array
    energy: Array


def step_error(
    body: RigidBody, states: State, stepper: Method, rate_bound: float, step: float, slenderness: float
) -> StepError:
    """The truncation errors of steps of a given length.

    Parameters
    ----------
    body : RigidBody
    states : State
        Along the motion, of shapes (K, 4) and (K, 3).
    stepper : Method
    rate_bound : float
        Bound Ω of the body rate, rad/s.
    step : float
        h, s.
    slenderness : float
        Condition number ‖π‖/(I₁Ω): how many times larger a relative error of the momentum shows in the rate.

    Returns
    -------
    StepError
    """
    turn = rate_bound * step
    probe = max(turn, PROBE_TURN / slenderness)
    span_ns = round(min(1e9 * probe / rate_bound, LONGEST_SPAN_NS)) if rate_bound > 0.0 else 0
    if span_ns < 1:  # beyond what nanoseconds resolve: the Taylor terms that are left out, at their largest
        worst = np.full(len(states), rate_bound * turn**stepper.order / math.factorial(stepper.order + 1))
        return StepError(worst, np.tile(worst, (3, 1)), rate_bound * worst, 2.0 * worst, 2.0 * worst)
    span = 1e-9 * span_ns
    found = MovingChart(body, states, method=stepper.name, max_step=2.0 * span).at(span_ns)
    exact = flow(body, states, np.full(len(states), span), rate_bound)
    scale = SAFETY * (step / span) ** stepper.order / span
    return StepError(*(scale * error for error in _errors(body, found, exact, rate_bound)))


def _errors(body: RigidBody, found: State, exact: State, rate_bound: float) -> tuple[Array, ...]:
    """The errors of one step, in the order of `StepError`."""
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    momentum, energy = body.angular_momentum(exact), body.kinetic_energy(exact)
    size = so3.norm(momentum)
    changed = (body.body_momentum(found) - body.body_momentum(exact)) / size[:, np.newaxis]
    return (
        so3.norm(quaternion.log(turned)),
        PathFrame.of(body, exact, rate_bound).components(changed),
        so3.norm(found.body_rate - exact.body_rate),
        so3.norm(body.angular_momentum(found) - momentum) / size,
        np.abs(body.kinetic_energy(found) - energy) / energy,
    )
