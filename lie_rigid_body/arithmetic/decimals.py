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

Tensor: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
"""A symmetric tensor: 3 rows of 3."""

PrincipalAxes: TypeAlias = tuple[Vector, tuple[Vector, Vector, Vector]]
"""Eigenvalues of a tensor and their unit axes."""

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


def sine_cosine_of_turns(turns: Decimal) -> tuple[Decimal, Decimal]:
    """The sine and cosine of an angle in the precision in force, by Taylor's series on an eighth of a turn."""
    quarters = (4 * turns).to_integral_value()
    x = 2 * PI * (turns - quarters / 4)
    square = -x * x
    negligible = Decimal(1).scaleb(-getcontext().prec)
    sine = term = x
    cosine = Decimal(1)
    power = 1
    while abs(term) > negligible:
        even = term * -x / (power + 1)
        power += 2
        term = term * square / (power * (power - 1))
        cosine += even
        sine += term
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[int(quarters) % 4]


@lru_cache(maxsize=64)
def diagonalised(matrix: Tensor, digits: int) -> PrincipalAxes:
    """Eigenvalues and unit axes, in the order of the diagonal entries that they came from; kept for the next call.

    Plane rotations of at most 45°, each of which makes the largest off-diagonal entry vanish (C. G. J. Jacobi; G. H.
    Golub, C. F. Van Loan, Matrix Computations, 4th ed., sec. 8.5). A rotation changes only the entries it concerns,
    so blocks that are uncoupled stay exactly so.

    Parameters
    ----------
    matrix : 3 rows of 3
        Symmetric positive definite.
    digits : int
        Decimal digits of the arithmetic.

    Returns
    -------
    eigenvalues : tuple of 3 Decimal
    axes : tuple of 3 vectors
        Of unit length and, in this order, right-handed.
    """
    with working_precision(digits):
        values = [Decimal(matrix[i][i]) for i in range(3)]
        # the r-th off-diagonal entry couples the two axes other than the r-th
        couplings = [Decimal(matrix[1][2]), Decimal(matrix[2][0]), Decimal(matrix[0][1])]
        one = Decimal(1)
        zero = Decimal(0)
        axes: list[Vector] = [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
        negligible = one.scaleb(-2 * digits)
        while True:
            # squares of the couplings, each relative to the diagonal entries of its two axes
            sizes = [couplings[r] ** 2 / (values[r - 2] * values[r - 1]) for r in range(3)]
            r = max(range(3), key=sizes.__getitem__)
            if sizes[r] <= negligible:
                return (values[0], values[1], values[2]), (axes[0], axes[1], axes[2])
            _decouple(values, couplings, axes, r)


def _decouple(values: list[Decimal], couplings: list[Decimal], axes: list[Vector], r: int) -> None:
    """Turn the two axes other than the r-th so that they are not coupled any more."""
    p = (r + 1) % 3
    q = (r + 2) % 3
    double = 2 * couplings[r]
    difference = values[q] - values[p]
    size = root(double * double + difference * difference)
    tangent = double / (difference + size.copy_sign(difference)) if difference else Decimal(1).copy_sign(double)
    cosine = 1 / root(1 + tangent * tangent)
    sine = tangent * cosine
    values[p] -= tangent * couplings[r]
    values[q] += tangent * couplings[r]
    couplings[r] = Decimal(0)
    coupling = couplings[q]
    couplings[q] = cosine * coupling - sine * couplings[p]
    couplings[p] = sine * coupling + cosine * couplings[p]
    rotated = [(cosine * x - sine * y, sine * x + cosine * y) for x, y in zip(axes[p], axes[q], strict=True)]
    (a, d), (b, e), (c, f) = rotated
    axes[p] = (a, b, c)
    axes[q] = (d, e, f)
