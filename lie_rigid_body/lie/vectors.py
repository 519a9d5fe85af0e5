"""Rotation vectors and matrices as arguments of the maps of SO(3): their shapes, norms, and polynomials of [v]."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, shaped


def as_vectors(v: ArrayLike) -> Array:
    """The argument as rotation vectors, shape (..., 3)."""
    return shaped("rotation vectors", v, (..., 3))


def as_matrices(m: ArrayLike) -> Array:
    """The argument as rotation matrices, shape (..., 3, 3)."""
    return shaped("rotation matrices", m, (..., 3, 3))


def norm(v: ArrayLike) -> Array:
    """Euclidean norm over the last axis, without underflow or overflow of squares.

    Parameters
    ----------
    v : array_like, shape (..., 3)

    Returns
    -------
    ndarray, shape (...)
    """
    v = as_vectors(v)
    return np.asarray(np.hypot(np.hypot(v[..., 0], v[..., 1]), v[..., 2]))


def matrix_polynomial(v: Array, linear: Array, quadratic: Array | float) -> Array:
    """The matrix I + linear·[v] + quadratic·[v]², with the diagonal of [v]² written without cancellation.

    Parameters
    ----------
    v : ndarray, shape (..., 3)
    linear, quadratic : ndarray, shape (...)
        The second may be one number.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    x = v[..., 0]
    y = v[..., 1]
    z = v[..., 2]
    m = np.empty((*v.shape, 3))
    m[..., 0, 0] = 1.0 - quadratic * (y * y + z * z)
    m[..., 1, 1] = 1.0 - quadratic * (x * x + z * z)
    m[..., 2, 2] = 1.0 - quadratic * (x * x + y * y)
    m[..., 0, 1], m[..., 1, 0] = quadratic * x * y - linear * z, quadratic * x * y + linear * z
    m[..., 2, 0], m[..., 0, 2] = quadratic * x * z - linear * y, quadratic * x * z + linear * y
    m[..., 1, 2], m[..., 2, 1] = quadratic * y * z - linear * x, quadratic * y * z + linear * x
    return m
