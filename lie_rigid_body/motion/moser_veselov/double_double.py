"""Double-double arithmetic on single numbers: unevaluated sums hi + lo of two doubles, about 32 digits.

For numbers of ordinary size only: all that it is used on is scaled to order 1.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224.
"""

from __future__ import annotations

import math
from typing import Final, TypeAlias

from lie_rigid_body.compilation import kernel

Pair: TypeAlias = tuple[float, float]

_SPLITTER: Final = 134217729.0  # 2²⁷ + 1


@kernel
def two_sum(a: float, b: float) -> Pair:
    """Exactly a + b (D. E. Knuth, The Art of Computer Programming, vol. 2, sec. 4.2.2, theorem B)."""
    hi = a + b
    shadow = hi - a
    return hi, (a - (hi - shadow)) + (b - shadow)


@kernel
def fast_two_sum(a: float, b: float) -> Pair:
    """Exactly a + b, for |a| ≥ |b| or a = 0 (Dekker 1971)."""
    hi = a + b
    return hi, b - (hi - a)


@kernel
def two_product(a: float, b: float) -> Pair:
    """Exactly a·b, while no part overflows or underflows (Dekker 1971)."""
    hi = a * b
    scaled = _SPLITTER * a
    ah = scaled - (scaled - a)
    al = a - ah
    scaled = _SPLITTER * b
    bh = scaled - (scaled - b)
    bl = b - bh
    return hi, ((ah * bh - hi) + ah * bl + al * bh) + al * bl


@kernel
def add(a: Pair, b: Pair) -> Pair:
    """The sum a + b, to 2⁻¹⁰⁴ of the larger."""
    hi, lo = two_sum(a[0], b[0])
    return fast_two_sum(hi, lo + (a[1] + b[1]))


@kernel
def subtract(a: Pair, b: Pair) -> Pair:
    """The difference a − b, to 2⁻¹⁰⁴ of the larger."""
    hi, lo = two_sum(a[0], -b[0])
    return fast_two_sum(hi, lo + (a[1] - b[1]))


@kernel
def multiply(a: Pair, b: Pair) -> Pair:
    """The product a·b, to 2⁻¹⁰² of itself."""
    first, error = two_product(a[0], b[0])
    rest = error + (a[0] * b[1] + a[1] * b[0])
    hi = first + rest
    return hi, rest - (hi - first)


@kernel
def divide(a: Pair, b: Pair) -> Pair:
    """The quotient a/b, to 2⁻¹⁰⁰ of itself: one Newton step on the quotient of doubles."""
    first = a[0] / b[0]
    rest = subtract(a, multiply((first, 0.0), b))
    return fast_two_sum(first, rest[0] / b[0])


@kernel
def square_root(a: Pair) -> Pair:
    """√a of a positive number, to 2⁻¹⁰⁰ of itself: one Newton step on the root of a double."""
    first = math.sqrt(a[0])
    rest = subtract(a, two_product(first, first))
    return fast_two_sum(first, 0.5 * rest[0] / first)
