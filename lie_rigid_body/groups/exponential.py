"""The exponential of square matrices, its companions φ(Z) = (e^Z − 1)/Z and φ(Z)⁻¹, and the principal logarithm.

The exponential, φ and φ⁻¹ come from one Padé table. The diagonal Padé approximant of the exponential is N(z)/N(−z).
With N split into its even part V and its odd part zW,

    e^z ≈ (V + zW)/(V − zW),    φ(z) ≈ 2W/(V − zW),    φ(z)⁻¹ ≈ (V − zW)/2W,

so that all three share their polynomials, and none cancels near z = 0. A matrix of an orthogonal or a unitary algebra
has an orthogonal or a unitary exponential by construction. Matrices of larger norm are halved first, and the result is
doubled: e^{2z} = (e^z)², φ(2z) = φ(z)(e^z + 1)/2.

The logarithm is the series of 2 artanh near the identity, to the digits of A − 1, and SciPy's elsewhere. The
exponential of SciPy is not taken, and SciPy has no φ. Matrices of norm 2 to 100, of the groups in the tests, were
compared with 50 digits. The exponential of SciPy 1.18 errs by up to 420 units of round-off (3 with 1.11), and the one
here by 5.

Matrices are real or complex, of shape (..., n, n); functions are batched over leading axes unless they say otherwise.

References
----------
N. J. Higham, "The scaling and squaring method for the matrix exponential revisited", SIAM J. Matrix Anal. Appl. 26
(2005) 1179, for the exponential; the split that gives φ and φ⁻¹ is elementary.
N. J. Higham, "Functions of Matrices", SIAM 2008, section 11.5, for the logarithm.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from contextlib import redirect_stdout
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import logm

from lie_rigid_body.foundation.arrays import Array

Matrix: TypeAlias = NDArray[Any]
"""Real or complex matrices, shape (..., n, n)."""

_DEGREE: Final = 9
"""Degree of the Padé approximant of the exponential."""
_N: Final = [
    math.factorial(2 * _DEGREE - j) * math.comb(_DEGREE, j) / math.factorial(2 * _DEGREE) for j in range(_DEGREE + 1)
]
_TABLE: Final = np.array([_N[0::2], _N[1::2]])
"""Rows: coefficients of V and of W in powers of z², shape (2, 5)."""

REACH: Final = 2.0
"""Largest 1-norm that is not halved: the relative error of φ there is (9!)² 2¹⁸/(18! 19!) < 5e-17."""

LOGARITHM_RADIUS: Final = 0.5
"""Frobenius distance from the identity up to which the series of the logarithm is used."""

HALF_TURN_MARGIN: Final = 1e-13
"""Angle, rad, from the negative real axis within which rounding decides on which side of it an eigenvalue lies."""

# With ‖A − 1‖ ≤ ½ the argument S of artanh has norm at most ⅓, and the first term left out is below 3⁻³³/33.
_SERIES_TERMS: Final = 16


def _halved(Z: Matrix) -> tuple[Matrix, NDArray[np.int_]]:
    """Matrices halved until the 1-norm of each is at most `REACH`, and how often, shape (...)."""
    norm = np.abs(Z).sum(axis=-2).max(axis=-1)
    halvings = np.maximum(np.frexp(norm / REACH)[1], 0)
    return Z * np.ldexp(1.0, -halvings)[..., np.newaxis, np.newaxis] if halvings.any() else Z, halvings


def _polynomials(Z: Matrix) -> tuple[Matrix, Matrix]:
    """V(Z²) and W(Z²), each of shape (..., n, n)."""
    powers = np.empty((_TABLE.shape[1], *Z.shape), dtype=Z.dtype)
    powers[0] = np.eye(Z.shape[-1])
    np.matmul(Z, Z, out=powers[1])
    for k in range(2, len(powers)):
        np.matmul(powers[k // 2], powers[k - k // 2], out=powers[k])
    V, W = (_TABLE @ powers.reshape(len(powers), -1)).reshape(2, *Z.shape)
    return V, W


def exp(Z: Matrix) -> Matrix:
    """The matrix exponential, which makes elements of a group, eq. (38) of A. Lucas, arXiv 1111.1275, to all orders.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    Z, halvings = _halved(Z)
    V, W = _polynomials(Z)
    U = Z @ W
    E: Matrix = np.linalg.solve(V - U, V + U)
    for k in range(int(halvings.max(initial=0))):
        E = np.where((halvings > k)[..., np.newaxis, np.newaxis], E @ E, E)
    return E


