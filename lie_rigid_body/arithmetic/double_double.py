"""Double-double arithmetic: a pair (hi, lo) stands for hi + lo, with hi the double nearest to it, about 32 digits.

The parts are floats, or arrays of one shape with an element for each of many times. On floats, on arrays and compiled
the operations are the same in the same order, and so are the bits. This needs rounding to nearest, no contraction of
a·b + c into one operation, and numbers of ordinary size: no part of a product may overflow or underflow.

What stands for `two_product` in `multiply`, `divide` and `square_root` is written out in them: in plain Python a call
costs as much as the arithmetic.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224.
D. E. Knuth, The Art of Computer Programming, vol. 2, 3rd ed., sec. 4.2.2.
"""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.arithmetic.numbers import Number, nearest
from lie_rigid_body.compilation import kernel
from lie_rigid_body.foundation.arrays import Integers

DoubleDouble: TypeAlias = tuple[Number, Number]

ZERO: Final[DoubleDouble] = (0.0, 0.0)
ONE: Final[DoubleDouble] = (1.0, 0.0)

_SPLITTER: Final = 134217729.0  # 2²⁷ + 1

_COARSE: Final = 1.5 * 2.0**64
"""Constant 1.5·2⁶⁴: adding it to a double and subtracting it again rounds to a multiple of 2¹²."""


def from_decimal(value: Decimal) -> tuple[float, float]:
    """A decimal number, rounded to a double-double of floats."""
    hi = float(value)
    return hi, float(value - Decimal(hi))


def from_integers(values: Integers) -> DoubleDouble:
    """The double-doubles of 64-bit integers, exactly."""
    low = values & 0xFFFFFFFF
    return fast_two_sum((values - low).astype(np.float64), low.astype(np.float64))


@kernel
def from_integer(value: int) -> DoubleDouble:
    """The double-double of one 64-bit integer, exactly."""
    low = value & 0xFFFFFFFF
    return fast_two_sum(float(value - low), float(low))


@kernel
def fast_two_sum(a: Number, b: Number) -> DoubleDouble:
    """The sum a + b, exactly, for |a| ≥ |b| or a = 0 (Dekker 1971)."""
    hi = a + b
    return hi, b - (hi - a)


@kernel
def two_sum(a: Number, b: Number) -> DoubleDouble:
    """The sum a + b, exactly (Knuth, theorem B)."""
    hi = a + b
    shadow = hi - a
    return hi, (a - (hi - shadow)) + (b - shadow)


@kernel
def split(a: Number) -> DoubleDouble:
    """The number a as a sum of two doubles of 26 bits, whose products are exact (Dekker 1971)."""
    scaled = _SPLITTER * a
    hi = scaled - (scaled - a)
    return hi, a - hi


@kernel
def two_product(a: Number, b: Number) -> DoubleDouble:
    """Exactly a·b (Dekker 1971)."""
    hi = a * b
    ah, al = split(a)
    bh, bl = split(b)
    return hi, ((ah * bh - hi) + ah * bl + al * bh) + al * bl


@kernel
def add(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The sum a + b, to 2⁻¹⁰⁴ of the larger."""
    ah, al = a
    bh, bl = b
    total = ah + bh
    shadow = total - ah
    rest = (ah - (total - shadow)) + (bh - shadow) + (al + bl)
    hi = total + rest
    return hi, rest - (hi - total)


@kernel
def subtract(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The difference a − b, to 2⁻¹⁰⁴ of the larger."""
    return add(a, (-b[0], -b[1]))


@kernel
def multiply(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The product a·b, to 2⁻¹⁰² of itself."""
    a1, a2 = a
    b1, b2 = b
    # first + rest is a1·b1 exactly, and the two products that are left of a·b
    first = a1 * b1
    scaled = _SPLITTER * a1
    ah = scaled - (scaled - a1)
    al = a1 - ah
    scaled = _SPLITTER * b1
    bh = scaled - (scaled - b1)
    bl = b1 - bh
    rest = ((ah * bh - first) + ah * bl + al * bh) + al * bl + (a1 * b2 + a2 * b1)
    hi = first + rest
    return hi, rest - (hi - first)


@kernel
def divide(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The quotient a/b, to 2⁻¹⁰⁰ of itself: one Newton step on the quotient of doubles."""
    a1, a2 = a
    b1, b2 = b
    first = a1 / b1
    # a − first·b over b1, with first·b1 exactly
    scaled = _SPLITTER * first
    ah = scaled - (scaled - first)
    al = first - ah
    scaled = _SPLITTER * b1
    bh = scaled - (scaled - b1)
    bl = b1 - bh
    back = first * b1
    rest = ((a1 - back) - (((ah * bh - back) + ah * bl + al * bh) + al * bl) + a2 - first * b2) / b1
    hi = first + rest
    return hi, rest - (hi - first)


@kernel
def square_root(a: DoubleDouble) -> DoubleDouble:
    """The root √a of a number that is not negative, to 2⁻¹⁰⁰ of itself: one Newton step on the root of a double."""
    a1, a2 = a
    first = math.sqrt(a1)
    # a − first² over 2·first, with first² exactly
    scaled = _SPLITTER * first
    ah = scaled - (scaled - first)
    al = first - ah
    back = first * first
    # where a is 0, so is the numerator
    rest = ((a1 - back) - (((ah * ah - back) + 2.0 * ah * al) + al * al) + a2) / (2.0 * first + (first == 0.0))
    hi = first + rest
    return hi, rest - (hi - first)


@kernel
def scaled(a: DoubleDouble, factor: Number) -> DoubleDouble:
    """The product of a number and ±1, or another power of two."""
    hi, lo = a
    return hi * factor, lo * factor


def remainder(a: DoubleDouble) -> DoubleDouble:
    """The number a, of at most 2⁶³, minus its nearest integer: in [−½, ½], but for round-off."""
    # what is beyond 2⁵¹ goes first
    hi, lo = two_sum(a[0] - ((a[0] + _COARSE) - _COARSE), a[1])
    return fast_two_sum(hi - nearest(hi), lo)
