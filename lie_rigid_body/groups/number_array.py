"""Reading arrays of numbers at the edge of the group functions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError


def as_numbers(what: str, value: ArrayLike) -> NDArray[Any]:
    """The argument as an array of real or complex numbers, or an error that says what it is instead.

    Parameters
    ----------
    what : str
        What it is called in the message, in the plural.
    value : array_like

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
