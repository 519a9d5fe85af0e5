"""One discrete Moser–Veselov step, of a state carried in double-double.

In the frame and units of `DimensionlessMotion` Euler's equations read ṅ₁ = (e₃ − e₂) n₂n₃ and cyclically, and are
solved by Jacobi's functions of time. Here n₂ is an sn, n₁ and n₃ are a cn and a dn (Landau, Lifshitz, Mechanics,
§37). Their addition theorems (DLMF 22.8) give the momentum n⁺ after a step from that before it, n:

    n₁⁺ = (χ n₁ + S δ (e₃ − e₂) n₂n₃)/D         D = 1 − S²(e₃ − e₂)(e₂ − e₁) n₂²
    n₂⁺ = (χδ n₂ + S (e₁ − e₃) n₃n₁)/D          χ² = 1 − S²P,  P = (e₂ − e₃)(e₁ − 2H)
    n₃⁺ = (δ n₃ + S χ (e₂ − e₁) n₁n₂)/D         δ² = 1 − S²Q,  Q = (e₁ − e₂)(2H − e₃)

For any S this keeps |n| and the energy. The quaternion (ρ, ρ₀) of the step's rotation follows from the Moser–Veselov
equation with the preprocessed inertia dⱼ = α + βeⱼ of `preprocessing`,

    ρ₀ρⱼ = ½dⱼ (nⱼ + nⱼ⁺),

in Cayley's coordinates ρ/ρ₀ of the chart. S is the one number for which this rotation takes n⁺ to n. On the step that
is symmetric about n₂ = 0 that is a condition on S(x/2), which is called T here:

    T ρ₀² = β χ δ,     ρ₀²(1 − ρ₀²) = d₁²χ²m₁ + d₃²δ²m₃,     with χ² = 1 − T²P, δ² = 1 − T²Q.

Increments of the momentum are products of doubles, so rounded to 1e-16 of themselves and 1e-18 of the momentum. What
would repeat from step to step, the rounding of constants and of components that stay, is made up for by lo parts. So
the errors that remain are as good as random. The attitude's increments are all but exact.
"""

from __future__ import annotations

import math
from typing import Final

from lie_rigid_body.arithmetic.double_double import (
    ONE,
    DoubleDouble,
    add,
    divide,
    fast_two_sum,
    multiply,
    scaled,
    square_root,
    subtract,
    two_product,
    two_sum,
)
from lie_rigid_body.arithmetic.numbers import Number, magnitude
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.moser_veselov.records import Four, PowerSeries, Step, StepperConstants, Three

MAX_NEWTON_STEPS: Final = 6
"""Newton iterations needed from the order-2 initial guess, for steps up to ¼ rad, to double precision."""

CONVERGED: Final = 1e-9
"""Largest relative correction after which the iteration ends: its square is below round-off."""


@kernel
def step_of_length(x: DoubleDouble, constants: StepperConstants) -> Step:
    """The constants of all steps of a given length, in the motion's unit of time."""
    e1, e2, e3 = constants.inverse_moments
    square = multiply(x, x)
    alpha = multiply(multiply(x, square), power_series(square, constants.alpha))
    beta = multiply(x, power_series(square, constants.beta))
    d1 = add(alpha, multiply(beta, e1))
    d2 = add(alpha, multiply(beta, e2))
    d3 = add(alpha, multiply(beta, e3))
    half = half_step(beta, d1, d3, constants)
    both = multiply(half, half)
    chi = complement(both, constants.p)
    delta = complement(both, constants.q)
    # duplication: S(x) = 2 T χ δ/(1 − T⁴PQ)
    below = subtract(ONE, multiply(multiply(both, constants.p), multiply(both, constants.q)))
    s = divide(multiply(multiply(scaled(half, 2.0), chi), delta), below)
    both = multiply(s, s)
    chi = complement(both, constants.p)
    delta = complement(both, constants.q)
    e32 = subtract(e3, e2)
    e13 = subtract(e1, e3)
    e21 = subtract(e2, e1)
    return Step(
        x,
        (subtract(chi, ONE), subtract(multiply(chi, delta), ONE), subtract(delta, ONE)),
        (multiply(multiply(s, delta), e32), multiply(s, e13), multiply(multiply(s, chi), e21)),
        multiply(both, multiply(e32, e21)),
        (scaled(d1, 0.5), scaled(d2, 0.5), scaled(d3, 0.5)),
    )


