"""A number of one motion, or of many, and its functions that are exact or correctly rounded.

For floats, for arrays and compiled the bits are the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.compilation import kernel, kernel_of
from lie_rigid_body.foundation.arrays import Array

Number: TypeAlias = float | Array
"""A float of one motion, or an array with an element for each of many.

Every formula of a motion is elementwise, so that a motion whose numbers are arrays is that many motions, and each of
them has the bits that it has alone.
"""

Triple: TypeAlias = tuple[Number, Number, Number]
Quadruple: TypeAlias = tuple[Number, Number, Number, Number]

_WHOLE: Final = 1.5 * 2.0**52
"""Constant 1.5·2⁵²: adding it to a double and subtracting it again rounds to the nearest integer."""

_EXPONENT_OF_ONE: Final = 1.5 * 2.0**52 + 1023.0
"""Double 1.5·2⁵² + 1023: plus a whole number k, its last bits are k + 1023, the exponent field of 2ᵏ."""


@kernel
def magnitude(x: Any) -> Number:
    """The size |x|."""
    size: Number = abs(x)
    return size


@kernel
def sign(x: Any) -> Number:
    """The sign: −1 where the number is negative, else 1."""
    side: Number = 1.0 - 2.0 * (x < 0.0)
    return side


@kernel
def nearest(x: Number) -> Number:
    """Nearest integer, ties to even, for |x| ≤ 2⁵¹."""
    return (x + _WHOLE) - _WHOLE


def _sqrt(x: float) -> float:
    return math.sqrt(x)


@kernel_of(_sqrt)
def sqrt(x: Number) -> Number:
    """The square root √x."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


def _at_most(x: float, limit: float) -> float:
    return x if x < limit else limit


@kernel_of(_at_most)
def at_most(x: Number, limit: float) -> Number:
    """The smaller of two numbers."""
    return min(x, limit) if isinstance(x, float) else np.minimum(x, limit)


def _power_of_two(k: float) -> float:
    # the bits of k + 1023, moved to where a double has its exponent
    bits = np.float64(k + _EXPONENT_OF_ONE).view(np.int64)
    power: float = np.int64(bits << 52).view(np.float64)
    return power


@kernel_of(_power_of_two)
def power_of_two(k: Number) -> Number:
    """The power 2ᵏ for a whole number k in [−1022, 0]."""
    return math.ldexp(1.0, int(k)) if isinstance(k, float) else np.ldexp(1.0, k.astype(np.int32))


@kernel
def pair(row: Sequence[Number], k: int) -> tuple[Number, Number]:
    """The two numbers in a row from place k on."""
    return row[k], row[k + 1]


@kernel
def triple(row: Sequence[Number], k: int) -> Triple:
    """The three numbers in a row from place k on."""
    return row[k], row[k + 1], row[k + 2]


@kernel
def quadruple(row: Sequence[Number], k: int) -> Quadruple:
    """The four numbers in a row from place k on."""
    return row[k], row[k + 1], row[k + 2], row[k + 3]


def each(function: Callable[..., float], *arguments: Number) -> Number:
    """Apply a function of Python's math library number by number: NumPy's own may differ in the last bit."""
    if isinstance(arguments[0], float):
        return function(*arguments)
    return np.array([function(*row) for row in zip(*(np.asarray(a).tolist() for a in arguments), strict=True)])
