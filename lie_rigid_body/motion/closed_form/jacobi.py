"""Jacobi's elliptic functions and the periodic part of the precession, by theta functions.

With z = 2q cos 2ζ, which for imaginary ζ = iχ is 2q cosh 2χ, each theta function is an elementary factor times a power
series in z. For a nome q ≤ exp(−π) and |z| ≤ 1 + q² its terms fall like qⁿ² zⁿ: four of them are enough, as
q¹⁶ < 2e-22. The cubic polynomials are (DLMF 20.2.1-20.2.4)

    θ₁ = 2q^¼ sin ζ · P₁(z),  θ₂ = 2q^¼ cos ζ · P₂(z),  θ₃ = P₃(z),  θ₄ = P₄(z).

For m ≤ ½ the argument is real, ζ = πu/2K with the nome q = exp(−πK′/K) (`RealTheta`). For m > ½ it is imaginary, χ =
πu/2K′ with the nome q′ = exp(−πK/K′) of the complementary parameter (`ImaginaryTheta`). So the nome never exceeds
exp(−π), and is 0 on the separatrix, where the functions are hyperbolic. The formulas serve floats, arrays and decimals.

The periodic part Θ of the precession is the odd function of u, π/2 at u = K, whose sine and cosine have the signs of sn
and cn, and

    Θ = √((1 − ν)(m − ν)/−ν) · (Π(ν; am u|m) − Π(ν|m) u/K) + πu/2K:

it comes back after a period (E. T. Whittaker, G. N. Watson, A Course of Modern Analysis, 4th ed., sec. 22.74). The
characteristic ν ≤ 0 enters by a in (0, K′] with sc(a|1 − m) = 1/√−ν.

References
----------
NIST Digital Library of Mathematical Functions (DLMF), https://dlmf.nist.gov, chapters 20 and 22.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import exponential
from lie_rigid_body.arithmetic.numbers import Number, guarded, sign

Cubic: TypeAlias = tuple[float, float, float, float]
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
        Sine and cosine of Θ, for imaginary argument of Θ − χ·drift, times a common positive factor.
    """

    sn: Number
    cn: Number
    dn: Number
    sine: Number
    cosine: Number

    def half_period_later(self, parity: Number) -> EllipticValues:
        """The values at u + 2K where the parity is −1, those at u where it is 1 (DLMF table 22.4.3)."""
        return EllipticValues(parity * self.sn, parity * self.cn, self.dn, parity * self.sine, parity * self.cosine)


PeriodicPrecession: TypeAlias = tuple[float, float, float]
"""The angle Θ at one u: the sine and cosine of Θ − drift, in proportion, and the drift, rad."""


class ThetaQuotients(NamedTuple):
    """Cubic polynomials in z whose quotients are the elliptic functions, but for elementary factors.

    Attributes
    ----------
    nome : float
        q, which makes z.
    sn, cn, dn, denominator : Cubic
        The functions are quotients of the first three by the last.
    sine, cosine : Cubic
        Sine and cosine of Θ.
    """

    nome: float
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic


