"""Bounds of how far a computed motion drifts from the exact one, for each family of steppers.

The rounding of the samples themselves is not counted. In these formulas Ω bounds the body rate, Θ = Ωt is the angle
turned at most, h the step and x = Ωh the angle turned in it at most. The number u = 2⁻⁵³ is the unit round-off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.error_growth import ErrorGrowth, Errors, PathFrame
from lie_rigid_body.motion.moser_veselov import LARGEST_TURN
from lie_rigid_body.motion.moser_veselov.loop import STEPS_BETWEEN_RESTORATIONS, TURN_BETWEEN_RESTORATIONS
from lie_rigid_body.motion.moser_veselov.preprocessing import Invariants, preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, ScaledMotion
from lie_rigid_body.motion.moving_chart import Method
from lie_rigid_body.motion.time_steps import longest_step, steps_between


@dataclass(frozen=True)
class ConditionNumbers:
    """Condition numbers, at least 1: amplification of a relative error of the rate, or of the momentum.

    A body given by its principal moments has the first three 1: there a momentum's component is as exact as the
    rate's. Products of inertia cancel in Mω, the more the slenderer the body.

    Parameters
    ----------
    momentum : float
        Condition of the momentum computed from a rate, ‖abs(M) abs(ω)‖/‖Mω‖.
    energy : float
        Condition of the energy computed from a rate, the larger of abs(ω)·abs(M) abs(ω)/2H and ‖ω‖‖Mω‖/2H.
    inverse : float
        Condition of a rate computed from a momentum, I₃/I₁.
    energy_of_momentum, rate_of_momentum : float
        Effect of an error of the momentum in any direction: ‖ω‖‖π‖/2H on the energy, ‖π‖/(I₁Ω) on the rate
        relative to Ω.
    """

    momentum: float = 1.0
    energy: float = 1.0
    inverse: float = 1.0
    energy_of_momentum: float = 1.0
    rate_of_momentum: float = 1.0

    @classmethod
    def of(cls, body: RigidBody, states: State, rate_bound: float) -> ConditionNumbers:
        """The largest along the states of a motion whose body rate is bounded by ``rate_bound``, rad/s."""
        rates, momenta = states.body_rate, body.body_momentum(states)
        speeds, sizes = so3.norm(rates), so3.norm(momenta)
        twice_energy = 2.0 * body.kinetic_energy(states)
        if rate_bound == 0.0 or twice_energy.min() == 0.0:
            return cls()
        smallest, _, largest = (float(moment) for moment in body.principal_moments)
        by_rate = _largest(sizes / (smallest * rate_bound))
        by_energy = _largest(speeds * sizes / twice_energy)
        if np.count_nonzero(body.inertia) <= len(body.inertia):
            return cls(energy_of_momentum=by_energy, rate_of_momentum=by_rate)
        parts = apply_tensor(np.abs(body.inertia), np.abs(rates))
        return cls(
            _largest(so3.norm(parts) / sizes),
            max(by_energy, _largest(np.sum(np.abs(rates) * parts, axis=-1) / twice_energy)),
            largest / smallest,
            by_energy,
            by_rate,
        )


def _largest(values: Array) -> float:
    return max(1.0, float(np.max(values)))


U: Final = 2.0**-53
"""Unit round-off u of double precision."""

RANDOM_WALK_FACTOR: Final = 8.0
"""Factor of the random walk that rounding makes. The largest observed in random motions of up to 3·10⁷ steps is 2.5."""

ROUNDING_BIAS: Final = 2.0**-6
"""Bound of the bias of rounding, in units of u x Θ. The largest observed value is 0.005."""

BIAS_IF_REPEATED: Final = 2.0**-3
"""The bound where all increments are rounded alike, in a steady rotation. The largest observed value is 0.061."""

SEPARATRIX_MARGIN: Final = 0.01
"""Distance of the energy from the separatrix, relative to its range, within which the walk is counted twice: flips are
sensitive to all of it."""

TRUNCATION: Final = 2.0
"""Factor by which a time shift along the orbit enlarges the attitude error."""

BIAS_OF_SLOPE: Final = 16.0
"""Round-off of a slope, in units of u, that may be alike in all steps and so adds up."""

BIAS_OF_STEP: Final = 2.0**-4
"""Part of the rounding of an attitude that is alike in all steps, in units of u. The largest observed is 0.015."""

REPEATED: Final = 4.0
"""Largest change of an increment between two steps, in units of u, at which its rounding is taken to repeat."""

_MORE_TERMS: Final = 4
"""Terms of the series beyond the stepper's own that are counted as its truncation."""


