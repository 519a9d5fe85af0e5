"""The exponential of square matrices and its two companions φ(Z) = (e^Z − 1)/Z and φ(Z)⁻¹, from one Padé table.

The diagonal Padé approximant of the exponential is N(z)/N(−z). With N split into its even part V and its odd part zW,

    e^z ≈ (V + zW)/(V − zW),    φ(z) ≈ 2W/(V − zW),    φ(z)⁻¹ ≈ (V − zW)/2W,

so that all three share their polynomials, none cancels near z = 0, and a matrix of an orthogonal or a unitary algebra
has an orthogonal or a unitary exponential by construction. Matrices of larger norm are halved first, and the result
is doubled: e^{2z} = (e^z)², φ(2z) = φ(z)(e^z + 1)/2.

All functions are batched over leading axes and take real or complex matrices of shape (..., n, n).

References
----------
N. J. Higham, "The scaling and squaring method for the matrix exponential revisited", SIAM J. Matrix Anal. Appl. 26
(2005) 1179, for the method; the split that gives φ and φ⁻¹ is elementary.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

_DEGREE: Final = 9
_N: Final = [
    math.factorial(2 * _DEGREE - j) * math.comb(_DEGREE, j) / math.factorial(2 * _DEGREE) for j in range(_DEGREE + 1)
]
_TABLE: Final = np.array([_N[0::2], _N[1::2]])
"""Rows: coefficients of V and of W in powers of z², shape (2, 5)."""

REACH: Final = 2.0
"""The 1-norm up to which the table alone serves: the relative error of φ there is (9!)² 2¹⁸/(18! 19!) < 5e-17."""


def _halvings(Z: Array) -> NDArray[np.int_]:
    """How often each matrix is to be halved for its 1-norm to come within reach, shape (...)."""
    norm = np.abs(Z).sum(axis=-2).max(axis=-1)
    return np.maximum(np.frexp(norm / REACH)[1], 0)


def _polynomials(Z: Array) -> tuple[Array, Array]:
    """V(Z²) and W(Z²), each of shape (..., n, n)."""
    powers = np.empty((_TABLE.shape[1], *Z.shape), dtype=Z.dtype)
    powers[0] = np.eye(Z.shape[-1])
    np.matmul(Z, Z, out=powers[1])
    for k in range(2, len(powers)):
        np.matmul(powers[k // 2], powers[k - k // 2], out=powers[k])
    V, W = (_TABLE @ powers.reshape(len(powers), -1)).reshape(2, *Z.shape)
    return V, W


def _scaled(Z: Array, halvings: NDArray[np.int_]) -> Array:
    return Z * np.ldexp(1.0, -halvings)[..., np.newaxis, np.newaxis] if halvings.any() else Z


def exp(Z: Array) -> Array:
    """The matrix exponential.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    halvings = _halvings(Z)
    Z = _scaled(Z, halvings)
    V, W = _polynomials(Z)
    U = Z @ W
    E: Array = np.linalg.solve(V - U, V + U)
    for k in range(int(halvings.max(initial=0))):
        E = np.where((halvings > k)[..., np.newaxis, np.newaxis], E @ E, E)
    return E


def phi(Z: Array) -> Array:
    """φ(Z) = Σ Zᵏ/(k+1)!, for any norm.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    halvings = _halvings(Z)
    Z = _scaled(Z, halvings)
    V, W = _polynomials(Z)
    F: Array = np.linalg.solve(V - Z @ W, 2.0 * W)
    if not halvings.any():
        return F
    one = np.eye(Z.shape[-1])
    E = one + Z @ F
    for k in range(int(halvings.max())):
        wanted = (halvings > k)[..., np.newaxis, np.newaxis]
        F = np.where(wanted, 0.5 * (F @ (E + one)), F)
        E = np.where(wanted, E @ E, E)
    return F


def phi_inverse(Z: Array) -> Array:
    """φ(Z)⁻¹ = Σ Bₖ Zᵏ/k!, continued beyond the series' radius 2π; not finite where φ is exactly singular.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    if not _halvings(Z).any():
        V, W = _polynomials(Z)
        F: Array = np.linalg.solve(2.0 * W, V - Z @ W)
        return F
    try:
        inverse: Array = np.linalg.inv(phi(Z))
    except np.linalg.LinAlgError:
        return np.full_like(Z, np.inf)
    return inverse
