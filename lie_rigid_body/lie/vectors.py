"""Rotation vectors and matrices as arguments of the maps of SO(3): their shapes, and the norm of a vector."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import NOT_NUMBERS, Array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import shown


def shaped(name: str, value: ArrayLike, own: tuple[int, ...], remedy: str) -> Array:
    """The argument as a float64 array of shape (..., own); a `ParameterError` if it has another, or is not numbers."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except NOT_NUMBERS:
        raise ParameterError(name, f"{shown(value)} is not numbers: {remedy}") from None
    if array.shape[-len(own) :] != own:
        raise ParameterError(name, f"shape {array.shape} is not (..., {', '.join(map(str, own))}): {remedy}")
    return array


def as_vectors(v: ArrayLike) -> Array:
    """The argument as rotation vectors, shape (..., 3); see `shaped`."""
    return shaped("rotation vectors", v, (3,), "put the components on the last axis")


def as_matrices(m: ArrayLike) -> Array:
    """The argument as rotation matrices, shape (..., 3, 3); see `shaped`."""
    return shaped("rotation matrices", m, (3, 3), "put rows and columns on the last two axes")


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