def phi(Z: Matrix) -> Matrix:
    """φ(Z) = Σ Zᵏ/(k+1)!, for any norm.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    Z, halvings = _halved(Z)
    V, W = _polynomials(Z)
    F: Matrix = np.linalg.solve(V - Z @ W, 2.0 * W)
    if not halvings.any():
        return F
    one = np.eye(Z.shape[-1])
    E = one + Z @ F
    for k in range(int(halvings.max())):
        wanted = (halvings > k)[..., np.newaxis, np.newaxis]
        F = np.where(wanted, 0.5 * (F @ (E + one)), F)
        E = np.where(wanted, E @ E, E)
    return F


def phi_inverse(Z: Matrix) -> Matrix:
    """φ(Z)⁻¹ = Σ Bₖ Zᵏ/k!, continued beyond the series' radius 2π; not finite where φ is exactly singular.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    _, halvings = _halved(Z)
    if not halvings.any():
        V, W = _polynomials(Z)
        return np.asarray(np.linalg.solve(2.0 * W, V - Z @ W))
    try:
        return np.asarray(np.linalg.inv(phi(Z)))
    except np.linalg.LinAlgError:
        return np.full_like(Z, np.inf)


def distance_from_identity(A: Matrix) -> Array:
    """Frobenius norm of A − 1, shape (...)."""
    return np.asarray(np.linalg.norm(A - np.eye(A.shape[-1]), axis=(-2, -1)))


def log_near_identity(A: Matrix) -> Matrix:
    """The logarithm of matrices within `LOGARITHM_RADIUS` of the identity: log A = 2 artanh((A − 1)(A + 1)⁻¹).

    The difference A − 1 enters first, so that the logarithm of 1 + δ has the relative accuracy of δ.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    one = np.eye(A.shape[-1])
    S = np.linalg.solve(A + one, A - one)
    squared = S @ S
    total = one / (2 * _SERIES_TERMS - 1)
    for k in reversed(range(_SERIES_TERMS - 1)):
        total = squared @ total + one / (2 * k + 1)
    return np.asarray(2.0 * (S @ total))


def batched_log(A: Matrix, far: Callable[[Matrix], Matrix]) -> Matrix:
    """Logarithms of a batch: by `log_near_identity` where it converges, by another function, one by one, elsewhere.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)
    far : callable
        The logarithm of one matrix, shape (n, n), that is farther from the identity than `LOGARITHM_RADIUS`.

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    flat = A.reshape(-1, *A.shape[-2:])
    near = distance_from_identity(flat) <= LOGARITHM_RADIUS
    result = np.empty_like(flat)
    result[near] = log_near_identity(flat[near])
    for k in np.flatnonzero(~near):
        result[k] = far(flat[k])
    return result.reshape(A.shape)


def principal_log(A: Matrix) -> Matrix:
    """The principal logarithm of one matrix without eigenvalues on the closed negative real axis.

    Parameters
    ----------
    A : ndarray, shape (n, n)

    Returns
    -------
    ndarray, shape (n, n)
        Not checked: where no logarithm is found it is not finite, or is no logarithm of the matrix.
    """
    if distance_from_identity(A) <= LOGARITHM_RADIUS:
        return log_near_identity(A)
    # SciPy before 1.18 prints, and later warns, where it doubts its result
    with warnings.catch_warnings(), redirect_stdout(None):
        warnings.simplefilter("ignore")
        found = logm(A)
    return np.asarray(found if np.iscomplexobj(A) else np.real(found), dtype=A.dtype)
