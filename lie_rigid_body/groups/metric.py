"""The metric M of the kinetic energy ½ Mᵃᵇωᵃωᵇ on a group: of a rigid body in n dimensions, or as given.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.mechanics.array_input import ROUND_OFF, symmetric_matrix, symmetrised
from lie_rigid_body.mechanics.second_moment import rotated_second_moment, second_moment_matrix

_GENERATOR_ROUND_OFF: Final = 1e-12


@within_doubles
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
    return symmetrised((T @ K[..., None, :, :]).reshape(*K.shape[:-2], *flat.shape) @ flat.T)


@within_doubles
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
    change = of_kind(group, MatrixLieGroup).structure_constants @ require_metric(metric, group.dimension)
    return -change - np.swapaxes(change, 1, 2)


@np.errstate(over="ignore")
def require_metric(metric: ArrayLike, dimension: int, name: str = "metric") -> Array:
    """A given metric, checked to be symmetric and positive definite.

    Parameters
    ----------
    metric : array_like, shape (d, d)
        M, positive definite, and symmetric to within 64 units in the last place of its largest entry.
    dimension : int
        d of the group.
    name : str, optional
        Name of the argument.

    Returns
    -------
    ndarray, shape (d, d)
        A copy, made exactly symmetric by averaging.

    Raises
    ------
    InputError
        If M is of the wrong size, not finite, not symmetric or not positive definite.
    """
    m = symmetric_matrix(name, real_array(name, metric, (dimension, dimension)))
    own = eigenvalues(m)
    least = own[0]
    largest = own[-1]
    if not least > ROUND_OFF * largest:
        raise ParameterError(
            name,
            f"smallest eigenvalue {least:.6g} is not positive beside the largest, {largest:.6g} "
            f"(limit: {ROUND_OFF:.2g} of that): give inertia about every axis, or rescale",
        )
    return m


@within_doubles
def eigenvalues(symmetric: Array) -> Array:
    """Eigenvalues of a symmetric matrix, ascending; refused where they leave double precision."""
    return np.linalg.eigvalsh(symmetric)


def _antisymmetric_generators(generators: ArrayLike, n: int) -> Array:
    T = real_array("generators", generators, ("d", n, n))
    gap = np.abs(T + T.swapaxes(-1, -2)).max(axis=(-1, -2))
    worst = np.argmax(gap)
    if gap[worst] > _GENERATOR_ROUND_OFF * np.abs(T).max():
        raise ParameterError(
            "generators",
            f"number {worst} plus its transpose has an entry of {gap[worst]:.9g} instead of 0: rotations "
            "of a body have antisymmetric generators, as those of SO(n)",
        )
    return T
