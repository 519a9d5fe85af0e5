"""Functions of one number that are exact or correctly rounded: for floats, for arrays and compiled the same bits."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from lie_rigid_body.compilation import kernel, kernel_of
from lie_rigid_body.motion.closed_form.double_double import Number

_EXPONENT_OF_ONE: Final = 1.5 * 2.0**52 + 1023.0
"""A double whose last bits are those of the exponent of 1."""


@kernel
def magnitude(x: Any) -> Number:
    """The size |x|."""
    size: Number = abs(x)
    return size


@kernel
def sign(x: Any) -> Number:
    """−1 where the number is negative, else 1."""
    side: Number = 1.0 - 2.0 * (x < 0.0)
    return side


def _square_root(x: float) -> float:
    return math.sqrt(x)


@kernel_of(_square_root)
def square_root(x: Number) -> Number:
    """√x."""
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
    """2ᵏ for a whole number in [−1022, 0]."""
    return math.ldexp(1.0, int(k)) if isinstance(k, float) else np.ldexp(1.0, k.astype(np.int32))
