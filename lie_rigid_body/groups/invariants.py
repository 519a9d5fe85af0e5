"""Integrals of free motion that are functions of the momentum alone: Casimirs, the Pfaffian, Manakov's integrals.

Casimirs are conserved whatever the body, Manakov's integrals for a rigid body in n dimensions. The energy is
`Lagrangian.value` or `Hamiltonian.value`; momenta that are conserved by symmetry are in `symmetries`. Equation numbers
are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import math
from itertools import accumulate, repeat
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array, require_finite, shaped
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.classical_groups import OrthogonalElements, PhaseElements, SpecialUnitaryElements
from lie_rigid_body.groups.coadjoint import invariant_form
from lie_rigid_body.groups.exponential import Complex, Matrix
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.symmetries import canonical_basis
from lie_rigid_body.mechanics.array_input import ROUND_OFF
from lie_rigid_body.mechanics.second_moment import second_moment_matrix

_CASIMIR_TOLERANCE: Final = 1e-10
"""Change of a quadratic form under the coadjoint action, relative to the structure constants, taken for round-off."""


@within_doubles
def momentum_matrix(group: MatrixLieGroup, momentum: ArrayLike) -> Matrix:
    """The momentum as a matrix P of the algebra, for which Euler's equations are Ṗ = [P, Ω] with Ω = A⁻¹Ȧ.

    P = hat(g⁻¹p) with `invariant_form` g: pᵃTᵃ on SO(n) and SU(n), as before eq. (23), and KΩ + ΩK for a body with
    second moment K. The trace of its square is the invariant of eq. (24).

    Parameters
    ----------
    group : MatrixLieGroup
        With an invariant form, as compact and semisimple groups.
    momentum : array_like, shape (..., d)

    Returns
    -------
    ndarray, shape (..., n, n)
        kg m²/s.

    Raises
    ------
    InputError
        If the group has no regular invariant form.
    """
    p = of_kind(group, MatrixLieGroup).as_components(momentum, "momenta")
    return group.hat(p @ np.linalg.inv(invariant_form(group)))


def quadratic_casimirs(group: MatrixLieGroup) -> Array:
    """The symmetric matrices C for which p·Cp is conserved by every motion on the group, whatever its metric.

    They are the solutions of f[a,b,c] Cᵇᵈ p_c p_d = 0 for all p. Eqs. (23) and (24) have the case C = 1, of totally
    antisymmetric structure constants. On a compact simple group it is the inverse of the invariant form and no other. A
    product has one for each simple factor, and products of the charges of its circles. On groups that are not
    semisimple C may be singular, as on rigid motions of the plane, and there may be none, as on x ↦ ax + b.

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.

    Returns
    -------
    ndarray, shape (k, d, d)
        A basis of them, of Frobenius norm 1; a function of their span, by `canonical_basis`.
    """
    f = of_kind(group, MatrixLieGroup).structure_constants
    symmetric = _symmetric_basis(group.dimension)
    # d/dt p·Cp along ad*_{Tᵃ} p has the coefficients f[a,b,c] Cᵇᵈ of p_c p_d, symmetrised
    change = np.einsum("abc,kbd->kacd", f, symmetric)
    conditions = (change + np.swapaxes(change, -1, -2)).reshape(len(symmetric), -1)
    directions, sizes, _ = np.linalg.svd(conditions, full_matrices=False)
    kept = directions[:, sizes <= _CASIMIR_TOLERANCE * np.abs(f).max()]
    return canonical_basis(kept.T @ symmetric.reshape(len(symmetric), -1)).reshape(-1, *symmetric.shape[1:])


@within_doubles
def casimirs(group: MatrixLieGroup, momentum: ArrayLike) -> Array:
    """The independent Casimirs of SO(n), SU(n), U(1) and their products, those of a product factor by factor.

    Each such group has eq. (24) as one of its Casimirs. All of them are `rotation_casimirs` of SO(n),
    `unitary_casimirs` of SU(n), and of U(1) its charge, the momentum itself.

    Parameters
    ----------
    group : MatrixLieGroup
    momentum : array_like, shape (..., d)
        p in the body frame, kg m²/s.

    Returns
    -------
    ndarray, shape (..., r)
        With r the rank of the group.

    Raises
    ------
    InputError
        If the group, or a factor of it, is given by generators.
    """
    p = of_kind(group, MatrixLieGroup).as_components(momentum, "momenta")
    if group.factors:
        parts = np.split(p, np.cumsum([factor.dimension for factor in group.factors])[:-1], axis=-1)
        return np.concatenate([casimirs(*pair) for pair in zip(group.factors, parts, strict=True)], axis=-1)
    if isinstance(group.elements, PhaseElements):
        return p
    if not isinstance(group.elements, OrthogonalElements | SpecialUnitaryElements):
        raise InputError(
            f"the Casimirs of {group.name} are not known: give SO(n), SU(n), U(1) or a product of these, "
            "or take quadratic_casimirs"
        )
    family = rotation_casimirs if isinstance(group.elements, OrthogonalElements) else unitary_casimirs
    return family(momentum_matrix(group, p))


@within_doubles
def rotation_casimirs(momentum: ArrayLike) -> Array:
    """The independent Casimirs of SO(n): tr(Pᵏ) for every even k < n, and for even n the Pfaffian of P.

    For even n tr(Pⁿ) depends on these, since Pf² = det P; odd powers have trace 0. There are ⌊n/2⌋, the rank of SO(n).
    With P = pᵃTᵃ, tr(P²) = −2 pᵃpᵃ, whose rate is 0 by eqs. (23) and (24). The paper names the traces only.

    Parameters
    ----------
    momentum : array_like, shape (..., n, n)
        P, antisymmetric, kg m²/s; see `momentum_matrix`.

    Returns
    -------
    ndarray, shape (..., n // 2)
        By ascending degree in P; the Pfaffian comes last.

    Raises
    ------
    InputError
        If P is not square, real, finite and antisymmetric.
    """
    p = _nonempty(_antisymmetric_matrices(momentum))
    n = p.shape[-1]
    traces = _power_traces(p)[..., 1 : n - 1 : 2]
    return traces if n % 2 else np.concatenate([traces, pfaffian(p)[..., np.newaxis]], axis=-1)


@within_doubles
def unitary_casimirs(momentum: ArrayLike) -> Array:
    """The independent Casimirs of SU(n): tr((−iP)ᵏ) for 2 ≤ k ≤ n, which is real; for even k it is ± tr(Pᵏ).

    There are n − 1, the rank of SU(n).

    Parameters
    ----------
    momentum : array_like, shape (..., n, n)
        P, anti-Hermitian, kg m²/s; see `momentum_matrix`.

    Returns
    -------
    ndarray, shape (..., n - 1)
        By ascending degree in P.

    Raises
    ------
    InputError
        If P is not square, finite and anti-Hermitian.
    """
    return _power_traces(-1j * _nonempty(_antihermitian_matrices(momentum)))[..., 1:].real


@within_doubles
def pfaffian(matrices: ArrayLike) -> Array:
    """The Pfaffian Pf P, with (Pf P)² = det P, by antisymmetric Gauss elimination with pivoting.

    Each step takes the largest entry of the first remaining column as pivot, clears that column with a congruence of
    determinant 1, and leaves a matrix smaller by two (B. N. Parlett, J. K. Reid, BIT 10 (1970) 386).

    Parameters
    ----------
    matrices : array_like, shape (..., n, n)
        Antisymmetric.

    Returns
    -------
    ndarray, shape (...)
        Of the sign with Pf [[0, a], [−a, 0]] = a; 1 for n = 0, and 0 for odd n.

    Raises
    ------
    InputError
        If the matrices are not square, real, finite and antisymmetric.
    """
    given = _antisymmetric_matrices(matrices)
    values = np.empty(given.shape[:-2])
    for index in np.ndindex(values.shape):
        values[index] = _pfaffian(np.triu(given[index], 1) - np.triu(given[index], 1).T)
    return values


def _pfaffian(P: Array) -> float:
    value = float(len(P) % 2 == 0)
    while len(P) > 1:
        largest = 1 + int(np.argmax(np.abs(P[0, 1:])))
        if P[0, largest] == 0.0:
            return 0.0
        if largest != 1:
            order = np.arange(len(P))
            order[[1, largest]] = order[[largest, 1]]
            P = P[np.ix_(order, order)]
            value = -value
        value *= P[0, 1]
        update = np.outer(P[1, 2:], P[0, 2:] / P[0, 1])
        P = P[2:, 2:] + update - update.T
    return value


@within_doubles
def manakov_integrals(momentum: ArrayLike, second_moment: ArrayLike) -> Array:
    """Manakov's integrals: the coefficients of tr (P + λK²)ᵏ, conserved by the free body with P = KΩ + ΩK.

    Euler's equations Ṗ = [P, Ω] are equivalent to d/dt (P + λK²) = [P + λK², Ω + λK] for every λ (S. V. Manakov,
    Funct. Anal. Appl. 10 (1976) 328); the order in the commutators belongs to Ȧ = AΩ. The coefficient of λᵏ⁻ᵐ has m
    factors P. It vanishes for odd m, since P is antisymmetric and K symmetric, and for m = 0 it is constant anyway.
    The rest, even m with 2 ≤ m ≤ k ≤ n, are ⌊n²/4⌋ integrals, independent if the eigenvalues of K differ. This is the
    rank of SO(n) plus half the dimension of a generic coadjoint orbit: the motion is integrable for every n. The energy
    is a function of them.

    Parameters
    ----------
    momentum : array_like, shape (..., n, n)
        P, antisymmetric, body frame, kg m²/s.
    second_moment : array_like, shape (n, n)
        K = ∫ρ x xᵀ, symmetric, in the same frame, kg m².

    Returns
    -------
    ndarray, shape (..., n² // 4)
        Ordered by k, then by m; in (kg m²)²ᵏ⁻ᵐ/sᵐ.

    Raises
    ------
    InputError
        If K is no second moment, or P not antisymmetric of the same size.
    """
    k = second_moment_matrix(second_moment)
    p = _antisymmetric_matrices(momentum)
    if p.shape[-2:] != k.shape:
        raise ParameterError("P", f"shape {p.shape} does not go with K of shape {k.shape}: give both of the same body")
    square = k @ k
    n = k.shape[0]
    words = [np.broadcast_to(np.eye(n), p.shape)]
    integrals = []
    for power in range(1, n + 1):
        words = _next_power(words, p, square)
        integrals += [np.trace(words[m], axis1=-2, axis2=-1) for m in range(2, power + 1, 2)]
    return np.stack(integrals, axis=-1) if integrals else np.zeros((*p.shape[:-2], 0))


def _symmetric_basis(d: int) -> Array:
    """The symmetric d×d matrices: an orthonormal basis of them, shape (d(d+1)/2, d, d)."""
    rows, columns = np.triu_indices(d)
    basis = np.zeros((len(rows), d, d))
    each = range(len(rows))
    basis[each, rows, columns] = basis[each, columns, rows] = np.where(rows == columns, 1.0, math.sqrt(0.5))
    return basis


def _power_traces(p: Matrix) -> Matrix:
    """The traces of p, p², …, pⁿ on a new last axis."""
    powers = accumulate(repeat(p, p.shape[-1]), np.matmul)
    return np.stack([np.trace(power, axis1=-2, axis2=-1) for power in powers], axis=-1)


def _nonempty(p: Matrix) -> Matrix:
    if p.shape[-1] == 0:
        raise ParameterError("P", f"shape {p.shape} has no rows: give momentum_matrix(group, p)")
    return p


def _next_power(words: list[Array], p: Array, square: Array) -> list[Array]:
    """The matrix coefficients of (P + λK²)ᵏ, listed by the number m of factors P, from those of the power k − 1."""
    longer = [word @ square for word in words] + [np.zeros_like(p)]
    for m, word in enumerate(words):
        longer[m + 1] = longer[m + 1] + word @ p
    return longer


def _antisymmetric_matrices(value: ArrayLike) -> Array:
    """Given matrices, shape (..., n, n), checked to be real and antisymmetric to within round-off."""
    given = real_array("P", value, (..., "n", "n"), empty=True)
    _require_small(given, given + np.swapaxes(given, -1, -2), "P + Pᵀ", "an antisymmetric")
    return given


def _antihermitian_matrices(value: ArrayLike) -> Complex:
    """Given matrices, shape (..., n, n), checked to be anti-Hermitian to within round-off."""
    given = shaped("P", value, (..., "n", "n"), np.complex128)
    require_finite("P", given)
    _require_small(given, given + np.swapaxes(given.conj(), -1, -2), "P + P†", "an anti-Hermitian")
    return given


def _require_small(given: Matrix, sums: Matrix, formula: str, kind: str) -> None:
    off = np.abs(sums).max(axis=(-2, -1), initial=0.0)
    limit = ROUND_OFF * np.abs(given).max(axis=(-2, -1), initial=0.0)
    if np.any(off > limit):
        worst = np.argmax(off - limit)
        raise ParameterError(
            "P",
            f"{formula} reaches {off.flat[worst]:.3g}, the limit is {limit.flat[worst]:.3g}: give {kind} matrix",
        )
