"""The Pfaffian of antisymmetric matrices: the square root of the determinant that is a polynomial in the entries."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.groups.antihermitian import antisymmetric_matrices

Array = NDArray[np.float64]


def pfaffian(matrices: ArrayLike) -> Array:
    """Pf P, by antisymmetric Gauss elimination with pivoting.

    Each step takes the largest entry of the first column left, clears that column with a congruence of determinant 1
    and leaves a matrix smaller by two (B. N. Parlett, J. K. Reid, BIT 10 (1970) 386).

    Parameters
    ----------
    matrices : array_like, shape (..., n, n)
        Antisymmetric.

    Returns
    -------
    ndarray, shape (...)
        With Pf [[0, a], [−a, 0]] = a, 1 for n = 0 as the empty product, and 0 for odd n.

    Raises
    ------
    InputError
        If the matrices are not square, real, finite and antisymmetric.
    """
    given = antisymmetric_matrices("P", matrices)
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
