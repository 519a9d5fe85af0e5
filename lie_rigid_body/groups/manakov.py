"""Manakov's integrals: why the free rigid body in n dimensions is integrable."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.antihermitian import antisymmetric_matrices
from lie_rigid_body.mechanics.second_moment import second_moment_matrix

Array = NDArray[np.float64]


def manakov_integrals(momentum: ArrayLike, second_moment: ArrayLike) -> Array:
    """The coefficients of tr (P + λK²)ᵏ, all of them conserved by the free body with P = KΩ + ΩK.

    Euler's equations Ṗ = [P, Ω] are d/dt (P + λK²) = [P + λK², Ω + λK] for every λ (S. V. Manakov, Funct. Anal. Appl.
    10 (1976) 328), where the order in the commutators is the one that goes with Ȧ = AΩ. The coefficient of λᵏ⁻ᵐ holds P
    in m places and vanishes for odd m, since P is antisymmetric and K symmetric; that of m = 0 holds no P. What is
    left, 2 ≤ m ≤ k ≤ n, are ⌊n²/4⌋ integrals, independent if the eigenvalues of K differ: as many as the rank of SO(n)
    and half the dimension of a generic coadjoint orbit together. The energy is a function of them.

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
    k, p = second_moment_matrix(second_moment), antisymmetric_matrices("P", momentum)
    if p.shape[-2:] != k.shape:
        raise InputError(
            f"Manakov's integrals need P of shape (..., n, n) and K of shape (n, n), given {p.shape} and {k.shape}: "
            "give both in the n dimensions of the body"
        )
    square, n = k @ k, k.shape[0]
    words = [np.broadcast_to(np.eye(n), p.shape)]
    integrals = []
    for power in range(1, n + 1):
        words = _next_power(words, p, square)
        integrals += [np.trace(words[m], axis1=-2, axis2=-1) for m in range(2, power + 1, 2)]
    return np.stack(integrals, axis=-1) if integrals else np.zeros((*p.shape[:-2], 0))


def _next_power(words: list[Array], p: Array, square: Array) -> list[Array]:
    """The matrix coefficients of (P + λK²)ᵏ by their number m of factors P, from those of the power before."""
    longer = [word @ square for word in words] + [np.zeros_like(p)]
    for m, word in enumerate(words):
        longer[m + 1] = longer[m + 1] + word @ p
    return longer
