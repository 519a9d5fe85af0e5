"""Numbers, stamps and attitudes as callers give them: read once, or refused in one line that says what to give."""

from __future__ import annotations

from numbers import Real
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import (
    NOT_NUMBERS,
    TO_NANOSECONDS,
    TRANSPOSED,
    Array,
    Integers,
    as_double,
    require_unmasked,
)
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.lie import quaternion

MAX_STAMP_NS: Final = 2**31 * 10**9
"""Largest stamp that a message can have, ns; differences of such stamps do not overflow."""
MIN_NORM: Final = 1e-12
"""Least norm of a quaternion; one of a smaller norm is taken for a quaternion that nobody has set."""


def quantity(name: str, value: Any, unit: str, example: str, *, or_zero: bool = False) -> float:
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
    number = as_double(value)
    if not (0.0 < number < np.inf or (number == 0.0 and or_zero)):
        raise InputError(
            f"{name}: {shown(value)} is not a finite number of {unit} {'from 0 on' if or_zero else 'above 0'}: "
            f"give for example {example}"
        )
    return number


def real_numbers(name: str, value: ArrayLike, wanted: str) -> Array:
    """Read an array of real numbers as float64, of which nothing is dropped: no imaginary part, and no mask.

    Raises
    ------
    InputError
        If it is none.
    """
    require_unmasked(name, value)
    try:
        array = np.asarray(value)
        # NumPy would read the texts '0' and '1', and True, as numbers
        if array.dtype.kind in "iuf" or all(isinstance(number, Real) for number in array.flat):
            return np.asarray(array, dtype=np.float64)
        fault = "complex numbers: give real ones," if np.iscomplexobj(array) else "not numbers: give"
    except NOT_NUMBERS:
        fault = "not numbers: give"
    raise InputError(f"{name}: {fault} an array of shape {wanted}")


def numbers(name: str, value: ArrayLike, *size: int, whole: bool = False) -> Array:
    """Read finite numbers whose last axes, or with `whole` all axes, have the given size, as float64.

    Raises
    ------
    InputError
        With the first row that is at fault.
    """
    wanted = str(size) if whole else f"(..., {', '.join(map(str, size))})"
    array = real_numbers(name, value, wanted)
    if (array.shape if whole else array.shape[-len(size) :]) != size:
        raise InputError(f"{name}: shape {array.shape} is not {wanted}: {shape_remedy(array.shape, size)}")
    if array.size == 0:
        raise InputError(f"{name}: empty: give at least one row")
    finite = np.isfinite(array).all(axis=tuple(range(whole - len(size), 0))).ravel()
    if not finite.all():
        raise InputError(
            f"{name}: {np.count_nonzero(~finite)} of {finite.size} rows are not finite, the first is row "
            f"{np.argmin(finite)}: leave them out, or find out why the filter gave them"
        )
    return array


def shape_remedy(shape: tuple[int, ...], size: tuple[int, ...]) -> str:
    """Words that tell what to do about an array of a wrong shape, whose last axes should have some size."""
    if len(shape) == 2 and size == shape[:1] != shape[1:]:
        return TRANSPOSED
    if size == (4,) and shape[-2:] == (3, 3):
        return "give quaternions, as by scipy's Rotation.from_matrix(...).as_quat()"
    if size == (4,) and len(shape) > 1 and shape[-1] == 3:
        return "Euler angles are no quaternions: convert them, as by scipy's Rotation.from_euler(...).as_quat()"
    return "give such an array"


def unit(name: str, value: ArrayLike) -> Array:
    """Read quaternions, and divide them by their norm.

    Raises
    ------
    InputError
        If one is not finite, or zero, or its norm is beyond float64.
    """
    array = numbers(name, value, 4)
    norms = quaternion.norm(array).ravel()
    bad = np.flatnonzero((norms < MIN_NORM) | np.isinf(norms))
    if bad.size:
        raise InputError(
            f"{name}: {bad.size} of {norms.size} quaternions are zero or overflow, the first is row {bad[0]}: "
            "leave them out, or fill in the orientation"
        )
    return quaternion.normalize(array)


def integer_stamps(name: str, stamps_ns: ArrayLike) -> Integers:
    """Read stamps of any shape, in any order, as int64.

    Raises
    ------
    InputError
        If they are no integers, or none that a message can have.
    """
    require_unmasked(f"{name}: stamps", stamps_ns)
    try:
        stamps = np.asarray(stamps_ns)
    except ValueError:  # rows of unequal length
        stamps = np.asarray(stamps_ns, dtype=object)
    if stamps.size and stamps.dtype.kind not in "iu":
        raise InputError(
            f"{name}: stamps of type {stamps.dtype}: give integer nanoseconds"
            f"{TO_NANOSECONDS.get(stamps.dtype.kind, '')}"
        )
    if stamps.size and max(int(stamps.max()), -int(stamps.min())) > MAX_STAMP_NS:
        raise InputError(
            f"{name}: stamps from {stamps.min()} to {stamps.max()}: those of ROS 2 are within 2**31 s: give nanoseconds"
        )
    return stamps.astype(np.int64)


def as_stamps(name: str, stamps_ns: ArrayLike) -> Integers:
    """Read stamps as `integer_stamps`, but for int64, which is not checked again: a fit may try a lag of any size."""
    return (
        stamps_ns if type(stamps_ns) is np.ndarray and stamps_ns.dtype == np.int64 else integer_stamps(name, stamps_ns)
    )


def read_stamps(name: str, stamps_ns: ArrayLike) -> Integers:
    """Read stamps as int64, never decreasing, at least one.

    Raises
    ------
    InputError
        If they are not that.
    """
    stamps = integer_stamps(name, stamps_ns)
    if stamps.ndim != 1 or stamps.size == 0:
        raise InputError(f"{name}: stamps of shape {stamps.shape}: give a flat list of at least one")
    back = np.flatnonzero(np.diff(stamps) < 0)
    if back.size:
        raise InputError(
            f"{name}: out of order in {back.size} places, first at sample {back[0] + 1}, "
            f"{(stamps[back[0]] - stamps[back[0] + 1]) / 1e9:g} s before the one ahead of it: sort by stamp, or "
            "evaluate the parts before and after a reset apart"
        )
    return stamps


def read_series(name: str, stamps_ns: ArrayLike, attitude_xyzw: ArrayLike) -> tuple[Integers, Array]:
    """Read stamps, shape (N,), and as many attitudes, shape (N, 4), which are divided by their norms.

    Raises
    ------
    InputError
        As `read_stamps` and `unit`, or if there is not an attitude for each stamp.
    """
    stamps = read_stamps(name, stamps_ns)
    attitude = unit(name, attitude_xyzw)
    if attitude.shape != (len(stamps), 4):
        raise InputError(
            f"{name}: attitudes of shape {attitude.shape} for {len(stamps)} stamps: give a row for each stamp"
        )
    return stamps, attitude
