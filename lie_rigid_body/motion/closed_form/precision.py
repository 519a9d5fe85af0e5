"""Decimal arithmetic of many digits and unlimited range, for the constants of a motion that is not ordinary."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from decimal import (
    MAX_EMAX,
    MIN_EMIN,
    ROUND_HALF_EVEN,
    Context,
    Decimal,
    DivisionByZero,
    InvalidOperation,
    Overflow,
    getcontext,
    localcontext,
)
from functools import lru_cache
from typing import Final

DIGITS: Final = 50
"""Decimal digits carried where nothing asks for more: no sum cancels, and time multiplies some rates by 1e10 rad."""

COUPLED_DIGITS: Final = 80
"""Digits carried with products of inertia, where moments may differ by round-off."""

PHASE_DIGITS: Final = 24
"""Digits of what is rounded to a double in the end, or is no rate that time multiplies."""

PI: Final = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534212")


def working_precision(digits: int) -> AbstractContextManager[Context]:
    """A decimal context of this many digits, in force inside a ``with`` block."""
    return localcontext(_context(digits))


@lru_cache(maxsize=16)
def _context(digits: int) -> Context:
    return Context(
        prec=digits,
        rounding=ROUND_HALF_EVEN,
        Emin=MIN_EMIN,
        Emax=MAX_EMAX,
        traps=[DivisionByZero, InvalidOperation, Overflow],
    )


def root(x: Decimal) -> Decimal:
    """√x, cut off beyond the precision in force; integers are faster at it than `Decimal.sqrt`."""
    exponent = x.adjusted() // 2 - getcontext().prec
    return Decimal(math.isqrt(int(x.scaleb(-2 * exponent)))).scaleb(exponent)


def dot(a: tuple[Decimal, ...], b: tuple[Decimal, ...]) -> Decimal:
    """Σ aᵢ bᵢ in the precision in force."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))
