"""The metric M of the kinetic energy ½ Mᵃᵇωᵃωᵇ on a group: of a rigid body in n dimensions, or as given.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.mechanics.array_input import ROUND_OFF, real_array
from lie_rigid_body.mechanics.second_moment import rotated_second_moment, second_moment_matrix

_GENERATOR_ROUND_OFF: Final = 1e-12


def mass_matrix(second_moment: ArrayLike, generators: ArrayLike, attitude: ArrayLike | None = None) -> Array:
    """The metric of a rigid body on its rotation group, Mᵃᵇ = −½ tr[A₀ K A₀ᵀ {Tᵃ, Tᵇ}]: eq. (13).

    The kinetic energy ½ ∫ρ |ẋ|² = ½ tr[K ȦᵀȦ] of ẋ = ωᵃTᵃ x, eqs. (7) and (9), is then ½ Mᵃᵇωᵃωᵇ, eqs. (12) and (14).
    For n = 3 in the basis Tᵃ = hat(eₐ), with the anticommutators (27), it is the inertia tensor, eq. (28). For diagonal
    K on SO(n), in the basis of the coordinate planes (i, j), it is diagonal with the entries Kᵢᵢ + Kⱼⱼ.

    Parameters
    ----------
    second_moment : array_like, shape (n, n)
        K in the body frame, kg m².
    generators : array_like, shape (d, n, n)
        Tᵃ, real and antisymmetric: of SO(n), or of a subgroup.
    attitude : array_like, shape (..., n, n), optional
        A₀, body to world. With it M belongs to the world rate, ẋ = ωᵃTᵃ A₀ y for the point y of the body. Without it
        A₀ = 1, and M belongs to the body rate, ẋ = A ωᵃTᵃ y.

    Returns
    -------
    ndarray, shape (..., d, d)
        Symmetric, positive semidefinite, kg m². Definite on SO(n) when rank K ≥ n−1.

    Raises
    ------
    InputError
        If K is not positive semidefinite, a generator not antisymmetric, A₀ not orthogonal, or sizes differ.
    """
    K = second_moment_matrix(second_moment)
    T = _antisymmetric_generators(generators, len(K))
    if attitude is not None:
        K = rotated_second_moment(K, attitude)
    # M is the symmetric part of −tr(TᵃKTᵇ) = Σᵢⱼ (TᵃK)ᵢⱼ Tᵇᵢⱼ, since Tᵇ is antisymmetric
    flat = T.reshape(len(T), -1)
    products = (T @ K[..., None, :, :]).reshape(*K.shape[:-2], *flat.shape) @ flat.T
    return np.asarray(0.5 * (products + products.swapaxes(-1, -2)))


def metric_derivative(group: MatrixLieGroup, metric: ArrayLike) -> Array:
    """The derivative of the metric in the space frame along the group, eq. (32) with the opposite sign.

    With `metric_at` it is ∂Mᵇᶜ/∂αᵃ = −f[a,b,d] Mᵈᶜ − f[a,c,d] Mᵇᵈ at the centre of the chart exp(αᵃTᵃ)A₀, where M is
    that at A₀. The printed right-hand side lacks both minus signs, with which it contradicts eq. (18). It vanishes
    exactly where M is bi-invariant.

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    metric : array_like, shape (d, d)
        M at A₀, kg m².

    Returns
    -------
    ndarray, shape (d, d, d)
        Entry [a, b, c] is ∂Mᵇᶜ/∂αᵃ, kg m².

    Raises
    ------
    InputError
        If M is not symmetric positive definite of size d.
    """
    change = group.structure_constants @ require_metric(metric, group.dimension)
    return -change - np.swapaxes(change, 1, 2)


def require_metric(metric: ArrayLike, dimension: int) -> Array:
    """A given metric, checked to be symmetric and positive definite.

    Parameters
    ----------
    metric : array_like, shape (d, d)
        M, positive definite, and symmetric to within 64 units in the last place of its largest entry.
    dimension : int
        d of the group.

    Returns
    -------
    ndarray, shape (d, d)
        A copy, made exactly symmetric by averaging.

    Raises
    ------
    InputError
        If M is of the wrong size, not finite, not symmetric or not positive definite.
    """
    m = _square_matrix(metric, dimension)
    i, j = np.unravel_index(np.argmax(np.abs(m - m.T)), m.shape)
    if abs(m[i, j] - m[j, i]) > ROUND_OFF * float(np.abs(m).max()):
        raise InputError(
            f"M is not symmetric: M[{i},{j}] = {m[i, j]:.17g} but M[{j},{i}] = {m[j, i]:.17g}: give (M + Mᵀ)/2"
        )
    m = symmetrised(m)
    eigenvalues = np.linalg.eigvalsh(m)
    if not eigenvalues[0] > ROUND_OFF * eigenvalues[-1]:
        raise InputError(
            f"M is not positive definite: its smallest eigenvalue is {eigenvalues[0]:.6g} where the largest is "
            f"{eigenvalues[-1]:.6g} (limit: {ROUND_OFF:.2g} of that): give inertia about every axis, or rescale"
        )
    return m


def symmetrised(m: Array) -> Array:
    """The symmetric part (m + mᵀ)/2 of matrices, shape (..., d, d)."""
    return np.asarray(0.5 * (m + np.swapaxes(m, -1, -2)))


def _square_matrix(metric: ArrayLike, d: int) -> Array:
    try:
        given = np.asarray(metric)
        m = np.array(given, dtype=np.float64) if not np.iscomplexobj(given) else None
    except (TypeError, ValueError):
        m = None
    if m is None:
        raise InputError(f"M is not an array of real numbers: give {d} rows of {d} numbers")
    if m.shape != (d, d):
        raise InputError(f"M has shape {m.shape}, the group needs ({d}, {d}): give one row for each generator")
    if not np.isfinite(m).all():
        raise InputError(f"M is not finite, it has {m[~np.isfinite(m)][0]} in it: give finite numbers in kg m²")
    return m


def _antisymmetric_generators(generators: ArrayLike, n: int) -> Array:
    T = real_array("generators", generators, "(d, n, n)")
    if T.shape[1:] != (n, n):
        raise InputError(f"generators: shape {T.shape} does not go with a {n}×{n} second moment: give (d, {n}, {n})")
    gap = np.abs(T + T.swapaxes(-1, -2)).max(axis=(-1, -2))
    worst = int(np.argmax(gap))
    if gap[worst] > _GENERATOR_ROUND_OFF * np.abs(T).max():
        raise InputError(
            f"generators: number {worst} plus its transpose has an entry of {gap[worst]:.9g} instead of 0: rotations "
            "of a body have antisymmetric generators, as those of SO(n)"
        )
    return T
