"""The truncation error of one step of a stepper of the moving chart, measured on a given motion.

At the real step the error of one step may lie below round-off. So it is measured at a larger one, where a body turns
by at most ``PROBE_TURN``, a slender one by less, since its own turn sooner becomes too long for the order to tell the
error. It is measured from many states along the exact motion, against the Taylor flow, and scaled by its order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moving_chart import Method, MovingChart
from lie_rigid_body.motion.taylor_flow import flow

PROBE_TURN: Final = 1.0 / 16.0
"""Rotation angle of the probe step, rad."""

LONGEST_SPAN_NS: Final = 1e18
"""Longest probe step, ns, thirty years: a body that turns less in it has no truncation to speak of."""

SAFETY: Final = 4.0
"""Safety factor on the measured error, for states between those tried and for the terms of higher order."""


@dataclass(frozen=True)
class StepError:
    """Truncation errors of a stepper for each radian of Ωt, where Ω bounds the body rate.

    Parameters
    ----------
    attitude : float
        rad
    rate : float
        Relative to Ω.
    momentum : float
        Of the spatial momentum, relative to its norm.
    energy : float
        Relative.
    """

    attitude: float = 0.0
    rate: float = 0.0
    momentum: float = 0.0
    energy: float = 0.0


def step_error(
    body: RigidBody, states: State, stepper: Method, rate_bound: float, step: float, slenderness: float
) -> StepError:
    """The truncation errors of steps of a given length.

    Parameters
    ----------
    body : RigidBody
    states : State
        Along the motion, of shapes (N, 4) and (N, 3).
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
    if rate_bound == 0.0:
        return StepError()
    probe = min(PROBE_TURN, max(rate_bound * step, PROBE_TURN / slenderness))
    span_ns = round(min(1e9 * probe / rate_bound, LONGEST_SPAN_NS))
    if span_ns < 1:  # beyond what nanoseconds resolve: the Taylor terms that are left out, at their largest
        worst = (rate_bound * step) ** stepper.order / math.factorial(stepper.order + 1)
        return StepError(worst, worst, 2.0 * worst, 2.0 * worst)
    turn = rate_bound * 1e-9 * span_ns
    found = _one_step(body, states, stepper.name, span_ns)
    exact = flow(body, states, np.full(len(states), 1e-9 * span_ns), rate_bound)
    scale = SAFETY * (rate_bound * step / turn) ** stepper.order / turn
    return StepError(*(scale * error for error in _errors(body, found, exact, rate_bound)))


def _one_step(body: RigidBody, states: State, method: str, span_ns: int) -> State:
    """The states after one step from each."""
    ends = [
        MovingChart(body, states[i], method=method, max_step=2e-9 * span_ns).at(span_ns) for i in range(len(states))
    ]
    return State.trusted(np.array([e.attitude_xyzw for e in ends]), np.array([e.body_rate for e in ends]))


def _errors(body: RigidBody, found: State, exact: State, rate_bound: float) -> tuple[float, float, float, float]:
    """The largest errors of attitude, rate, momentum and energy, in the units of `StepError`."""
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    momentum, energy = body.angular_momentum(exact), body.kinetic_energy(exact)
    return (
        float(so3.norm(quaternion.log(turned)).max()),
        float(so3.norm(found.body_rate - exact.body_rate).max()) / rate_bound,
        float((so3.norm(body.angular_momentum(found) - momentum) / so3.norm(momentum)).max()),
        float((np.abs(body.kinetic_energy(found) - energy) / energy).max()),
    )
