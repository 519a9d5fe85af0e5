"""Numbers as callers give them: read once, or refused in one line that says what to give."""

from __future__ import annotations

from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import shown


def quantity(name: str, value: object, unit: str, example: str, *, or_zero: bool = False) -> float:
    """Read a finite number above 0.

    Parameters
    ----------
    name : str
        What it was given as.
    value : object
    unit : str
        In words, for the message.
    example : str
        What to give instead.
    or_zero : bool
        Whether 0 will do.

    Raises
    ------
    InputError
        If it is anything else; a text is, and so are NaN and infinity.
    """
    try:
        number = np.nan if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number) or number < 0.0 or (number == 0.0 and not or_zero):
        fault = "is below 0" if or_zero else "is not above 0"
        if not np.isfinite(number):
            fault = f"is not a finite number of {unit} {'from 0 on' if or_zero else 'above 0'}"
        raise InputError(f"{name}: {shown(value)} {fault}: give for example {example}")
    return number


def real_numbers(name: str, value: ArrayLike, wanted: str) -> Array:
    """Read an array of real numbers as float64, of which nothing is dropped: no imaginary part, and no mask.

    Raises
    ------
    InputError
        If it is none.
    """
    unmasked(name, value)
    try:
        array = np.asarray(value)
        if np.iscomplexobj(array):
            raise InputError(f"{name}: complex numbers: give real ones, an array of shape {wanted}")
        # NumPy would read the texts '0' and '1', and True, as numbers
        if array.dtype.kind in "iuf" or all(isinstance(number, Real) for number in array.flat):
            return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:  # the last of a tensor that needs detach()
        if isinstance(error, InputError):
            raise
    raise InputError(f"{name}: not numbers: give an array of shape {wanted}") from None


def unmasked(name: str, value: ArrayLike) -> None:
    """Refuse an array of which some is masked: what is behind the mask would count.

    Raises
    ------
    InputError
    """
    if np.ma.is_masked(value):
        raise InputError(
            f"{name}: {np.ma.count_masked(value)} of its numbers are masked: leave these rows out, with their stamps"
        )


def shape_remedy(shape: tuple[int, ...], size: tuple[int, ...]) -> str:
    """Words that tell what to do about an array of a wrong shape, whose last axes should have some size."""
    if len(shape) == 2 and size == shape[:1] != shape[1:]:
        return "its rows are columns: transpose it, as array.T"
    if size == (4,) and shape[-2:] == (3, 3):
        return "give quaternions, as by scipy's Rotation.from_matrix(...).as_quat()"
    if size == (4,) and len(shape) > 1 and shape[-1] == 3:
        return "Euler angles are no quaternions: convert them, as by scipy's Rotation.from_euler(...).as_quat()"
    return "give such an array"
