"""The constants of regular motions in double-double: of one motion in floats, of many in arrays.

The fast tier: the same constants as `decimal_constants`, of nearly all motions (99.7 % of random bodies and rates).

What it buys, measured against decimals for all: a start costs 2.5 times less for one body, and 35 to 55 times less in
an ensemble of 4000. This is because decimals cannot be taken as arrays. What it costs: this file, `fast_frames` and
`landen`, a second derivation of every constant, which test_fast_constants holds against mpmath on both sides of every
switch. Neither tier can do without the other. Beside the separatrix, and with moments that differ by round-off, 32
digits are too few. As the bits of a motion must be the same alone and in an ensemble, one body cannot be left to
decimals.

Formulas and names are those of `decimal_constants`, without the exact determinant: 32 digits are enough where a motion
keeps away from the separatrix (see `fast_frames`). The rates that time multiplies come out to 2⁻⁸⁴ of the body rate,
5e-16 rad in 1e10 rad. Quotients of one denominator are kept as their numerators.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.decimals import NANOSECOND, PI, working_precision
from lie_rigid_body.arithmetic.double_double import (
    ONE,
    DoubleDouble,
    add,
    choose,
    divide,
    from_decimal,
    multiply,
    scaled,
    square_root,
    subtract,
)
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, sqrt, triple
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.motion.closed_form.attitude import GeneralMotion, Members, world_rotation
from lie_rigid_body.motion.closed_form.clock import PhaseClock
from lie_rigid_body.motion.closed_form.fast_frames import CoupledBody, DiagonalBody, FastFrame, Vector
from lie_rigid_body.motion.closed_form.jacobi import ImaginaryTheta, RealTheta
from lie_rigid_body.motion.closed_form.landen import (
    ArithmeticGeometricMean,
    angle,
    imaginary_phase,
    nome,
    phase_squares,
    third_kind_sum,
)
from lie_rigid_body.motion.motion import InitialConditions

Columns: TypeAlias = tuple[Array, ...]
"""Arrays with an element for each motion, in the order of `_columns`."""

with working_precision(40):
    _TURN: Final = from_decimal(2 * PI)
    _PER_TURN: Final = from_decimal(1 / (2 * PI))
    _PER_NANOSECOND: Final = from_decimal(NANOSECOND / (2 * PI))
    """Factor from rad/s to turns/ns, 1e-9/2π."""

_CIRCULAR_STEPS: Final = 2
_HYPERBOLIC_STEPS: Final = 4
"""Landen's steps in double-double for m ≤ ½ and for m > ½, after which the gap is below 2e-5."""
_COARSE_STEPS: Final = 2
"""Steps with a gap of more than 0.2, for m > ½."""

LEAST_MOTIONS_IN_ARRAYS: Final = 24
"""Smallest number of motions computed in arrays: fewer are faster one by one, in floats."""

MOTIONS_PER_BLOCK: Final = 4096
"""Largest number of motions computed together: their numbers then stay in a processor's cache."""


