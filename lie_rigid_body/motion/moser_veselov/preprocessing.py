"""The preprocessed inertia of the discrete Moser–Veselov algorithm, as power series in the step.

A step of the algorithm is a rotation whose unit quaternion (ρ, ρ₀) fulfils ρ₀ρⱼ = dⱼ m̄ⱼ, where m̄ is the mean of the
body momenta before and after it. With dⱼ = h/(2Iⱼ) it is of order 2. With

    dⱼ = α(h) + β(h)/Iⱼ

and the right numbers α, β the step is exact. They depend on the length of the step, the energy and the momentum, but
not on where on its orbit the motion is (E. Hairer, G. Vilmart, J. Phys. A 39 (2006) 13225, who give the series up to
order 10). Here the coefficients are not taken from formulas. They are found from the Taylor series of the motion
itself, for the step that is symmetric about the phase at which n₂, along the intermediate axis, vanishes.

In the units of `DimensionlessMotion`, n is the unit body momentum, eⱼ are the inverse moments, and m₁ and m₃ are n₁²
and n₃² where n₂ = 0. A time t after that phase, momentum and quaternion are

    n = (√m₁ a, (e₁ − e₃)√(m₁m₃) t s, √m₃ c),     (ρ, ρ₀) = (√m₁ t x, √(m₁m₃) y, √m₃ t z, w),

in which a, c, s and x, y, z, w are the seven unknown series in t². Their coefficients are polynomials in m₁, m₃ and eⱼ:
nothing is singular, whatever the body and its motion.

The numbers may be Decimals or doubles.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any, NamedTuple, TypeAlias, TypeVar

from lie_rigid_body.motion.moser_veselov.principal_frame import DimensionlessMotion

Number = TypeVar("Number", Decimal, float)
Series: TypeAlias = list[Number]


class Invariants(NamedTuple):
    """The constants of the motion that its Taylor series depend on, formed so that nothing cancels in the series.

    Axes 1 and 3 are those of the frame or exchanged, which changes neither α nor β, so that e₁ ≤ e₃.

    Attributes
    ----------
    a_rate, c_rate : number
        (e₃ − e₂)(e₁ − e₃)m₃ and (e₂ − e₁)(e₁ − e₃)m₁: ȧ and ċ are these times t s c and t s a.
    f1, f2, f3 : number
        Factors of the quaternion's equations: ½e₁, ½e₂(e₁ − e₃), ½e₃.
    m1, m3 : number
        n₁² and n₃² where n₂ = 0.
    """

    a_rate: Any
    c_rate: Any
    f1: Any
    f2: Any
    f3: Any
    m1: Any
    m3: Any

    @classmethod
    def of(cls, motion: DimensionlessMotion) -> Invariants:
        """The invariants of a motion in its own units."""
        e1, e2, e3 = motion.inverse_moments
        (e1, m1), (e3, m3) = sorted([(e1, motion.m1), (e3, motion.m3)])
        difference = e1 - e3
        a_rate = (e3 - e2) * difference * m3
        c_rate = (e2 - e1) * difference * m1
        return Invariants(a_rate, c_rate, e1 / 2, e2 * difference / 2, e3 / 2, m1, m3)


def preprocessed_inertia(motion: Invariants, terms: int) -> tuple[Series[Any], Series[Any]]:
    """The series of α and β for a step h, in the unit of time of `DimensionlessMotion`.

    Parameters
    ----------
    motion : Invariants
    terms : int
        Number of coefficients of β: half the order of the method.

    Returns
    -------
    alpha : list of ``terms`` − 1 numbers
        α = h³ (alpha[0] + alpha[1] h² + …).
    beta : list of ``terms`` numbers
        β = h (beta[0] + beta[1] h² + …).
    """
    a, c, s, x, y, z, w = _half_step(motion, terms)
    *_, m1, m3 = motion
    # with the half step mirrored, the whole one has the quaternion (√m₁ρ₁, 0, √m₃ρ₃, 1 − 2t²(m₁x² + m₃z²))
    sines = [m1 * p + m3 * q for p, q in zip(_times(x, x), _times(z, z), strict=True)]
    whole = [w[0], *(-2 * p for p in sines[:-1])]
    turn = [2 * (p - m3 * q) for p, q in zip(_times(w, x), _times(y, z), strict=True)]
    # d₁ = α + βe₁; either of d₁ and d₃ gives α, and the smaller cancels less
    d1 = _over(_times(whole, turn), a)
    beta = _over(_times(_times(whole, whole), s), _times(a, c))
    alpha = [p - 2 * motion.f1 * q for p, q in zip(d1, beta, strict=True)]
    # in powers of the whole step
    return [p / 2 ** (2 * k + 1) for k, p in enumerate(alpha)][1:], [p / 2 ** (2 * k + 1) for k, p in enumerate(beta)]


def _half_step(motion: Invariants, terms: int) -> tuple[Series[Any], ...]:
    """Taylor coefficients of the motion after the symmetric phase, n₂ = 0, in powers of t².

    Each line is one component of Euler's equations or of q̇ = ½ q ⊗ ω, compared power by power. The coefficient n of an
    even function of t is that of its derivative divided by 2n, of an odd one divided by 2n + 1.
    """
    a_rate, c_rate, f1, f2, f3, m1, m3 = motion
    zero = f1 - f1
    a, c, w, s = ([zero + 1] for _ in range(4))
    x = [f1]
    y = [zero]
    z = [f3]
    for n in range(1, terms):
        k = n - 1
        a.append(a_rate * _term(s, c, k) / (2 * n))
        c.append(c_rate * _term(s, a, k) / (2 * n))
        w.append(-(m1 * (f1 * _term(x, a, k) + m3 * f2 * _term(y, s, k)) + m3 * f3 * _term(z, c, k)) / (2 * n))
        y.append((f2 * _term(w, s, k) + f1 * _term(z, a, k) - f3 * _term(x, c, k)) / (2 * n))
        s.append(_term(a, c, n) / (2 * n + 1))
        x.append((f1 * _term(w, a, n) + m3 * (f3 * _term(y, c, n) - f2 * _term(z, s, k))) / (2 * n + 1))
        z.append((f3 * _term(w, c, n) + m1 * (f2 * _term(x, s, k) - f1 * _term(y, a, n))) / (2 * n + 1))
    return a, c, s, x, y, z, w


def _term(a: Series[Number], b: Series[Number], n: int) -> Number:
    """The n-th coefficient of the product of two series (Cauchy's product)."""
    total = a[0] * b[n]
    for i in range(1, n + 1):
        total += a[i] * b[n - i]
    return total


def _times(a: Series[Number], b: Series[Number]) -> Series[Number]:
    """The product of two series of equal length."""
    return [_term(a, b, n) for n in range(len(a))]


def _over(a: Series[Number], b: Series[Number]) -> Series[Number]:
    """The quotient of two series, the divisor's beginning with 1."""
    quotient = [a[0]]
    for n in range(1, len(a)):
        rest = a[n]
        for i in range(n):
            rest -= quotient[i] * b[n - i]
        quotient.append(rest)
    return quotient
