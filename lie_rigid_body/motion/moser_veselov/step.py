"""One Moser–Veselov step of a state carried in double-double.

Increments of the momentum are products of doubles, so rounded to 1e-16 of themselves and 1e-18 of the momentum. What
would repeat from step to step, the rounding of constants and of components that stay, is made up for by lo parts, so
that the errors that remain are as good as random. The attitude's increments are all but exact.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble, fast_two_sum, two_product, two_sum
from lie_rigid_body.arithmetic.numbers import Number, sqrt
from lie_rigid_body.compilation import kernel

Three: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble]
Four: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble]


@kernel
def increased(value: DoubleDouble, hi: Number, lo: Number) -> DoubleDouble:
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
def scaled_sum(before: DoubleDouble, after: DoubleDouble, hi: Number, lo: Number) -> DoubleDouble:
    """ρ₀ρⱼ = ½dⱼ (nⱼ + nⱼ⁺), not normalised."""
    total, error = two_sum(before[0], after[0])
    product, rest = two_product(total, hi)
    return product, rest + (hi * (error + (before[1] + after[1])) + lo * total)


@kernel
def step_rotation(
    before: Three, after: Three, step: Any, at: int
) -> tuple[DoubleDouble, DoubleDouble, DoubleDouble, Number]:
    """The vector part ρ of the step's quaternion, and 1 − ρ₀."""
    v1 = scaled_sum(before[0], after[0], step[at + 14], step[at + 15])
    v2 = scaled_sum(before[1], after[1], step[at + 16], step[at + 17])
    v3 = scaled_sum(before[2], after[2], step[at + 18], step[at + 19])
    s, s_lo = sum_of_squares(v1, v2, v3)
    square = 0.5 + 0.5 * sqrt(1.0 - 4.0 * s)
    scalar = sqrt(square)
    # 1 − ρ₀² and 1 − ρ₀
    t = (s + s_lo) / square
    less = t / (1.0 + scalar)
    # 1/ρ₀ − 1 as ½s, which is exact, and what is left
    rest = 0.5 * (s_lo + s * (3.0 * t + less - t * (less + t)) / (square * (scalar + square)))
    half = 0.5 * s
    return enlarged(v1, half, rest), enlarged(v2, half, rest), enlarged(v3, half, rest), less


@kernel
def sum_of_squares(a: DoubleDouble, b: DoubleDouble, c: DoubleDouble) -> DoubleDouble:
    """The sum a² + b² + c², not normalised."""
    p, p_lo = two_product(a[0], a[0])
    q, q_lo = two_product(b[0], b[0])
    r, r_lo = two_product(c[0], c[0])
    total, e1 = two_sum(p, q)
    total, e2 = two_sum(total, r)
    return total, (e1 + e2) + (p_lo + q_lo + r_lo) + 2.0 * (a[0] * a[1] + b[0] * b[1] + c[0] * c[1])


@kernel
def enlarged(value: DoubleDouble, hi: Number, lo: Number) -> DoubleDouble:
    """The value times 1 + hi + lo."""
    product, error = two_product(value[0], hi)
    total, rest = fast_two_sum(value[0], product)
    return total, rest + (error + (value[1] + (value[0] * lo + value[1] * hi)))


@kernel
def turned(q: Four, r: tuple[DoubleDouble, DoubleDouble, DoubleDouble, Number]) -> Four:
    """The attitude after the step, q ⊗ (ρ, ρ₀), as increments."""
    x, y, z, w = q
    a, b, c, less = r
    minus_x, minus_y, minus_z = (-x[0], -x[1]), (-y[0], -y[1]), (-z[0], -z[1])
    return (
        with_products(x, w, a, y, c, minus_z, b, less),
        with_products(y, w, b, z, a, minus_x, c, less),
        with_products(z, w, c, x, b, minus_y, a, less),
        with_products(w, minus_x, a, minus_y, b, minus_z, c, less),
    )


@kernel
def with_products(
    value: DoubleDouble,
    a: DoubleDouble,
    b: DoubleDouble,
    c: DoubleDouble,
    d: DoubleDouble,
    e: DoubleDouble,
    f: DoubleDouble,
    less: Number,
) -> DoubleDouble:
    """The value (1 − less) + ab + cd + ef."""
    p, p_lo = two_product(a[0], b[0])
    q, q_lo = two_product(c[0], d[0])
    r, r_lo = two_product(e[0], f[0])
    total, e1 = two_sum(value[0], p)
    total, e2 = two_sum(total, q)
    total, e3 = two_sum(total, r)
    p_lo += a[0] * b[1] + a[1] * b[0]
    q_lo += c[0] * d[1] + c[1] * d[0]
    r_lo += e[0] * f[1] + e[1] * f[0]
    return two_sum(total, ((value[1] - less * value[0]) + (e1 + e2 + e3)) + (p_lo + q_lo + r_lo))
