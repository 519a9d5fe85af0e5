"""Sine, cosine and exponential by sums and products alone.

Libraries of mathematics differ in the last bit. These have the same bits for floats and for arrays.
"""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Any, Final

from lie_rigid_body.arithmetic.decimals import PI, working_precision
from lie_rigid_body.arithmetic.double_double import DoubleDouble, fast_two_sum, split
from lie_rigid_body.arithmetic.numbers import Number, at_most, magnitude, nearest, power_of_two

# 2π, its first 26 bits, and the rest
with working_precision(40):  # whatever is in force where the module is imported
    _RADIANS: Final = float(2 * PI)
    _RADIANS_HI: Final = split(_RADIANS)[0]
    _RADIANS_LO: Final = float(2 * PI - Decimal(float(_RADIANS_HI)))

# Taylor's coefficients, up to 1/17!: on an eighth of a turn the next terms are below 1e-19
_S3, _S5, _S7, _S9, _S11, _S13, _S15, _S17 = ((-1.0) ** k / math.factorial(2 * k + 1) for k in range(1, 9))
_C4, _C6, _C8, _C10, _C12, _C14, _C16 = ((-1.0) ** k / math.factorial(2 * k) for k in range(2, 9))

# ln 2, and as the sum of a number of few bits and another
_LN2: Final = math.log(2.0)
_LN2_HI: Final = 0.693359375
with working_precision(40):
    _LN2_LO: Final = float(Decimal(2).ln() - Decimal(_LN2_HI))

_MAX_EXPONENT: Final = 800.0
"""Largest x of exp(−x) that is used: exp(−800) is 0 in doubles."""

# Taylor's coefficients of the exponential: on ½ ln 2 the next term is below 5e-18
_E: Final = tuple(1.0 / math.factorial(k) for k in range(14))
_E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12, _E13 = _E[2:]


def sine_cosine(turns: DoubleDouble) -> tuple[Number, Number]:
    """The sine and the cosine of an angle of at most ½ turn, each to less than one unit in the last place.

    Where one of them is 0 but for round-off of the turns, it has no relative accuracy.
    """
    quarters = nearest(4.0 * turns[0])
    # exact: what is left of a whole quarter turn
    rest = turns[0] - 0.25 * quarters
    angle = radians(rest, turns[1])
    s, c = sine_cosine_of_small(angle[0], angle[1])
    # the cosine and sine of the quarters: 0, 1 or −1
    size = magnitude(quarters)
    cosine = 1.0 - size
    sine = quarters * (2.0 - size)
    return s * cosine + c * sine, c * cosine - s * sine


def radians(hi: Number, lo: Number) -> DoubleDouble:
    """An angle hi + lo of turns in radians, to some 75 bits."""
    first, second = split(hi)
    # 26 by 26 and 27 by 26 bits: exact
    return fast_two_sum(first * _RADIANS_HI, second * _RADIANS_HI + (hi * _RADIANS_LO + lo * _RADIANS))


def sine_cosine_of_small(x: Number, rest: Number) -> tuple[Number, Number]:
    """The sine and cosine of an angle x + rest, rad, of at most ¼π."""
    z = x * x
    w = z * z
    # sin x = x + x z odd, cos x = 1 − ½z + w even
    odd = ((_S3 + z * _S5) + w * (_S7 + z * _S9)) + (w * w) * ((_S11 + z * _S13) + w * (_S15 + z * _S17))
    even = ((_C4 + z * _C6) + w * (_C8 + z * _C10)) + (w * w) * ((_C12 + z * _C14) + w * _C16)
    half = 0.5 * z
    upper = 1.0 - half
    return x + (x * z * odd + rest * upper), upper + (((1.0 - upper) - half) + (w * even - x * rest))


def exponential(size: Any) -> tuple[Any, Any]:
    """The exponential exp(−x), and exp(−x) − 1, for x ≥ 0, each to a unit in the last place; 0 and −1 beyond 750.

    Parameters
    ----------
    size : number
        x; a decimal has those of its precision.
    """
    if isinstance(size, Decimal):
        decay = (-size).exp()
        return decay, decay - 1
    x = -at_most(size, _MAX_EXPONENT)
    # exp(x) = 2ᵏ exp(r) with |r| ≤ ½ ln 2
    count = nearest(x * (1.0 / _LN2))
    r = (x - count * _LN2_HI) - count * _LN2_LO
    z = r * r
    w = z * z
    low = (_E2 + r * _E3) + z * (_E4 + r * _E5)
    high = ((_E6 + r * _E7) + z * (_E8 + r * _E9)) + w * ((_E10 + r * _E11) + z * (_E12 + r * _E13))
    growth = r + z * (low + w * high)
    # in two factors, as doubles end at 2⁻¹⁰²²
    first = nearest(0.5 * count)
    power = power_of_two(first) * power_of_two(count - first)
    return power + power * growth, (power - 1.0) + power * growth
