"""Mass, centre and second moment of point masses, and of densities given on a grid or as functions.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array, whole_number
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics.array_input import require_share, symmetrised
from lie_rigid_body.mechanics.mass_moments import MassMoments

MAX_EVALUATIONS: Final = 2**22
"""Largest number of points at which a density is evaluated."""

QUADRATURE_TOLERANCE: Final = 1e-9
"""Largest difference of second moments by two numbers of nodes, relative to the trace."""


def moments_of_points(points: ArrayLike, masses: ArrayLike) -> MassMoments:
    """The moments of point masses, K = Σ mᵢ xᵢ xᵢᵀ: eq. (10) as a sum.

    Parameters
    ----------
    points : array_like, shape (N, n)
        xᵢ, m.
    masses : array_like, shape (N,)
        mᵢ, kg. Not negative, and not all 0.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If shapes do not match, numbers are not finite, or a mass is negative.
    """
    x = real_array("points", points, ("N", "n"))
    m = real_array("masses", masses, (len(x),))
    require_share("masses", m, " kg")
    mass = m.sum()
    centre = m @ x / mass
    offsets = x - centre
    return MassMoments(mass, centre, symmetrised((m[:, None] * offsets).T @ offsets))


def moments_on_grid(density: ArrayLike, low: ArrayLike, high: ArrayLike) -> MassMoments:
    """The moments of a density given on a regular grid, each cell of it a homogeneous box: eq. (10).

    Parameters
    ----------
    density : array_like, shape (N₁, …, Nₙ)
        ρ of each cell, kg/mⁿ; axis k runs along coordinate k. Not negative, and not all 0.
    low, high : array_like, shape (n,)
        Opposite corners of the whole grid (outer faces of its cells, not centres), m.

    Returns
    -------
    MassMoments
        Exact for cells of constant density, whatever their number.

    Raises
    ------
    ParameterError
        If shapes do not match, a density is negative or not finite, or ``high`` is not above ``low``.
    """
    rho = real_array("density", density, (...,))
    first, last = (real_array(name, end, (rho.ndim,)) for name, end in (("low", low), ("high", high)))
    _require_order(first, last)
    require_share("density", rho, " kg/mⁿ")
    steps = (last - first) / rho.shape
    centres = first + steps * (np.indices(rho.shape).reshape(rho.ndim, -1).T + 0.5)
    middles = moments_of_points(centres, rho.ravel() * np.prod(steps))
    # a cell has a second moment of its own, m h²/12
    return MassMoments(
        middles.mass, middles.centre, middles.central_second_moment + middles.mass * np.diag(steps**2 / 12)
    )


def moments_of_density(
    density: Callable[[Array], ArrayLike], limits: Sequence[tuple[float, float]], nodes: int = 16
) -> MassMoments:
    """The moments of a smooth density in a box, eq. (10), by Gauss–Legendre quadrature.

    Parameters
    ----------
    density : callable, (N, n) ↦ (N,)
        ρ at N points at once, kg/mⁿ. Smooth inside the limits, and not negative.
    limits : sequence of n pairs
        Ends of each coordinate, m.
    nodes : int
        Points along each coordinate, at least 3. There are nodesⁿ points in all, at most `MAX_EVALUATIONS`.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the results of ``nodes`` and of one less disagree, or there are too many nodes. Also if a density is
        negative, not finite or no function, or limits are no pairs, not finite or out of order.
    """
    if not callable(density):
        raise ParameterError("density", f"{shown(density)} is no function: give one, or call moments_on_grid")
    low, high = real_array("limits", limits, ("n", 2)).T
    _require_order(low, high)
    nodes = whole_number("nodes", nodes, 3, int(MAX_EVALUATIONS ** (1.0 / len(low)) + 1e-9))
    fine, coarse = (_quadrature(density, low, high, count) for count in (nodes, nodes - 1))
    error = np.abs(fine.second_moment - coarse.second_moment).max() / np.trace(fine.second_moment)
    if not error <= QUADRATURE_TOLERANCE:
        raise ParameterError(
            "density",
            f"quadrature with {nodes - 1} and {nodes} nodes a coordinate differs by {error:.3g}, more than "
            f"{QUADRATURE_TOLERANCE:g}: raise nodes, or split the region where the density jumps",
        )
    return fine


def _quadrature(density: Callable[[Array], ArrayLike], low: Array, high: Array, nodes: int) -> MassMoments:
    n = len(low)
    roots, weights = np.polynomial.legendre.leggauss(nodes)
    chosen = np.indices([nodes] * n).reshape(n, -1).T
    points = 0.5 * (low + high) + 0.5 * (high - low) * roots[chosen]
    rho = real_array("density", density(points), (len(points),))
    require_share("density", rho, " kg/mⁿ")
    return moments_of_points(points, rho * np.prod(0.5 * (high - low) * weights[chosen], axis=1))


def _require_order(low: Array, high: Array) -> None:
    worst = np.argmin(high - low)
    if not low[worst] < high[worst]:
        raise ParameterError("limits", f"{low[worst]:.9g} m is not below {high[worst]:.9g} m: give the lower end first")
