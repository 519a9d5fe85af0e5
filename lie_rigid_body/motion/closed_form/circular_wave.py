"""Elliptic functions for m ≤ ½, by theta functions of real argument."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.motion.closed_form import theta
from lie_rigid_body.motion.closed_form.double_double import Array, Number
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.theta import Cubic
from lie_rigid_body.motion.closed_form.wave import Crest


@dataclass(frozen=True)
class CircularWave:
    """A `Wave` of phase ζ = πu/2K (DLMF 22.2.4-22.2.6).

    The libration Θ is the argument of i/θ₁(ζ + iα) with α = πa/2K, odd in ζ and ½π at K: the periodic part of Π(ν)
    (E. T. Whittaker, G. N. Watson, A Course of Modern Analysis, sec. 22.74).
    """

    nome: Number
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic

    @classmethod
    def of(cls, periods: Periods) -> CircularWave:
        """The wave of a polhode's periods."""
        decay, codecay = (math.exp(-math.pi * float(x / periods.real)) for x in (periods.pole, periods.copole))
        q = decay * codecay
        p1, p2, p3, p4 = theta.p1(q), theta.p2(q), theta.p3(q), theta.p4(q)
        unity = theta.value(p4, 2.0 * q)
        # e^(−(2n+1)α) times twice the hyperbolic cosine and sine of (2n+1)α, times the powers of q left over
        two_alpha = math.pi * float(periods.pole / periods.real)
        growths = [math.expm1(-(2 * n + 1) * two_alpha) for n in range(4)]
        w0, w1, w2, w3 = (codecay**n * (2.0 + growth) for n, growth in enumerate(growths))
        v0, v1, v2, v3 = (-(codecay**n) * growth for n, growth in enumerate(growths))
        return cls(
            nome=q,
            sn=theta.scaled(p1, theta.value(p4, -2.0 * q) / theta.value(p1, -2.0 * q)),
            cn=theta.scaled(p2, unity / theta.value(p2, 2.0 * q)),
            dn=theta.scaled(p3, unity / theta.value(p3, 2.0 * q)),
            denominator=p4,
            sine=theta.odd_sines(q, (w0, w1, w2, w3)),
            cosine=theta.odd_cosines(q, (v0, v1, v2, v3)),
        )

    def at(self, phase: Array) -> Crest:
        """The functions at ζ in [−½π, ½π], shape (..., N)."""
        s, c = np.sin(phase), np.cos(phase)
        z = 2.0 * self.nome * ((c - s) * (c + s))
        inverse = 1.0 / theta.values(self.denominator, z)
        return Crest(
            sn=s * (theta.values(self.sn, z) * inverse),
            cn=c * (theta.values(self.cn, z) * inverse),
            dn=theta.values(self.dn, z) * inverse,
            sine=s * theta.values(self.sine, z),
            cosine=c * theta.values(self.cosine, z),
            drift=np.zeros_like(phase),
        )
