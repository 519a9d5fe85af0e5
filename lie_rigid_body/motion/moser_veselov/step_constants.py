"""What a step of a given length needs to know, in double-double.

The step of the momentum is explicit. In the frame of `spinning_frame` the component n₁ is a Jacobi function cn, n₂ an
sn and n₃ a dn of time, or n₁ and n₃ the other way round, so that their addition theorems (DLMF 22.8) give the momentum
after a step from that before it:

    n₁⁺ = (χ n₁ + S δ (e₃ − e₂) n₂n₃)/D         D = 1 − S²(e₃ − e₂)(e₂ − e₁) n₂²
    n₂⁺ = (χδ n₂ + S (e₁ − e₃) n₃n₁)/D          χ² = 1 − S²P,  P = (e₂ − e₃)(e₁ − 2H)
    n₃⁺ = (δ n₃ + S χ (e₂ − e₁) n₁n₂)/D         δ² = 1 − S²Q,  Q = (e₁ − e₂)(2H − e₃)

For any S this keeps |n| and the energy. The value that belongs to a preprocessed inertia dⱼ = α + βeⱼ is the one for
which the Moser–Veselov equation holds. For the half step T = S(x/2) of the symmetric step about n₂ = 0 it reads

    T ρ₀² = β χ δ,     ρ₀²(1 − ρ₀²) = d₁²χ²m₁ + d₃²δ²m₃     with χ² = 1 − T²P, δ² = 1 − T²Q
"""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.arithmetic.double_double import (
    DoubleDouble,
    add,
    divide,
    multiply,
    square_root,
    subtract,
    two_product,
)
from lie_rigid_body.arithmetic.numbers import Number, magnitude, sqrt
from lie_rigid_body.compilation import kernel

COEFFICIENTS: Final = 36
ALPHA: Final = COEFFICIENTS
BETA: Final = COEFFICIENTS + 2
STRIDE: Final = 4
"""Where the series of α and β lie among the constants of a motion: their pairs by turns, at least two of each."""

NEWTON_STEPS: Final = 6
"""From the order-2 guess at a turn of ¼ rad, to the last bit of a double."""

CONVERGED: Final = 1e-9
"""A relative correction whose square is below round-off."""


@kernel
def step_constants(x: DoubleDouble, constants: Any) -> Any:
    """The constants of a step, as hi and lo parts.

    Parameters
    ----------
    x : pair
        Length of the step, in the units of the frame.
    constants : floats
        Of the motion; see `MoserVeselovIntegrator`.

    Returns
    -------
    tuple of 20 floats
        χ − 1, χδ − 1, δ − 1; Sδ(e₃ − e₂), S(e₁ − e₃), Sχ(e₂ − e₁); S²(e₃ − e₂)(e₂ − e₁); ½d₁, ½d₂, ½d₃.
    """
    e1, e2, e3 = (constants[2], constants[3]), (constants[4], constants[5]), (constants[6], constants[7])
    p, q = (constants[8], constants[9]), (constants[10], constants[11])
    square = multiply(x, x)
    alpha = multiply(multiply(x, square), series(square, constants, ALPHA))
    beta = multiply(x, series(square, constants, BETA))
    d1, d2, d3 = add(alpha, multiply(beta, e1)), add(alpha, multiply(beta, e2)), add(alpha, multiply(beta, e3))
    half = half_step(beta, d1, d3, constants)
    both = multiply(half, half)
    chi, delta = complement(both, p), complement(both, q)
    # duplication: S(x) = 2 T χ δ/(1 − T⁴PQ)
    below = subtract((1.0, 0.0), multiply(multiply(both, p), multiply(both, q)))
    s = divide(multiply(multiply((2.0 * half[0], 2.0 * half[1]), chi), delta), below)
    both = multiply(s, s)
    chi, delta = complement(both, p), complement(both, q)
    e32, e13, e21 = subtract(e3, e2), subtract(e1, e3), subtract(e2, e1)
    one = (1.0, 0.0)
    c1, c2, c3 = subtract(chi, one), subtract(multiply(chi, delta), one), subtract(delta, one)
    a1, a2, a3 = multiply(multiply(s, delta), e32), multiply(s, e13), multiply(multiply(s, chi), e21)
    k = multiply(both, multiply(e32, e21))
    return (
        c1[0], c1[1], c2[0], c2[1], c3[0], c3[1], a1[0], a1[1], a2[0], a2[1], a3[0], a3[1], k[0], k[1],
        0.5 * d1[0], 0.5 * d1[1], 0.5 * d2[0], 0.5 * d2[1], 0.5 * d3[0], 0.5 * d3[1],
    )  # fmt: skip


