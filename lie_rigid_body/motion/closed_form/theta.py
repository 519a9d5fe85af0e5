"""Theta functions of real or imaginary argument as cubic polynomials.

With z = 2q cos 2ζ, which for imaginary ζ = iχ is 2q cosh 2χ, each theta function is an elementary factor times
a power series in z. For a nome q ≤ exp(−π) and |z| ≤ 1 + q² its terms fall like qⁿ² zⁿ: four of them are enough, as
q¹⁶ < 2e-22. The polynomials are (DLMF 20.2.1-20.2.4)

    θ₁ = 2q^¼ sin ζ · P₁(z),  θ₂ = 2q^¼ cos ζ · P₂(z),  θ₃ = P₃(z),  θ₄ = P₄(z).
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.motion.closed_form.double_double import Array, Number

Cubic = tuple[Number, Number, Number, Number]
"""Coefficients from the constant up."""

Weights = tuple[float, float, float, float]

_UNIT: Final[Cubic] = (1.0, 0.0, 0.0, 0.0)


def _combine(weights: Weights, rows: tuple[Cubic, Cubic, Cubic]) -> Cubic:
    c0, c1, c2, c3 = (sum(w * row[k] for w, row in zip(weights, (_UNIT, *rows), strict=True)) for k in range(4))
    return c0, c1, c2, c3


def odd_sines(q: float, weights: Weights) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² sin((2n+1)ζ)/sin ζ as a polynomial in z."""
    first = (-q, -1.0, 0.0, 0.0)
    second = (-(q**4), q**3, q**2, 0.0)
    third = (q**9, 2.0 * q**8, -(q**7), -(q**6))
    return _combine(weights, (first, second, third))


def odd_cosines(q: float, weights: Weights) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² cos((2n+1)ζ)/cos ζ as a polynomial in z."""
    first = (q, -1.0, 0.0, 0.0)
    second = (-(q**4), -(q**3), q**2, 0.0)
    third = (-(q**9), 2.0 * q**8, q**7, -(q**6))
    return _combine(weights, (first, second, third))


def even_cosines(q: float, sign: float) -> Cubic:
    """1 + 2 Σ signⁿ qⁿ² cos 2nζ as a polynomial in z."""
    first = (0.0, 1.0, 0.0, 0.0)
    second = (-2.0 * q**4, 0.0, q**2, 0.0)
    third = (0.0, -3.0 * q**8, 0.0, q**6)
    return _combine((1.0, sign, 1.0, sign), (first, second, third))


def p1(q: float) -> Cubic:
    """P₁ of the module's docstring."""
    return odd_sines(q, (1.0, q, q**2, q**3))


def p2(q: float) -> Cubic:
    """P₂ of the module's docstring."""
    return odd_cosines(q, (1.0, -q, q**2, -(q**3)))


def p3(q: float) -> Cubic:
    """P₃ of the module's docstring."""
    return even_cosines(q, 1.0)


def p4(q: float) -> Cubic:
    """P₄ of the module's docstring."""
    return even_cosines(q, -1.0)


def scaled(p: Cubic, factor: Number) -> Cubic:
    """The polynomial times a number."""
    return p[0] * factor, p[1] * factor, p[2] * factor, p[3] * factor


def value(p: Cubic, z: Number) -> Number:
    """The polynomial at one point."""
    return ((p[3] * z + p[2]) * z + p[1]) * z + p[0]


def values(p: Cubic, z: Array) -> Array:
    """The polynomial at every point of an array."""
    return np.asarray(value(p, z))
