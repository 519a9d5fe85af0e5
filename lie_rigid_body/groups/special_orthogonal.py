"""The rotation groups SO(n)."""

from __future__ import annotations

from itertools import combinations
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups import logarithm
from lie_rigid_body.groups.elements import Elements
from lie_rigid_body.groups.matrix_lie_algebra import MatrixLieAlgebra, frobenius
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.sizes import as_size

Array = NDArray[Any]
Real = NDArray[np.float64]

UNIQUE_LIMIT: Final = 1e-12
"""Singular values, relative to the largest, below which a nearest rotation is not singled out."""


def SO(n: int) -> MatrixLieGroup:  # noqa: N802
    """The group of n×n rotation matrices, of dimension n(n−1)/2.

    The generators are ±(E_ji − E_ij) over the planes i < j in the order that makes those of SO(3) the basis of
    `so3.hat` and obey [Tᵃ, Tᵇ] = +εᵃᵇᶜTᶜ: planes in descending order, (n−2, n−1) first and (0, 1) last, with the sign
    (−1)^(i+j+1). The first (n−1)(n−2)/2 of them are thereby those of SO(n−1) on all axes but the first.

    Parameters
    ----------
    n : int
        At least 2.
    """
    n = as_size("SO", n)
    algebra = MatrixLieAlgebra(_generators(n))
    return MatrixLieGroup(f"SO({n})", algebra, algebra.trace_metric(0.5), OrthogonalElements(n))


def _generators(n: int) -> Real:
    planes = list(combinations(range(n), 2))[::-1]
    T = np.zeros((len(planes), n, n))
    for t, (i, j) in zip(T, planes, strict=True):
        t[j, i] = (-1.0) ** (i + j + 1)
        t[i, j] = -t[j, i]
    return T


class OrthogonalElements(Elements):
    """Rotation matrices: AᵀA = 1 and det A = 1.

    Parameters
    ----------
    n : int
    """

    def __init__(self, n: int) -> None:
        self._n = n

    def distance(self, A: Array) -> Real:
        """Frobenius norm of AᵀA − 1, or infinity where the determinant is not positive."""
        off = frobenius(np.swapaxes(A, -1, -2) @ A - np.eye(self._n))
        return np.where(np.linalg.det(A) > 0.0, off, np.inf)

    def project(self, A: Array) -> Array:
        """The nearest rotation, U diag(1, …, 1, det UV) Vᵀ of A = U Σ Vᵀ (Kabsch, Acta Cryst. A 32 (1976) 922)."""
        U, sigma, Vt = np.linalg.svd(A)
        sign = np.sign(np.linalg.det(U @ Vt))
        _refuse_ambiguous(sigma, sign)
        U[..., :, -1] *= sign[..., np.newaxis]
        return np.asarray(U @ Vt)

    def inverse(self, A: Array) -> Array:
        """The transpose."""
        return np.swapaxes(A, -1, -2)

    def log(self, A: Array) -> Array:
        """The principal logarithm, from the real Schur form where the series does not serve."""
        return logarithm.each(A, _schur_log)

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """By Haar measure: orthogonalised normal matrices (F. Mezzadri, Notices AMS 54 (2007) 592)."""
        Q, R = np.linalg.qr(rng.standard_normal((*shape, self._n, self._n)))
        Q = Q * np.sign(np.diagonal(R, axis1=-2, axis2=-1))[..., np.newaxis, :]
        Q[..., :, 0] *= np.linalg.det(Q)[..., np.newaxis].round()
        return np.asarray(Q)


def _refuse_ambiguous(sigma: Real, sign: Real) -> None:
    """An error where the two smallest singular values leave a plane in which any rotation is as near."""
    margin = (sigma[..., -2] + sign * sigma[..., -1]) / np.maximum(sigma[..., 0], np.finfo(np.float64).tiny)
    worst = np.min(margin, initial=np.inf)
    if not worst > UNIQUE_LIMIT:
        raise InputError(
            f"no nearest rotation: the smallest singular values of a matrix leave a margin of {worst:.3g} "
            f"(limit {UNIQUE_LIMIT:g} of the largest), so that several are equally near; give a matrix nearer to one"
        )


def _schur_log(A: Array) -> Array:
    """The principal logarithm of one rotation matrix, shape (n, n): in the Schur basis it is a rotation per plane."""
    T, Z = schur(A, output="real")
    L, k = np.zeros_like(A), 0
    while k < len(A):
        if k + 1 < len(A) and T[k + 1, k] != 0.0:
            angle = np.arctan2(T[k + 1, k] - T[k, k + 1], T[k, k] + T[k + 1, k + 1])
            L[k + 1, k], L[k, k + 1] = angle, -angle
            k += 2
        else:
            angle = 0.0 if T[k, k] > 0.0 else np.pi
            k += 1
        _refuse_half_turn(float(angle))
    return np.asarray(Z @ L @ Z.T)


def _refuse_half_turn(angle: float) -> None:
    margin = logarithm.HALF_TURN_MARGIN
    if np.pi - abs(angle) <= margin:
        raise InputError(
            f"no principal logarithm: a plane turns by {abs(angle):.15g} rad (limit π − {margin:g}), "
            "where either sense is right; give an element closer to the identity"
        )