@dataclass(frozen=True)
class FastPolhode:
    """The polhode of a regular motion.

    Attributes
    ----------
    frame : FastFrame
        J₁, J₂, J₃, the initial ω and the sense.
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

    frame: FastFrame
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
    def of(cls, frame: FastFrame) -> FastPolhode:
        """The polhode of a frame."""
        j1, j2, j3 = frame.moments
        d21, d31, d32 = (scaled(subtract(p, q), frame.sense) for p, q in ((j2, j1), (j3, j1), (j3, j2)))
        q1, q2, q3 = (multiply(j, multiply(w, w)) for j, w in zip(frame.moments, frame.rate, strict=True))
        sine_square, cosine_square, transverse = multiply(d32, q2), multiply(d31, q1), multiply(d21, q2)
        c1, c3 = add(transverse, multiply(d31, q3)), add(sine_square, cosine_square)
        c2 = subtract(multiply(d32, q3), multiply(d21, q1))
        return cls(
            frame=frame,
            d21=d21,
            d31=d31,
            d32=d32,
            c1=c1,
            c3=c3,
            momentum=square_root(add(add(multiply(j1, q1), multiply(j2, q2)), multiply(j3, q3))),
            sine_square=sine_square,
            cosine_square=cosine_square,
            # m1 = d31 c2/(d32 c1), m = d21 c3/(d32 c1)
            a=square_root(multiply(d32, c1)),
            b=square_root(multiply(d31, c2)),
            excess=multiply(d21, c3),
        )

    def amplitudes(self) -> Vector:
        """A₁, A₂, A₃, rad/s."""
        j1, j2, j3 = self.frame.moments
        return (
            square_root(divide(self.c3, multiply(j1, self.d31))),
            square_root(divide(self.c3, multiply(j2, self.d32))),
            square_root(divide(self.c1, multiply(j3, self.d31))),
        )

    def mean(self, steps: int) -> ArithmeticGeometricMean:
        """The mean of 1 and √m1, which is π/2K (DLMF 19.8.5)."""
        # d = (a − b)/(a + b) = (a² − b²)/(a + b)²
        total = add(self.a, self.b)
        return ArithmeticGeometricMean.of(divide(self.excess, multiply(total, total)), steps)

    def complementary_mean(self, steps: int) -> ArithmeticGeometricMean:
        """The mean of 1 and √m, which is π/2K′."""
        total = add(self.a, square_root(self.excess))
        return ArithmeticGeometricMean.of(divide(multiply(self.b, self.b), multiply(total, total)), steps)

    def circulation_rate(self, mean: ArithmeticGeometricMean) -> DoubleDouble:
        """The rate πλ/2K of the phase πu/2K, rad/s."""
        # λ = a/√(J₁J₂J₃), and the mean of 1 and b/a is ½(1 + b/a) times its factor
        j1, j2, j3 = self.frame.moments
        scaled_mean = multiply(scaled(add(self.a, self.b), 0.5), mean.factor)
        return divide(scaled_mean, square_root(multiply(multiply(j1, j2), j3)))

    def precession_rate(self, mean: ArithmeticGeometricMean, steps: int) -> DoubleDouble:
        """Mean rate, rad/s, at which the third axis circles the momentum; see `decimal_constants.precession_rate`."""
        j1, _, j3 = self.frame.moments
        third = self._mean_third(mean, steps)
        # share and rest are as m to −ν
        share, rest = multiply(j1, self.c3), multiply(j3, self.c1)
        swing = divide(add(share, multiply(rest, third)), add(share, rest))
        weighted = add(j1, scaled(multiply(self.d31, swing), self.frame.sense))
        return divide(multiply(self.momentum, weighted), multiply(j1, j3))

    def _mean_third(self, mean: ArithmeticGeometricMean, steps: int) -> DoubleDouble:
        """(1 − n) Π(n|m)/K with 1 − n = m1/(1 − ν); see `elliptic_integrals.mean_third`."""
        j1, _, j3 = self.frame.moments
        one = multiply(j1, self.d32)
        # 1 − ν = (J₁d32 + J₃d21)/(J₁d32), so that p² = 1 − n is to √m1 as near to far
        near = multiply(one, self.b)
        far = multiply(add(one, multiply(j3, self.d21)), self.a)
        total = third_kind_sum(divide(subtract(near, far), add(near, far)), mean.shortfalls, steps)
        n1 = divide(multiply(near, self.b), multiply(far, self.a))
        return add(n1, multiply(subtract(ONE, n1), scaled(total, 0.5)))


def fast_motion(start: FastFrame, attitude: Quadruple, hyperbolic: bool, steps: int) -> GeneralMotion:
    """The motion from its frame, the attitude at the start, and what its computation branches on."""
    polhode = FastPolhode.of(start)
    mean = polhode.mean(_HYPERBOLIC_STEPS if hyperbolic else _CIRCULAR_STEPS)
    clock, theta = (_hyperbolic if hyperbolic else _circular)(polhode, mean)
    amplitudes = polhode.amplitudes()
    (a1, _), (a2, _), (a3, _) = amplitudes
    m1, m2, m3 = _direction(polhode, amplitudes)
    n1, n2, n3 = _direction(polhode, start.rate)
    libration = theta.libration(clock.initial_phase())
    return GeneralMotion(
        phase_clock=clock,
        half_turn_rate=_half_turn_rate(polhode, mean, steps),
        theta=theta,
        rate_amplitudes=(a1, start.sense * a2, a3),
        direction_amplitudes=(m1, start.sense * m2, m3),
        transverse=(m1, m2),
        sense=start.sense,
        axes=start.axes,
        world_xyzw=world_rotation(
            libration, (n1, n2, n3), (n1, start.sense * n2), start.sense, start.frame_xyzw, attitude
        ),
        frame_xyzw=start.frame_xyzw,
    )


def _direction(polhode: FastPolhode, rate: Vector) -> list[Number]:
    """The unit momentum of a rate in the frame."""
    return [divide(multiply(j, w), polhode.momentum)[0] for j, w in zip(polhode.frame.moments, rate, strict=True)]


def _half_turn_rate(polhode: FastPolhode, mean: ArithmeticGeometricMean, steps: int) -> DoubleDouble:
    """Mean rate of ψ/2, turns/ns: of the precession, less the turn of n about the third axis."""
    circulation = scaled(polhode.circulation_rate(mean), polhode.frame.sense)
    rate = subtract(polhode.precession_rate(mean, steps), circulation)
    return multiply(scaled(rate, 0.5), _PER_NANOSECOND)


def _circular(polhode: FastPolhode, mean: ArithmeticGeometricMean) -> tuple[PhaseClock, RealTheta]:
    """The clock of ζ and the theta functions for m ≤ ½."""
    q = nome(mean.gaps[0][0])
    j1, _, j3 = polhode.frame.moments
    # −ν and m/−ν are 1/sc² at a and at K′ − a: the larger is that of the smaller argument, at most ½K′
    inner = divide(multiply(j3, polhode.d21), multiply(j1, polhode.d32))
    outer = divide(multiply(j1, polhode.c3), multiply(j3, polhode.c1))
    near = inner[0] > outer[0]
    # 1/sinh α, from which e^(−α) = value/(1 + coth α); the nome is the product of e^(−2α) and q e^(2α)
    value = imaginary_phase(choose(near, inner, outer), mean.gaps)
    upright = 1.0 + sqrt(1.0 + value * value)
    larger = (value / upright) * (value / upright)
    decay, codecay = choose(near, (larger, q / larger), (q / larger, larger))
    fall, _ = choose(near, (2.0 / upright, 0.0), (1.0 - decay, 0.0))
    return _clock(polhode, mean, _TURN, 0), RealTheta.of(q, decay, codecay, fall)


def _hyperbolic(polhode: FastPolhode, mean: ArithmeticGeometricMean) -> tuple[PhaseClock, ImaginaryTheta]:
    """The clock of χ and the theta functions for m > ½."""
    complementary = polhode.complementary_mean(_CIRCULAR_STEPS)
    j1, _, j3 = polhode.frame.moments
    # β = πa/2K′ from sc²(a|m1) = 1/−ν
    sine, cosine = phase_squares(multiply(j1, polhode.d32), multiply(j3, polhode.d21), complementary.gaps, 0)
    size = sine[0] + cosine[0]
    # K/K′ is the mean of 1 and √m over that of 1 and √m1
    denominator = multiply(add(polhode.a, polhode.b), mean.factor)
    numerator = multiply(add(polhode.a, square_root(polhode.excess)), complementary.factor)
    # 2πK/K′
    period = multiply(_TURN, divide(numerator, denominator))
    quarter = scaled(period, 0.25)
    theta = ImaginaryTheta.of(
        q=nome(complementary.gaps[0][0]),
        quarter=quarter[0],
        sine=sqrt(sine[0] / size),
        cosine=sqrt(cosine[0] / size),
        drift=divide(angle(sine, cosine), quarter)[0],
    )
    return _clock(polhode, mean, period, _COARSE_STEPS), theta


def _clock(polhode: FastPolhode, mean: ArithmeticGeometricMean, period: DoubleDouble, steps: int) -> PhaseClock:
    """The clock of a period in the unit of its phase, by so many Landen's steps in double-double for its start."""
    size = angle(*phase_squares(polhode.sine_square, polhode.cosine_square, mean.gaps, steps))
    turns = multiply(size, _PER_TURN)
    backward = polhode.frame.sense * polhode.frame.rate[1][0] < 0.0
    return PhaseClock(
        rate=multiply(polhode.circulation_rate(mean), _PER_NANOSECOND),
        start=choose(backward, scaled(turns, -1.0), turns),
        period=period,
    )