class RealTheta(ThetaQuotients):
    """Elliptic functions for m ≤ ½, by theta functions of the real argument ζ = πu/2K."""

    @classmethod
    def of(cls, q: float, power: float, copower: float, complement: float) -> RealTheta:
        """The functions of a parameter and a characteristic.

        With α = πa/2K, Θ is arg(i/θ₁(ζ + iα)). Its sine and cosine are as Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ cosh (2n+1)α sin (2n+1)ζ to
        Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ sinh (2n+1)α cos (2n+1)ζ (DLMF 20.2.1).

        Parameters
        ----------
        q, power, copower, complement : float
            The nome q, its powers q^(a/K′) = e^(−2α) and q^(1 − a/K′) = q e^(2α), and 1 − e^(−2α).
        """
        p1, p2, p3, p4 = theta_cubics(q)
        unity = value(p4, 2 * q)
        # 2e^(−α) qⁿ cosh (2n+1)α = (q e^(2α))ⁿ (1 + e^(−2(2n+1)α)), and with − for sinh
        third = power**3
        square = copower**2
        cosh = (
            1 + power,
            copower * (1 + third),
            square * (1 + power**5),
            square * copower * (1 + power**7),
        )
        # 1 − xⁿ = (1 − x)(1 + x + … + xⁿ⁻¹), as x = e^(−2α) may be near 1
        three_terms = 1 + power + power**2
        sinh = (
            complement,
            copower * complement * three_terms,
            square * complement * (three_terms + third * (1 + power)),
            square * copower * (1 - power**7),
        )
        return cls(
            nome=q,
            # DLMF 22.2.4-22.2.6; the constant factors follow from sn K = cn 0 = dn 0 = 1
            sn=_times(p1, value(p4, -2 * q) / value(p1, -2 * q)),
            cn=_times(p2, unity / value(p2, 2 * q)),
            dn=_times(p3, unity / value(p3, 2 * q)),
            denominator=p4,
            sine=odd(q, q, cosh),
            cosine=odd(q, -q, sinh),
        )

    def periodic_precession(self, phase: float) -> PeriodicPrecession:
        """The angle Θ at one ζ."""
        s = math.sin(phase)
        c = math.cos(phase)
        z = 2.0 * self.nome * ((c - s) * (c + s))
        return s * float(value(self.sine, z)), c * float(value(self.cosine, z)), 0.0

    def values(self, s: Number, c: Number) -> EllipticValues:
        """The elliptic functions at any ζ, from its sine and cosine."""
        # z = 2q cos 2ζ
        z = 2 * self.nome * ((c - s) * (c + s))
        # 1/θ₄
        inverse = 1 / value(self.denominator, z)
        return EllipticValues(
            s * (value(self.sn, z) * inverse),
            c * (value(self.cn, z) * inverse),
            value(self.dn, z) * inverse,
            s * value(self.sine, z),
            c * value(self.cosine, z),
        )


class ImaginaryTheta(NamedTuple):
    """Elliptic functions for m > ½, by theta functions of the imaginary argument iχ, χ = πu/2K′.

    Attributes
    ----------
    quotients : ThetaQuotients
        Polynomials of the nome q′.
    quarter : float
        X = πK/2K′, a quarter period of χ; infinite on the separatrix.
    drift : float
        a/K: Θ grows by it with χ, besides what the polynomials give.
    """

    quotients: ThetaQuotients
    quarter: float
    drift: float

    @classmethod
    def of(cls, q: float, quarter: float, sine: float, cosine: float, drift: float) -> ImaginaryTheta:
        """The functions of a parameter and a characteristic, by Jacobi's imaginary transformation (DLMF 22.6.1).

        With β = πa/2K′, Θ is −arg θ₁(β − iχ|q′) + χa/K (DLMF 20.7.30). Without the last term its sine and cosine are as
        Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ cos (2n+1)β sinh (2n+1)χ to Σ (−1)ⁿ qⁿ⁽ⁿ⁺¹⁾ sin (2n+1)β cosh (2n+1)χ.

        Parameters
        ----------
        q, quarter, sine, cosine, drift : float
            q′ = exp(−2X), X, sin β, cos β and a/K.
        """
        p1, p2, p3, p4 = theta_cubics(q)
        # P₂ at χ = 0, and z at χ = X
        unity = value(p2, 2 * q)
        last = 1 + q * q
        # qⁿ cos (2n+1)β and qⁿ sin (2n+1)β, by twice the cosine of 2β
        double = 2 * (cosine - sine) * (cosine + sine)
        cosines = [cosine, cosine * (double - 1)]
        sines = [sine, sine * (double + 1)]
        for series in (cosines, sines):
            series.append(double * series[1] - series[0])
            series.append(double * series[2] - series[1])
        nome, _ = exponential(2 * quarter)
        quotients = ThetaQuotients(
            nome=nome,
            # sn u = −i sc(iu|m₁), cn u = nc(iu|m₁), dn u = dc(iu|m₁); sn K = 1 where tanh X = (1 − q)/(1 + q)
            sn=_times(p1, value(p2, last) / value(p1, last) * ((1 + q) / (1 - q))),
            cn=_times(p4, unity / value(p4, 2 * q)),
            dn=_times(p3, unity / value(p3, 2 * q)),
            denominator=p2,
            sine=odd(q, q, _times_powers(cosines, q)),
            cosine=odd(q, -q, _times_powers(sines, q)),
        )
        return cls(quotients, quarter, drift)

    def periodic_precession(self, phase: float) -> PeriodicPrecession:
        """The angle Θ at one χ."""
        size = abs(phase)
        # 2q cosh 2χ = exp(2χ − 2X) (1 + exp(−4χ))
        z = math.exp(2.0 * (size - self.quarter)) * (1.0 + math.exp(-2.0 * size) ** 2)
        sine = math.tanh(phase) * float(value(self.quotients.sine, z))
        return sine, float(value(self.quotients.cosine, z)), self.drift * phase

    def values(self, phase: DoubleDouble) -> EllipticValues:
        """The elliptic functions at χ in [−X, X]."""
        theta = self.quotients
        side = sign(phase[0])
        # e^(−|χ|) and e^(−|χ|) − 1, with the low part of the phase in first order
        decay, fall = exponential(side * phase[0])
        rest = decay * (side * phase[1])
        decay = decay - rest
        fall = fall - rest
        square = decay * decay
        inverse = 1 / (1 + square)
        # sech χ = 2e^(−|χ|)/(1 + e^(−2|χ|)), tanh |χ| = (1 − e^(−2|χ|))/(1 + e^(−2|χ|))
        sech = 2 * decay * inverse
        tanh = -side * (fall * (2 + fall)) * inverse
        # z = 2q cosh 2χ; where e^(−2χ) underflows q does so too
        z = theta.nome * (1 + square * square) / guarded(square, _NEGLIGIBLE)
        # 1/θ₂, whose factor cosh χ is in sech and tanh
        unit = 1 / value(theta.denominator, z)
        return EllipticValues(
            tanh * (value(theta.sn, z) * unit),
            sech * (value(theta.cn, z) * unit),
            sech * (value(theta.dn, z) * unit),
            tanh * value(theta.sine, z),
            value(theta.cosine, z),
        )


