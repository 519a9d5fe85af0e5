"""The Pfaffian of antisymmetric matrices: the square root of the determinant that is a polynomial in the entries."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics.array_input import real_array

Array = NDArray[np.float64]

_ROUND_OFF: Final = 64.0 * float(np.finfo(np.float64).eps)


def antisymmetric_matrices(name: str, value: ArrayLike) -> Array:
    """Matrices that are antisymmetric to within round-off.

    Parameters
    ----------
    name : str
        What they are called in the message.
    value : array_like, shape (..., n, n)

    Returns
    -------
    ndarray, shape (..., n, n)

    Raises
    ------
    InputError
        If they are not square, real, finite and antisymmetric.
    """
    given = real_array(name, value, "(…, n, n)")
    if given.ndim < 2 or given.shape[-1] != given.shape[-2]:
        raise InputError(f"{name}: shape {given.shape} is not (..., n, n): give square matrices")
    off = float(np.abs(given + np.swapaxes(given, -1, -2)).max())
    limit = _ROUND_OFF * float(np.abs(given).max())
    if off > limit:
        raise InputError(f"{name}: P + Pᵀ reaches {off:.3g}, the limit is {limit:.3g}: give an antisymmetric matrix")
    return given


def pfaffian(matrices: ArrayLike) -> Array:
    """Pf P, by antisymmetric Gauss elimination with pivoting.

    Each step takes the largest entry of the first column left, clears that column with a congruence of determinant 1
    and leaves a matrix smaller by two (B. N. Parlett, J. K. Reid, BIT 10 (1970) 386).

    Parameters
    ----------
    matrices : array_like, shape (..., n, n)
        Antisymmetric. Only entries above the diagonal are read.

    Returns
    -------
    ndarray, shape (...)
        With Pf [[0, a], [−a, 0]] = a, and 0 for odd n.

    Raises
    ------
    InputError
        If the matrices are not square.
    """
    given = np.asarray(matrices, dtype=np.float64)
    if given.ndim < 2 or given.shape[-1] != given.shape[-2]:
        raise InputError(f"a Pfaffian needs shape (..., n, n), given {given.shape}: give square matrices")
    rest = np.triu(given, 1) - np.swapaxes(np.triu(given, 1), -1, -2)
    value = np.full(given.shape[:-2], float(given.shape[-1] % 2 == 0))
    while rest.shape[-1] > 1:
        rest, sign = _pivoted(rest)
        value = value * (sign * rest[..., 0, 1])
        rest = _eliminated(rest)
    return np.asarray(value)


def _pivoted(p: Array) -> tuple[Array, Array]:
    """The matrices with rows and columns 1 and j exchanged, j the largest of row 0, and the sign this costs."""
    n = p.shape[-1]
    largest = 1 + np.argmax(np.abs(p[..., 0, 1:]), axis=-1)
    order: NDArray[Any] = np.broadcast_to(np.arange(n), (*largest.shape, n)).copy()
    np.put_along_axis(order, largest[..., np.newaxis], 1, axis=-1)
    order[..., 1] = largest
    rows = np.take_along_axis(p, order[..., :, np.newaxis], axis=-2)
    return np.take_along_axis(rows, order[..., np.newaxis, :], axis=-1), np.where(largest == 1, 1.0, -1.0)


def _eliminated(p: Array) -> Array:
    """What is left of the matrices when their first two rows and columns are cleared."""
    pivot = p[..., 0, 1]
    factors = p[..., 0, 2:] / np.where(pivot == 0.0, 1.0, pivot)[..., np.newaxis]
    update = p[..., 1, 2:, np.newaxis] * factors[..., np.newaxis, :]
    return np.asarray(p[..., 2:, 2:] + update - np.swapaxes(update, -1, -2))
