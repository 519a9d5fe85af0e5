"""The polhode of an ordinary motion, in pairs.

Formulas and names are those of `polhode`, `periods` and `herpolhode`, without the exact determinant: 32 digits are
enough where the motion keeps away from the separatrix. Quotients of one denominator are kept as their numerators.
"""

from __future__ import annotations

from dataclasses import dataclass

from lie_rigid_body.arithmetic.double_double import (
    ONE,
    DoubleDouble,
    add,
    divide,
    multiply,
    scaled,
    square_root,
    subtract,
)
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.motion.closed_form.landen import Ladder, mean_sum

Pairs = tuple[DoubleDouble, DoubleDouble, DoubleDouble]


@dataclass(frozen=True)
class OrdinaryPolhode:
    """Constants of an ordinary motion.

    Attributes
    ----------
    moments : 3 DoubleDouble
        J₁, J₂, J₃ of its `PrincipalFrame`.
    sense : number
        ±1.
    d21, d31, d32 : DoubleDouble
        |J₂ − J₁|, |J₃ − J₁|, |J₃ − J₂|.
    c1, c3 : DoubleDouble
        |l² − 2HJ₁|, |l² − 2HJ₃|.
    momentum : DoubleDouble
        l.
    sine_square, cosine_square : DoubleDouble
        c3 sn²u₀ and c3 cn²u₀.
    a, b : DoubleDouble
        a² = d32 c1, b² = m1 a².
    excess : DoubleDouble
        m a².
    """

    moments: Pairs
    sense: Number
    d21: DoubleDouble
    d31: DoubleDouble
    d32: DoubleDouble
    c1: DoubleDouble
    c3: DoubleDouble
    momentum: DoubleDouble
    sine_square: DoubleDouble
    cosine_square: DoubleDouble
    a: DoubleDouble
    b: DoubleDouble
    excess: DoubleDouble

    @classmethod
    def of(cls, moments: Pairs, rate: Pairs, sense: Number) -> OrdinaryPolhode:
        """The polhode from the moments, the initial ω and the sense of a `PrincipalFrame`."""
        j1, j2, j3 = moments
        d21, d31, d32 = (scaled(subtract(p, q), sense) for p, q in ((j2, j1), (j3, j1), (j3, j2)))
        q1, q2, q3 = (multiply(j, multiply(w, w)) for j, w in zip(moments, rate, strict=True))
        sine_square, cosine_square, transverse = multiply(d32, q2), multiply(d31, q1), multiply(d21, q2)
        c1, c3 = add(transverse, multiply(d31, q3)), add(sine_square, cosine_square)
        c2 = subtract(multiply(d32, q3), multiply(d21, q1))
        return cls(
            moments=moments,
            sense=sense,
            d21=d21,
            d31=d31,
            d32=d32,
            c1=c1,
            c3=c3,
            momentum=square_root(add(add(multiply(j1, q1), multiply(j2, q2)), multiply(j3, q3))),
            sine_square=sine_square,
            cosine_square=cosine_square,
            a=square_root(multiply(d32, c1)),
            b=square_root(multiply(d31, c2)),
            excess=multiply(d21, c3),
        )

    def amplitudes(self) -> Pairs:
        """A₁, A₂, A₃, rad/s."""
        j1, j2, j3 = self.moments
        return (
            square_root(divide(self.c3, multiply(j1, self.d31))),
            square_root(divide(self.c3, multiply(j2, self.d32))),
            square_root(divide(self.c1, multiply(j3, self.d31))),
        )

    def ladder(self, steps: int) -> Ladder:
        """That of 1 and √m1, whose limit is π/2K."""
        total = add(self.a, self.b)
        return Ladder.of(divide(self.excess, multiply(total, total)), steps)

    def complementary_ladder(self, steps: int) -> Ladder:
        """That of 1 and √m, whose limit is π/2K′."""
        total = add(self.a, square_root(self.excess))
        return Ladder.of(divide(multiply(self.b, self.b), multiply(total, total)), steps)

    def circulation_rate(self, ladder: Ladder) -> DoubleDouble:
        """The rate πλ/2K of the phase πu/2K, rad/s."""
        j1, j2, j3 = self.moments
        mean = multiply(scaled(add(self.a, self.b), 0.5), ladder.factor)
        return divide(mean, square_root(multiply(multiply(j1, j2), j3)))

    def precession_rate(self, ladder: Ladder, steps: int) -> DoubleDouble:
        """Mean rate, rad/s, at which the third axis circles the momentum; see `herpolhode.precession_rate`."""
        j1, _, j3 = self.moments
        third = self._mean_third(ladder, steps)
        share, rest = multiply(j1, self.c3), multiply(j3, self.c1)
        swing = divide(add(share, multiply(rest, third)), add(share, rest))
        weighted = add(j1, scaled(multiply(self.d31, swing), self.sense))
        return divide(multiply(self.momentum, weighted), multiply(j1, j3))

    def _mean_third(self, ladder: Ladder, steps: int) -> DoubleDouble:
        """(1 − n) Π(n|m)/K with 1 − n = m1/(1 − ν); see `elliptic_integrals.mean_third`."""
        j1, _, j3 = self.moments
        one = multiply(j1, self.d32)
        near = multiply(one, self.b)
        far = multiply(add(one, multiply(j3, self.d21)), self.a)
        total = mean_sum(divide(subtract(near, far), add(near, far)), ladder.shortfalls, steps)
        n1 = divide(multiply(near, self.b), multiply(far, self.a))
        return add(n1, multiply(subtract(ONE, n1), scaled(total, 0.5)))
