"""The limits of the laws: what a sample in doubles can carry, and how far the declared motion may drift.

- Reading. A recorded state carries a few roundings, and so does the state of the closed form that it is held against.
  Both of these and the closed form's own error, twice, make ``READING``. Products of inertia enlarge it in momentum and
  energy (`ConditionNumbers`).
- Drift. A closed form has none; Moser–Veselov steps lose the phase alone, Runge–Kutta steps energy and momentum as
  well. Their errors are bounded with the growth that they have along the motion until the end (`error_growth`).
- Between neighbours the flow is summed in doubles, ``FLOW`` roundings in each of its substeps, and carries the
  roundings of the rate that it starts from.

No limit of a state is looser than ``ATTITUDE_CAP`` or ``ENERGY_CAP``, and what a stepper errs between neighbours is not
either: what errs more is no ground truth. The roundings of that comparison itself have no such cap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.parameters import Vector
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import METHODS, ClosedForm
from lie_rigid_body.motion.description import MotionConstants
from lie_rigid_body.motion.drift import ConditionNumbers, Drift, MoserVeselovDrift, MuntheKaasDrift, NoDrift, U
from lie_rigid_body.motion.error_growth import ErrorGrowth
from lie_rigid_body.motion.step_error import step_error
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN, TURN_PER_SUBSTEP
from lie_rigid_body.motion.time_steps import steps_between
from lie_rigid_body.scenario import Scenario

ATTITUDE_CAP: Final = 1e-7
"""Largest limit of the attitude error, rad."""

ENERGY_CAP: Final = 1e-9
"""Largest limit of the relative error of energy and momentum."""

CLOSED_FORM: Final = 2e-15
"""Largest error of the closed form in every regime up to 1e15 rad, rad, as its tests find by multiprecision."""
_PHASE: Final = 2.0**-101
"""Relative error of a phase, of all that it has gone through, or of π rad a nanosecond where it is faster than that.

