"""Types of arrays, of float64, int64 and bool, and small functions of arrays that several rooms call."""

from __future__ import annotations

import operator
import sys
from numbers import Real
from pathlib import PurePath
from types import EllipsisType
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import shown

Array: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""

Integers: TypeAlias = NDArray[np.int64]
"""Whole numbers of 64 bits: times in nanoseconds, counts, indices."""

Booleans: TypeAlias = NDArray[np.bool_]
"""Truth values."""

Sizes: TypeAlias = tuple[int, ...]
"""Lengths of axes."""

Shape: TypeAlias = "tuple[int | str | EllipsisType, ...]"
"""Lengths of the axes of an array, as `shaped` takes them."""

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
    """A number or an array of NumPy, or a view of memory, as numbers and lists of Python; a path as text."""
    if isinstance(value, PurePath):
        return str(value)
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


def shaped(name: str, value: ArrayLike, shape: Shape, dtype: DTypeLike = np.float64) -> NDArray[Any]:
    """An argument as numbers of some shape in double precision, not copied where it is of the type already.

    Parameters
    ----------
    name : str
        Name of the argument in the error and its message.
    value : array_like
    shape : tuple
        Length of each axis, as a number or, for any length, as a letter; the same letter stands for the same length.
        An ellipsis at the beginning stands for any number of axes.
    dtype : optional
        float64 or complex128.

    Raises
    ------
    ParameterError
        If the argument is not numbers, of another shape, or complex where real numbers are asked for.
    """
    if type(value) is np.ndarray and value.dtype == dtype and _fits(value.shape, shape):
        return value  # at once, as most are: the checks take longer than a product of quaternions
    given = as_numbers(name, value)
    is_real = np.dtype(dtype).kind == "f"
    if not _fits(given.shape, shape) or (is_real and np.iscomplexobj(given)):
        raise ParameterError(name, _misfit(given, shape, is_real=is_real))
    with np.errstate(over="ignore"):  # what is finite in more digits may be none in double precision
        return given.astype(dtype, copy=False)


def _misfit(given: NDArray[Any], shape: Shape, *, is_real: bool) -> str:
    """Fault of an array that has another shape, or is complex, and the remedy."""
    form = f"({', '.join('…' if axis is ... else str(axis) for axis in shape)}{',' * (len(shape) == 1)})"
    remedy = f"give {'real ' * is_real}numbers of shape {form}"
    if _fits(given.shape, shape):
        return f"complex numbers: {remedy}"
    is_transposed = given.ndim == 2 and given.size and _fits(given.shape[::-1], shape)
    return f"shape {given.shape} is not {form}: {TRANSPOSED if is_transposed else remedy}"


def _fits(given: Sizes, shape: Shape) -> bool:
    if shape[:1] == (...,):
        shape = shape[1:]
        given = given[max(0, len(given) - len(shape)) :]
    if given == shape:
        return True
    lengths: dict[object, int] = {axis: axis for axis in shape if isinstance(axis, int)}
    return len(given) == len(shape) and all(
        lengths.setdefault(axis, length) == length for axis, length in zip(shape, given, strict=True)
    )


def real_array(name: str, value: ArrayLike, shape: Shape, *, empty: bool = False) -> Array:
    """A copy of an argument as finite real numbers of some shape; see `shaped`.

    Parameters
    ----------
    name : str
    value : array_like
    shape : tuple
    empty : bool, optional
        Whether an array without any number is accepted.

    Raises
    ------
    ParameterError
    """
    array = np.array(shaped(name, value, shape))
    if not (array.size or empty):
        raise ParameterError(name, f"shape {array.shape} has no numbers: give at least one")
    require_finite(name, array)
    return array


def require_finite(name: str, array: NDArray[Any]) -> None:
    """Refuse numbers that are infinite or NaN, with the first of them in the message."""
    bad = array[~np.isfinite(array)]
    if bad.size:
        raise ParameterError(name, f"{bad[0]} is not finite: give finite numbers")


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


def linear(stamps_ns: Integers, known_ns: Integers, values: Array) -> Array:
    """Vectors at stamps, ns, shape (K, 3), linear between those at known ones, (N, 3), which do not fall."""
    # as doubles hold no time of day to the nanosecond
    since = stamps_ns - known_ns[0]
    known = known_ns - known_ns[0]
    return np.stack([np.interp(since, known, axis) for axis in values.T], axis=-1)
