"""Elliptic integrals in double-double by Landen's transformation, in a number of steps that is known beforehand.

One step takes two numbers a ≥ b to their arithmetic and geometric means (DLMF 19.8.1). All that is needed of them is
their gap d = (a − b)/(a + b). As ab = ¼(a + b)² (1 − d²), the geometric mean over the arithmetic one is 1 − e with
e = 1 − √(1 − d²), and the next gap e/(2 − e), about d²/4. The gap is carried in double-double as long as it is large,
and in doubles from there.

References
----------
NIST Digital Library of Mathematical Functions (DLMF), https://dlmf.nist.gov, sections 19.8 and 22.7.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.decimals import PI, working_precision
from lie_rigid_body.arithmetic.double_double import (
    ONE,
    ZERO,
    DoubleDouble,
    add,
    choose,
    divide,
    from_decimal,
    multiply,
    scaled,
    square_root,
    subtract,
)
from lie_rigid_body.arithmetic.elementary import arctangent
from lie_rigid_body.arithmetic.numbers import Number, sqrt

_TWO: Final[DoubleDouble] = (2.0, 0.0)
with working_precision(40):
    _HALF_PI: Final = from_decimal(PI / 2)


class ArithmeticGeometricMean(NamedTuple):
    """The arithmetic-geometric mean of two numbers a ≥ b, and the steps that lead to it.

    Attributes
    ----------
    gaps, shortfalls : list of DoubleDouble
        d and e before each step. In all further steps both are below 1e-20.
    factor : DoubleDouble
        The mean over ½(a + b).
    """

    gaps: list[DoubleDouble]
    shortfalls: list[DoubleDouble]
    factor: DoubleDouble

    @classmethod
    def of(cls, gap: DoubleDouble, steps: int) -> ArithmeticGeometricMean:
        """The mean from a first gap: so many steps in double-double, after which d < 2e-5, and two in doubles."""
        gaps, shortfalls, factor = [], [], ONE
        for _ in range(steps):
            e = subtract(ONE, square_root(subtract(ONE, multiply(gap, gap))))
            rest = subtract(_TWO, e)
            gaps.append(gap)
            shortfalls.append(e)
            # the next arithmetic mean over this one is 1 − ½e
            factor = multiply(factor, scaled(rest, 0.5))
            gap = divide(e, rest)
        # the mean of 1 + d and 1 − d is 1 − d²/4 − 5d⁴/64 − …
        hi, lo = multiply(gap, gap)
        factor = multiply(factor, subtract(ONE, (0.25 * hi, 0.25 * lo + 0.078125 * hi * hi)))
        for _ in range(2):
            # 1 − √(1 − d²) = d²/2 + d⁴/8 + d⁶/16 + …
            square = gap[0] * gap[0]
            shortfall = square * (0.5 + square * (0.125 + 0.0625 * square))
            gaps.append((gap[0], 0.0))
            shortfalls.append((shortfall, 0.0))
            gap = shortfall / (2.0 - shortfall), 0.0
        return cls(gaps, shortfalls, factor)


def third_kind_sum(ratio: DoubleDouble, shortfalls: Sequence[DoubleDouble], steps: int) -> DoubleDouble:
    """The sum ΣQ of DLMF 19.8.6 from the first ε = (p² − ab)/(p² + ab) of 19.8.7.

    Each Q is ½ε times the one before. As p² = ab (1 + ε)/(1 − ε), one step takes ε to (ε² − e)/(2 − e − ε²).

    Parameters
    ----------
    ratio : DoubleDouble
        The first ε.
    shortfalls : sequence of DoubleDouble
        Values of the mean of 1 and k′.
    steps : int
        Number of steps in double-double; two more are taken in doubles.
    """
    term = total = ONE
    padded = [*shortfalls, *[ZERO] * steps]
    for e in padded[:steps]:
        term = scaled(multiply(term, ratio), 0.5)
        total = add(total, term)
        square = multiply(ratio, ratio)
        ratio = divide(subtract(square, e), subtract(subtract(_TWO, e), square))
    first = ratio[0]
    second = _next_ratio(first, padded[steps][0])
    third = _next_ratio(second, padded[steps + 1][0])
    return add(total, (term[0] * (0.5 * first * (1.0 + 0.5 * second * (1.0 + 0.5 * third))), 0.0))


def _next_ratio(ratio: Number, shortfall: Number) -> Number:
    square = ratio * ratio
    return (square - shortfall) / (2.0 - shortfall - square)


def phase_squares(
    sine_square: DoubleDouble, cosine_square: DoubleDouble, gaps: Sequence[DoubleDouble], steps: int
) -> tuple[DoubleDouble, DoubleDouble]:
    """The squares of sine and cosine of πu/2K from sn²u and cn²u, all in proportion.

    From one modulus k to the next, u/K stays what it is and sn²/cn² changes by (dn + k′)/((1 + d)(1 + dn)). Here k′ =
    b/a = (1 − d)/(1 + d) (DLMF 22.7.2-22.7.4; d is their k₁). With k = 0 in the end, sn is the sine.

    Parameters
    ----------
    sine_square, cosine_square : DoubleDouble
        Not negative, not both 0.
    gaps : sequence of DoubleDouble
        Values of the mean of 1 and k′.
    steps : int
        Number of steps in double-double. The others are taken in doubles, for which the gap should be below 0.2.
    """
    s, c = sine_square, cosine_square
    for d in gaps[:steps]:
        k = divide(subtract(ONE, d), add(ONE, d))
        # dn² = (cn² + k′² sn²)/(cn² + sn²)
        dn = square_root(divide(add(c, multiply(multiply(k, k), s)), add(c, s)))
        s = multiply(s, divide(add(dn, k), multiply(add(ONE, d), add(ONE, dn))))
    # the share of sn²/cn² that is lost, for it is small: 1 − (dn + k′)/((1 + d)(1 + dn))
    loss: Number = 0.0
    for gap, _ in gaps[steps:]:
        sine, ratio = s[0] * (1.0 - loss), (1.0 - gap) / (1.0 + gap)
        dn_double = sqrt((c[0] + ratio * ratio * sine) / (c[0] + sine))
        part = gap * (2.0 + ratio + dn_double) / ((1.0 + gap) * (1.0 + dn_double))
        loss = loss + part - loss * part
    return add(s, (-s[0] * loss, 0.0)), c


def angle(sine_square: DoubleDouble, cosine_square: DoubleDouble) -> DoubleDouble:
    """The angle in [0, ½π] from the squares of its sine and its cosine, in proportion."""
    steep = sine_square[0] > cosine_square[0]
    ratio = divide(choose(steep, cosine_square, sine_square), choose(steep, sine_square, cosine_square))
    slope = arctangent(square_root(ratio))
    return choose(steep, subtract(_HALF_PI, slope), slope)


def imaginary_phase(inverse_square: DoubleDouble, gaps: Sequence[DoubleDouble]) -> Number:
    """1/sinh(πa/2K) from 1/sc²(a|m1), for a ≤ ½K′, in doubles: the steps of `phase_squares` for an imaginary argument.

    sn²(ia|m) = −sc²(a|m1) goes to −sinh². From sn = (1 + d) sn₁/(1 + d sn₁²) (DLMF 22.7.2), one step takes r = 1/sc² to
    r (1 + x)² with x = d + 2d/(r (1 + d + √((1 + d)² + 4d/r))).
    """
    square = inverse_square[0]
    # the product of 1 + x, less 1, for it is small
    growth: Number = 0.0
    for d, _ in gaps:
        stretch = 1.0 + d
        part = d + 2.0 * d / (square * (stretch + sqrt(stretch * stretch + 4.0 * d / square)))
        growth = growth + part + growth * part
        square = square * ((1.0 + part) * (1.0 + part))
    value = square_root(inverse_square)
    return value[0] + (value[1] + value[0] * growth)


def nome(gap: Number) -> Number:
    """The nome exp(−πK′/K) from the first gap of the mean of 1 and k′, at most 0.18 (DLMF 19.5.6).

    Its series is in λ = ½ (1 − √k′)/(1 + √k′) = ½ d/(1 + √(1 − d²)), with the nome λ + 2λ⁵ + 15λ⁹ + 150λ¹³ + ….
    """
    half = 0.5 * gap / (1.0 + sqrt(1.0 - gap * gap))
    power = (half * half) * (half * half)
    return half * (1.0 + power * (2.0 + power * (15.0 + 150.0 * power)))
