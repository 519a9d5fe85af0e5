"""The chart A₀ exp(βᵃTᵃ) of a matrix Lie group: its metric, and its reach.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.elements import multiple_until
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.mechanics.array_input import symmetrised

_REAL_PART: Final = 1e-9
"""Real part of an eigenvalue, relative to the norm of the matrix, up to which it counts as imaginary."""


_SPLIT: Final = 1e-4
"""Distance of eigenvalues, relative to the largest, up to which their mean counts as well as each of them.

Along a screw ad cannot be made diagonal. Rounding then splits a multiple eigenvalue by its square or cube root, 1e-8 or
1e-5, and leaves the mean as it is."""


class ChartReach(NamedTuple):
    """Reach of a chart along a direction ξ, as the multiples t of ξ at which it ends.

    Attributes
    ----------
    one_to_one : ndarray, shape (...)
        Multiple below which `MatrixLieGroup.log` takes exp(tξ) back to tξ. There the coordinates of a point cease to be
        unique, on SO(3) for a half turn.
    regular : ndarray, shape (...)
        Multiple at which dexp(tξ) first loses rank, as an eigenvalue of ad(tξ) is ±2πi; on SO(3) for a full turn.
        Velocities have no coordinates there, and geodesics of a bi-invariant metric have their first conjugate point.
    """

    one_to_one: Array
    regular: Array


# the multiples of a direction of nearly 0 are infinite, and what leaves double precision is refused
@np.errstate(over="ignore", invalid="ignore")
def chart_reach(group: MatrixLieGroup, direction: ArrayLike) -> ChartReach:
    """The reach of the chart A₀ exp(βᵃTᵃ), eq. (38), along a direction: where its coordinates end.

    Both are infinite where nothing turns, as along translations. Steps of `GroupMovingChart` end at half of `regular`.

    Parameters
    ----------
    group : MatrixLieGroup
    direction : array_like, shape (..., d)
        ξ, not 0.

    Returns
    -------
    ChartReach
    """
    X = of_kind(group, MatrixLieGroup).hat(direction)
    ad = group.ad(direction)
    eigenvalues = np.linalg.eigvals(ad)
    apart = np.abs(eigenvalues[..., :, np.newaxis] - eigenvalues[..., np.newaxis, :])
    near = apart <= _SPLIT * np.abs(eigenvalues).max(axis=-1, initial=0.0)[..., np.newaxis, np.newaxis]
    means = (near @ eigenvalues[..., np.newaxis])[..., 0] / near.sum(axis=-1)
    both = np.stack([eigenvalues, means])
    round_off = _REAL_PART * np.linalg.norm(ad, axis=(-2, -1))[..., np.newaxis]
    turn = np.where(np.abs(both.real) <= round_off, np.abs(both.imag), 0.0).max(axis=(0, -1))
    return ChartReach(group.elements.one_to_one(X), multiple_until(2.0 * np.pi, turn, ad))


@within_doubles
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
    to_rate = of_kind(lagrangian, Lagrangian).group.dexp(-lagrangian.group.as_components(coordinates, "coordinates"))
    return symmetrised(np.swapaxes(to_rate, -1, -2) @ lagrangian.metric @ to_rate)
