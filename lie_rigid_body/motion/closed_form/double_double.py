"""Double-double arithmetic on arrays: unevaluated sums hi + lo of two doubles, about 32 digits.

Elementwise and branch-free, so a batch gives the bits of its rows. Needs round-to-nearest and no contraction of
a·b + c into one operation, both of which numpy keeps.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Final, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Number: TypeAlias = float | Array
"""A constant of one motion; of many motions in a `Stack`, their column of shape (B, 1)."""

_SPLITTER: Final = 134217729.0  # 2²⁷ + 1


class DoubleDouble(NamedTuple):
    """The number hi + lo, with hi the double nearest to it. Parts are arrays of one shape, or scalars."""

    hi: Array
    lo: Array


def from_decimal(value: Decimal) -> DoubleDouble:
    """A decimal number, rounded to a scalar double-double."""
    hi = float(value)
    return of_parts((hi, float(value - Decimal(hi))))


def of_parts(parts: tuple[Number, Number]) -> DoubleDouble:
    """The double-double of these parts, both scalars or both columns."""
    hi, lo = parts
    return DoubleDouble(cast(Array, hi), cast(Array, lo))


def from_integers(values: NDArray[np.int64]) -> DoubleDouble:
    """64-bit integers, exactly."""
    low = values & 0xFFFFFFFF
    return fast_two_sum((values - low).astype(np.float64), low.astype(np.float64))


def fast_two_sum(a: Array, b: Array) -> DoubleDouble:
    """Exactly a + b, for |a| ≥ |b| or a = 0 (Dekker 1971)."""
    hi = a + b
    return DoubleDouble(hi, b - (hi - a))


def two_sum(a: Array, b: Array) -> DoubleDouble:
    """Exactly a + b (D. E. Knuth, The Art of Computer Programming, vol. 2, sec. 4.2.2, theorem B)."""
    hi = a + b
    shadow = hi - a
    return DoubleDouble(hi, (a - (hi - shadow)) + (b - shadow))


def _halves(a: Array) -> tuple[Array, Array]:
    """The number a as a sum of two doubles of 26 bits, whose products are exact."""
    scaled = _SPLITTER * a
    hi = scaled - (scaled - a)
    return hi, a - hi


def two_product(a: Array, b: Array) -> DoubleDouble:
    """Exactly a·b, while no part overflows or underflows (Dekker 1971)."""
    hi = np.asarray(a * b)
    (ah, al), (bh, bl) = _halves(a), _halves(b)
    return DoubleDouble(hi, np.asarray(((ah * bh - hi) + ah * bl + al * bh) + al * bl))


def add(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The sum a + b, to 2⁻¹⁰⁴ of the larger."""
    hi, lo = two_sum(a.hi, b.hi)
    return fast_two_sum(hi, lo + (a.lo + b.lo))


def multiply(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble:
    """The product a·b, to 2⁻¹⁰² of itself."""
    hi, lo = two_product(a.hi, b.hi)
    return fast_two_sum(hi, lo + (a.hi * b.lo + a.lo * b.hi))


def remainder(a: DoubleDouble) -> DoubleDouble:
    """The number a minus its nearest integer: in [−½, ½], but for round-off."""
    hi = a.hi - np.rint(a.hi)
    hi, lo = two_sum(hi, a.lo)
    # beyond 2⁵³ the first step leaves an integer in the low part
    return fast_two_sum(hi - np.rint(hi), lo)
