"""The limits of the laws, derived from round-off and from the declared stepper's own error.

For a sample at time t after the segment's start let Ω bound the body rate, Θ = Ωt the angle turned at most, h the step,
x = Ωh, p the stepper's order and n = t/h the number of steps so far; u = 2⁻⁵³.

- Round-off. A recorded state carries a few dozen roundings, ``FLOOR``. A stepper adds a few at each step; those of a
  slow body repeat from step to step and add up linearly: ``PER_STEP · u · n``. The closed form's error does not grow.
- Truncation. `step_error` measures what one step costs on this very motion; n of them cost c·xᵖ·Θ.
- Propagation. An error of the rate costs attitude later. How much is a property of the motion alone: G(t), the largest
  turn at time t that a unit relative change of the initial rate causes, read off the closed form. Near the separatrix
  it is enormous, and no integrator in double precision can follow.
- Stamps are integer nanoseconds at which the state was evaluated; a stepper adds the rounding of t in seconds, u·Θ.

A limit is never looser than ``ATTITUDE_CAP`` or ``ENERGY_CAP``: what errs more is no ground truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import METHODS, ClosedForm
from lie_rigid_body.recording.certificate.step_error import StepError, step_error
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
PER_STEP: Final = 4.0

_PROBE: Final = 2.0**-30
_PROBE_TIMES: Final = 257


@dataclass(frozen=True)
class Tolerance:
    """The limits for one segment.

    Parameters
    ----------
    fastest : float
        Bound Ω of the body rate, rad/s.
    step : float
        The stepper's step h, s; infinite for the closed form.
    error : StepError
        What the stepper's truncation costs for each radian turned.
    energy_condition, rate_condition : float
        How many times larger a relative error of the momentum may show in the energy, and in the rate relative to Ω.
    gain_times : ndarray, shape (K,)
        Times at which the propagation was read off, s.
    gains : ndarray, shape (K,)
        The largest G up to each of those times, for a change of the rate by Ω.
    """

    fastest: float
    step: float
    error: StepError
    energy_condition: float
    rate_condition: float
    gain_times: Array
    gains: Array

    def energy(self, t: Array) -> Array:
        """Limit of relative energy at times t, capped, shape (N,)."""
        round_off = 2.0 * self.energy_condition * (FLOOR + self._rounding(t))
        return np.asarray(np.minimum(round_off + self.error.energy * self._turn(t), ENERGY_CAP))

    def world_momentum(self, t: Array) -> Array:
        """Limit of the components of world momentum relative to its norm, capped, shape (N,)."""
        limit = 2.0 * (FLOOR + self._rounding(t)) + self.error.momentum * self._turn(t)
        return np.asarray(np.minimum(limit, ENERGY_CAP))

    def attitude(self, t: Array) -> Array:
        """Limit of the angle to the closed form at times t, capped, rad, shape (N,)."""
        return np.asarray(np.minimum(self.attitude_uncapped(t), ATTITUDE_CAP))

    def attitude_uncapped(self, t: Array) -> Array:
        """What the declared motion may err by at times t, rad, shape (N,)."""
        gain = self.gains[np.minimum(np.searchsorted(self.gain_times, t), len(self.gains) - 1)]
        direct = self._rounding(t) + self.error.attitude * self._turn(t)
        clock = _U * self._turn(t) if np.isfinite(self.step) else 0.0
        return np.asarray(FLOOR + direct + clock + gain * self._rate_error(t))

    def attitude_step(self, spans: Array) -> Array:
        """Limit of what the attitudes of neighbouring samples may disagree by, capped, rad, shape (N,)."""
        limit = 2.0 * (FLOOR + self._rounding(spans)) + self.error.attitude * self._turn(spans)
        carried = self.rate_condition * FLOOR + self._rate_error(spans)
        return np.asarray(np.minimum((limit + carried * self._turn(spans)) * self._growth(spans), ATTITUDE_CAP))

    def rate_step(self, spans: Array) -> Array:
        """The same for their rates, relative to Ω, shape (N,)."""
        limit = 2.0 * self.rate_condition * FLOOR + self._rate_error(spans)
        return np.asarray(np.minimum(limit * self._growth(spans), ATTITUDE_CAP))

    def _rate_error(self, t: Array) -> Array:
        """What a stepper's rate may have gone wrong by after a time, relative to Ω."""
        return np.asarray(self.rate_condition * self._rounding(t) + self.error.rate * self._turn(t))

    def _growth(self, spans: Array) -> Array:
        """Over an interval a disturbance grows no faster than exp(Ωt), and no more than G allows."""
        return np.asarray(np.minimum(np.exp(np.minimum(self._turn(spans), 700.0)), 1.0 + self.gains[-1]))

    def _turn(self, t: Array) -> Array:
        return self.fastest * t

    def _rounding(self, t: Array) -> Array:
        return PER_STEP * _U * t / self.step


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
    t_ns = np.linspace(0.0, duration * 1e9, _PROBE_TIMES).astype(np.int64)
    states = ClosedForm(scenario.body(), scenario.start()).at(t_ns)
    fastest = _fastest(scenario)
    if scenario.motion == "closed_form":
        step, error = np.inf, StepError()
    else:
        step = _step(scenario)
        error = step_error(scenario.body(), states, METHODS[scenario.method], fastest, step)
    gains = _propagation(scenario, t_ns, states, fastest)
    times = np.asarray(1e-9 * t_ns, dtype=np.float64)
    return Tolerance(fastest, float(step), error, *_conditions(scenario, states, fastest), times, gains)


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


def _conditions(scenario: Scenario, states: State, fastest: float) -> tuple[float, float]:
    """|ω||π|/2H along the motion, and |π|/(I_min Ω); both at least 1."""
    body = scenario.body()
    energy = float(body.kinetic_energy(scenario.start()))
    if energy == 0.0 or fastest == 0.0:
        return 1.0, 1.0
    momentum = so3.norm(body.body_momentum(states))
    by_energy = float(np.max(so3.norm(states.body_rate) * momentum)) / (2.0 * energy)
    by_rate = float(np.max(momentum)) / (float(body.principal_moments[0]) * fastest)
    return max(1.0, by_energy), max(1.0, by_rate)


def _propagation(scenario: Scenario, t_ns: NDArray[np.int64], states: State, fastest: float) -> Array:
    """The running maximum of G at the times, by differences of the closed form."""
    body, start = scenario.body(), scenario.start()
    speed = float(so3.norm(start.body_rate))
    gains = np.zeros(len(t_ns))
    for axis in speed * np.vstack([np.eye(3), -np.eye(3)]):
        disturbed = State.trusted(start.attitude_xyzw.copy(), start.body_rate + _PROBE * axis)
        moved = ClosedForm(body, disturbed).at(t_ns).attitude_xyzw
        turned = quaternion.multiply(quaternion.conjugate(states.attitude_xyzw), moved)
        gains = np.maximum(gains, so3.norm(quaternion.log(turned)) / _PROBE)
    scale = fastest / speed if speed > 0.0 else 1.0
    return np.asarray(scale * np.maximum.accumulate(gains), dtype=np.float64)
