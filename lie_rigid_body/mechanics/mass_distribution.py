"""Mass, centre and second moment of point masses, and of densities given on a grid or as functions.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Final, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, whole_number
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics.array_input import real_array, require_share, symmetrised
from lie_rigid_body.mechanics.mass_moments import MassMoments

Limits: TypeAlias = "tuple[float, float] | Callable[[Array], tuple[ArrayLike, ArrayLike]]"
"""Lower and upper end of one coordinate: numbers, or a function of the coordinates before it, (N, k) ↦ (N,), (N,)."""

MOST_EVALUATIONS: Final = 2**22
"""Largest number of points at which a density is evaluated."""


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
    x = real_array("points", points, "(N, n)")
    m = real_array("masses", masses, f"({len(x)},)")
    require_share("masses", m, " kg")
    return _weighed(x, m)


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
    rho = real_array("density", density, "(…)")
    ends = np.array([real_array(name, end, f"({rho.ndim},)") for name, end in (("low", low), ("high", high))])
    for a, b in ends.T:
        _require_order(a, b)
    require_share("density", rho, " kg/mⁿ")
    steps = (ends[1] - ends[0]) / rho.shape
    centres = [a + h * (np.arange(count) + 0.5) for a, h, count in zip(ends[0], steps, rho.shape, strict=True)]
    cells = rho * np.prod(steps)
    mass, n = float(cells.sum()), rho.ndim
    lines = [_sum_over_others(cells, k) / mass for k in range(n)]
    centre = np.array([line @ x for line, x in zip(lines, centres, strict=True)])
    offsets = [x - c for x, c in zip(centres, centre, strict=True)]
    # a cell has a second moment of its own, m h²/12
    central = np.diag([mass * (line @ x**2 + h**2 / 12) for line, x, h in zip(lines, offsets, steps, strict=True)])
    for i, j in combinations(range(n), 2):
        central[i, j] = central[j, i] = offsets[i] @ _sum_over_others(cells, i, j) @ offsets[j]
    return MassMoments(mass, centre, central)


def moments_of_density(
    density: Callable[[Array], ArrayLike], limits: Sequence[Limits], nodes: int = 16, tolerance: float = 1e-9
) -> MassMoments:
    """The moments of a density given as a function, eq. (10), by Gauss-Legendre quadrature in a box or a curved region.

    A coordinate on which limits of later ones depend is substituted by x = ½(a + b) + ½(b − a) sin θ. At an end where
    the boundary is smooth the extent of the region goes to 0 like a square root of x, and is smooth in θ. The result is
    compared with that of two nodes fewer, and refused when the two disagree.

    Parameters
    ----------
    density : callable, (N, n) ↦ (N,)
        ρ at N points at once, kg/mⁿ. Smooth inside the limits, and not negative.
    limits : sequence of n pairs or callables
        Ends of each coordinate, m: two numbers, or a function of the coordinates before it. The function takes these at
        N points as an array of shape (N, k), and gives the N lower and the N upper ends.
    nodes : int
        Points along each coordinate, at least 4. There are nodesⁿ points in all, at most `MOST_EVALUATIONS`.
    tolerance : float
        Largest disagreement allowed, relative to √(JᵢᵢJⱼⱼ) for each of the moments J.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the two results disagree, or a density is negative or not finite, or no function. Also if limits are no
        pairs, not finite or out of order, or nodes or tolerance no such number.
    """
    if not callable(density):
        raise ParameterError("density", f"{shown(density)} is no function: give one, or call moments_on_grid")
    limits = [*limits] if np.iterable(limits) else []
    nodes = _affordable(nodes, len(limits))
    allowed = float(real_array("tolerance", tolerance, "()"))
    coarse, fine = (_weighed(*_masses_at_nodes(density, limits, count)) for count in (nodes - 2, nodes))
    error = _disagreement(coarse, fine)
    if not error <= allowed:
        raise ParameterError(
            "density",
            f"quadrature with {nodes - 2} and {nodes} nodes a coordinate differs by {error:.3g}, "
            f"more than the tolerance {allowed:g}: raise nodes, or split the region where the density jumps",
        )
    return fine


def _weighed(points: Array, masses: Array) -> MassMoments:
    mass = float(masses.sum())
    centre = masses @ points / mass
    offsets = points - centre
    return MassMoments(mass, centre, symmetrised((masses[:, None] * offsets).T @ offsets))


def _require_order(low: float, high: float) -> None:
    if not low < high:
        raise ParameterError("limits", f"{low:.9g} m is not below {high:.9g} m: give the lower end first")


def _sum_over_others(cells: Array, *kept: int) -> Array:
    return np.asarray(cells.sum(axis=tuple(k for k in range(cells.ndim) if k not in kept)))


def _affordable(nodes: int, n: int) -> int:
    nodes = whole_number("nodes", nodes, 4)
    if n == 0:
        raise ParameterError("limits", "of no coordinate: give two numbers, or a function, for each")
    if nodes**n > MOST_EVALUATIONS:
        most = int(MOST_EVALUATIONS ** (1.0 / n) + 1e-9)
        raise ParameterError(
            "nodes",
            f"{shown(nodes)} along each of {n} coordinates are {shown(nodes**n)} points, more than {MOST_EVALUATIONS}: "
            f"give at most {most} nodes, or split the region and add the parts",
        )
    return nodes


def _masses_at_nodes(
    density: Callable[[Array], ArrayLike], limits: Sequence[Limits], nodes: int
) -> tuple[Array, Array]:
    points, volumes = _nodes(limits, nodes)
    rho = real_array("density", density(points), f"({len(points)},)")
    require_share("density", rho, " kg/mⁿ")
    return points, rho * volumes


def _nodes(limits: Sequence[Limits], nodes: int) -> tuple[Array, Array]:
    """Quadrature points, shape (N, n), and their weights as volumes, shape (N,), built up coordinate by coordinate."""
    points, volumes = np.zeros((1, 0)), np.ones(1)
    for k, end in enumerate(limits):
        roots, weights = _rule(nodes, curved=any(callable(inner) for inner in limits[k + 1 :]))
        low, high = _ends(end, points)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        coordinate = (middle[:, None] + half[:, None] * roots).reshape(-1, 1)
        volumes = (volumes[:, None] * half[:, None] * weights).reshape(-1)
        points = np.hstack([np.repeat(points, nodes, axis=0), coordinate])
    return points, volumes


def _rule(nodes: int, *, curved: bool) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [−1, 1]; with x = sin θ, θ in [−½π, ½π], for curved limits."""
    roots, weights = np.polynomial.legendre.leggauss(nodes)
    if not curved:
        return roots, weights
    angles = 0.5 * np.pi * roots
    return np.sin(angles), 0.5 * np.pi * weights * np.cos(angles)


def _ends(limits: Limits, points: Array) -> tuple[Array, Array]:
    given = cast("ArrayLike", limits(points) if callable(limits) else limits)
    ends = real_array("limits", given, f"(2, {len(points)})" if callable(limits) else "(2,)")
    low, high = (np.broadcast_to(end, len(points)) for end in ends)
    narrowest = int(np.argmin(high - low))
    _require_order(float(low[narrowest]), float(high[narrowest]))
    return low, high


def _disagreement(one: MassMoments, other: MassMoments) -> float:
    """The largest |Jᵢⱼ − J′ᵢⱼ|/√(JᵢᵢJⱼⱼ) of two sets of moments about one centre, with J of `_pseudo_inertia`."""
    first, second = _pseudo_inertia(one.about(other.centre)), _pseudo_inertia(other.about(other.centre))
    size = np.sqrt(np.diag(second))
    return float((np.abs(first - second) / np.outer(size, size)).max())


def _pseudo_inertia(moments: MassMoments) -> Array:
    """All moments in one matrix, ∫ρ (x, 1)(x, 1)ᵀ."""
    side = moments.first_moment[:, None]
    return np.block([[moments.second_moment, side], [side.T, np.full((1, 1), moments.mass)]])
