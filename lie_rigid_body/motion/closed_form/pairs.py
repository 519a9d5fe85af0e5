"""Double-double arithmetic for the constants of ordinary motions: of one motion in floats, of many in arrays.

A pair (hi, lo) stands for hi + lo, with hi the double nearest to it: about 32 digits. The operations on doubles and
their order are the same for floats and for arrays, and so are the bits. For numbers of ordinary size only: no part of
a product may overflow or underflow.

References
----------
T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18 (1971) 224.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeAlias, cast

import numpy as np

from lie_rigid_body.motion.closed_form.double_double import Number

Pair: TypeAlias = tuple[Number, Number]

ZERO: Final[Pair] = (0.0, 0.0)
ONE: Final[Pair] = (1.0, 0.0)

_SPLITTER: Final = 134217729.0  # 2²⁷ + 1


def add(a: Pair, b: Pair) -> Pair:
    """The sum a + b, to 2⁻¹⁰⁴ of the larger (D. E. Knuth, The Art of Computer Programming, vol. 2, sec. 4.2.2)."""
    ah, al = a
    bh, bl = b
    total = ah + bh
    shadow = total - ah
    rest = (ah - (total - shadow)) + (bh - shadow) + (al + bl)
    hi = total + rest
    return hi, rest - (hi - total)


def subtract(a: Pair, b: Pair) -> Pair:
    """The difference a − b; see `add`."""
    ah, al = a
    bh, bl = b
    total = ah - bh
    shadow = total - ah
    rest = (ah - (total - shadow)) - (bh + shadow) + (al - bl)
    hi = total + rest
    return hi, rest - (hi - total)


def multiply(a: Pair, b: Pair) -> Pair:
    """The product a·b, to 2⁻¹⁰² of itself, with that of the high parts in full (Dekker 1971)."""
    a1, a2 = a
    b1, b2 = b
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


def divide(a: Pair, b: Pair) -> Pair:
    """The quotient a/b, to 2⁻¹⁰⁰ of itself: one Newton step on the quotient of doubles."""
    a1, a2 = a
    b1, b2 = b
    first = a1 / b1
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


def square_root(a: Pair) -> Pair:
    """√a of a number that is not negative, to 2⁻¹⁰⁰ of itself: one Newton step on the root of a double."""
    a1, a2 = a
    first = math.sqrt(a1) if isinstance(a1, float) else np.sqrt(a1)
    scaled = _SPLITTER * first
    ah = scaled - (scaled - first)
    al = first - ah
    back = first * first
    # where a is 0, so is the numerator
    rest = ((a1 - back) - (((ah * ah - back) + 2.0 * ah * al) + al * al) + a2) / (2.0 * first + (first == 0.0))
    hi = first + rest
    return hi, rest - (hi - first)


def times(a: Pair, factor: Number) -> Pair:
    """The product of a pair and ±1, or another power of two."""
    hi, lo = a
    return hi * factor, lo * factor


def root(x: Number) -> Number:
    """√x of a double."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


def size(x: Number) -> Number:
    """|x| of a double."""
    return cast(Number, abs(x))


def each(function: Callable[..., float], *arguments: Number) -> Number:
    """A function of Python's math library, which numpy's own may differ from in the last bit, number by number."""
    if isinstance(arguments[0], float):
        return function(*arguments)
    return np.array([function(*row) for row in zip(*(_list(a) for a in arguments), strict=True)])


def choose(condition: Any, a: Pair, b: Pair) -> Pair:
    """One or the other, number by number."""
    if isinstance(condition, np.ndarray):
        return np.where(condition, a[0], b[0]), np.where(condition, a[1], b[1])
    return a if condition else b


def _list(column: Number) -> list[float]:
    numbers: list[float] = np.asarray(column).tolist()
    return numbers
