"""The constants of ordinary motions, from doubles and pairs of doubles: of one in floats, of many in arrays."""

from __future__ import annotations

from decimal import Decimal
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.decimals import PI, working_precision
from lie_rigid_body.arithmetic.double_double import (
    ZERO,
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
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, sqrt
from lie_rigid_body.motion.closed_form.circular_wave import CircularWave
from lie_rigid_body.motion.closed_form.clock import Clock
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.hyperbolic_wave import HyperbolicWave
from lie_rigid_body.motion.closed_form.landen import Ladder, angle, imaginary_phase, nome, phase_squares
from lie_rigid_body.motion.closed_form.ordinary import Shape
from lie_rigid_body.motion.closed_form.ordinary_polhode import OrdinaryPolhode, Pairs
from lie_rigid_body.motion.closed_form.placement import Start, world

with working_precision(40):
    _TURN: Final = from_decimal(2 * PI)
    _PER_TURN: Final = from_decimal(1 / (2 * PI))
    _PER_NANOSECOND: Final = from_decimal(Decimal("1e-9") / (2 * PI))
    """Turns per nanosecond, in rad/s."""

_CIRCULAR_STEPS: Final = 2
_HYPERBOLIC_STEPS: Final = 4
_COARSE_STEPS: Final = 2
"""Steps with a gap of more than 0.2, where m > ½."""


class OrdinaryFrame(NamedTuple):
    """A `PrincipalFrame` in pairs.

    Attributes
    ----------
    moments, rate : 3 DoubleDouble
    sense : number
    axes : 3 rows of 3 numbers
        Columns are the frame's axes in the body frame.
    frame : 4 numbers
        conj(F) of `GeneralMotion`.
    """

    moments: Pairs
    rate: Pairs
    sense: Number
    axes: tuple[Triple, Triple, Triple]
    frame: Quadruple


def ordinary_motion(start: OrdinaryFrame, attitude: Quadruple, shape: Shape) -> GeneralMotion:
    """The motion from a frame and an attitude, placed in the world."""
    polhode = OrdinaryPolhode.of(start.moments, start.rate, start.sense)
    ladder = polhode.ladder(_HYPERBOLIC_STEPS if shape.hyperbolic else _CIRCULAR_STEPS)
    clock, wave = (_hyperbolic if shape.hyperbolic else _circular)(polhode, start, ladder)
    a1, a2, a3 = polhode.amplitudes()
    (j1, j2, j3), (w1, w2, w3) = polhode.moments, start.rate
    (m1, _), (m2, _), (m3, _) = (divide(multiply(j, a), polhode.momentum) for j, a in ((j1, a1), (j2, a2), (j3, a3)))
    (n1, _), (n2, _), (n3, _) = (divide(multiply(j, w), polhode.momentum) for j, w in ((j1, w1), (j2, w2), (j3, w3)))
    begin = Start(wave, clock.begin(), (n1, n2, n3), (n1, start.sense * n2))
    return GeneralMotion(
        polhode_clock=clock,
        half_turn_clock=_half_turn_clock(polhode, ladder, shape.steps),
        wave=wave,
        rate_amplitudes=(a1[0], start.sense * a2[0], a3[0]),
        direction_amplitudes=(m1, start.sense * m2, m3),
        slopes=(m1, m2),
        sense=start.sense,
        axes=start.axes,
        world=world(begin, start.frame, attitude, start.sense),
        frame=start.frame,
    )


def _half_turn_clock(polhode: OrdinaryPolhode, ladder: Ladder, steps: int) -> Clock:
    circulation = scaled(polhode.circulation_rate(ladder), polhode.sense)
    rate = subtract(polhode.precession_rate(ladder, steps), circulation)
    return Clock(multiply(scaled(rate, 0.5), _PER_NANOSECOND), ZERO, _TURN)


def _circular(polhode: OrdinaryPolhode, start: OrdinaryFrame, ladder: Ladder) -> tuple[Clock, CircularWave]:
    q = nome(ladder.gaps[0][0])
    j1, _, j3 = polhode.moments
    # −ν and m/−ν, the smaller of which comes from the zero of 1 − ν sn² that is farther away
    inner = divide(multiply(j3, polhode.d21), multiply(j1, polhode.d32))
    outer = divide(multiply(j1, polhode.c3), multiply(j3, polhode.c1))
    near = inner[0] > outer[0]
    value = imaginary_phase(choose(near, inner, outer), ladder.gaps)
    upright = 1.0 + sqrt(1.0 + value * value)
    larger = (value / upright) * (value / upright)
    decay, codecay = choose(near, (larger, q / larger), (q / larger, larger))
    fall, _ = choose(near, (2.0 / upright, 0.0), (1.0 - decay, 0.0))
    return _clock(polhode, start, ladder, _TURN, 0), CircularWave.of_nome(q, decay, codecay, fall)


def _hyperbolic(polhode: OrdinaryPolhode, start: OrdinaryFrame, ladder: Ladder) -> tuple[Clock, HyperbolicWave]:
    complementary = polhode.complementary_ladder(_CIRCULAR_STEPS)
    j1, _, j3 = polhode.moments
    sine, cosine = phase_squares(multiply(j1, polhode.d32), multiply(j3, polhode.d21), complementary.gaps, 0)
    size = sine[0] + cosine[0]
    mean = multiply(add(polhode.a, polhode.b), ladder.factor)
    comean = multiply(add(polhode.a, square_root(polhode.excess)), complementary.factor)
    # 2πK/K′
    period = multiply(_TURN, divide(comean, mean))
    quarter = scaled(period, 0.25)
    wave = HyperbolicWave.of_nome(
        q=nome(complementary.gaps[0][0]),
        quarter=quarter[0],
        sine=sqrt(sine[0] / size),
        cosine=sqrt(cosine[0] / size),
        drift=divide(angle(sine, cosine), quarter)[0],
    )
    return _clock(polhode, start, ladder, period, _COARSE_STEPS), wave


def _clock(polhode: OrdinaryPolhode, start: OrdinaryFrame, ladder: Ladder, period: DoubleDouble, steps: int) -> Clock:
    size = angle(*phase_squares(polhode.sine_square, polhode.cosine_square, ladder.gaps, steps))
    turns = multiply(size, _PER_TURN)
    backward = start.sense * start.rate[1][0] < 0.0
    return Clock(
        rate=multiply(polhode.circulation_rate(ladder), _PER_NANOSECOND),
        start=choose(backward, scaled(turns, -1.0), turns),
        period=period,
    )
