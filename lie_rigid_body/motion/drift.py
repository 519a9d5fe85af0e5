"""Bounds of how far a computed motion drifts from the exact one, for each family of steppers.

The rounding of the samples themselves is not counted. In these formulas Ω bounds the body rate, Θ = Ωt is the angle
turned at most, h the step and x = Ωh the angle turned in it at most; u = 2⁻⁵³ is the unit round-off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.arrays import Array
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.condition_numbers import ConditionNumbers
from lie_rigid_body.motion.moser_veselov import LARGEST_TURN
from lie_rigid_body.motion.moser_veselov.loop import STEPS_BETWEEN_RESTORATIONS, TURN_BETWEEN_RESTORATIONS
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, ScaledMotion
from lie_rigid_body.motion.moving_chart import Method
from lie_rigid_body.motion.step_error import StepError
from lie_rigid_body.motion.time_steps import longest_step, steps_between

U: Final = 2.0**-53
"""Unit round-off u of double precision."""

RANDOM_WALK_FACTOR: Final = 8.0
"""Factor of the attitude's random walk. In some hundred random motions of up to 3·10⁷ steps it was 2.5 at most."""

BIAS: Final = 2.0**-6
"""Safety factor of the residual rounding bias, in units of u x Θ. The largest observed value is 0.005."""

SEPARATRIX_MARGIN: Final = 0.01
"""Distance of the energy from the separatrix, relative to its range, within which the walk is counted twice: flips are
sensitive to all of it."""

TRUNCATION: Final = 2.0
"""Factor by which a time shift along the orbit enlarges the attitude error."""

ROUNDINGS_PER_STEP: Final = 4.0
"""Rounding errors of a Runge–Kutta–Munthe-Kaas step, in units of u."""

_MORE_TERMS: Final = 4
"""Terms of the series beyond the stepper's own that are counted as its truncation."""


class Drift(Protocol):
    """Bounds of the errors at times t after the start, s, each of shape (N,)."""

    def attitude(self, t: Array) -> Array:
        """Bound of the attitude error at time t, as a rotation angle, rad."""
        ...

    def rate(self, t: Array) -> Array:
        """Bound of the body-rate error, divided by Ω."""
        ...

    def momentum(self, t: Array) -> Array:
        """Bound of the error of the spatial momentum, relative to its norm."""
        ...

    def energy(self, t: Array) -> Array:
        """Bound of the error of the kinetic energy, relative."""
        ...


class NoDrift:
    """The drift of the closed form: its error does not grow."""

    def attitude(self, t: Array) -> Array:
        """0: no drift."""
        return np.zeros_like(t)

    rate = momentum = energy = attitude


@dataclass(frozen=True)
class MoserVeselovDrift:
    """The drift of Moser–Veselov steps, which keep energy and momentum, so that only the phase goes wrong.

    Two things move it: the terms that the preprocessed inertia leaves out, the same at every step; and round-off of the
    increments, u x a step, at random, which grows near the separatrix until the next projection onto the energy.

    Parameters
    ----------
    rate_bound, step : float
        Ω, rad/s, and h, s.
    truncation : float
        Turn that a step lacks, rad.
    growth : float
        Largest growth factor of a rounding error until the next projection onto the energy.
    """

    rate_bound: float
    step: float
    truncation: float
    growth: float

    @classmethod
    def of(
        cls, body: RigidBody, start: State, stepper: Method, rate_bound: float, period: float, max_step: float
    ) -> MoserVeselovDrift:
        """The drift of a motion sampled every ``period`` seconds, by the series of its preprocessed inertia."""
        with working_precision(DIGITS):
            frame = ScaledMotion.of(body, start)
            terms = stepper.order // 2
            series = preprocessed_inertia(Invariants.of(frame), terms + _MORE_TERMS)
            alpha, beta = (tuple(map(float, coefficients)) for coefficients in series)
            quickest = float(frame.fastest)
            step = period / steps_between(period, longest_step(max_step, stepper.largest_turn, quickest))
            fully = quickest * step
            # ρ₀ρⱼ = (α + β eⱼ) nⱼ, of which abs(eⱼ nⱼ) ≤ 1, and a step turns by twice the vector ρ
            missing = sum(abs(c) * fully ** (3 + 2 * k) for k, c in enumerate(alpha) if k >= terms - 1)
            missing += sum(abs(c) * fully ** (1 + 2 * k) for k, c in enumerate(beta) if k >= terms)
            # n is the mean over the step, which a slender body's own turn makes worse
            implicit = 1.0 + 2.0 * fully * max(map(float, frame.inverse_moments))
            return cls(rate_bound, step, 2.0 * implicit * missing, _growth(frame, step))

    def attitude(self, t: Array) -> Array:
        """Bound of the attitude error at time t, as a rotation angle, rad."""
        way = self.rate_bound * self.step * self.rate_bound * t
        round_off = U * (self.growth * RANDOM_WALK_FACTOR * np.sqrt(way) + BIAS * way)
        return np.asarray(round_off + TRUNCATION * self.truncation / self.step * t)

    rate = attitude

    def momentum(self, t: Array) -> Array:
        """0: kept to round-off."""
        return np.zeros_like(t)

    energy = momentum


