"""Theta functions of real or imaginary argument as cubic polynomials.

With z = 2q cos 2ζ, which for imaginary ζ = iχ is 2q cosh 2χ, each theta function is an elementary factor times
a power series in z. For a nome q ≤ exp(−π) and |z| ≤ 1 + q² its terms fall like qⁿ² zⁿ: four of them are enough, as
q¹⁶ < 2e-22. The polynomials are (DLMF 20.2.1-20.2.4)

    θ₁ = 2q^¼ sin ζ · P₁(z),  θ₂ = 2q^¼ cos ζ · P₂(z),  θ₃ = P₃(z),  θ₄ = P₄(z).
"""

from __future__ import annotations

from collections.abc import Sequence

from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import kernel

Cubic = tuple[Number, Number, Number, Number]
"""Coefficients from the constant up."""


def odd_sines(q: Number, weights: Cubic) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² sin((2n+1)ζ)/sin ζ as a polynomial in z."""
    return _odd(q, q, weights)


def odd_cosines(q: Number, weights: Cubic) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² cos((2n+1)ζ)/cos ζ as a polynomial in z."""
    return _odd(q, -q, weights)


def _odd(q: Number, signed: Number, weights: Cubic) -> Cubic:
    # products, not powers: they have the same bits for a float and for an array
    w0, w1, w2, w3 = weights
    q2 = q * q
    q4, q6, cube = q2 * q2, q2 * q2 * q2, signed * q2
    return (
        w0 - signed * w1 - q4 * w2 + cube * q6 * w3,
        cube * w2 - w1 + 2.0 * q4 * q4 * w3,
        q2 * w2 - cube * q4 * w3,
        -q6 * w3,
    )


def even_cosines(q: Number, sign: float) -> Cubic:
    """1 + 2 Σ signⁿ qⁿ² cos 2nζ as a polynomial in z."""
    q2 = q * q
    q4, q6 = q2 * q2, q2 * q2 * q2
    return 1.0 - 2.0 * q4, sign * (1.0 - 3.0 * q4 * q4), q2, sign * q6


def p1(q: Number) -> Cubic:
    """P₁ of the module's docstring."""
    return odd_sines(q, (1.0, q, q * q, q * q * q))


def p2(q: Number) -> Cubic:
    """P₂ of the module's docstring."""
    return odd_cosines(q, (1.0, -q, q * q, -q * q * q))


def p3(q: Number) -> Cubic:
    """P₃ of the module's docstring."""
    return even_cosines(q, 1.0)


def p4(q: Number) -> Cubic:
    """P₄ of the module's docstring."""
    return even_cosines(q, -1.0)


def scaled(p: Cubic, factor: Number) -> Cubic:
    """The polynomial times a number."""
    return p[0] * factor, p[1] * factor, p[2] * factor, p[3] * factor


@kernel
def value(p: Cubic, z: Number) -> Number:
    """The polynomial at one point."""
    return ((p[3] * z + p[2]) * z + p[1]) * z + p[0]


@kernel
def cubic(row: Sequence[Number], k: int) -> Cubic:
    """The polynomial whose coefficients stand in a row from a place on."""
    return row[k], row[k + 1], row[k + 2], row[k + 3]