@kernel
def power_series(square: DoubleDouble, series: PowerSeries) -> DoubleDouble:
    """Σ cₖ x²ᵏ, from x²; doubles will do for the terms beyond x²."""
    tail: Number = 0.0
    for coefficient in series.later:
        tail = tail * square[0] + coefficient
    return add(series.first, multiply(square, add(series.second, multiply(square, (tail, 0.0)))))


@kernel
def complement(square: DoubleDouble, p: DoubleDouble) -> DoubleDouble:
    """√(1 − S²P), from S²."""
    return square_root(subtract(ONE, multiply(square, p)))


@kernel
def half_step(beta: DoubleDouble, d1: DoubleDouble, d3: DoubleDouble, constants: StepperConstants) -> DoubleDouble:
    """The root T of T ρ₀² = β χ δ: by Newton's method in doubles, and one step more in double-double."""
    t: Number = beta[0]
    for _ in range(MAX_NEWTON_STEPS):
        less = residual(t, beta[0], d1[0], d3[0], constants) / slope(t, beta[0], d1[0], d3[0], constants)
        t = t - less
        if magnitude(less) <= CONVERGED * t:
            break
    both = two_product(t, t)
    chi = complement(both, constants.p)
    delta = complement(both, constants.q)
    # ρ₀² = ½ + ½√(1 − 4s) with s = ρ₀²(1 − ρ₀²)
    v1 = multiply(d1, chi)
    v3 = multiply(d3, delta)
    s = add(multiply(multiply(v1, v1), constants.m1), multiply(multiply(v3, v3), constants.m3))
    scalar_squared = add((0.5, 0.0), scaled(square_root(subtract(ONE, scaled(s, 4.0))), 0.5))
    rest = subtract(multiply((t, 0.0), scalar_squared), multiply(beta, multiply(chi, delta)))
    return add((t, 0.0), (-rest[0] / slope(t, beta[0], d1[0], d3[0], constants), 0.0))


@kernel
def residual(t: Number, beta: Number, d1: Number, d3: Number, constants: StepperConstants) -> Number:
    """T ρ₀² − β χ δ."""
    x = 1.0 - t * t * constants.p[0]
    y = 1.0 - t * t * constants.q[0]
    s = d1 * d1 * x * constants.m1[0] + d3 * d3 * y * constants.m3[0]
    return t * (0.5 + 0.5 * math.sqrt(1.0 - 4.0 * s)) - beta * math.sqrt(x * y)


@kernel
def slope(t: Number, beta: Number, d1: Number, d3: Number, constants: StepperConstants) -> Number:
    """The derivative of the residual with respect to T."""
    p = constants.p[0]
    q = constants.q[0]
    m1 = constants.m1[0]
    m3 = constants.m3[0]
    x = 1.0 - t * t * p
    y = 1.0 - t * t * q
    root = math.sqrt(1.0 - 4.0 * (d1 * d1 * x * m1 + d3 * d3 * y * m3))
    turning = 2.0 * t * t * (d1 * d1 * p * m1 + d3 * d3 * q * m3) / root
    return 0.5 + 0.5 * root + turning + beta * t * (p * y + q * x) / math.sqrt(x * y)


@kernel
def step_momentum(n: Three, step: Step) -> Three:
    """The momentum n⁺ after a step, by the addition theorems.

    It is n₁ + ((χ − 1 + k) n₁ + f₁n₂n₃)/D, and so on, with k = 1 − D and fⱼ the factors of the products.
    """
    (a, a_lo), (b, b_lo), (c, c_lo) = n
    k = step.curvature[0] * (b * b)
    k_lo = step.curvature[1] * (b * b)
    # 1/D − 1; not 1/D, which is rounded upwards more often than not where it is near to 1
    g = k / (1.0 - k)
    # an axis about which the momentum circles leaves the products constant, and what is left out would add up
    return (
        step_component(n[0], step.changes[0], step.factors[0], (b * c, b * c_lo + b_lo * c), (k, k_lo), g),
        step_component(n[1], step.changes[1], step.factors[1], (c * a, c * a_lo + c_lo * a), (k, k_lo), g),
        step_component(n[2], step.changes[2], step.factors[2], (a * b, a * b_lo + a_lo * b), (k, k_lo), g),
    )


@kernel
def step_component(
    n: DoubleDouble, change: DoubleDouble, factor: DoubleDouble, product: DoubleDouble, k: DoubleDouble, g: Number
) -> DoubleDouble:
    """One component of the momentum after a step, from the product of the two others, k and 1/D − 1."""
    s = change[0] + k[0]
    # what the products of hi parts below leave out
    lo = (n[0] * (change[1] + k[1]) + s * n[1]) + (factor[1] * product[0] + factor[0] * product[1])
    hi = factor[0] * product[0]
    t = n[0] * s
    return add_increment(n, hi, (t + g * (hi + t)) + lo * (1.0 + g))


