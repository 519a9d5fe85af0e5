"""The preprocessed inertia of the discrete Moser–Veselov algorithm, as power series in the step.

The algorithm takes steps with a rotation whose unit quaternion (ρ, ρ₀) fulfils ρ₀ρⱼ = dⱼ m̄ⱼ, m̄ being the mean of
the body momenta before and after. It is a discretisation of order 2 for dⱼ = h/(2Iⱼ). With

    dⱼ = α(h) + β(h)/Iⱼ

and the right numbers α, β, which depend on the step and on the two invariants but not on the phase of the motion, the
step is exact (E. Hairer, G. Vilmart, J. Phys. A 39 (2006) 13225, who give the series up to order 10). Here the
coefficients are not taken from formulas: they are found from the Taylor series of the motion itself, for the step
that is symmetric about the phase at which the component along the intermediate axis vanishes. There, with n = (√m₁ a,
(e₁ − e₃)√(m₁m₃) s, √m₃ c) and the quaternion (√m₁ x, √(m₁m₃) y, √m₃ z, w) since that phase, everything is a power
series in the half step, with coefficients that are polynomials in m₁, m₃ and eⱼ: nothing is singular, whatever the
body and its motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import TypeAlias

from lie_rigid_body.motion.moser_veselov.spinning_frame import SpinningFrame

Series: TypeAlias = list[Decimal]


def preprocessed_inertia(frame: SpinningFrame, terms: int) -> tuple[Series, Series]:
    """The series of α and β for a step x in units of the frame.

    Parameters
    ----------
    frame : SpinningFrame
    terms : int
        Half the order.

    Returns
    -------
    alpha : list of ``terms`` Decimal
        α = x³ (alpha[0] + alpha[1] x² + …), of which the last belongs to an order beyond ``terms``.
    beta : list of ``terms`` Decimal
        β = x (beta[0] + beta[1] x² + …).
    """
    length = 2 * terms + 2
    a, c, s, x, y, z, w = _half_step(frame, length)
    m1, m3 = frame.m1, frame.m3
    # the whole step: with the half step mirrored, the quaternion is (√m₁ ρ₁, 0, √m₃ ρ₃, ρ₀)
    whole = _sum((1, _times(w, w)), (-m1, _times(x, x)), (m1 * m3, _times(y, y)), (-m3, _times(z, z)))
    beta = _over(_times(_times(whole, whole), s), _times(a, c))
    e1, _, e3 = frame.inverse_moments
    # either of d₁ and d₃ gives α; the smaller cancels less
    if e1 < e3:
        turn, along, e = _sum((2, _times(w, x)), (-2 * m3, _times(y, z))), a, e1
    else:
        turn, along, e = _sum((2, _times(w, z)), (2 * m1, _times(x, y))), c, e3
    alpha = _sum((1, _over(_times(whole, turn), along)), (-e, beta))
    return _odd(alpha, 3, terms), _odd(beta, 1, terms)


def _half_step(frame: SpinningFrame, length: int) -> tuple[Series, ...]:
    """Taylor coefficients of Euler's equations and of the quaternion's, q̇ = ½ q⊗ω, from the symmetric phase."""
    e1, e2, e3 = frame.inverse_moments
    m1, m3, difference = frame.m1, frame.m3, frame.inverse_moments[0] - frame.inverse_moments[2]
    zero, one = Decimal(0), Decimal(1)
    a, c, s, x, y, z, w = [one], [one], [zero], [zero], [zero], [zero], [one]
    f1, f2, f3 = e1 / 2, e2 * difference / 2, e3 / 2
    for n in range(length - 1):
        rates = (
            (e3 - e2) * difference * m3 * _term(s, c, n),
            (e2 - e1) * difference * m1 * _term(s, a, n),
            _term(a, c, n),
            f1 * _term(w, a, n) + m3 * (f3 * _term(y, c, n) - f2 * _term(z, s, n)),
            f2 * _term(w, s, n) + f1 * _term(z, a, n) - f3 * _term(x, c, n),
            f3 * _term(w, c, n) + m1 * (f2 * _term(x, s, n) - f1 * _term(y, a, n)),
            -m1 * f1 * _term(x, a, n) - m1 * m3 * f2 * _term(y, s, n) - m3 * f3 * _term(z, c, n),
        )
        for series, rate in zip((a, c, s, x, y, z, w), rates, strict=True):
            series.append(rate / (n + 1))
    return a, c, s, x, y, z, w


def _term(a: Series, b: Series, n: int) -> Decimal:
    """The n-th coefficient of a product."""
    return sum((p * q for p, q in zip(a[: n + 1], b[n::-1], strict=True) if p and q), Decimal(0))


def _times(a: Series, b: Series) -> Series:
    return [_term(a, b, n) for n in range(len(a))]


def _over(a: Series, b: Series) -> Series:
    """The quotient of two series, the divisor's beginning with 1."""
    quotient: Series = []
    for n, coefficient in enumerate(a):
        quotient.append(coefficient - sum((quotient[i] * b[n - i] for i in range(n)), Decimal(0)))
    return quotient


def _sum(*weighted: tuple[Decimal | int, Series]) -> Series:
    return [sum((weight * series[n] for weight, series in weighted), Decimal(0)) for n in range(len(weighted[0][1]))]


def _odd(series: Sequence[Decimal], first: int, terms: int) -> Series:
    """The coefficients of xᶠⁱʳˢᵗ⁺²ᵏ in the whole step x, from those in half of it."""
    powers = range(first, first + 2 * terms, 2)
    return [series[k] / 2**k if k < len(series) else Decimal(0) for k in powers]
