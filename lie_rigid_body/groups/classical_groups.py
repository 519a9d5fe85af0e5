"""The classical compact groups: the rotations SO(n), the unitary matrices SU(n) of determinant 1, and the circle U(1).

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import sys
from abc import abstractmethod
from itertools import combinations
from typing import Final

import numpy as np
from scipy.linalg import schur

from lie_rigid_body.foundation.arrays import Array, Sizes, whole_number
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups.algebra import MatrixLieAlgebra, frobenius
from lie_rigid_body.groups.elements import Elements, multiple_until
from lie_rigid_body.groups.exponential import HALF_TURN_MARGIN, Matrix, batched_log
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

TINY: Final = sys.float_info.min
UNIQUE_LIMIT: Final = 1e-12
"""Singular values, relative to the largest, and angles, rad, up to which a nearest element is not unique."""

TIE_MARGIN: Final = 1e-13
"""Angle, rad, below which rounding decides which of two logarithms is the shorter."""

MAX_SO: Final = 40
"""Largest n of SO(n): the next has more than `MAX_GENERATORS`."""

MAX_SU: Final = 28
"""Largest n of SU(n), by the same limit."""


def SO(n: int) -> MatrixLieGroup:  # noqa: N802
    """The group of n×n rotation matrices, of dimension n(n−1)/2: eqs. (6) and (39).

    The generators are antisymmetric, by eqs. (40) and (41): ±(E_ji − E_ij) for the planes i < j in descending order,
    (n−2, n−1) first and (0, 1) last, with the sign (−1)^(i+j+1). Those of SO(3) are the basis of `so3.hat` and obey
    [Tᵃ, Tᵇ] = +εᵃᵇᶜTᶜ, eq. (26); the matrices printed in (25) have the opposite sign. The first (n−1)(n−2)/2 generators
    are those of SO(n−1) on all axes but the first.

    Parameters
    ----------
    n : int
        From 2 to 40.
    """
    n = whole_number("n", n, 2, MAX_SO)
    return _compact_group(_so_generators(n), f"SO({n})", 0.5, OrthogonalElements(n))


def SU(n: int) -> MatrixLieGroup:  # noqa: N802
    """The group of unitary n×n matrices of determinant 1, of dimension n² − 1; eq. (31) is SU(2).

    The generators are Tᵃ = −iλᵃ/2 with the generalised Gell-Mann matrices λᵃ in their usual order. That is, for each
    column j the symmetric and the antisymmetric matrix of each row i < j, then the diagonal one. Those of SU(2) are
    −iσᵃ/2 and obey [Tᵃ, Tᵇ] = +εᵃᵇᶜTᶜ, as those of SO(3).

    Parameters
    ----------
    n : int
        From 2 to 28.
    """
    n = whole_number("n", n, 2, MAX_SU)
    return _compact_group(_su_generators(n), f"SU({n})", 2.0, SpecialUnitaryElements(n))


def U1() -> MatrixLieGroup:  # noqa: N802
    """The circle: phases e^{iθ} as 1×1 matrices, with the generator i; the coordinate is the angle θ."""
    return _compact_group(np.array([[[1j]]]), "U(1)", 1.0, PhaseElements())


def _compact_group(generators: Matrix, name: str, scale: float, elements: Elements) -> MatrixLieGroup:
    return MatrixLieGroup(generators, name, MatrixLieAlgebra(generators).scaled_trace(scale), elements)


def _so_generators(n: int) -> Array:
    planes = list(combinations(range(n), 2))[::-1]
    T = np.zeros((len(planes), n, n))
    for t, (i, j) in zip(T, planes, strict=True):
        t[j, i] = (-1.0) ** (i + j + 1)
        t[i, j] = -t[j, i]
    return T


class CompactElements(Elements):
    """Matrices with A†A = 1 and det A = 1, as far as SO(n) and SU(n) are alike.

    Parameters
    ----------
    n : int
        Size of the matrices.
    """

    def __init__(self, n: int) -> None:
        self._n = n

    def distance(self, A: Matrix) -> Array:
        """The larger of the Frobenius norm of A†A − 1, eqs. (4) and (5), and |det A − 1|, eq. (6)."""
        off = frobenius(self.inverse(A) @ A - np.eye(self._n))
        return np.asarray(np.maximum(off, np.abs(np.linalg.det(A) - 1.0)))

    def inverse(self, A: Matrix) -> Matrix:
        """The conjugate transpose."""
        return np.swapaxes(A.conj(), -1, -2)

    def random(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Elements by the Haar measure: orthogonalised normal matrices (F. Mezzadri, Notices AMS 54 (2007) 592)."""
        Q, R = np.linalg.qr(self._normal(rng, (*shape, self._n, self._n)))
        phases = np.diagonal(R, axis1=-2, axis2=-1)
        Q = Q * (phases / np.abs(phases))[..., np.newaxis, :]
        Q[..., :, 0] /= np.linalg.det(Q)[..., np.newaxis]
        return np.asarray(Q)

    def log(self, A: Matrix) -> Matrix:
        """The logarithm, by the series near the identity and from the Schur form elsewhere."""
        return batched_log(A, self._log)

    @abstractmethod
    def _log(self, A: Matrix) -> Matrix:
        """The logarithm of one element, shape (n, n), in the basis of its Schur form."""

    @abstractmethod
    def _normal(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Matrices with independent standard normal entries."""


class OrthogonalElements(CompactElements):
    """Rotation matrices: AᵀA = 1 and det A = 1, eq. (6)."""

    def project(self, A: Matrix) -> Matrix:
        """The nearest rotation, U diag(1, …, 1, det UV) Vᵀ of A = U Σ Vᵀ (Kabsch, Acta Cryst. A 32 (1976) 922)."""
        U, sigma, Vt = np.linalg.svd(A)
        sign = np.sign(np.linalg.det(U @ Vt))
        _require_unique((sigma[..., -2] + sign * sigma[..., -1]) / np.maximum(sigma[..., 0], TINY))
        U[..., :, -1] *= sign[..., np.newaxis]
        return np.asarray(U @ Vt)

    def _log(self, A: Matrix) -> Matrix:
        """The principal logarithm from the angle of each plane of the real Schur form, which keeps its digits at π."""
        T, Z = schur(A, output="real")
        # what is not 0 beside the diagonal are sines of planes; the other diagonal entries are ±1
        below = np.diag(T, -1)
        diagonal = np.diag(T)
        angles = np.where(below == 0.0, 0.0, np.arctan2(below - np.diag(T, 1), diagonal[:-1] + diagonal[1:]))
        alone = (np.append(below, 0.0) == 0.0) & (np.append(0.0, below) == 0.0)
        _refuse_half_turn(np.pi if (diagonal[alone] < 0.0).any() else (np.abs(angles).max()))
        L = np.diag(angles, -1)
        return np.asarray(Z @ (L - L.T) @ Z.T)

    def _normal(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        return rng.standard_normal(shape)


def _require_unique(margin: Array) -> None:
    """Refuse matrices to which several elements are equally near."""
    worst = np.min(margin, initial=np.inf)
    if not worst > UNIQUE_LIMIT:
        raise InputError(
            f"no nearest element: several are equally near, as singular values or the phase of a matrix leave a margin "
            f"of {worst:.3g} (limit {UNIQUE_LIMIT:g}); give a matrix nearer to one"
        )


def _refuse_half_turn(angle: float) -> None:
    if np.pi - angle <= HALF_TURN_MARGIN:
        raise InputError(
            f"no principal logarithm: a plane turns by {angle:.15g} rad (limit π − {HALF_TURN_MARGIN:g}), "
            "where either sense is right; give an element closer to the identity"
        )


def _su_generators(n: int) -> Matrix:
    T = np.zeros((n * n - 1, n, n), dtype=np.complex128)
    rows = iter(T)
    for j in range(1, n):
        for i in range(j):
            symmetric = next(rows)
            antisymmetric = next(rows)
            symmetric[i, j] = symmetric[j, i] = -0.5j
            antisymmetric[i, j], antisymmetric[j, i] = -0.5, 0.5
        next(rows)[range(j + 1), range(j + 1)] = -0.5j * np.sqrt(2.0 / (j * (j + 1))) * np.array([1.0] * j + [-j])
    return T


class SpecialUnitaryElements(CompactElements):
    """Unitary matrices of determinant 1."""

    def project(self, A: Matrix) -> Matrix:
        """The nearest unitary matrix UV† of A = UΣV†, over the n-th root of its determinant."""
        U, sigma, Vh = np.linalg.svd(A)
        phase = np.angle(np.linalg.det(U @ Vh))
        _require_unique(np.minimum(sigma[..., -1] / np.maximum(sigma[..., 0], TINY), np.pi - np.abs(phase)))
        return np.asarray(np.exp(-1j * phase / self._n)[..., np.newaxis, np.newaxis] * (U @ Vh))

    def _log(self, A: Matrix) -> Matrix:
        """The logarithm of least norm, of principal angles with 2π taken off the largest, or added to the smallest,
        until their sum is 0.
        """
        T, Z = schur(A, output="complex")
        angles = np.angle(np.diagonal(T))
        turns = round((angles.sum()) / (2.0 * np.pi))
        order = np.argsort(angles)
        angles[order[len(order) - turns :] if turns > 0 else order[:-turns]] -= np.sign(turns) * 2.0 * np.pi
        spread = np.ptp(angles)
        if 2.0 * np.pi - spread <= TIE_MARGIN:
            raise InputError(
                f"no logarithm is singled out: the eigenvalues' angles spread over {spread:.15g} rad "
                f"(limit 2π − {TIE_MARGIN:g}), where several are equally short; give an element closer to the identity"
            )
        return (Z * (1j * angles)) @ Z.conj().T

    def one_to_one(self, X: Matrix) -> Array:
        """The multiple t at which angles of two eigenvalues of tX are 2π apart, and another logarithm is as short."""
        angles = np.linalg.eigvalsh(-1j * X)
        return multiple_until(2.0 * np.pi, angles[..., -1] - angles[..., 0], X)

    def _normal(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


class PhaseElements(Elements):
    """Complex numbers of modulus 1, as 1×1 matrices."""

    def distance(self, A: Matrix) -> Array:
        """Distance of the modulus from 1."""
        return np.abs(np.abs(A[..., 0, 0]) - 1.0)

    def project(self, A: Matrix) -> Matrix:
        """The number divided by its modulus."""
        modulus = np.abs(A)
        if not np.all(modulus > 0.0):
            raise InputError("no nearest phase: 0 is equally near to all; give a number other than 0")
        return A / modulus

    def inverse(self, A: Matrix) -> Matrix:
        """The complex conjugate."""
        return A.conj()

    def log(self, A: Matrix) -> Matrix:
        """The angle, within ±π, times i."""
        angle = np.angle(A)
        _refuse_half_turn(np.abs(angle).max(initial=0.0))
        return 1j * angle

    def random(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Uniform phases."""
        return np.exp(1j * rng.uniform(-np.pi, np.pi, (*shape, 1, 1)))
