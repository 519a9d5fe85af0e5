"""The limits of the laws, derived from round-off and from the declared stepper's own error.

For a sample at time t after the segment's start let Ω bound the body rate, Θ = Ωt the angle turned at most, h the step,
x = Ωh, p the stepper's order and n the number of steps so far; u = 2⁻⁵³.

- Round-off. A recorded state carries a few dozen roundings of u, and a stepper adds a few more at each step, which
  accumulate like a random walk: ``FLOOR + u · PER_STEP · √n``; n = 0 for the closed form, whose error does not grow.
- Truncation. A step of order p leaves out the Taylor terms from order p + 1: at most about xᵖ⁺¹/(p+1)! in angle and in
  relative momentum, as the triangle inequality keeps the coefficients of Euler's equations below 1. Steps add up to
  xᵖ·Θ/(p+1)!. On random bodies the real errors came within a factor of 3 of this; the tests hold them against it.
- Propagation. An error of the momentum shifts the frequencies of the motion. How much attitude it costs later is a
  property of the motion alone: G(t), the largest turn at time t that a unit relative change of the initial rate causes,
  read off the closed form. Near the separatrix it is enormous, and no integrator in double precision can follow.
- Stamps are integer nanoseconds at which the state was evaluated, so they add nothing but the rounding of t in seconds,
  u·Θ. A limit is never looser than ``ATTITUDE_CAP`` or ``ENERGY_CAP``: what errs more is no ground truth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import METHODS, ClosedForm
from lie_rigid_body.scenario import Scenario

Array = NDArray[np.float64]

ATTITUDE_CAP: Final = 1e-7
"""rad"""

ENERGY_CAP: Final = 1e-9
"""Relative, of energy and momentum."""

CLOSED_FORM: Final = 2e-15
"""rad: the error of the closed form in every regime, which its tests hold against multiprecision."""

_U: Final = 2.0**-53
NORM_LIMIT: Final = 16 * _U
FLOOR: Final = 256 * _U
PER_STEP: Final = 8.0

_PROBE: Final = 2.0**-30
_PROBE_TIMES: Final = 257


@dataclass(frozen=True)
class Tolerance:
    """The limits for one segment.

    Parameters
    ----------
    fastest : float
        Bound Ω of the body rate, rad/s.
    order : int
        Order p of the declared stepper; 0 for the closed form.
    step : float
        Its step h, s.
    gain_times : ndarray, shape (K,)
        Times at which the propagation was read off, s.
    gains : ndarray, shape (K,)
        The largest G up to each of those times.
    """

    fastest: float
    order: int
    step: float
    gain_times: Array
    gains: Array

    def momentum(self, t: Array) -> Array:
        """Limit of relative momentum and relative body rate at times t, uncapped, shape (N,)."""
        return FLOOR + self._per_turn() * self.fastest * t + self._random_walk(t)

    def energy(self, t: Array) -> Array:
        """Limit of relative energy at times t, capped, shape (N,)."""
        return np.minimum(2.0 * self.momentum(t), ENERGY_CAP)

    def world_momentum(self, t: Array) -> Array:
        """Limit of the components of world momentum relative to its norm, capped, shape (N,)."""
        return np.minimum(2.0 * self.momentum(t), ENERGY_CAP)

    def attitude(self, t: Array) -> Array:
        """Limit of the angle to the closed form at times t, capped, rad, shape (N,)."""
        return np.minimum(self.attitude_uncapped(t), ATTITUDE_CAP)

    def attitude_uncapped(self, t: Array) -> Array:
        """What the declared motion may err by at times t, rad, shape (N,)."""
        gain = self.gains[np.minimum(np.searchsorted(self.gain_times, t), len(self.gains) - 1)]
        return np.asarray(self.momentum(t) + (self.momentum(t) - FLOOR) * gain + _U * self.fastest * t)

    def interval(self, spans: Array) -> Array:
        """Limit of what neighbouring samples may disagree by, rad or relative, capped, shape (N,).

        Over one interval the disturbance of either neighbour grows no faster than exp(Ωt), and no more than G allows.
        """
        growth = np.minimum(np.exp(np.minimum(self.fastest * spans, 700.0)), 1.0 + self.gains[-1])
        return np.asarray(np.minimum(2.0 * self.momentum(spans) * growth, ATTITUDE_CAP))

    def _per_turn(self) -> float:
        return (self.fastest * self.step) ** self.order / math.factorial(self.order + 1) if self.order else 0.0

    def _random_walk(self, t: Array) -> Array:
        return PER_STEP * _U * np.sqrt(t / self.step) if self.order else np.zeros_like(t)


def tolerance(scenario: Scenario, duration: float) -> Tolerance:
    """The limits for a segment of a scenario.

    Parameters
    ----------
    scenario : Scenario
        As declared in the bag.
    duration : float
        Length of the segment, s.

    Returns
    -------
    Tolerance
    """
    times, gains = _propagation(scenario, duration)
    order = METHODS[scenario.method].order if scenario.motion == "moving_chart" else 0
    return Tolerance(_fastest(scenario), order, _step(scenario), times, gains)


def _step(scenario: Scenario) -> float:
    period = 1.0 / scenario.rate
    return period / max(1.0, float(np.ceil(period / scenario.max_step - 1e-9)))


def _fastest(scenario: Scenario) -> float:
    """Ω from ½ I_min |ω|² ≤ H and from I_min |ω| ≤ |L|, whichever is tighter."""
    body, start = scenario.body(), scenario.start()
    smallest = float(body.principal_moments[0])
    by_energy = np.sqrt(2.0 * float(body.kinetic_energy(start)) / smallest)
    by_momentum = float(so3.norm(body.body_momentum(start))) / smallest
    return float(min(by_energy, by_momentum))


def _propagation(scenario: Scenario, duration: float) -> tuple[Array, Array]:
    """Times, and the running maximum of G at them, by differences of the closed form."""
    t_ns = np.linspace(0.0, duration * 1e9, _PROBE_TIMES).astype(np.int64)
    body, start = scenario.body(), scenario.start()
    reference = ClosedForm(body, start).at(t_ns).attitude_xyzw
    speed = float(so3.norm(start.body_rate))
    gains = np.zeros(_PROBE_TIMES)
    for axis in speed * np.vstack([np.eye(3), -np.eye(3)]):
        disturbed = State.trusted(start.attitude_xyzw.copy(), start.body_rate + _PROBE * axis)
        turned = quaternion.multiply(
            quaternion.conjugate(reference), ClosedForm(body, disturbed).at(t_ns).attitude_xyzw
        )
        gains = np.maximum(gains, so3.norm(quaternion.log(turned)) / _PROBE)
    return np.asarray(1e-9 * t_ns), np.asarray(np.maximum.accumulate(gains), dtype=np.float64)
