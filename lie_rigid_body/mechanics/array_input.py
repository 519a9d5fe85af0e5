"""Reading the arrays that a caller gives: checked and converted once, or refused with an error that names them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import shown

ROUND_OFF: Final = 64.0 * float(np.finfo(np.float64).eps)
"""Rounding error allowed in a given or computed matrix, relative to its largest entry or eigenvalue."""

ORTHOGONAL_TOLERANCE: Final = 1e-9
"""A matrix is refused as a rotation when an entry of AᵀA − 1 exceeds this."""


def as_numbers(what: str, value: ArrayLike) -> NDArray[Any]:
    """An argument as an array of real or complex numbers, not copied where it is one already.

    Parameters
    ----------
    what : str
        What the argument is called in the message, in the plural.
    value : array_like

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If it is text, another object, or rows of unequal length.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        raise InputError(f"{what} have rows of unequal length: give an array of numbers") from None
    if array.dtype.kind not in "biufc":
        raise InputError(f"{what} are no numbers, given type {array.dtype}: give an array of numbers")
    return array


def real_array(name: str, value: ArrayLike, form: str) -> Array:
    """An argument as finite real numbers.

    Parameters
    ----------
    name : str
        What the argument is called in the message.
    value : array_like
    form : str
        The shape in symbols, as ``"(N, n)"``. Its number of axes is required, unless it has an ellipsis.

    Returns
    -------
    ndarray
        A copy.

    Raises
    ------
    InputError
        If it is not numbers, complex, not finite, empty, or has another number of axes.
    """
    remedy = f"give finite real numbers of shape {form}"
    try:
        given = np.asarray(value)
        if np.iscomplexobj(given):
            raise InputError(f"{name}: complex numbers: {remedy}")
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{name}: {shown(value)} is not numbers: {remedy}") from None
    if array.size == 0 or not _fits(array.ndim, form):
        raise InputError(f"{name}: shape {array.shape} is not {form}: {remedy}")
    if not np.isfinite(array).all():
        worst = array[~np.isfinite(array)][0]
        raise InputError(f"{name}: {worst} is not finite: {remedy}")
    return array


def symmetric_matrix(name: str, value: ArrayLike) -> Array:
    """A symmetric matrix, rid of the round-off of its asymmetry.

    Parameters
    ----------
    name : str
        What it is called in the message.
    value : array_like, shape (n, n)

    Returns
    -------
    ndarray, shape (n, n)
        A copy, exactly symmetric.

    Raises
    ------
    InputError
        If it is not a finite square matrix, or not symmetric within round-off.
    """
    matrix = real_array(name, value, "(n, n)")
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{name}: shape {matrix.shape} is not square: give n rows of n numbers")
    gap, limit = float(np.abs(matrix - matrix.T).max()), ROUND_OFF * float(np.abs(matrix).max())
    if gap > limit:
        raise InputError(
            f"{name}: entries across the diagonal differ by {gap:.9g}, more than round-off ({limit:.3g}): "
            "give a symmetric matrix"
        )
    return 0.5 * (matrix + matrix.T)


def orthogonal_matrix(name: str, value: ArrayLike, n: int) -> Array:
    """Rotations of n dimensions, or reflections.

    Parameters
    ----------
    name : str
        What they are called in the message.
    value : array_like, shape (..., n, n)
    n : int

    Returns
    -------
    ndarray, shape (..., n, n)

    Raises
    ------
    InputError
        If the shape is another or AᵀA is not 1 within `ORTHOGONAL_TOLERANCE`.
    """
    matrices = real_array(name, value, "(…, n, n)")
    if matrices.shape[-2:] != (n, n):
        raise InputError(
            f"{name}: shape {matrices.shape} is not (..., {n}, {n}): give matrices of the body's dimension"
        )
    worst = float(np.abs(matrices.swapaxes(-1, -2) @ matrices - np.eye(n)).max())
    if not worst <= ORTHOGONAL_TOLERANCE:
        raise InputError(
            f"{name}: AᵀA differs from 1 by {worst:.3g}, more than {ORTHOGONAL_TOLERANCE:g}: "
            "give an orthogonal matrix, or project it onto the group"
        )
    return matrices


def _fits(axes: int, form: str) -> bool:
    return "…" in form or axes == len([axis for axis in form.strip("()").split(",") if axis.strip()])
