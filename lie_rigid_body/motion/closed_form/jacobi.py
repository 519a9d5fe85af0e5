"""Jacobi's elliptic functions and the libration of the precession, by theta functions of real or imaginary argument.

With z = 2q cos 2ζ, which for imaginary ζ = iχ is 2q cosh 2χ, each theta function is an elementary factor times a power
series in z. For a nome q ≤ exp(−π) and |z| ≤ 1 + q² its terms fall like qⁿ² zⁿ: four of them are enough, as
q¹⁶ < 2e-22. The cubic polynomials are (DLMF 20.2.1-20.2.4)

    θ₁ = 2q^¼ sin ζ · P₁(z),  θ₂ = 2q^¼ cos ζ · P₂(z),  θ₃ = P₃(z),  θ₄ = P₄(z).

For m ≤ ½ the argument is real, ζ = πu/2K with the nome q = exp(−πK′/K) (`RealTheta`). For m > ½ it is imaginary, χ =
πu/2K′ with the nome q′ = exp(−πK/K′) of the complementary parameter (`ImaginaryTheta`). So the nome never exceeds
exp(−π), and is 0 on the separatrix, where the functions are hyperbolic. Elsewhere the first regime is called circular,
the second hyperbolic.

The libration Θ is the odd function of u, π/2 at u = K, whose sine and cosine have the signs of sn and cn, and

    Θ = √((1 − ν)(m − ν)/−ν) · (Π(ν; am u|m) − Π(ν|m) u/K) + πu/2K:

the part of the precession that comes back after a period (E. T. Whittaker, G. N. Watson, A Course of Modern Analysis,
4th ed., sec. 22.74). The characteristic ν ≤ 0 enters by a in (0, K′] with sc(a|1 − m) = 1/√−ν.

References
----------
NIST Digital Library of Mathematical Functions (DLMF), https://dlmf.nist.gov, chapters 20 and 22.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import exponential
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, each, quadruple, sign
from lie_rigid_body.compilation import kernel

Cubic: TypeAlias = Quadruple
"""Coefficients of a polynomial of degree 3, the constant first."""

_NEGLIGIBLE: Final = 1e-305
"""Added to e^(−2χ) to avoid 0/0: without effect on any result."""


class EllipticValues(NamedTuple):
    """Values at one u, or at each u of an array.

    Attributes
    ----------
    sn, cn, dn : number
        Jacobi's functions.
    sine, cosine : number
        Sine and cosine of the libration Θ, for imaginary argument of Θ − χ·drift, times a common positive factor.
    """

    sn: Number
    cn: Number
    dn: Number
    sine: Number
    cosine: Number


Libration: TypeAlias = tuple[Number, Number, Number]
"""The libration Θ at one u: the sine and cosine of Θ − drift, in proportion, and the drift, rad."""


class ThetaQuotients(NamedTuple):
    """Cubic polynomials in z whose quotients are the elliptic functions, but for elementary factors.

    Attributes
    ----------
    nome : number
        q, which makes z.
    sn, cn, dn, denominator : Cubic
        The functions are quotients of the first three by the last.
    sine, cosine : Cubic
        Sine and cosine of the libration.
    """

    nome: Number
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic


QUOTIENTS_LENGTH: Final = 25
"""Numbers of `ThetaQuotients` in a row: the nome and six cubics."""
_SN, _CN, _DN, _DENOMINATOR, _SINE, _COSINE = range(1, QUOTIENTS_LENGTH, 4)


class RealTheta(NamedTuple):
    """Elliptic functions for m ≤ ½, by theta functions of the real argument ζ = πu/2K."""

    quotients: ThetaQuotients

    @classmethod
    def of(cls, q: Number, power: Number, copower: Number, complement: Number) -> RealTheta:
        """The functions of a parameter and a characteristic.

        With α = πa/2K the libration is arg(i/θ₁(ζ + iα)). Its sine and cosine are as Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ cosh (2n+1)α sin
        (2n+1)ζ to Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ sinh (2n+1)α cos (2n+1)ζ (DLMF 20.2.1).

        Parameters
        ----------
        q, power, copower, complement : number
            The nome q, its powers q^(a/K′) = e^(−2α) and q^(1 − a/K′) = q e^(2α), and 1 − e^(−2α).
        """
        p1, p2, p3, p4 = theta_cubics(q)
        unity = value(p4, 2.0 * q)
        # 2e^(−α) qⁿ cosh (2n+1)α = (q e^(2α))ⁿ (1 + e^(−2(2n+1)α)), and with − for sinh
        third, square = power * power * power, copower * copower
        fifth, seventh = third * power * power, third * third * power
        w0, w1, w2, w3 = (
            1.0 + power,
            copower * (1.0 + third),
            square * (1.0 + fifth),
            square * copower * (1.0 + seventh),
        )
        # 1 − xⁿ = (1 − x)(1 + x + … + xⁿ⁻¹), as x = e^(−2α) may be near 1
        more = power * power
        v1 = copower * complement * (1.0 + power + more)
        v2 = square * complement * (1.0 + power + more * (1.0 + power + more))
        v3 = square * copower * (1.0 - seventh)
        return cls(
            ThetaQuotients(
                nome=q,
                # DLMF 22.2.4-22.2.6; the constant factors follow from sn K = cn 0 = dn 0 = 1
                sn=_times(p1, value(p4, -2.0 * q) / value(p1, -2.0 * q)),
                cn=_times(p2, unity / value(p2, 2.0 * q)),
                dn=_times(p3, unity / value(p3, 2.0 * q)),
                denominator=p4,
                sine=odd_sines(q, (w0, w1, w2, w3)),
                cosine=odd_cosines(q, (complement, v1, v2, v3)),
            )
        )

    def libration(self, phase: Number) -> Libration:
        """The libration at one ζ, or at one of each motion."""
        s, c = each(math.sin, phase), each(math.cos, phase)
        z = 2.0 * self.quotients.nome * ((c - s) * (c + s))
        return s * value(self.quotients.sine, z), c * value(self.quotients.cosine, z), 0.0


class ImaginaryTheta(NamedTuple):
    """Elliptic functions for m > ½, by theta functions of the imaginary argument iχ, χ = πu/2K′.

    Attributes
    ----------
    quotients : ThetaQuotients
        Polynomials of the nome q′.
    quarter : number
        X = πK/2K′, a quarter period of χ; infinite on the separatrix.
    drift : number
        a/K: the libration grows by it with χ, besides what the polynomials give.
    """

    quotients: ThetaQuotients
    quarter: Number
    drift: Number

    @classmethod
    def of(cls, q: Number, quarter: Number, sine: Number, cosine: Number, drift: Number) -> ImaginaryTheta:
        """The functions of a parameter and a characteristic, by Jacobi's imaginary transformation (DLMF 22.6.1).

        With β = πa/2K′ the libration is −arg θ₁(β − iχ|q′) + χa/K (DLMF 20.7.30). Without the last term its sine and
        cosine are as Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ cos (2n+1)β sinh (2n+1)χ to Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ sin (2n+1)β cosh (2n+1)χ.

        Parameters
        ----------
        q, quarter, sine, cosine, drift : number
            q′ = exp(−2X), X, sin β, cos β and a/K.
        """
        p1, p2, p3, p4 = theta_cubics(q)
        # P₂ at χ = 0, and z at χ = X
        unity, last = value(p2, 2.0 * q), 1.0 + q * q
        # qⁿ cos (2n+1)β and qⁿ sin (2n+1)β, by twice the cosine of 2β
        double = 2.0 * (cosine - sine) * (cosine + sine)
        c1, s1 = cosine * (double - 1.0), sine * (double + 1.0)
        c2, s2 = double * c1 - cosine, double * s1 - sine
        c3, s3 = double * c2 - c1, double * s2 - s1
        q2, q3 = q * q, q * q * q
        nome, _ = exponential(2.0 * quarter)
        quotients = ThetaQuotients(
            nome=nome,
            # sn u = −i sc(iu|m₁), cn u = nc(iu|m₁), dn u = dc(iu|m₁); sn K = 1 where tanh X = (1 − q)/(1 + q)
            sn=_times(p1, value(p2, last) / value(p1, last) * ((1.0 + q) / (1.0 - q))),
            cn=_times(p4, unity / value(p4, 2.0 * q)),
            dn=_times(p3, unity / value(p3, 2.0 * q)),
            denominator=p2,
            sine=odd_sines(q, (cosine, q * c1, q2 * c2, q3 * c3)),
            cosine=odd_cosines(q, (sine, q * s1, q2 * s2, q3 * s3)),
        )
        return cls(quotients, quarter, drift)

    def libration(self, phase: Number) -> Libration:
        """The libration at one χ, or at one of each motion."""
        size = each(abs, phase)
        square = each(math.exp, -2.0 * size)
        # 2q cosh 2χ = exp(2χ − 2X) (1 + exp(−4χ))
        z = each(math.exp, 2.0 * (size - self.quarter)) * (1.0 + square * square)
        sine, cosine = each(math.tanh, phase) * value(self.quotients.sine, z), value(self.quotients.cosine, z)
        return sine, cosine, self.drift * phase


Theta: TypeAlias = RealTheta | ImaginaryTheta


@kernel
def real_values(theta: ThetaQuotients, s: Number, c: Number) -> EllipticValues:
    """The elliptic functions at any ζ, from its sine and cosine."""
    # z = 2q cos 2ζ
    z = 2.0 * theta.nome * ((c - s) * (c + s))
    # 1/θ₄
    inverse = 1.0 / value(theta.denominator, z)
    return EllipticValues(
        s * (value(theta.sn, z) * inverse),
        c * (value(theta.cn, z) * inverse),
        value(theta.dn, z) * inverse,
        s * value(theta.sine, z),
        c * value(theta.cosine, z),
    )


@kernel
def imaginary_values(theta: ThetaQuotients, phase: DoubleDouble) -> EllipticValues:
    """The elliptic functions at χ in [−X, X]."""
    side = sign(phase[0])
    # e^(−|χ|) and e^(−|χ|) − 1, with the low part of the phase in first order
    decay, fall = exponential(side * phase[0])
    rest = decay * (side * phase[1])
    decay, fall = decay - rest, fall - rest
    square = decay * decay
    inverse = 1.0 / (1.0 + square)
    # sech χ = 2e^(−|χ|)/(1 + e^(−2|χ|)), tanh |χ| = (1 − e^(−2|χ|))/(1 + e^(−2|χ|))
    sech, tanh = 2.0 * decay * inverse, -side * (fall * (2.0 + fall)) * inverse
    # z = 2q cosh 2χ; where e^(−2χ) underflows q does so too
    z = theta.nome * (1.0 + square * square) / (square + _NEGLIGIBLE)
    # 1/θ₂, whose factor cosh χ is in sech and tanh
    unit = 1.0 / value(theta.denominator, z)
    return EllipticValues(
        tanh * (value(theta.sn, z) * unit),
        sech * (value(theta.cn, z) * unit),
        sech * (value(theta.dn, z) * unit),
        tanh * value(theta.sine, z),
        value(theta.cosine, z),
    )


@kernel
def half_period_later(values: EllipticValues, parity: Number) -> EllipticValues:
    """The values at u + 2K where the parity is −1, those at u where it is 1 (DLMF table 22.4.3)."""
    return EllipticValues(
        parity * values.sn, parity * values.cn, values.dn, parity * values.sine, parity * values.cosine
    )


@kernel
def theta_quotients(row: Sequence[Number], k: int) -> ThetaQuotients:
    """The polynomials whose numbers stand in a row from place k on."""
    return ThetaQuotients(
        row[k],
        quadruple(row, k + _SN),
        quadruple(row, k + _CN),
        quadruple(row, k + _DN),
        quadruple(row, k + _DENOMINATOR),
        quadruple(row, k + _SINE),
        quadruple(row, k + _COSINE),
    )


@kernel
def value(p: Cubic, z: Number) -> Number:
    """The polynomial at one point, by Horner's rule."""
    return ((p[3] * z + p[2]) * z + p[1]) * z + p[0]