def fast_motions(starts: InitialConditions) -> Iterator[tuple[GeneralMotion, Members]]:
    """The regular motions of an ensemble with their places: many that branch alike as one motion of arrays."""
    columns = _columns(starts)
    count = len(starts.states)
    groups = _groups(columns) if count >= LEAST_MOTIONS_IN_ARRAYS else np.zeros(count, dtype=np.intp)
    for group in sorted(set(groups[groups >= 0].tolist())):  # np.unique loads masked arrays
        members = np.flatnonzero(groups == group)
        if len(members) < LEAST_MOTIONS_IN_ARRAYS:
            yield from _one_by_one(columns, members)
            continue
        hyperbolic, steps = group // 2 % 2 == 1, group // 4
        for begin in range(0, len(members), MOTIONS_PER_BLOCK):
            some = members[begin : begin + MOTIONS_PER_BLOCK]
            numbers = _indices_first(columns, some)
            x, y, z, w = numbers[3]
            yield fast_motion(_body(numbers, products=group % 2 == 1).frame(), (x, y, z, w), hyperbolic, steps), some


def _columns(starts: InitialConditions) -> Columns:
    """Inertia, principal moments and axes, attitude and body rate of each motion."""
    bodies, states = starts.bodies, starts.states
    return bodies.inertia, bodies.principal_moments, bodies.principal_axes, states.attitude_xyzw, states.body_rate