def _growth(frame: ScaledMotion, step: float) -> float:
    """Largest growth factor of a rounding error until the next projection: exp(λt) near the intermediate axis."""
    e1, e2, e3 = frame.inverse_moments
    squared = float((e1 - e2) * (e2 - e3))
    if squared <= 0.0:
        return 1.0
    turn = min(STEPS_BETWEEN_RESTORATIONS * step * float(frame.fastest), TURN_BETWEEN_RESTORATIONS + LARGEST_TURN)
    near = float(abs(frame.twice_energy - e2)) < SEPARATRIX_MARGIN * float(abs(e1 - e3))
    return math.exp(math.sqrt(squared) * turn) * (2.0 if near else 1.0)


@dataclass(frozen=True)
class MuntheKaasDrift:
    """The drift of Runge–Kutta–Munthe-Kaas steps, which conserve neither energy nor spatial momentum.

    An error of the body rate makes an error of the attitude later.

    Parameters
    ----------
    rate_bound, step : float
        Ω, rad/s, and h, s.
    error : StepError
        Truncation for each radian turned.
    conditions : ConditionNumbers
    gain : callable
        G at times t, shape (N,): the largest turn up to each time, rad, that changing the initial rate by Ω causes, for
        each unit of that change.
    """

    rate_bound: float
    step: float
    error: StepError
    conditions: ConditionNumbers
    gain: Callable[[Array], Array]

    def attitude(self, t: Array) -> Array:
        """Bound of the attitude error, as a rotation angle, rad, with the rounding of stamps to seconds, uΘ."""
        direct = self._rounding(t) + (self.error.attitude + U) * self.rate_bound * t
        return np.asarray(direct + self.gain(t) * self.rate(t))

    def rate(self, t: Array) -> Array:
        """Bound of the body-rate error, divided by Ω."""
        return np.asarray(self.conditions.rate_of_momentum * self._rounding(t) + self.error.rate * self.rate_bound * t)

    def momentum(self, t: Array) -> Array:
        """Bound of the error of the spatial momentum, relative to its norm."""
        return np.asarray(2.0 * self._rounding(t) + self.error.momentum * self.rate_bound * t)

    def energy(self, t: Array) -> Array:
        """Bound of the error of the kinetic energy, relative."""
        rounding = 2.0 * self.conditions.energy_of_momentum * self._rounding(t)
        return np.asarray(rounding + self.error.energy * self.rate_bound * t)

    def _rounding(self, t: Array) -> Array:
        """Sum of the roundings, relative: those of a slow body repeat from step to step and add up linearly."""
        return ROUNDINGS_PER_STEP * U * self.conditions.inverse * t / self.step
