"""The chart of any matrix Lie group, with the momentum of a left-invariant metric carried along."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.stepper import Point
from lie_rigid_body.lie.series import bernoulli_over_factorial

Array = NDArray[np.float64]

_EVEN_TERMS: Final = tuple(bernoulli_over_factorial(2 * k) for k in range(1, 16))
_LEFT_OUT: Final = 1e-18

LARGEST_TURN: Final = math.pi
"""Turn within a step, rad, the largest eigenvalue of ad_β: half the series' radius, where its terms leave 1e-10."""


class GroupChart:
    """A₀ exp(βᵃTᵃ) with the momentum p = Mω. A centre is a matrix.

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
        """The chart rate, dexp⁻¹ of −β applied to ω, and ṗ = ad*_ω p (Euler–Poincaré), with ω = M⁻¹p."""
        d = self.dimension
        both = np.array(point)
        coordinates, momentum = both[:d], both[d:]
        rate = self._inverse @ momentum
        force = momentum @ self._ad(rate)
        return [*self._chart_rate(coordinates, rate).tolist(), *force.tolist()]

    def recentred(self, centre: NDArray[Any], coordinates: Point) -> NDArray[Any]:
        """The matrix A₀ exp(βᵃTᵃ); refused where the chart ends, which a stepper with one stage does not look at."""
        self._bound(self._ad(np.array(coordinates)))
        return np.asarray(centre @ self._group.exp(np.array(coordinates)))

    def restored(self, centre: NDArray[Any]) -> NDArray[Any]:
        """The matrix rid of what round-off has carried off the group."""
        return self._group.restored(centre)

    def _ad(self, x: Array) -> Array:
        """The matrix of y ↦ [x, y] in coordinates."""
        d = self.dimension
        return np.asarray((x @ self._bracket).reshape(d, d))

    def _bound(self, ad: Array) -> float:
        """A bound of the norm of ad_β, which is refused where the chart ends."""
        bound = float(np.abs(ad).max()) * self.dimension
        if not bound < 2.0 * math.pi:
            _require_convergence(ad)
        return bound

    def _chart_rate(self, coordinates: Array, rate: Array) -> Array:
        """Σ Bₖ/k! (−ad_β)ᵏ ω, up to terms below round-off; β is a step's, far inside the radius 2π."""
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
    """Refuse a turn that the series does not reach; of motions without one, as translations, ad has no eigenvalues."""
    turn = float(np.abs(np.linalg.eigvals(ad)).max())
    if not turn <= LARGEST_TURN:
        raise InputError(
            f"a step turns by {turn:.3g} rad (limit {LARGEST_TURN:.3g} rad): lower max_step by a factor of "
            f"{10.0 * turn / LARGEST_TURN:.1g} or more"
        )


def _terms(bound: float) -> int:
    """How many even terms matter, as |B₂ₖ|/(2k)! < 4/(2π)²ᵏ; ``bound`` is one of the norm of ad_β."""
    ratio = bound / (2.0 * math.pi)
    if not 0.0 < ratio < 1.0:
        return 1 if ratio == 0.0 else len(_EVEN_TERMS)
    return max(1, math.ceil(0.5 * math.log(_LEFT_OUT) / math.log(ratio)))
