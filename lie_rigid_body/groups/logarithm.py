"""The principal logarithm of square matrices without special structure.

Inverse scaling and squaring: square roots until the matrix is near the identity, and the series of 2 artanh there.

References
----------
N. J. Higham, "Functions of Matrices", SIAM 2008: section 6.3 for the square root (product form of the Denman–Beavers
iteration), section 11.5 for the logarithm.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

NEAR: Final = 0.5
"""Frobenius distance from the identity up to which the series serves."""

HALF_TURN_MARGIN: Final = 1e-13
"""Angle, rad: an eigenvalue this close to the negative real axis has lost to rounding which side of it it is on."""

# With ‖A − 1‖ ≤ ½ the argument S of artanh has norm at most ⅓, and the first term left out is below 3⁻³³/33.
_TERMS: Final = 16
_ROOTS: Final = 64
_ITERATIONS: Final = 60
_FAR: Final = 1e-2
_SETTLED: Final = 1e-15


def distance_from_identity(A: Array) -> NDArray[np.float64]:
    """Frobenius norm of A − 1, shape (...)."""
    return np.asarray(np.linalg.norm(A - np.eye(A.shape[-1]), axis=(-2, -1)))


def near_identity(A: Array) -> Array:
    """The logarithm of matrices within `NEAR` of the identity: log A = 2 artanh((A − 1)(A + 1)⁻¹).

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
    total = one / (2 * _TERMS - 1)
    for k in reversed(range(_TERMS - 1)):
        total = squared @ total + one / (2 * k + 1)
    return np.asarray(2.0 * (S @ total))


def each(A: Array, far: Callable[[Array], Array]) -> Array:
    """Logarithms of a batch, one by one: by `near_identity` where that serves, by another function elsewhere.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)
    far : callable
        The logarithm of one matrix, shape (n, n).

    Returns
    -------
    ndarray, shape (..., n, n)
    """
    flat = A.reshape(-1, *A.shape[-2:])
    near = distance_from_identity(flat) <= NEAR
    logs = np.empty_like(flat)
    logs[near] = near_identity(flat[near])
    for k in np.flatnonzero(~near):
        logs[k] = far(flat[k])
    return logs.reshape(A.shape)


def _square_root(A: Array) -> Array:
    """The principal square root of one matrix, shape (n, n), by the product form of Denman and Beavers."""
    one = np.eye(len(A))
    M, X = A, A
    for _ in range(_ITERATIONS):
        # scaling by the determinant shortens the way from afar and spoils the convergence nearby
        far = np.linalg.norm(M - one) > _FAR
        scale = abs(np.linalg.det(M)) ** (-0.5 / len(A)) if far else 1.0
        inverse = np.linalg.inv(scale * M) / scale
        X = 0.5 * scale * (X @ (one + inverse))
        M = 0.5 * (one + 0.5 * (scale * M * scale + inverse))
        if np.linalg.norm(M - one) <= _SETTLED * len(A):
            break
    return X


def principal(A: Array) -> Array:
    """The principal logarithm of one matrix without eigenvalues on the closed negative real axis.

    Parameters
    ----------
    A : ndarray, shape (n, n)

    Returns
    -------
    ndarray, shape (n, n)
        Unchecked: not finite, or not a logarithm, where the iteration fails.
    """
    root, doublings = A, 0
    while distance_from_identity(root) > NEAR and doublings < _ROOTS:
        root, doublings = _square_root(root), doublings + 1
    return near_identity(root) * 2.0**doublings
