"""Rotation vectors and matrices as arguments of the maps of SO(3): their shapes, and the norm of a vector."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import ParameterError


def as_vectors(v: ArrayLike) -> Array:
    """The argument as float64 vectors, shape (..., 3); a `ParameterError` with its shape, if that is another."""
    array = np.asarray(v, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ParameterError(
            "rotation vectors", f"shape {array.shape} is not (..., 3): put the components on the last axis"
        )
    return array


def as_matrices(m: ArrayLike) -> Array:
    """The argument as float64 matrices, shape (..., 3, 3); a `ParameterError` with its shape, if that is another."""
    array = np.asarray(m, dtype=np.float64)
    if array.shape[-2:] != (3, 3):
        raise ParameterError(
            "rotation matrices", f"shape {array.shape} is not (..., 3, 3): put rows and columns on the last two axes"
        )
    return array


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
