"""Sine and cosine of an angle in turns, by sums and products alone.

The same for floats, for arrays and compiled, to the bit; libraries of mathematics differ in the last one.
"""

from __future__ import annotations

import math
from decimal import Decimal
from typing import Final

from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.double_double import DoubleDouble, Number, fast_two_sum, halves, nearest
from lie_rigid_body.motion.closed_form.elementary import magnitude
from lie_rigid_body.motion.closed_form.precision import PI

_RADIANS: Final = float(2 * PI)
_RADIANS_HI: Final = halves(_RADIANS)[0]
_RADIANS_LO: Final = float(2 * PI - Decimal(float(_RADIANS_HI)))
"""2π, its first 26 bits, and the rest."""

_S3, _S5, _S7, _S9, _S11, _S13, _S15, _S17 = ((-1.0) ** k / math.factorial(2 * k + 1) for k in range(1, 9))
_C4, _C6, _C8, _C10, _C12, _C14, _C16 = ((-1.0) ** k / math.factorial(2 * k) for k in range(2, 9))
"""Taylor's, up to 1/17!: on an eighth of a turn the next are below 1e-19."""


@kernel
def sine_cosine(turns: DoubleDouble) -> tuple[Number, Number]:
    """The sine and the cosine of an angle of at most ½ turn, each to less than one unit in the last place.

    Where one of them is 0 but for round-off of the turns, it has no relative accuracy.
    """
    quarters = nearest(4.0 * turns.hi)
    # exact: what is left of a whole quarter turn
    rest = turns.hi - 0.25 * quarters
    angle = radians(rest, turns.lo)
    s, c = sine_cosine_of_small(angle.hi, angle.lo)
    # the cosine and sine of the quarters: 0, 1 or −1
    size = magnitude(quarters)
    cosine, sine = 1.0 - size, quarters * (2.0 - size)
    return s * cosine + c * sine, c * cosine - s * sine


@kernel
def radians(hi: Number, lo: Number) -> DoubleDouble:
    """An angle hi + lo of turns in radians, to some 75 bits."""
    first, second = halves(hi)
    # 26 by 26 and 27 by 26 bits: exact
    return fast_two_sum(first * _RADIANS_HI, second * _RADIANS_HI + (hi * _RADIANS_LO + lo * _RADIANS))


@kernel
def sine_cosine_of_small(x: Number, rest: Number) -> tuple[Number, Number]:
    """The sine and cosine of an angle x + rest, rad, of at most ¼π."""
    z = x * x
    w = z * z
    odd = ((_S3 + z * _S5) + w * (_S7 + z * _S9)) + (w * w) * ((_S11 + z * _S13) + w * (_S15 + z * _S17))
    even = ((_C4 + z * _C6) + w * (_C8 + z * _C10)) + (w * w) * ((_C12 + z * _C14) + w * _C16)
    half = 0.5 * z
    upper = 1.0 - half
    return x + (x * z * odd + rest * upper), upper + (((1.0 - upper) - half) + (w * even - x * rest))
