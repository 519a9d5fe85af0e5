"""Elliptic functions for m > ½, by theta functions of imaginary argument; on the separatrix, hyperbolic functions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from lie_rigid_body.motion.closed_form import theta
from lie_rigid_body.motion.closed_form.double_double import Array, Number
from lie_rigid_body.motion.closed_form.pairs import each
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.precision import PI
from lie_rigid_body.motion.closed_form.theta import Cubic
from lie_rigid_body.motion.closed_form.wave import Crest


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

    def at(self, phase: Array) -> Crest:
        """The functions at χ in [−X, X], shape (..., N)."""
        size = np.abs(phase)
        decay = np.exp(-size)
        square = decay * decay
        sech, tanh = 2.0 * decay / (1.0 + square), np.tanh(phase)
        z = np.exp(2.0 * (size - self.quarter)) * (1.0 + square * square)
        inverse = 1.0 / theta.values(self.denominator, z)
        return Crest(
            sn=tanh * (theta.values(self.sn, z) * inverse),
            cn=sech * (theta.values(self.cn, z) * inverse),
            dn=sech * (theta.values(self.dn, z) * inverse),
            sine=tanh * theta.values(self.sine, z),
            cosine=theta.values(self.cosine, z),
            drift=self.drift * phase,
        )
