"""How far a declared motion may go from the exact one, beside the rounding of its samples.

In these formulas Ω bounds the body rate, Θ = Ωt is the angle turned at most, h the step, x = Ωh, p the stepper's order
and n = t/h the number of steps so far; u = 2⁻⁵³.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.certificate.conditions import Conditions
from lie_rigid_body.certificate.propagation import Propagation
from lie_rigid_body.certificate.step_error import StepError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import Method
from lie_rigid_body.motion.moser_veselov import LARGEST_TURN
from lie_rigid_body.motion.moser_veselov.loop import STEPS_BETWEEN_RESTORATIONS, TURN_BETWEEN_RESTORATIONS
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.spinning_frame import SpinningFrame, working_precision
from lie_rigid_body.motion.time_steps import steps_between

Array = NDArray[np.float64]

U: Final = 2.0**-53

WALK: Final = 8.0
"""Of the attitude's random walk. In some hundred random motions of up to 3·10⁷ steps it was 2.5 at most."""

BIAS: Final = 2.0**-6
"""Of what is left of a bias, for each u of x Θ. It was 0.005 at most."""

NEAR: Final = 0.01
"""Distance from the separatrix within which the walk is counted twice, as flips are sensitive to all of it."""

TRUNCATION: Final = 2.0
"""For what a shift along the motion adds to the turn."""

PER_STEP: Final = 4.0

_MORE_TERMS: Final = 4


def equal_steps(period: float, longest: float) -> float:
    """The step when equal ones divide a period, s, none longer than allowed."""
    return period / steps_between(period, longest)


class Drift(Protocol):
    """Errors at times t after the start, each of shape (N,)."""

    def attitude(self, t: Array) -> Array:
        """Turn, rad."""
        ...

    def rate(self, t: Array) -> Array:
        """Body rate, relative to Ω."""
        ...

    def momentum(self, t: Array) -> Array:
        """World momentum, relative."""
        ...

    def energy(self, t: Array) -> Array:
        """Relative."""
        ...


class NoDrift:
    """Of the closed form: its error does not grow."""

    def attitude(self, t: Array) -> Array:
        """None."""
        return np.zeros_like(t)

    rate = momentum = energy = attitude


@dataclass(frozen=True)
class MoserVeselovDrift:
    """Of Moser–Veselov steps, which keep energy and momentum, so that only the phase goes wrong.

    Two things move it: the terms that the preprocessed inertia leaves out, the same at every step; and round-off of the
    increments, u x a step, at random, which grows near the separatrix until the energy is restored.

    Parameters
    ----------
    fastest, step : float
        Ω, rad/s, and h, s.
    truncation : float
        Turn that a step lacks, rad.
    growth : float
        How many times larger a rounding may become until the energy is next restored.
    """

    fastest: float
    step: float
    truncation: float
    growth: float

    @classmethod
    def of(
        cls, body: RigidBody, start: State, stepper: Method, fastest: float, period: float, max_step: float
    ) -> MoserVeselovDrift:
        """Of a motion sampled every ``period`` seconds, by the series of its preprocessed inertia."""
        with working_precision():
            frame = SpinningFrame.of(body, start)
            terms = stepper.order // 2
            series = preprocessed_inertia(Invariants.of(frame), terms + _MORE_TERMS)
            alpha, beta = (tuple(map(float, coefficients)) for coefficients in series)
            quickest = float(frame.fastest)
            step = equal_steps(period, min(max_step, stepper.largest_turn / quickest) if quickest else max_step)
            fully = quickest * step
            # ρ₀ρⱼ = (α + β eⱼ) nⱼ, of which abs(eⱼ nⱼ) ≤ 1, and a step turns by twice the vector ρ
            missing = sum(abs(c) * fully ** (3 + 2 * k) for k, c in enumerate(alpha) if k >= terms - 1)
            missing += sum(abs(c) * fully ** (1 + 2 * k) for k, c in enumerate(beta) if k >= terms)
            # n is the mean over the step, which a slender body's own turn makes worse
            implicit = 1.0 + 2.0 * fully * max(map(float, frame.inverse_moments))
            return cls(fastest, step, 2.0 * implicit * missing, _growth(frame, step))

    def attitude(self, t: Array) -> Array:
        """Turn, rad."""
        way = self.fastest * self.step * self.fastest * t
        round_off = U * (self.growth * WALK * np.sqrt(way) + BIAS * way)
        return np.asarray(round_off + TRUNCATION * self.truncation / self.step * t)

    rate = attitude

    def momentum(self, t: Array) -> Array:
        """None."""
        return np.zeros_like(t)

    energy = momentum


def _growth(frame: SpinningFrame, step: float) -> float:
    """How a rounding may grow until the energy is restored: at the rate λ about the intermediate axis."""
    e1, e2, e3 = frame.inverse_moments
    squared = float((e1 - e2) * (e2 - e3))
    if squared <= 0.0:
        return 1.0
    turn = min(STEPS_BETWEEN_RESTORATIONS * step * float(frame.fastest), TURN_BETWEEN_RESTORATIONS + LARGEST_TURN)
    near = float(abs(frame.twice_energy - e2)) < NEAR * float(abs(e1 - e3))
    return math.exp(math.sqrt(squared) * turn) * (2.0 if near else 1.0)


@dataclass(frozen=True)
class MuntheKaasDrift:
    """Of Runge–Kutta–Munthe-Kaas steps, which keep nothing: an error of the rate costs attitude later.

    Parameters
    ----------
    fastest, step : float
        Ω, rad/s, and h, s.
    error : StepError
        What truncation costs for each radian turned.
    conditions : Conditions
    propagation : Propagation
    """

    fastest: float
    step: float
    error: StepError
    conditions: Conditions
    propagation: Propagation

    def attitude(self, t: Array) -> Array:
        """Turn, rad. Stamps are integers, and the stepper adds their rounding in seconds, uΘ."""
        direct = self._rounding(t) + (self.error.attitude + U) * self.fastest * t
        return np.asarray(direct + self.propagation.gain(t) * self.rate(t))

    def rate(self, t: Array) -> Array:
        """Body rate, relative to Ω."""
        return np.asarray(self.conditions.rate_of_momentum * self._rounding(t) + self.error.rate * self.fastest * t)

    def momentum(self, t: Array) -> Array:
        """World momentum, relative."""
        return np.asarray(2.0 * self._rounding(t) + self.error.momentum * self.fastest * t)

    def energy(self, t: Array) -> Array:
        """Relative."""
        rounding = 2.0 * self.conditions.energy_of_momentum * self._rounding(t)
        return np.asarray(rounding + self.error.energy * self.fastest * t)

    def _rounding(self, t: Array) -> Array:
        """Roundings of a slow body repeat from step to step and add up linearly."""
        return PER_STEP * U * self.conditions.inverse * t / self.step
