"""A number of one time, or of many, and its functions that are exact or correctly rounded: one set of bits for both."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.compilation import kernel
from lie_rigid_body.foundation.arrays import Array

Number: TypeAlias = float | Array
"""A float, or an array with an element for each of many times."""

_WHOLE: Final = 1.5 * 2.0**52
"""Constant 1.5·2⁵²: adding it to a double and subtracting it again rounds to the nearest integer."""


@kernel
def magnitude(x: Any) -> Number:
    """The size |x|."""
    size: Number = abs(x)
    return size


def sign(x: Any) -> Number:
    """The sign: −1 where the number is negative, else 1."""
    side: Number = 1 - 2 * (x < 0)
    return side


def guarded(x: Any, least: float) -> Any:
    """A sum of a number that is not negative and the least one that is not 0; a decimal never underflows."""
    return x if isinstance(x, Decimal) else x + least


def nearest(x: Number) -> Number:
    """Nearest integer, ties to even, for |x| ≤ 2⁵¹."""
    return (x + _WHOLE) - _WHOLE


def sqrt(x: Any) -> Any:
    """The square root √x, of a decimal as well."""
    if isinstance(x, Decimal):
        return x.sqrt()
    return np.sqrt(x) if isinstance(x, np.ndarray) else math.sqrt(x)


def at_most(x: Number, limit: float) -> Number:
    """The smaller of two numbers."""
    return np.minimum(x, limit) if isinstance(x, np.ndarray) else min(x, limit)


def power_of_two(k: Number) -> Number:
    """The power 2ᵏ for a whole number k in [−1022, 0]."""
    return np.ldexp(1.0, k.astype(np.int32)) if isinstance(k, np.ndarray) else math.ldexp(1.0, int(k))
