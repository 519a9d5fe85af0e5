"""Decimal arithmetic of many digits and unlimited range, and the axes of a symmetric 3×3 matrix in it.

A principal moment wrong by 1e-16 turns a body by 1e-9 rad in 1e7 s at 1 rad/s: doubles will not do.
"""

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

NANOSECOND: Final = Decimal("1e-9")
"""One nanosecond, s."""


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


def diagonalised(matrix: Sequence[Sequence[float]]) -> tuple[list[Decimal], list[Vector]]:
    """Eigenvalues and unit axes, in the order of the diagonal entries that they came from.

    Plane rotations of at most 45°, each of which makes the largest off-diagonal entry vanish (C. G. J. Jacobi; G. H.
    Golub, C. F. Van Loan, Matrix Computations, 4th ed., sec. 8.5). A rotation changes only the entries it concerns,
    so blocks that are uncoupled stay exactly so.

    Parameters
    ----------
    matrix : 3 rows of 3
        Symmetric positive definite.

    Returns
    -------
    eigenvalues : list of 3 Decimal
    axes : list of 3 vectors
        Of unit length and, in this order, right-handed.
    """
    values = [Decimal(matrix[i][i]) for i in range(3)]
    # the r-th off-diagonal entry couples the two axes other than the r-th
    couplings = [Decimal(matrix[1][2]), Decimal(matrix[2][0]), Decimal(matrix[0][1])]
    one, zero = Decimal(1), Decimal(0)
    axes: list[Vector] = [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
    negligible = Decimal(1).scaleb(-2 * getcontext().prec)
    while True:
        # squares of the couplings, each relative to the diagonal entries of its two axes
        sizes = [couplings[r] ** 2 / (values[r - 2] * values[r - 1]) for r in range(3)]
        r = max(range(3), key=sizes.__getitem__)
        if sizes[r] <= negligible:
            return values, axes
        _decouple(values, couplings, axes, r)


def _decouple(values: list[Decimal], couplings: list[Decimal], axes: list[Vector], r: int) -> None:
    """Turn the two axes other than the r-th so that they are not coupled any more."""
    p, q = (r + 1) % 3, (r + 2) % 3
    double, difference = 2 * couplings[r], values[q] - values[p]
    size = root(double * double + difference * difference)
    tangent = double / (difference + size.copy_sign(difference)) if difference else Decimal(1).copy_sign(double)
    cosine = 1 / root(1 + tangent * tangent)
    sine = tangent * cosine
    change = tangent * couplings[r]
    values[p], values[q] = values[p] - change, values[q] + change
    couplings[r] = Decimal(0)
    couplings[q], couplings[p] = (
        cosine * couplings[q] - sine * couplings[p],
        sine * couplings[q] + cosine * couplings[p],
    )
    (a, b, c), (d, e, f) = axes[p], axes[q]
    axes[p] = cosine * a - sine * d, cosine * b - sine * e, cosine * c - sine * f
    axes[q] = sine * a + cosine * d, sine * b + cosine * e, sine * c + cosine * f