@kernel
def series(square: DoubleDouble, constants: Any, first: int) -> DoubleDouble:
    """Σ cₖ x²ᵏ, with coefficients from place ``first``; for the terms beyond x² doubles are enough."""
    x = square[0]
    tail = 0.0
    for place in range(len(constants) - COEFFICIENTS - STRIDE + first, first + STRIDE, -STRIDE):
        tail = tail * x + constants[place]
    second = (constants[first + STRIDE], constants[first + STRIDE + 1])
    rest = multiply(square, add(second, multiply(square, (tail, 0.0))))
    return add((constants[first], constants[first + 1]), rest)


@kernel
def complement(square: DoubleDouble, p: DoubleDouble) -> DoubleDouble:
    """√(1 − S²P), from S²."""
    return square_root(subtract((1.0, 0.0), multiply(square, p)))


@kernel
def half_step(beta: DoubleDouble, d1: DoubleDouble, d3: DoubleDouble, constants: Any) -> DoubleDouble:
    """The root T of T ρ₀² = β χ δ: by Newton's method in doubles, and one step more in double-double."""
    t = beta[0]
    for _ in range(NEWTON_STEPS):
        less = residual(t, beta[0], d1[0], d3[0], constants) / slope(t, beta[0], d1[0], d3[0], constants)
        t = t - less
        if magnitude(less) <= CONVERGED * t:
            break
    p, q = (constants[8], constants[9]), (constants[10], constants[11])
    m1, m3 = (constants[12], constants[13]), (constants[14], constants[15])
    both = two_product(t, t)
    chi, delta = complement(both, p), complement(both, q)
    v1, v3 = multiply(d1, chi), multiply(d3, delta)
    s = add(multiply(multiply(v1, v1), m1), multiply(multiply(v3, v3), m3))
    root = square_root(subtract((1.0, 0.0), (4.0 * s[0], 4.0 * s[1])))
    scalar = add((0.5, 0.0), (0.5 * root[0], 0.5 * root[1]))
    rest = subtract(multiply((t, 0.0), scalar), multiply(beta, multiply(chi, delta)))
    return add((t, 0.0), (-rest[0] / slope(t, beta[0], d1[0], d3[0], constants), 0.0))


@kernel
def residual(t: Number, beta: Number, d1: Number, d3: Number, constants: Any) -> Number:
    """T ρ₀² − β χ δ."""
    x, y = 1.0 - t * t * constants[8], 1.0 - t * t * constants[10]
    s = d1 * d1 * x * constants[12] + d3 * d3 * y * constants[14]
    return t * (0.5 + 0.5 * sqrt(1.0 - 4.0 * s)) - beta * sqrt(x * y)


@kernel
def slope(t: Number, beta: Number, d1: Number, d3: Number, constants: Any) -> Number:
    """Its derivative with respect to T."""
    p, q, m1, m3 = constants[8], constants[10], constants[12], constants[14]
    x, y = 1.0 - t * t * p, 1.0 - t * t * q
    root = sqrt(1.0 - 4.0 * (d1 * d1 * x * m1 + d3 * d3 * y * m3))
    turning = 2.0 * t * t * (d1 * d1 * p * m1 + d3 * d3 * q * m3) / root
    value: Number = 0.5 + 0.5 * root + turning + beta * t * (p * y + q * x) / sqrt(x * y)
    return value
