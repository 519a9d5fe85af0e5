"""Elliptic functions for m ≤ ½, by theta functions of real argument."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from lie_rigid_body.arithmetic.numbers import Number, each
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form import theta
from lie_rigid_body.motion.closed_form.periods import Periods
from lie_rigid_body.motion.closed_form.theta import Cubic, cubic, value
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
        return cls.of_nome(decay * codecay, decay, codecay, -math.expm1(-math.pi * float(periods.pole / periods.real)))

    @classmethod
    def of_nome(cls, q: Number, decay: Number, codecay: Number, fall: Number) -> CircularWave:
        """The wave of a nome, of e^(−2α), of q e^(2α) and of 1 − e^(−2α)."""
        p1, p2, p3, p4 = theta.p1(q), theta.p2(q), theta.p3(q), theta.p4(q)
        unity = theta.value(p4, 2.0 * q)
        # e^(−(2n+1)α) times twice the hyperbolic cosine and sine of (2n+1)α, times the powers of q left over
        third, square = decay * decay * decay, codecay * codecay
        fifth, seventh = third * decay * decay, third * third * decay
        w0, w1, w2, w3 = (
            1.0 + decay,
            codecay * (1.0 + third),
            square * (1.0 + fifth),
            square * codecay * (1.0 + seventh),
        )
        more = decay * decay
        v1 = codecay * fall * (1.0 + decay + more)
        v2 = square * fall * (1.0 + decay + more * (1.0 + decay + more))
        v3 = square * codecay * (1.0 - seventh)
        return cls(
            nome=q,
            sn=theta.scaled(p1, theta.value(p4, -2.0 * q) / theta.value(p1, -2.0 * q)),
            cn=theta.scaled(p2, unity / theta.value(p2, 2.0 * q)),
            dn=theta.scaled(p3, unity / theta.value(p3, 2.0 * q)),
            denominator=p4,
            sine=theta.odd_sines(q, (w0, w1, w2, w3)),
            cosine=theta.odd_cosines(q, (fall, v1, v2, v3)),
        )

    def begin(self, phase: Number) -> tuple[Number, Number, Number]:
        """Sine, cosine and drift of the libration at one ζ; see `Crest`."""
        s, c = each(math.sin, phase), each(math.cos, phase)
        z = 2.0 * self.nome * ((c - s) * (c + s))
        return s * theta.value(self.sine, z), c * theta.value(self.cosine, z), 0.0


class CircularNumbers(NamedTuple):
    """What a sample takes of a `CircularWave`: twice its nome, and the polynomials."""

    twice_nome: Number
    sn: Cubic
    cn: Cubic
    dn: Cubic
    denominator: Cubic
    sine: Cubic
    cosine: Cubic


@kernel
def circular_numbers(row: Sequence[Number], k: int) -> CircularNumbers:
    """Those that stand in a row from a place on."""
    first, second = (cubic(row, k + 1), cubic(row, k + 5), cubic(row, k + 9)), (cubic(row, k + 13), cubic(row, k + 17))
    return CircularNumbers(row[k], first[0], first[1], first[2], second[0], second[1], cubic(row, k + 21))


@kernel
def circular_crest(wave: CircularNumbers, s: Number, c: Number) -> Crest:
    """The functions at any ζ, of which the sine and cosine are given."""
    z = wave.twice_nome * ((c - s) * (c + s))
    inverse = 1.0 / value(wave.denominator, z)
    return Crest(
        s * (value(wave.sn, z) * inverse),
        c * (value(wave.cn, z) * inverse),
        value(wave.dn, z) * inverse,
        s * value(wave.sine, z),
        c * value(wave.cosine, z),
    )
