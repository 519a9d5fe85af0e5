"""Decimal arithmetic of many digits and unlimited range."""

from __future__ import annotations

import math
from collections.abc import Sequence
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
from typing import Final, TypeAlias

Vector: TypeAlias = tuple[Decimal, Decimal, Decimal]

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
    """The square root √x, cut off beyond the precision in force; integers are faster than `Decimal.sqrt`."""
    exponent = x.adjusted() // 2 - getcontext().prec
    return Decimal(math.isqrt(int(x.scaleb(-2 * exponent)))).scaleb(exponent)


def dot(a: Sequence[Decimal], b: Sequence[Decimal]) -> Decimal:
    """The scalar product Σ aᵢ bᵢ in the precision in force."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))
