"""Double-double arithmetic: unevaluated sums hi + lo of two doubles, about 32 digits.

On floats, on arrays and compiled, with the same operations in the same order and so the same bits. Needs
round-to-nearest and no contraction of a·b + c into one operation.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.compilation import kernel

Array = NDArray[np.float64]

Number: TypeAlias = float | Array
"""A constant of one motion; of many, their column."""

_SPLITTER: Final = 134217729.0  # 2²⁷ + 1


_WHOLE: Final = 1.5 * 2.0**52
_COARSE: Final = 1.5 * 2.0**64
"""Numbers so large that added to a smaller one they leave whole multiples of 1 and of 2¹²."""


class DoubleDouble(NamedTuple):
    """The number hi + lo, with hi the double nearest to it. Parts are floats, or arrays of one shape."""

    hi: Number
    lo: Number


def from_decimal(value: Decimal) -> DoubleDouble:
    """A decimal number, rounded to a double-double of floats."""
    hi = float(value)
    return DoubleDouble(hi, float(value - Decimal(hi)))


def of_parts(parts: tuple[Number, Number]) -> DoubleDouble:
    """The double-double of these parts, both scalars or both columns."""
    hi, lo = parts
    return DoubleDouble(hi, lo)


def from_integers(values: NDArray[np.int64]) -> DoubleDouble:
    """64-bit integers, exactly."""
    low = values & 0xFFFFFFFF
    return fast_two_sum((values - low).astype(np.float64), low.astype(np.float64))


@kernel
def from_integer(value: int) -> DoubleDouble:
    """One 64-bit integer, exactly."""
    low = value & 0xFFFFFFFF
    return fast_two_sum(float(value - low), float(low))


@kernel
def fast_two_sum(a: Number, b: Number) -> DoubleDouble:
    """Exactly a + b, for |a| ≥ |b| or a = 0 (Dekker 1971)."""
    hi = a + b
    return DoubleDouble(hi, b - (hi - a))


@kernel
def two_sum(a: Number, b: Number) -> DoubleDouble:
    """Exactly a + b (D. E. Knuth, The Art of Computer Programming, vol. 2, sec. 4.2.2, theorem B)."""
    hi = a + b
    shadow = hi - a
    return DoubleDouble(hi, (a - (hi - shadow)) + (b - shadow))


@kernel
def halves(a: Number) -> tuple[Number, Number]:
    """The number a as a sum of two doubles of 26 bits, whose products are exact."""
    scaled = _SPLITTER * a
    hi = scaled - (scaled - a)
    return hi, a - hi


@kernel
def two_product(a: Number, b: Number) -> DoubleDouble:
    """Exactly a·b, while no part overflows or underflows (Dekker 1971)."""
    hi = a * b
    ah, al = halves(a)
    bh, bl = halves(b)
    return DoubleDouble(hi, ((ah * bh - hi) + ah * bl + al * bh) + al * bl)


@kernel
def add(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The sum a + b, to 2⁻¹⁰⁴ of the larger."""
    hi, lo = two_sum(a.hi, b.hi)
    return fast_two_sum(hi, lo + (a.lo + b.lo))


@kernel
def multiply(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The product a·b, to 2⁻¹⁰² of itself."""
    hi, lo = two_product(a.hi, b.hi)
    return fast_two_sum(hi, lo + (a.hi * b.lo + a.lo * b.hi))


@kernel
def nearest(x: Number) -> Number:
    """The integer nearest to a number of at most 2⁵¹, the even one of two."""
    return (x + _WHOLE) - _WHOLE


@kernel
def remainder(a: DoubleDouble) -> DoubleDouble:
    """The number a, of at most 2⁶³, minus its nearest integer: in [−½, ½], but for round-off."""
    # what is beyond 2⁵¹ goes first
    hi, lo = two_sum(a.hi - ((a.hi + _COARSE) - _COARSE), a.lo)
    return fast_two_sum(hi - nearest(hi), lo)