class NoDrift:
    """The drift of the closed form: its error does not grow."""

    def attitude(self, t: Array) -> Array:
        """0: no drift."""
        return np.zeros_like(t)

    rate = momentum = energy = attitude_step = rate_step = attitude


@dataclass(frozen=True)
class MoserVeselovDrift:
    """The drift of Moser–Veselov steps, which keep energy and momentum, so that only the phase goes wrong.

    Two things move it. The terms that the preprocessed inertia leaves out are the same at every step. Round-off of the
    increments, u x a step, is at random, and grows near the separatrix until the next projection onto the energy.

    Parameters
    ----------
    rate_bound, fastest, step : float
        Ω and the largest body rate, which of a slender body is far smaller, rad/s, and h, s.
    truncation : float
        Turn that a step lacks, rad.
    growth : float
        Largest growth factor of a rounding error until the next projection onto the energy.
    bias : float
        Bound of the bias of rounding, in units of u x Θ.
    """

    rate_bound: float
    fastest: float
    step: float
    truncation: float
    growth: float
    bias: float

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
            change = float(so3.norm(body.angular_acceleration(start))) * step**2
            bias = BIAS_IF_REPEATED if change <= REPEATED * U * fully else ROUNDING_BIAS
            return cls(rate_bound, quickest, step, 2.0 * implicit * missing, _growth(frame, step), bias)

    def attitude(self, t: Array) -> Array:
        """Bound of the attitude error at time t, as a rotation angle, rad."""
        way = self.fastest * self.step * self.fastest * t
        round_off = U * (self.growth * RANDOM_WALK_FACTOR * np.sqrt(way) + self.bias * way)
        return np.asarray(round_off + TRUNCATION * self.truncation / self.step * t)

    attitude_step = attitude

    def rate(self, t: Array) -> Array:
        """Bound of the body-rate error, divided by Ω: energy and momentum are kept, and with the phase it moves."""
        return np.asarray(self.attitude(t) * (self.fastest / self.rate_bound))

    rate_step = rate

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

    Errors of the momentum grow along the motion, and turn the attitude. They are made by truncation, and by rounding
    the rate and the slopes, alike in all steps. They are also made by rounding each sum of a momentum and its
    increment. These roundings are at random where increments change from step to step by more than a rounding, and
    alike where they do not.

    Parameters
    ----------
    rate_bound, step : float
        Ω, rad/s, and h, s.
    conditions : ConditionNumbers
    turned, moved, quickened, heated : float
        Largest errors that truncation, and roundings that are alike, make in a second. They are of the attitude by
        truncation, rad; of the momentum and of the rate, relative to the norm and to Ω; of the energy, relative.
    attitudes, rates : tuple of Errors
        Errors of the attitude, rad, and of the rate, rad/s, that those of the momentum lead to.
    """

    rate_bound: float
    step: float
    conditions: ConditionNumbers
    turned: float
    moved: float
    quickened: float
    heated: float
    attitudes: tuple[Errors, ...]
    rates: tuple[Errors, ...]

    @classmethod
    def of(
        cls,
        body: RigidBody,
        states: State,
        growth: ErrorGrowth,
        error: tuple[Array, Array],
        conditions: ConditionNumbers,
        rate_bound: float,
        step: float,
    ) -> MuntheKaasDrift:
        """The drift of steps of one length, from what `step_error` finds at the nodes of a motion."""
        turned, truncated = error
        rates, n = np.abs(states.body_rate), np.abs(growth.frame.axes[0])
        if np.count_nonzero(body.inertia) > len(body.inertia):  # then each axis has the roundings of all
            rates, n = (np.tile(so3.norm(v)[:, np.newaxis], 3) for v in (conditions.inverse * rates, n))
        slope, bend = (np.abs(derivative) for derivative in _derivatives(body, states, growth.frame))
        slopes = n[:, [1, 2, 0]] * rates[:, [2, 0, 1]] + n[:, [2, 0, 1]] * rates[:, [1, 2, 0]]
        repeated = step**2 * bend < REPEATED * U * n
        alike = BIAS_OF_SLOPE * U * slopes + np.where(repeated, 2.0 * np.minimum(U * n / step, slope), 0.0)
        together = math.sqrt(max(1.0, _alike_in_momentum(rate_bound * step)) / step)
        walk = np.where(repeated, 0.0, RANDOM_WALK_FACTOR * U * n * together)
        made = growth.frame.largest_components(alike) + truncated
        independent = growth.frame.largest_components(walk)
        # divided first: the energy of a slow body may be below what a double holds
        energies = 0.5 * np.sum(states.body_rate * (body.body_momentum(states) / growth.frame.size), axis=-1)
        return cls(
            rate_bound,
            step,
            conditions,
            float(turned.max()),
            float(np.sum(made, axis=0).max()),
            float(np.sum(growth.rates * made, axis=0).max()) / rate_bound,
            float((growth.energy_rates(made) / energies).max()),
            (growth.attitude(made), growth.attitude(independent, 2)),
            (growth.rate(made), growth.rate(independent, 2)),
        )

    def attitude(self, t: Array) -> Array:
        """Bound of the attitude error, as a rotation angle, rad."""
        return np.asarray(self.attitude_step(t) + sum(errors(t) for errors in self.attitudes))

    def rate(self, t: Array) -> Array:
        """Bound of the body-rate error, divided by Ω."""
        return np.asarray(sum(errors(t) for errors in self.rates) / self.rate_bound)

    def momentum(self, t: Array) -> Array:
        """Bound of the error of the spatial momentum, relative to its norm."""
        return np.asarray(self._walk(t) + self.moved * t + self.attitude_step(t))

    def energy(self, t: Array) -> Array:
        """Bound of the error of the kinetic energy, relative."""
        return np.asarray(2.0 * self.conditions.energy_of_momentum * self._walk(t) + self.heated * t)

    def attitude_step(self, spans: Array) -> Array:
        """Bound of the attitude errors made in a time, rad, before any of them grows."""
        steps, turn = spans / self.step, self.rate_bound * self.step
        # as in the momentum: q cos(θ/2) is q less qθ²/8, which changes by up to θ³/16, and this change by θ⁴/16
        alike = 4.0 * math.sqrt(U) / max(turn, U) ** 2
        bias = (BIAS_OF_STEP + BIAS_OF_SLOPE * self.conditions.inverse * turn) * U * steps
        return np.asarray(2.0 * self._walk(spans, alike) + bias + self.turned * spans)

    def rate_step(self, spans: Array) -> Array:
        """Bound of the errors of the body rate made in a time, divided by Ω, before any of them grows."""
        return np.asarray(self.conditions.rate_of_momentum * self._walk(spans) + self.quickened * spans)

    def _walk(self, t: Array, alike: float | None = None) -> Array:
        """Bound of a walk of one rounding a step, at random but for so many that are alike: those of the momentum."""
        alike = _alike_in_momentum(self.rate_bound * self.step) if alike is None else alike
        steps = t / self.step
        return np.asarray(RANDOM_WALK_FACTOR * U * np.sqrt(steps * np.clip(alike, 1.0, np.maximum(steps, 1.0))))


def _alike_in_momentum(turn: float) -> float:
    """Number of steps whose roundings of the momentum are alike, where its increment differs by u at most from another.

    An increment changes by up to x² a step, and this change by up to x³. Where it is a multiple of a unit in the last
    place, the increments of √(u/x³) steps are alike but for such units.
    """
    return math.sqrt(U / max(turn, U) ** 3)


def _derivatives(body: RigidBody, states: State, frame: PathFrame) -> tuple[Array, Array]:
    """First and second derivative of n by time, of shape (K, 3): n × ω, and what follows from Euler's equations."""
    n, rates = frame.axes[0], states.body_rate
    first = np.cross(n, rates)
    return first, np.cross(first, rates) + np.cross(n, frame.size * apply_tensor(body.inverse_inertia, first))


Drift: TypeAlias = NoDrift | MoserVeselovDrift | MuntheKaasDrift
"""Bounds of errors at times t, s after the start, each of shape (N,).

The attitude's error is a rotation angle, rad; that of the body rate is divided by Ω; those of the spatial momentum and
of the kinetic energy are relative. ``attitude_step`` and ``rate_step`` bound what is made in a time, before it grows.
"""
