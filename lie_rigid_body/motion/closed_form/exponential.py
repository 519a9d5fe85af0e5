"""The exponential of numbers that are not positive, by sums and products alone; see `sine`."""

from __future__ import annotations

import math
from decimal import Context, Decimal
from typing import Final

from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.double_double import Number, nearest
from lie_rigid_body.motion.closed_form.elementary import at_most, power_of_two

_LN2: Final = math.log(2.0)
_LN2_HI: Final = 0.693359375
_LN2_LO: Final = float(Context(prec=40).ln(2) - Decimal(_LN2_HI))
"""ln 2, and as the sum of a number of few bits and another."""

_FARTHEST: Final = 800.0
"""exp(−800) is 0 in doubles."""

_E: Final = tuple(1.0 / math.factorial(k) for k in range(14))
_E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12, _E13 = _E[2:]
"""Taylor's: on ½ ln 2 the next is below 5e-18."""


@kernel
def exponential(size: Number) -> tuple[Number, Number]:
    """exp(−x) and exp(−x) − 1 for x ≥ 0, each to a unit in the last place; 0 and −1 beyond 750.

    Parameters
    ----------
    size : number
        x.
    """
    x = -at_most(size, _FARTHEST)
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