See docs/closed_form.md, Phases."""
_PHASE_RATE: Final = 1e-48
"""Relative error of the rates of phases, which have 50 digits: up to 8e-50 by enclosures of 1e36 to 1e45 rad."""

NORM_LIMIT: Final = 8 * U
"""Limit of | |q| − 1 |, dimensionless."""

READING: Final = 48 * U
"""Limit of the reading error, relative or rad: 2 · ``CLOSED_FORM`` and 12 roundings, 5.3e-15."""

FLOW: Final = 16 * U
"""Rounding error of one substep of the Taylor flow, relative or rad."""
SHARED: Final = 512
"""Largest number of segments whose limits are kept in memory: one batch of a bag may have as many."""
_NODES: Final = 257
"""Number of states along the motion, or along one of its periods."""
_ASIDE: Final = 2.0**-30 * np.array([0.61, -0.53, 0.59])
"""Change of the initial body rate, relative to its size, that takes it off a steady rotation, where errors of the rate
would seem not to grow. A growth by more than its inverse makes every limit its cap."""


@dataclass(frozen=True)
class Propagation:
    """States of the exact motion of a body for ``duration`` seconds, and the growth of errors between them.

    Parameters
    ----------
    body : RigidBody
    duration, fastest, turning : float
        s, bound of the body rate, rad/s, and sum of the mean rates of the phases, rad/s.
    states : State
        Shapes (K, 4) and (K, 3).
    growth : ErrorGrowth
    """

    body: RigidBody
    duration: float
    fastest: float
    turning: float
    states: State
    growth: ErrorGrowth

    @classmethod
    @lru_cache(maxsize=SHARED // 8)
    def of(
        cls, inertia: Vector, attitude_xyzw: Vector, body_rate: Vector, duration: float, fastest: float
    ) -> Propagation:
        """The propagation along a motion: most of the work, and the same for all steps and rates of samples."""
        body, start = RigidBody(inertia), State(attitude_xyzw, body_rate)
        near = State(start.attitude_xyzw, start.body_rate + _ASIDE * so3.norm(start.body_rate))
        circulation = MotionConstants.of(body, near).circulation
        turning = float(so3.norm(start.body_rate))
        if circulation is not None:
            turning = circulation.precession_rate_rad_s + 2.0 * np.pi / circulation.period_s
        # energy and momentum do not tell a state from that half a period later
        period = duration if circulation is None else min(duration, 0.5 * circulation.period_s)
        t_ns = np.linspace(0.0, period * 1e9, _NODES).astype(np.int64)
        states = ClosedForm(body, near).at(t_ns)
        growth = ErrorGrowth.of(body, np.asarray(1e-9 * t_ns), states, fastest)
        return cls(body, duration, fastest, turning, states, growth)

    @cached_property
    def largest_growth(self) -> float:
        """Largest factor by which an error grows between two times of the motion."""
        return self.growth.largest(self.body, self.fastest, self.duration)


@dataclass(frozen=True)
class Tolerance:
    """The limits of the laws for one segment.

    Parameters
    ----------
    fastest : float
        Bound Ω of the body rate, rad/s.
    conditions : ConditionNumbers
    drift : Drift
    propagation : Propagation
    inversion : float
        Factor of the roundings of a recorded rate, of a stepper that computes it from the momentum.
    """

    fastest: float
    conditions: ConditionNumbers
    drift: Drift
    propagation: Propagation
    inversion: float = 1.0

    def energy(self, t: Array) -> Array:
        """Limit of the relative energy error at times t, capped, shape (N,)."""
        reading = READING * self.conditions.energy * self.inversion
        return np.asarray(np.minimum(reading + self.drift.energy(t), ENERGY_CAP))

    def world_momentum(self, t: Array) -> Array:
        """Limit of the error of a world momentum component relative to its norm, at times t, capped, shape (N,)."""
        reading = READING * self.conditions.momentum * self.inversion
        return np.asarray(np.minimum(reading + self.drift.momentum(t), ENERGY_CAP))

    def attitude(self, t: Array) -> Array:
        """Limit of the angle to the closed form at times t, capped, rad, shape (N,)."""
        return np.asarray(np.minimum(self.attitude_uncapped(t), ATTITUDE_CAP))

    def attitude_uncapped(self, t: Array) -> Array:
        """Limit of the attitude error before the cap, rad, shape (N,)."""
        return np.asarray(READING + self.drift.attitude(t) + self.phases(t))

    def phases(self, t: Array) -> Array:
        """Bound of the closed form's own error at times t beyond ``CLOSED_FORM``, rad, shape (N,)."""
        turned = self.propagation.turning * t
        reduced = np.minimum(turned, np.pi * 1e9 * t)
        return np.asarray(np.minimum(np.maximum(_PHASE * reduced - CLOSED_FORM, 0.0) + _PHASE_RATE * turned, np.pi))

    def stepper_attitude(self, t: Array) -> Array:
        """Limit of the declared stepper's error of the attitude at times t, capped, rad, shape (N,)."""
        return np.asarray(np.minimum(self.drift.attitude(t), ATTITUDE_CAP))

    def stepper_rate(self, t: Array) -> Array:
        """Limit of the declared stepper's error of the body rate at times t, capped, rad/s, shape (N,)."""
        return np.asarray(self.fastest * np.minimum(self.drift.rate(t), ATTITUDE_CAP))

    def stepper_mean_rate(self, t: Array, span: float) -> Array:
        """Limit of the declared stepper's error of the mean rate over ``span``, s, up to times t, rad/s.

        That is the difference of the errors of two attitudes. It is at most the sum of both. It is also at most what
        the steps between them add, and an error of the rate before them, which is capped as that of any gyro.
        """
        spans = np.array([span])
        turn, growth = self.fastest * spans, self._growth(self.fastest * spans)
        between = self.drift.attitude_step(spans) + turn * self.drift.rate_step(spans) + spans * self.stepper_rate(t)
        turned = np.minimum(2.0 * self.drift.attitude(t), growth * between)
        return np.asarray(np.minimum(turned, ATTITUDE_CAP) / span)

    def attitude_step(self, spans: Array) -> Array:
        """Limit of the angle of a sample to the flow over spans, s, from the one before, rad, shape (N,)."""
        turns = self.fastest * spans
        rounded = 2.0 * READING + FLOW * turns / TURN_PER_SUBSTEP + turns * self._rate_reading(turns)
        stepped = self.drift.attitude_step(spans) + turns * self.drift.rate_step(spans)
        growth = self._growth(turns)
        return np.asarray(np.minimum(rounded * growth, np.pi) + np.minimum(stepped * growth, ATTITUDE_CAP))

    def rate_step(self, spans: Array) -> Array:
        """Limit of |ω_sample − ω_flow|/Ω over spans, s, shape (N,)."""
        turns = self.fastest * spans
        growth = self._growth(turns)
        stepped = np.minimum(self.drift.rate_step(spans) * growth, ATTITUDE_CAP)
        return np.asarray(np.minimum(self._rate_reading(turns) * growth, 2.0) + stepped)  # both rates are at most Ω

    def _growth(self, turns: Array) -> Array:
        """Largest factor by which an error grows over turns, rad: exp(turn), and at most that of any two states."""
        grown = np.exp(np.minimum(turns, LONGEST_TURN))
        if np.max(grown, initial=1.0) > 2.0:  # the largest is not below that, and takes a while to compute
            grown = np.minimum(grown, self.propagation.largest_growth)
        return np.asarray(grown)

    def _rate_reading(self, turns: Array) -> Array:
        """Roundings of a recorded rate, and of the momentum and the flow that start from it, relative to Ω."""
        return np.asarray(READING * self.conditions.inverse + FLOW * self.conditions.rate_of_momentum * turns)


@lru_cache(maxsize=SHARED)
def tolerance(scenario: Scenario, duration: float) -> Tolerance:
    """The limits for a segment of a scenario, which the truth and the sensors of one rate share.

    Parameters
    ----------
    scenario : Scenario
        Scenario that the bag declares.
    duration : float
        Length of the segment, s.

    Returns
    -------
    Tolerance
    """
    body, start, fastest = scenario.body(), scenario.start(), scenario.rate_bound()
    propagation = Propagation.of(
        scenario.inertia, scenario.initial_attitude_xyzw, scenario.initial_body_rate, duration, fastest
    )
    conditions = ConditionNumbers.of(body, propagation.states, fastest)
    if scenario.motion == "closed_form" or fastest == 0.0:
        return Tolerance(fastest, conditions, NoDrift(), propagation)
    method = METHODS[scenario.method]
    period = 1.0 / scenario.rate
    if method.largest_turn < math.inf:
        drift = MoserVeselovDrift.of(body, start, method, fastest, period, scenario.max_step)
        return Tolerance(fastest, conditions, drift, propagation)
    step = period / steps_between(period, scenario.max_step)
    error = step_error(body, propagation.states, method, fastest, step, conditions.rate_of_momentum)
    steps = MuntheKaasDrift.of(body, propagation.states, propagation.growth, error, conditions, fastest, step)
    return Tolerance(fastest, conditions, steps, propagation, conditions.inverse)
