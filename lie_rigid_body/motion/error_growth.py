"""Growth of small errors of momentum and attitude along a torque-free motion.

Let n be the unit vector of the body momentum π, and v = |n × ω| the speed of n. An error of the momentum, divided by
|π|, has three components: c along n, a along the gradient of the energy on the sphere, g = (ω − (ω·n) n)/v, and b along
the path of n, h = n × g. Euler's equations, linear in small errors, keep c and v a, as they keep |π| and the energy.
The delay b/v along the path grows:

    d/dt (b/v) = c + κ a/v,     κ = |π| (g·M⁻¹g − h·M⁻¹h).

The angle of the error of the attitude about the spatial momentum grows by ω·δn a second, as ω·δπ is the error of the
energy. The spatial momentum of the erring motion is constant, which gives the angle across it. So the error at a time t
is known in closed form from that at any time s before it, with S(t) = ∫κ/v² dt. Near the separatrix it grows by
v(t)/v(s) and by v(t)v(s)(S(t) − S(s)). All of that but the growth with t − s repeats with the period of v.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor

_SLOWEST: Final = 2.0**-40
"""Speed across n, relative to the body rate, that is added, so that g exists where n does not move."""


@dataclass(frozen=True)
class PathFrame:
    """Axes along and across the path of the momentum's direction, of N states.

    Parameters
    ----------
    axes : ndarray, shape (3, N, 3)
        Unit vectors n, g and h, body frame.
    speed : ndarray, shape (N,)
        v, rad/s.
    size : float
        |π| of the first state, kg m²/s.
    """

    axes: Array
    speed: Array
    size: float

    @classmethod
    def of(cls, body: RigidBody, states: State, rate_bound: float) -> PathFrame:
        """The axes at states of one motion, whose body rate is bounded by ``rate_bound``, rad/s."""
        rates, momenta = states.body_rate, body.body_momentum(states)
        sizes = np.maximum(so3.norm(momenta), np.finfo(float).tiny)
        n = momenta / sizes[:, np.newaxis]
        anywhere = np.cross(n, np.eye(3)[np.argmin(np.abs(n), axis=-1)])
        across = rates - np.sum(rates * n, axis=-1, keepdims=True) * n + _SLOWEST * rate_bound * anywhere
        speed = np.maximum(so3.norm(across), np.finfo(float).tiny)
        g = across / speed[:, np.newaxis]
        return cls(np.stack([n, g, np.cross(n, g)]), speed, float(sizes[0]))

    def components(self, errors: Array) -> Array:
        """The sizes of c, a and b, shape (3, N), of errors of n in the body frame, shape (N, 3)."""
        return np.asarray(np.abs(np.sum(self.axes * errors, axis=-1)))

    def largest_components(self, errors: Array) -> Array:
        """The largest c, a and b, shape (3, N), of errors of n whose components are at most these, shape (N, 3)."""
        return np.asarray(np.sum(np.abs(self.axes) * errors, axis=-1))


@dataclass(frozen=True)
class Errors:
    """Bound of the sum of errors made from the start to a time, as a function of the time.

    Parameters
    ----------
    times : ndarray, shape (K,)
        Times of nodes, s, from 0 to the period.
    values : ndarray, shape (K,)
        Bounds at these times.
    period, later : float
        Bound, anywhere in a period, of what the errors made in it amount to, and increase of that in each later period.
    power : int
        1 where errors add up; 2 where they are independent, and their squares add up.
    """

    times: Array
    values: Array
    period: float
    later: float
    power: int

    def __call__(self, t: Array) -> Array:
        """The bound at times t, s, shape (N,)."""
        first = self.values[np.minimum(np.searchsorted(self.times, t), len(self.times) - 1)]
        begun = np.maximum(np.ceil(t / max(self.times[-1], np.finfo(float).tiny)), 1.0)
        # 1ᵖ + … + (n − 1)ᵖ is at most the integral up to n − ½, as xᵖ is convex
        lags = (begun - 0.5) ** (self.power + 1) / (self.power + 1)
        repeated = begun ** (1 / self.power) * self.period + lags ** (1 / self.power) * self.later
        return np.where(begun > 1.0, np.maximum(repeated, self.values[-1]), first)


@dataclass(frozen=True)
class ErrorGrowth:
    """Growth of errors from each of K nodes of the exact motion to each later one.

    Parameters
    ----------
    times : ndarray, shape (K,)
        Equal steps from 0 to the period of v, or to the end of a shorter motion, s.
    frame : PathFrame
    along : ndarray, shape (K,)
        Component |ω·n|, rad/s.
    rates : ndarray, shape (3, K)
        Change of the body rate for that of n along n, g and h, rad/s.
    shear : ndarray, shape (K,)
        S, s.
    """

    times: Array
    frame: PathFrame
    along: Array
    rates: Array
    shear: Array

    @classmethod
    def of(cls, body: RigidBody, times: Array, states: State, rate_bound: float) -> ErrorGrowth:
        """The growth along states of the exact motion at these times."""
        frame = PathFrame.of(body, states, rate_bound)
        changed = frame.size * apply_tensor(body.inverse_inertia, frame.axes)
        kappa = np.sum(frame.axes[1] * changed[1] - frame.axes[2] * changed[2], axis=-1)
        slope = kappa / frame.speed / frame.speed
        shear = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(times))])
        along = np.abs(np.sum(states.body_rate * frame.axes[0], axis=-1))
        return cls(times, frame, along, so3.norm(changed), shear)

    def attitude(self, local: Array, power: int = 1) -> Errors:
        """Errors of the attitude, rad, that come of errors of the momentum made all along the motion.

        Parameters
        ----------
        local : ndarray, shape (3, K)
            Sizes of c, a and b that are made in a second at each node; of independent ones the root of the sum of
            squares.
        power : int, optional
            1 or 2; see `Errors`.
        """
        return self._errors(self._attitude_gains, local, power)

    def rate(self, local: Array, power: int = 1) -> Errors:
        """Errors of the body rate, rad/s, that come of errors of the momentum; see `attitude`."""
        return self._errors(self._rate_gains, local, power)

    def energy_rates(self, local: Array) -> Array:
        """Errors |ω·δn| of the energy over |π|, rad/s, shape (K,), from c, a and b, shape (3, K)."""
        return np.asarray(self.along * local[0] + self.frame.speed * local[1])

    def largest(self, body: RigidBody, rate_bound: float, duration: float) -> float:
        """Largest factor, at least 1, by which an error of the body rate grows within ``duration``, s.

        An error of the rate over its bound becomes an error of the rate over its bound, or of the attitude, rad.
        """
        if rate_bound == 0.0:
            return 1.0
        momentum = so3.norm(apply_tensor(body.inertia, self.frame.axes)) / self.frame.size
        later = max(math.ceil(duration / self.times[-1]) - 1, 0) if self.times[-1] > 0.0 else 0
        lag, shear = self._lags()
        gains = (
            unit * (of(lag, shear, 1.0) + later * of(*self._period(), 0.0))
            for of, unit in ((self._rate_gains, 1.0), (self._attitude_gains, rate_bound))
        )
        grown = [np.max(np.einsum("kij,kj->ij", each, momentum)) for each in gains]
        return math.inf if np.isnan(grown).any() else 1.0 + float(max(grown))  # NaN where products overflow

    def _errors(self, gains: Callable[[Array, Array, float], Array], local: Array, power: int) -> Errors:
        step = self.times[-1] / (len(self.times) - 1)
        made = step * local**power
        now = np.einsum("kij,kj->ij", gains(*self._lags(), 1.0) ** power, made)
        later = np.einsum("kij,kj->ij", gains(*self._period(), 0.0) ** power, made)
        first, whole, more = (x ** (1.0 / power) for x in (np.tril(now).sum(1), now.sum(1).max(), later.sum(1).max()))
        first[0] = 0.0
        return Errors(self.times, np.maximum.accumulate(first), float(whole), float(more), power)

    def _lags(self) -> tuple[Array, Array]:
        """Distances in time and in shear between nodes, shapes (K, K)."""
        return np.abs(np.subtract.outer(self.times, self.times)), np.abs(np.subtract.outer(self.shear, self.shear))

    def _period(self) -> tuple[Array, Array]:
        """Distances in time and in shear from one period to the next, shapes (1, 1)."""
        return self.times[-1:, np.newaxis], np.abs(self.shear[-1:, np.newaxis])

    def _attitude_gains(self, lag: Array, shear: Array, still: float) -> Array:
        """Gains from c, a and b at node j to the turn at node i, rad, shape (3, K, K).

        The turn about the spatial momentum is ω·δn times the lag; the turn across it is at most the sum of the errors
        of n at both nodes. If ``still`` is 0, parts that do not grow with the lag are left out.
        """
        v, ahead = self.frame.speed, self.frame.speed[:, np.newaxis]
        return np.stack(
            [
                2.0 * still + (self.along + ahead) * lag,
                still * (1.0 + v / ahead) + v * lag + ahead * (v * shear),
                still * (1.0 + ahead / v) + 0.0 * lag,
            ]
        )

    def _rate_gains(self, lag: Array, shear: Array, still: float) -> Array:
        """Gains from c, a and b at node j to the body rate at node i, rad/s, shape (3, K, K), as for the attitude."""
        v, ahead, (by_c, by_a, by_b) = self.frame.speed, self.frame.speed[:, np.newaxis], self.rates[:, :, np.newaxis]
        return np.stack(
            [
                still * by_c + by_b * ahead * lag + 0.0 * v,
                still * by_a * v / ahead + by_b * ahead * (v * shear),
                still * by_b * ahead / v + 0.0 * lag,
            ]
        )
