"""One Moser–Veselov step, with the state carried in double-double and its increments reckoned in doubles.

An increment is a small part of the state, so its own rounding is a small part of the state's; what would repeat from
step to step, the rounding of constants, is compensated by their lo parts. The errors that remain are as good as
random.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.moser_veselov.double_double import Pair, fast_two_sum, two_product, two_sum

Three: TypeAlias = tuple[Pair, Pair, Pair]
Four: TypeAlias = tuple[Pair, Pair, Pair, Pair]


@kernel
def increased(value: Pair, hi: float, lo: float) -> Pair:
    """A value with an increment added, given as a double and a smaller one that it lacks."""
    total, error = two_sum(value[0], hi)
    return two_sum(total, value[1] + (error + lo))


@kernel
def moved_momentum(n: Three, step: Any, at: int) -> Three:
    """The momentum after a step, by the addition theorems of `step_constants`, whose results begin at a place."""
    (a, a_lo), (b, b_lo), (c, c_lo) = n
    bc, ca, ab = b * c, c * a, a * b
    # an axis about which the momentum circles leaves them constant, and what is left out would add up
    bc_lo, ca_lo, ab_lo = b * c_lo + b_lo * c, c * a_lo + c_lo * a, a * b_lo + a_lo * b
    k, k_lo = step[at + 12] * (b * b), step[at + 13] * (b * b)
    # 1/D − 1; not 1/D, which is rounded upwards more often than not where it is near to 1
    g = k / (1.0 - k)
    s1, s2, s3 = step[at] + k, step[at + 2] + k, step[at + 4] + k
    f1, f2, f3 = step[at + 6], step[at + 8], step[at + 10]
    lo1 = (a * (step[at + 1] + k_lo) + s1 * a_lo) + (step[at + 7] * bc + f1 * bc_lo)
    lo2 = (b * (step[at + 3] + k_lo) + s2 * b_lo) + (step[at + 9] * ca + f2 * ca_lo)
    lo3 = (c * (step[at + 5] + k_lo) + s3 * c_lo) + (step[at + 11] * ab + f3 * ab_lo)
    hi1, hi2, hi3 = f1 * bc, f2 * ca, f3 * ab
    t1, t2, t3 = a * s1, b * s2, c * s3
    return (
        increased(n[0], hi1, (t1 + g * (hi1 + t1)) + lo1 * (1.0 + g)),
        increased(n[1], hi2, (t2 + g * (hi2 + t2)) + lo2 * (1.0 + g)),
        increased(n[2], hi3, (t3 + g * (hi3 + t3)) + lo3 * (1.0 + g)),
    )


@kernel
def scaled_sum(before: Pair, after: Pair, hi: float, lo: float) -> Pair:
    """ρ₀ρⱼ = ½dⱼ (nⱼ + nⱼ⁺), not normalised."""
    total, error = two_sum(before[0], after[0])
    product, rest = two_product(total, hi)
    return product, rest + (hi * (error + (before[1] + after[1])) + lo * total)


@kernel
def step_rotation(before: Three, after: Three, step: Any, at: int) -> tuple[Pair, Pair, Pair, float]:
    """The vector part ρ of the step's quaternion, and 1 − ρ₀."""
    v1 = scaled_sum(before[0], after[0], step[at + 14], step[at + 15])
    v2 = scaled_sum(before[1], after[1], step[at + 16], step[at + 17])
    v3 = scaled_sum(before[2], after[2], step[at + 18], step[at + 19])
    s = v1[0] * v1[0] + v2[0] * v2[0] + v3[0] * v3[0]
    square = 0.5 + 0.5 * math.sqrt(1.0 - 4.0 * s)
    scalar = math.sqrt(square)
    # 1/ρ₀ − 1
    excess = s / (square * (scalar + square))
    r1, r2, r3 = (
        fast_two_sum(v1[0], v1[0] * excess),
        fast_two_sum(v2[0], v2[0] * excess),
        fast_two_sum(v3[0], v3[0] * excess),
    )
    return (r1[0], r1[1] + v1[1]), (r2[0], r2[1] + v2[1]), (r3[0], r3[1] + v3[1]), excess * scalar


@kernel
def turned(q: Four, r: tuple[Pair, Pair, Pair, float]) -> Four:
    """The attitude after the step, q ⊗ (ρ, ρ₀), as increments."""
    x, y, z, w = q[0][0], q[1][0], q[2][0], q[3][0]
    (a, a_lo), (b, b_lo), (c, c_lo), less = r
    return (
        increased(q[0], (w * a + (y * c - z * b)) - less * x, w * a_lo + (y * c_lo - z * b_lo)),
        increased(q[1], (w * b + (z * a - x * c)) - less * y, w * b_lo + (z * a_lo - x * c_lo)),
        increased(q[2], (w * c + (x * b - y * a)) - less * z, w * c_lo + (x * b_lo - y * a_lo)),
        increased(q[3], -(x * a + y * b + z * c) - less * w, -(x * a_lo + y * b_lo + z * c_lo)),
    )
