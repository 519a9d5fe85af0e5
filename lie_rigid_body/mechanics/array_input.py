"""Reading an array at the edge: finite real numbers with the right number of axes, or an error that names them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError


def real_array(name: str, value: ArrayLike, form: str) -> Array:
    """A float64 copy of an argument.

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
        raise InputError(f"{name}: {value!r} is not numbers: {remedy}") from None
    if array.size == 0 or not _fits(array.ndim, form):
        raise InputError(f"{name}: shape {array.shape} is not {form}: {remedy}")
    if not np.isfinite(array).all():
        worst = array[~np.isfinite(array)][0]
        raise InputError(f"{name}: {worst} is not finite: {remedy}")
    return array


def _fits(axes: int, form: str) -> bool:
    return "…" in form or axes == len([axis for axis in form.strip("()").split(",") if axis.strip()])