@kernel
def add_increment(value: DoubleDouble, hi: Number, lo: Number) -> DoubleDouble:
    """The value + hi + lo, for an increment hi of the value and a smaller one, lo."""
    total, error = two_sum(value[0], hi)
    return two_sum(total, value[1] + (error + lo))


@kernel
def step_rotation(before: Three, after: Three, half_inertia: Three) -> Four:
    """The vector part ρ of the step's quaternion, and 1 − ρ₀, from the momenta before and after it and ½d."""
    v1 = scaled_sum(before[0], after[0], half_inertia[0])
    v2 = scaled_sum(before[1], after[1], half_inertia[1])
    v3 = scaled_sum(before[2], after[2], half_inertia[2])
    # s = ρ₀²(1 − ρ₀²), so ρ₀² = ½ + ½√(1 − 4s)
    s, s_lo = sum_of_squares(v1, v2, v3)
    square = 0.5 + 0.5 * math.sqrt(1.0 - 4.0 * s)
    scalar = math.sqrt(square)
    # 1 − ρ₀² and 1 − ρ₀
    t = (s + s_lo) / square
    less = t / (1.0 + scalar)
    # a steady rotation repeats them: t(1 − t) = s, and less (2 − less) = t
    t_lo = rest_of_root(t, 1.0, s, s_lo)
    less_lo = rest_of_root(less, 2.0, t, t_lo)
    # 1/ρ₀ − 1 = s/(ρ₀³(1 + ρ₀)), as ½s, which is exact, and what is left: ½s (2 − ρ₀³ − ρ₀⁴)/(ρ₀³(1 + ρ₀))
    rest = 0.5 * (s_lo + s * (3.0 * t + less - t * (less + t)) / (square * (scalar + square)))
    half = 0.5 * s
    return (
        times_one_plus(v1, half, rest),
        times_one_plus(v2, half, rest),
        times_one_plus(v3, half, rest),
        (less, less_lo),
    )


@kernel
def rest_of_root(x: Number, k: Number, c: Number, c_lo: Number) -> Number:
    """Error of x as the root of x (k − x) = c, by one step of Newton's method."""
    square, square_lo = two_product(x, x)
    total, total_lo = two_sum(c, square)
    return ((total - k * x) + (total_lo + square_lo + c_lo)) / (k - 2.0 * x)


@kernel
def scaled_sum(before: DoubleDouble, after: DoubleDouble, half: DoubleDouble) -> DoubleDouble:
    """ρ₀ρⱼ = ½dⱼ (nⱼ + nⱼ⁺), not normalised."""
    total, error = two_sum(before[0], after[0])
    product, rest = two_product(total, half[0])
    return product, rest + (half[0] * (error + (before[1] + after[1])) + half[1] * total)


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
def times_one_plus(value: DoubleDouble, hi: Number, lo: Number) -> DoubleDouble:
    """The value times 1 + hi + lo."""
    product, error = two_product(value[0], hi)
    total, rest = fast_two_sum(value[0], product)
    return total, rest + (error + (value[1] + (value[0] * lo + value[1] * hi)))


@kernel
def step_attitude(q: Four, r: Four) -> Four:
    """The attitude q ⊗ (ρ, ρ₀) after the step, as q − (1 − ρ₀) q + q ⊗ (ρ, 0): Hamilton's product, scalar last."""
    x, y, z, w = q
    a, b, c, less = r
    minus_x = (-x[0], -x[1])
    minus_y = (-y[0], -y[1])
    minus_z = (-z[0], -z[1])
    return (
        sum_of_products(x, w, a, y, c, minus_z, b, less),
        sum_of_products(y, w, b, z, a, minus_x, c, less),
        sum_of_products(z, w, c, x, b, minus_y, a, less),
        sum_of_products(w, minus_x, a, minus_y, b, minus_z, c, less),
    )


@kernel
def sum_of_products(
    value: DoubleDouble,
    a: DoubleDouble,
    b: DoubleDouble,
    c: DoubleDouble,
    d: DoubleDouble,
    e: DoubleDouble,
    f: DoubleDouble,
    less: DoubleDouble,
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
    taken, rest = two_product(less[0], value[0])
    rest += less[1] * value[0] + less[0] * value[1]
    return two_sum(total, ((value[1] - taken) + (e1 + e2 + e3)) + (p_lo + q_lo + r_lo - rest))
