"""Elliptic functions for m > ½, by theta functions of imaginary argument; on the separatrix, hyperbolic functions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.decimals import PI
from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import exponential
from lie_rigid_body.arithmetic.numbers import Number, each, sign
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form import theta
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.theta import Cubic, cubic, value
from lie_rigid_body.motion.closed_form.wave import Crest

_NEGLIGIBLE: Final = 1e-305
"""Beside e^(−2χ), wherever it is of any consequence."""


@dataclass(frozen=True)
class HyperbolicWave:
    """A `Wave` of phase χ = πu/2K′, by Jacobi's imaginary transformation (DLMF 22.6.1, 20.7.30).

    The nome is that of the complementary parameter, q′ = exp(−2X) with X = πK/2K′. The libration is
    −arg θ₁(β − iχ|q′) + χa/K with β = πa/2K′.
    """

    quarter: Number
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic
    drift: Number

    @classmethod
    def of(cls, periods: Periods) -> HyperbolicWave:
        """The wave of a polhode's periods."""
        quarter = float(PI * periods.real / (2 * periods.imaginary))
        beta, cobeta = (float(PI * x / (2 * periods.imaginary)) for x in (periods.pole, periods.copole))
        drift = 0.0 if periods.real == Decimal("Infinity") else float(periods.pole / periods.real)
        return cls.of_nome(math.exp(-2.0 * quarter), quarter, math.sin(beta), math.sin(cobeta), drift)

    @classmethod
    def of_nome(cls, q: Number, quarter: Number, sine: Number, cosine: Number, drift: Number) -> HyperbolicWave:
        """The wave of the nome q′ = exp(−2X), X, sin β, cos β and a/K."""
        p1, p2, p3, p4 = theta.p1(q), theta.p2(q), theta.p3(q), theta.p4(q)
        unity, crest = theta.value(p2, 2.0 * q), 1.0 + q * q
        # qⁿ cos (2n+1)β and qⁿ sin (2n+1)β, by twice the cosine of 2β
        double = 2.0 * (cosine - sine) * (cosine + sine)
        c1, s1 = cosine * (double - 1.0), sine * (double + 1.0)
        c2, s2 = double * c1 - cosine, double * s1 - sine
        c3, s3 = double * c2 - c1, double * s2 - s1
        q2, q3 = q * q, q * q * q
        return cls(
            quarter=quarter,
            sn=theta.scaled(p1, theta.value(p2, crest) / theta.value(p1, crest) * ((1.0 + q) / (1.0 - q))),
            cn=theta.scaled(p4, unity / theta.value(p4, 2.0 * q)),
            dn=theta.scaled(p3, unity / theta.value(p3, 2.0 * q)),
            denominator=p2,
            sine=theta.odd_sines(q, (cosine, q * c1, q2 * c2, q3 * c3)),
            cosine=theta.odd_cosines(q, (sine, q * s1, q2 * s2, q3 * s3)),
            drift=drift,
        )

    def begin(self, phase: Number) -> tuple[Number, Number, Number]:
        """Sine, cosine and drift of the libration at one χ; see `Crest`."""
        size = each(abs, phase)
        square = each(math.exp, -2.0 * size)
        z = each(math.exp, 2.0 * (size - self.quarter)) * (1.0 + square * square)
        sine, cosine = each(math.tanh, phase) * theta.value(self.sine, z), theta.value(self.cosine, z)
        return sine, cosine, self.drift * phase


class HyperbolicNumbers(NamedTuple):
    """What a sample takes of a `HyperbolicWave`: its nome, which may be 0, and the polynomials."""

    nome: Number
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic


@kernel
def hyperbolic_numbers(row: Sequence[Number], k: int) -> HyperbolicNumbers:
    """Those that stand in a row from a place on."""
    first, second = (cubic(row, k + 1), cubic(row, k + 5), cubic(row, k + 9)), (cubic(row, k + 13), cubic(row, k + 17))
    return HyperbolicNumbers(row[k], first[0], first[1], first[2], second[0], second[1], cubic(row, k + 21))


@kernel
def hyperbolic_crest(wave: HyperbolicNumbers, phase: DoubleDouble) -> Crest:
    """The functions at χ in [−X, X]."""
    side = sign(phase[0])
    decay, fall = exponential(side * phase[0])
    rest = decay * (side * phase[1])
    decay, fall = decay - rest, fall - rest
    square = decay * decay
    inverse = 1.0 / (1.0 + square)
    sech, tanh = 2.0 * decay * inverse, -side * (fall * (2.0 + fall)) * inverse
    # 2q cosh 2χ; where that is not the nome times a number of doubles, it has no effect
    z = wave.nome * (1.0 + square * square) / (square + _NEGLIGIBLE)
    unit = 1.0 / value(wave.denominator, z)
    return Crest(
        tanh * (value(wave.sn, z) * unit),
        sech * (value(wave.cn, z) * unit),
        sech * (value(wave.dn, z) * unit),
        tanh * value(wave.sine, z),
        value(wave.cosine, z),
    )
