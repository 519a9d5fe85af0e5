"""Rotation vectors and matrices as arguments of the maps of SO(3): their shapes, and the norm of a vector."""

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
