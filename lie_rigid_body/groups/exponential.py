"""The exponential of square matrices, its companions φ(Z) = (e^Z − 1)/Z and φ(Z)⁻¹, and the principal logarithm.

The exponential and the logarithm are SciPy's. φ is a corner of an exponential of twice the size,

    exp [[Z, 1], [0, 0]] = [[e^Z, φ(Z)], [0, 1]].

All matrices are given to SciPy as complex ones. Against 40 digits, SciPy 1.18 errs by 350 units of round-off on real
matrices of norm 2 to 5, and by 4 on the same matrices as complex ones.

Near the identity the logarithm is the series of 2 artanh, which keeps the digits of A − 1. SciPy's logarithm of 1 + δ
has the accuracy of 1, and not that of δ.

Matrices are real or complex, of shape (..., n, n); functions are batched over leading axes unless they say otherwise.

References
----------
N. J. Higham, "Functions of Matrices", SIAM 2008, section 10.7.4 for φ, and 11.5 for the logarithm.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import redirect_stdout
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, logm

Matrix: TypeAlias = NDArray[Any]
"""Real or complex matrices, shape (..., n, n)."""

Complex: TypeAlias = NDArray[np.complex128]
"""Complex numbers."""

LOGARITHM_RADIUS: Final = 0.5
"""Frobenius distance from the identity up to which the series of the logarithm is used."""

HALF_TURN_MARGIN: Final = 1e-13
"""Angle, rad, from the negative real axis within which rounding decides on which side of it an eigenvalue lies."""

# with ‖A − 1‖ ≤ ½ the argument S of artanh has norm at most ⅓, and the first term left out is below 3⁻³³/33
_SERIES_TERMS: Final = 16


def exp(Z: Matrix) -> Matrix:
    """The matrix exponential, which makes elements of a group, eq. (38) of A. Lucas, arXiv 1111.1275, to all orders.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    if not Z.size:
        return Z
    E = expm(Z.astype(np.complex128))
    return E if np.iscomplexobj(Z) else E.real


def phi(Z: Matrix) -> Matrix:
    """φ(Z) = Σ Zᵏ/(k+1)!, for any norm.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    n = Z.shape[-1]
    doubled = np.zeros((*Z.shape[:-2], 2 * n, 2 * n), Z.dtype)
    doubled[..., :n, :n] = Z
    doubled[..., :n, n:] = np.eye(n)
    return exp(doubled)[..., :n, n:]


def phi_inverse(Z: Matrix) -> Matrix:
    """φ(Z)⁻¹ = Σ Bₖ Zᵏ/k!, continued beyond the series' radius 2π; not finite where φ is exactly singular.

    Parameters
    ----------
    Z : ndarray, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    try:
        return np.linalg.inv(phi(Z))
    except np.linalg.LinAlgError:
        return np.full_like(Z, np.inf)


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
    return 2.0 * (S @ total)


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
    near = np.linalg.norm(flat - np.eye(A.shape[-1]), axis=(-2, -1)) <= LOGARITHM_RADIUS
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
    # SciPy before 1.18 prints, and later warns, where it doubts its result
    with warnings.catch_warnings(), redirect_stdout(None):
        warnings.simplefilter("ignore")
        found = logm(A)
    return np.asarray(found if np.iscomplexobj(A) else np.real(found), dtype=A.dtype)
