"""States of a `GeneralMotion` with a `HyperbolicWave` and a period."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

from lie_rigid_body.arithmetic.double_double import (
    DoubleDouble,
    fast_two_sum,
    from_integer,
    multiply,
    remainder,
    two_sum,
)
from lie_rigid_body.arithmetic.elementary import exponential
from lie_rigid_body.arithmetic.numbers import Number, magnitude, nearest
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.clock import turns, turns_from_zero
from lie_rigid_body.motion.closed_form.course import Course, course, course_row, state
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.hyperbolic_wave import (
    HyperbolicNumbers,
    HyperbolicWave,
    hyperbolic_crest,
    hyperbolic_numbers,
)
from lie_rigid_body.motion.closed_form.samples import BLOCK, Sample, put, store
from lie_rigid_body.motion.closed_form.wave import Crest

_HALF_TURN: Final = 0.25 / math.pi
"""Of a radian, half, in turns."""


class Hyperbolic(NamedTuple):
    """Constants: the clock of the wave, the rate of half of ψ, its growth with χ in turns, the wave and the course."""

    rate: DoubleDouble
    start: DoubleDouble
    period: DoubleDouble
    half_rate: DoubleDouble
    drift: Number
    wave: HyperbolicNumbers
    course: Course


def hyperbolic_row(motion: GeneralMotion, wave: HyperbolicWave, period: DoubleDouble) -> list[Number]:
    """The constants in a row, of one motion or of many."""
    clock, half_turn = motion.polhode_clock, motion.half_turn_clock
    nome, _ = exponential(2.0 * wave.quarter)
    polynomials = [*wave.sn, *wave.cn, *wave.dn, *wave.denominator, *wave.sine, *wave.cosine]
    clocks = [*clock.rate, *clock.start, *period, *half_turn.rate]
    return [*clocks, motion.sense * wave.drift * _HALF_TURN, nome, *polynomials, *course_row(motion)]


@kernel
def hyperbolic(row: Sequence[Number]) -> Hyperbolic:
    """The constants from their row."""
    rate, start = (row[0], row[1]), (row[2], row[3])
    period, half_rate = (row[4], row[5]), (row[6], row[7])
    return Hyperbolic(rate, start, period, half_rate, row[8], hyperbolic_numbers(row, 9), course(row, 34))


@kernel
def hyperbolic_state(constants: Hyperbolic, time: DoubleDouble) -> Sample:
    """The state at a time in ns."""
    phase, parity = folded_phase(turns(constants.rate, constants.start, time), constants.period)
    crest = hyperbolic_crest(constants.wave, phase)
    half_turn = turns_from_zero(constants.half_rate, time)
    growth = two_sum(half_turn[0], constants.drift * phase[0])
    half_turn = remainder(fast_two_sum(growth[0], growth[1] + half_turn[1]))
    return state(constants.course, turned_over(crest, parity), half_turn)


@kernel
def folded_phase(turns: DoubleDouble, period: DoubleDouble) -> tuple[DoubleDouble, Number]:
    """The phase less the half turn nearest to it, and −1 where that is one, else 1."""
    half = 0.5 * nearest(2.0 * turns[0])
    folded = fast_two_sum(turns[0] - half, turns[1])
    return multiply(folded, period), 1.0 - 4.0 * magnitude(half)


@kernel
def turned_over(crest: Crest, parity: Number) -> Crest:
    """The crest half a period later, where the parity is −1: of the libration nothing changes."""
    return Crest(parity * crest.sn, parity * crest.cn, crest.dn, parity * crest.sine, parity * crest.cosine)


def fill(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of many; see `samples.SIGNATURE`."""
    for b in range(len(members)):
        constants = hyperbolic(table[:, b])
        for begin in range(0, len(t_ns), BLOCK):
            times = t_ns[begin : begin + BLOCK]
            for i in range(len(times)):
                put(columns, i, hyperbolic_state(constants, from_integer(times[i])))
            store(columns, len(times), attitude[members[b]], rate[members[b]], first + begin)
