"""Types of arrays, of float64, int64 and bool, and small functions of arrays that several rooms call."""

from __future__ import annotations

import operator
import sys
from numbers import Real
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import shown

Array: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""

Integers: TypeAlias = NDArray[np.int64]
"""Whole numbers of 64 bits: times in nanoseconds, counts, indices."""

Booleans: TypeAlias = NDArray[np.bool_]
"""Truth values."""

NOT_NUMBERS: Final = (OverflowError, RuntimeError, TypeError, ValueError)
"""Errors by which NumPy, and objects that it asks, refuse to be an array of numbers."""
TRANSPOSED: Final = "its rows are columns: transpose it, as array.T"
"""Remedy for an array whose transposed one has the shape that is wanted."""

TO_NANOSECONDS: Final = {
    "f": ", as np.round(t_s * 1e9).astype(np.int64) of seconds",
    "M": ", as stamps.astype('int64') of ns",
}
"""Remedies for times that are no integers, by the kind of their type."""


def plain(value: object) -> Any:
    """A number or an array of NumPy, or a view of memory, as numbers and lists of Python."""
    if not isinstance(value, np.ndarray | np.generic | memoryview) or np.asarray(value).dtype.kind in "mM":
        return value  # a time span would become a bare number of its own unit
    return value.tolist()


def as_double(value: object) -> float:
    """A real number of Python or NumPy in double precision: NaN for what is none, infinity for one beyond doubles."""
    if isinstance(value, bool | np.timedelta64) or not isinstance(value, Real):
        return np.nan
    try:
        return float(value)
    except OverflowError:
        return np.inf


def require_unmasked(name: str, value: ArrayLike) -> None:
    """Refuse an array of which some is masked: what is behind the mask would count."""
    # who has a masked array has loaded the module, which takes 5 ms
    if "numpy.ma" in sys.modules and np.ma.is_masked(value):
        raise ParameterError(
            name,
            f"{np.ma.count_masked(value)} of its numbers are masked: fill them in, or leave their rows out, with "
            "their stamps",
        )


def as_numbers(name: str, value: ArrayLike) -> NDArray[Any]:
    """An argument as an array of real or complex numbers, not copied where it is one already.

    Parameters
    ----------
    name : str
        Name of the argument in the error and its message.
    value : array_like
        Numbers, or objects that convert to them, as fractions do.

    Returns
    -------
    ndarray

    Raises
    ------
    ParameterError
        If the argument is text, another object, rows of unequal length, or in part masked.
    """
    require_unmasked(name, value)
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O":
            array = array.astype(np.float64)
        if array.dtype.kind not in "biufc":
            raise TypeError
    except NOT_NUMBERS:
        raise ParameterError(name, f"{shown(value)} is not numbers: give an array of them, in equal rows") from None
    return array


def whole_number(name: str, value: object, least: int, most: float = np.inf) -> int:
    """An argument as a whole number within limits; a truth value is none.

    Raises
    ------
    ParameterError
    """
    try:
        number = operator.index(None if isinstance(value, bool) else value)  # type: ignore[arg-type]
    except TypeError:
        number = None
    if number is None or not least <= number <= most:
        limits = f"from {least} on" if most == np.inf else f"from {least} to {most:g}"
        raise ParameterError(name, f"{shown(value)} is no whole number {limits}: give one")
    return number


def same_bits(one: Array, other: Array) -> bool:
    """Whether two arrays have one shape and the same bits, where 0 is not −0 and NaN may be NaN."""
    return np.array_equal(one.view(np.int64), other.view(np.int64))


def items(data: bytes | memoryview, starts: Integers, size: int) -> NDArray[np.void]:
    """Pieces of some data, each of one size from 1 byte on, that begin at given places; copied, shape (N,)."""
    return np.ndarray((max(0, len(data) - size + 1),), f"V{size}", data, strides=(1,))[starts]


def runs_of(first: int, which: Booleans) -> tuple[Integers, Integers]:
    """First and last of each run of numbers that are of some kind.

    Parameters
    ----------
    first : int
    which : ndarray of bool, shape (N,)
        Of the numbers from ``first`` on.
    """
    edges = first + np.flatnonzero(np.diff(which, prepend=False, append=False))
    return edges[::2], edges[1::2] - 1