def value(p: Cubic, z: Number) -> Number:
    """The polynomial at one point, by Horner's rule."""
    return ((p[3] * z + p[2]) * z + p[1]) * z + p[0]


def _times(p: Cubic, factor: Any) -> Cubic:
    a, b, c, d = (coefficient * factor for coefficient in p)
    return a, b, c, d


def _times_powers(values: list[float], q: float) -> Cubic:
    a, b, c, d = (coefficient * q**n for n, coefficient in enumerate(values))
    return a, b, c, d


def odd(q: float, signed: float, weights: Cubic) -> Cubic:
    """Σ (−1)ⁿ wₙ qⁿ² sin((2n+1)ζ)/sin ζ as a polynomial in z; with −q for ``signed`` the same of cosines."""
    # with x = 2 cos 2ζ = z/q the quotients of sines are 1, x + 1, x² + x − 1, x³ + x² − 2x − 1, those of cosines the
    # same with x − 1, x² − x − 1, x³ − x² − 2x + 1: the sign of each odd power of q changes
    w0, w1, w2, w3 = weights
    q2 = q * q
    cube = signed * q2
    return (
        w0 - signed * w1 - q2**2 * w2 + cube * q2**3 * w3,
        cube * w2 - w1 + 2 * q2**4 * w3,
        q2 * w2 - cube * q2**2 * w3,
        -(q2**3) * w3,
    )


def even_cosines(q: float, sign: float) -> Cubic:
    """1 + 2 Σ signⁿ qⁿ² cos 2nζ as a polynomial in z."""
    # 2 cos 2nζ is x, x² − 2, x³ − 3x with x = z/q
    q2 = q * q
    return 1 - 2 * q2**2, sign * (1 - 3 * q2**4), q2, sign * q2**3


def theta_cubics(q: float) -> tuple[Cubic, Cubic, Cubic, Cubic]:
    """P₁, P₂, P₃ and P₄ of the module's docstring."""
    return (
        odd(q, q, (1, q, q * q, q * q * q)),
        odd(q, -q, (1, -q, q * q, -q * q * q)),
        even_cosines(q, 1),
        even_cosines(q, -1),
    )
