"""The special unitary groups SU(n)."""

from __future__ import annotations

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

TIE_MARGIN: Final = 1e-13
"""Logarithms whose angles, rad, are this close to a tie have lost their choice to rounding."""

UNIQUE_LIMIT: Final = 1e-12
"""Singular values, relative to the largest, and angles, rad, below which a nearest element is not singled out."""

_BISECTIONS: Final = 60


def SU(n: int) -> MatrixLieGroup:  # noqa: N802
    """The group of unitary n×n matrices of determinant 1, of dimension n² − 1.

    The generators are Tᵃ = −iλᵃ/2 with the generalised Gell-Mann matrices λᵃ in their usual order: for each column j
    the symmetric and the antisymmetric matrix of each row i < j, then the diagonal one. Those of SU(2) are −iσᵃ/2 and
    obey [Tᵃ, Tᵇ] = +εᵃᵇᶜTᶜ, as those of SO(3).

    Parameters
    ----------
    n : int
        At least 2.
    """
    n = as_size("SU", n)
    algebra = MatrixLieAlgebra(_generators(n))
    return MatrixLieGroup(f"SU({n})", algebra, algebra.trace_metric(2.0), SpecialUnitaryElements(n))


def _generators(n: int) -> Array:
    T = np.zeros((n * n - 1, n, n), dtype=np.complex128)
    rows = iter(T)
    for j in range(1, n):
        for i in range(j):
            symmetric, antisymmetric = next(rows), next(rows)
            symmetric[i, j] = symmetric[j, i] = -0.5j
            antisymmetric[i, j], antisymmetric[j, i] = -0.5, 0.5
        next(rows)[range(j + 1), range(j + 1)] = -0.5j * np.sqrt(2.0 / (j * (j + 1))) * np.array([1.0] * j + [-j])
    return T


class SpecialUnitaryElements(Elements):
    """Unitary matrices of determinant 1.

    Parameters
    ----------
    n : int
    """

    def __init__(self, n: int) -> None:
        self._n = n

    def distance(self, A: Array) -> Real:
        """The larger of the Frobenius norm of A†A − 1 and |det A − 1|."""
        off = frobenius(self.inverse(A) @ A - np.eye(self._n))
        return np.asarray(np.maximum(off, np.abs(np.linalg.det(A) - 1.0)))

    def project(self, A: Array) -> Array:
        """The nearest element: A = U Σ V† becomes U diag(e^{iθ}) V†, with the angles that cost least.

        The distance asks for the largest Σ σₖ cos θₖ under Σ θₖ = −arg det UV†, hence for σₖ sin θₖ equal for all k.
        """
        U, sigma, Vh = np.linalg.svd(A)
        theta = _cheapest_angles(sigma, -np.angle(np.linalg.det(U @ Vh)))
        return np.asarray((U * np.exp(1j * theta)[..., np.newaxis, :]) @ Vh)

    def inverse(self, A: Array) -> Array:
        """The conjugate transpose."""
        return np.swapaxes(A.conj(), -1, -2)

    def log(self, A: Array) -> Array:
        """The logarithm of least norm in the algebra, from the Schur form where the series does not serve."""
        return logarithm.each(A, _schur_log)

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """By Haar measure: orthogonalised normal matrices (F. Mezzadri, Notices AMS 54 (2007) 592), det divided out."""
        size = (*shape, self._n, self._n)
        Q, R = np.linalg.qr(rng.standard_normal(size) + 1j * rng.standard_normal(size))
        phases = np.diagonal(R, axis1=-2, axis2=-1)
        Q = Q * (phases / np.abs(phases))[..., np.newaxis, :]
        Q[..., :, 0] /= np.linalg.det(Q)[..., np.newaxis]
        return np.asarray(Q)


def _cheapest_angles(sigma: Real, total: Real) -> Real:
    """Angles θ with the given sum and σₖ sin θₖ equal for all k, shape (..., n); see `SpecialUnitaryElements.project`.

    The angle of the smallest σ parametrises the others and is bisected: the sum is 0 at 0 and π at π.
    """
    _refuse_ambiguous(sigma, total)
    ratio = sigma[..., -1:] / sigma[..., :-1]
    first = 0.5 * np.pi + np.arcsin(ratio).sum(axis=-1) >= np.abs(total)
    low, high = np.where(first, 0.0, 0.5 * np.pi), np.where(first, 0.5 * np.pi, np.pi)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        below = middle + np.arcsin(ratio * np.sin(middle)[..., np.newaxis]).sum(axis=-1) < np.abs(total)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    others = np.arcsin(ratio * np.sin(low)[..., np.newaxis])
    last = np.abs(total) - others.sum(axis=-1)
    return np.asarray(np.sign(total)[..., np.newaxis] * np.concatenate([others, last[..., np.newaxis]], axis=-1))


def _refuse_ambiguous(sigma: Real, total: Real) -> None:
    margin = sigma[..., -2] / np.maximum(sigma[..., 0], np.finfo(np.float64).tiny)
    worst = np.min(np.minimum(margin, np.pi - np.abs(total)), initial=np.inf)
    if not worst > UNIQUE_LIMIT:
        raise InputError(
            f"no nearest element of SU(n): the singular values or the phase of a matrix leave a margin of {worst:.3g} "
            f"(limit {UNIQUE_LIMIT:g}), so that several are equally near; give a matrix nearer to one"
        )


def _schur_log(A: Array) -> Array:
    """The logarithm of least norm of one element, shape (n, n), in the basis of its Schur form."""
    T, Z = schur(A, output="complex")
    angles = _balanced(np.angle(np.diagonal(T)))
    return np.asarray((Z * (1j * angles)) @ Z.conj().T)


def _balanced(angles: Real) -> Real:
    """Principal angles, shape (n,), with 2π moved off the largest or onto the smallest until their sum is 0."""
    turns = round(float(angles.sum()) / (2.0 * np.pi))
    order = np.argsort(angles)
    balanced = angles.copy()
    extreme = order[len(order) - turns :] if turns > 0 else order[:-turns]
    balanced[extreme] -= np.sign(turns) * 2.0 * np.pi
    spread = float(np.ptp(balanced))
    if 2.0 * np.pi - spread <= TIE_MARGIN:
        raise InputError(
            f"no logarithm is singled out: the eigenvalues' angles spread over {spread:.15g} rad "
            f"(limit 2π − {TIE_MARGIN:g}), where several are equally short; give an element closer to the identity"
        )
    return balanced