def _one_by_one(columns: Columns, members: Members) -> Iterator[tuple[GeneralMotion, Members]]:
    for i in members:
        motion = fast_motion_of_one(*(column[i].tolist() for column in columns))
        if motion is not None:
            yield motion, np.array([i])


def fast_motion_of_one(
    inertia: list[list[float]],
    moments: list[float],
    axes: list[list[float]],
    attitude_xyzw: list[float],
    body_rate: list[float],
) -> GeneralMotion | None:
    """The motion of one body, or None if it is not regular."""
    products = inertia[0][1] != 0.0 or inertia[0][2] != 0.0 or inertia[1][2] != 0.0
    body = _body((inertia, moments, axes, attitude_xyzw, body_rate), products=products)
    regular, hyperbolic, steps = body.classified()
    if not regular:
        return None
    x, y, z, w = attitude_xyzw
    return fast_motion(body.frame(), (x, y, z, w), hyperbolic, steps)


def _groups(columns: Columns) -> NDArray[np.intp]:
    """Numbers of groups that branch alike: 1 for products of inertia, 2 for m > ½, 4 per step; −1 if not regular."""
    straight = (columns[0][:, [0, 0, 1], [1, 2, 2]] == 0.0).all(axis=1)
    groups = np.full(len(straight), -1)
    with np.errstate(all="ignore"):
        for products, members in enumerate((np.flatnonzero(straight), np.flatnonzero(~straight))):
            body = _body(_indices_first(columns, members), products=products == 1)
            regular, hyperbolic, steps = body.classified()
            groups[members] = np.where(regular, products + 2 * hyperbolic + 4 * steps, -1)
    return groups


def _body(numbers: Any, *, products: bool) -> DiagonalBody | CoupledBody:
    """The body of one motion, from lists, or of many, from arrays that end with their axis; see `_columns`."""
    inertia, moments, axes, _, rate = numbers
    if products:
        first, second, third = zip(*axes, strict=True)
        return CoupledBody(inertia, moments, (first, second, third), rate)
    return DiagonalBody.of((inertia[0][0], inertia[1][1], inertia[2][2]), triple(rate, 0))


def _indices_first(columns: Columns, members: Members) -> list[Array]:
    return [np.ascontiguousarray(np.moveaxis(column[members], 0, -1)) for column in columns]
