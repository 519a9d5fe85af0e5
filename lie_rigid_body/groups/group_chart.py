"""The chart A₀ exp(βᵃTᵃ) of a matrix Lie group: its metric, its reach, and the equations of motion in its coordinates.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.elements import multiple_until
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import symmetrised
from lie_rigid_body.groups.runge_kutta import Point
from lie_rigid_body.lie.series import bernoulli_over_factorial

_EVEN_TERMS: Final = tuple(bernoulli_over_factorial(2 * k) for k in range(1, 16))
_LEFT_OUT: Final = 1e-18
"""Relative size of the terms of the series that are left out."""

LARGEST_TURN: Final = math.pi
"""Largest turn of a step, rad, as eigenvalue of ad_β: half the radius of the series, whose remainder is 1e-10 there."""


_REAL_PART: Final = 1e-9
"""Real part of an eigenvalue, relative to the norm of the matrix, up to which it counts as imaginary."""


class ChartReach(NamedTuple):
    """How far a chart reaches along a direction ξ, as multiples t of it.

    Attributes
    ----------
    one_to_one : ndarray, shape (...)
        Below it `MatrixLieGroup.log` takes exp(tξ) back to tξ. At it the coordinates of a point cease to be unique, on
        SO(3) for a half turn.
    regular : ndarray, shape (...)
        At it dexp(tξ) first loses rank, as an eigenvalue of ad(tξ) is ±2πi, on SO(3) for a full turn: velocities
        have no coordinates there, and geodesics of a bi-invariant metric have their first conjugate point.
    """

    one_to_one: Array
    regular: Array


def chart_reach(group: MatrixLieGroup, direction: ArrayLike) -> ChartReach:
    """How far the chart A₀ exp(βᵃTᵃ), eq. (38), reaches along a direction: where its coordinates end.

    Both are infinite where nothing turns, as along translations. `GroupChart` stops its steps at half of `regular`.

    Parameters
    ----------
    group : MatrixLieGroup
    direction : array_like, shape (..., d)
        ξ, not 0.

    Returns
    -------
    ChartReach
    """
    X, ad = group.hat(direction), group.ad(direction)
    eigenvalues = np.linalg.eigvals(ad)
    imaginary = np.abs(eigenvalues.real) <= _REAL_PART * np.linalg.norm(ad, axis=(-2, -1))[..., np.newaxis]
    turn = np.where(imaginary, np.abs(eigenvalues.imag), 0.0).max(axis=-1)
    return ChartReach(group.elements.one_to_one(X), multiple_until(2.0 * np.pi, turn, ad))


def chart_metric(lagrangian: Lagrangian, coordinates: ArrayLike) -> Array:
    """The metric in the chart A₀ exp(βᵃTᵃ), dexp(−β)ᵀ M dexp(−β): L = ½ Gᵃᵇ(β) β̇ᵃβ̇ᵇ, eq. (14) away from the centre.

    Lagrange's equations (37) of this L hold along every motion, wherever the centre A₀ lies.

    Parameters
    ----------
    lagrangian : Lagrangian
        The group, of dimension d, and M.
    coordinates : array_like, shape (..., d)
        β.

    Returns
    -------
    ndarray, shape (..., d, d)
        Exactly symmetric, kg m². Singular where the chart ends; see `chart_reach`.
    """
    to_rate = lagrangian.group.dexp(-lagrangian.group.as_components(coordinates, "coordinates"))
    return symmetrised(np.swapaxes(to_rate, -1, -2) @ lagrangian.metric @ to_rate)


class GroupChart:
    """The chart A₀ exp(βᵃTᵃ) about an element A₀, with the body momentum p = Mω of the motion.

    A point is the list of the coordinates β, followed by the momentum p. In the coordinates of the space frame the
    chart is exp(αᵃTᵃ) A₀ with α = Ad(A₀)β, as in eq. (11).

    Parameters
    ----------
    lagrangian : Lagrangian
        The group and its metric M.
    """

    def __init__(self, lagrangian: Lagrangian) -> None:
        self._group = lagrangian.group
        self._inverse = lagrangian.inverse_metric
        self.dimension: int = lagrangian.group.dimension
        d = self.dimension
        # [x, y]ᶜ = f[a,b,c] xᵃ yᵇ as (x @ bracket).reshape(d, d) applied to y
        self._bracket = np.ascontiguousarray(np.swapaxes(self._group.structure_constants, 1, 2)).reshape(d, d * d)

    def field(self, point: Point) -> Point:
        """The rates of a point: β̇ = dexp⁻¹(−β) ω and ṗ = ad*_ω p (Euler–Poincaré), with ω = M⁻¹p."""
        d = self.dimension
        both = np.array(point)
        coordinates, momentum = both[:d], both[d:]
        rate = self._inverse @ momentum
        force = momentum @ self._ad(rate)
        return [*self._chart_rate(coordinates, rate).tolist(), *force.tolist()]

    def recentred(self, centre: NDArray[Any], coordinates: Point) -> NDArray[Any]:
        """The element A₀ exp(βᵃTᵃ), the centre of the next chart.

        It is refused beyond the chart's end here as well, since the only stage of `rkmk1` is evaluated at β = 0.
        """
        self._bound(self._ad(np.array(coordinates)))
        return np.asarray(centre @ self._group.exp(np.array(coordinates)))

    def _ad(self, x: Array) -> Array:
        """The matrix of y ↦ [x, y] in coordinates."""
        d = self.dimension
        return np.asarray((x @ self._bracket).reshape(d, d))

    def _bound(self, ad: Array) -> float:
        """An upper bound of the norm of ad_β; refused where β is beyond `LARGEST_TURN`."""
        bound = float(np.abs(ad).max()) * self.dimension
        if not bound < 2.0 * math.pi:
            _require_convergence(ad)
        return bound

    def _chart_rate(self, coordinates: Array, rate: Array) -> Array:
        """β̇ = Σ Bₖ/k! (−ad_β)ᵏ ω, without terms below round-off."""
        ad = self._ad(coordinates)
        bound = self._bound(ad)
        power = ad @ rate
        total = rate + 0.5 * power
        power = ad @ power
        square = ad @ ad
        for coefficient in _EVEN_TERMS[: _terms(bound)]:
            total = total + coefficient * power
            power = square @ power
        return np.asarray(total)


def _require_convergence(ad: Array) -> None:
    """Refuse eigenvalues of ad_β beyond `LARGEST_TURN`; where nothing turns, as in translations, they are all 0."""
    turn = float(np.abs(np.linalg.eigvals(ad)).max())
    if not turn <= LARGEST_TURN:
        raise InputError(
            f"a step turns by {turn:.3g} rad (limit {LARGEST_TURN:.3g} rad): lower max_step by a factor of "
            f"{10.0 * turn / LARGEST_TURN:.1g} or more"
        )


def _terms(bound: float) -> int:
    """Number of even terms above round-off, from |B₂ₖ|/(2k)! < 4/(2π)²ᵏ and a bound of the norm of ad_β."""
    ratio = bound / (2.0 * math.pi)
    if not 0.0 < ratio < 1.0:
        return 1 if ratio == 0.0 else len(_EVEN_TERMS)
    return max(1, math.ceil(0.5 * math.log(_LEFT_OUT) / math.log(ratio)))