def _times(p: Cubic, factor: Number) -> Cubic:
    return p[0] * factor, p[1] * factor, p[2] * factor, p[3] * factor


def odd_sines(q: Number, weights: Cubic) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² sin((2n+1)ζ)/sin ζ as a polynomial in z."""
    return _odd(q, q, weights)


def odd_cosines(q: Number, weights: Cubic) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² cos((2n+1)ζ)/cos ζ as a polynomial in z."""
    return _odd(q, -q, weights)


def _odd(q: Number, signed: Number, weights: Cubic) -> Cubic:
    # with x = 2 cos 2ζ = z/q the quotients of sines are 1, x + 1, x² + x − 1, x³ + x² − 2x − 1, those of cosines the
    # same with x − 1, x² − x − 1, x³ − x² − 2x + 1: the sign of each odd power of q changes.
    # Products, not powers: they have the same bits for a float and for an array
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
    # 2 cos 2nζ is x, x² − 2, x³ − 3x with x = z/q
    q2 = q * q
    q4, q6 = q2 * q2, q2 * q2 * q2
    return 1.0 - 2.0 * q4, sign * (1.0 - 3.0 * q4 * q4), q2, sign * q6


def theta_cubics(q: Number) -> tuple[Cubic, Cubic, Cubic, Cubic]:
    """P₁, P₂, P₃ and P₄ of the module's docstring."""
    return (
        odd_sines(q, (1.0, q, q * q, q * q * q)),
        odd_cosines(q, (1.0, -q, q * q, -q * q * q)),
        even_cosines(q, 1.0),
        even_cosines(q, -1.0),
    )
