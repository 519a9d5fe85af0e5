"""States of a `GeneralMotion` that never returns: on the separatrix, with a `HyperbolicWave` of infinite period."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from lie_rigid_body.arithmetic.double_double import DoubleDouble, from_integer
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.clock import endless_phase, turns_from_zero
from lie_rigid_body.motion.closed_form.course import Course, course, course_row, state
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.hyperbolic_wave import (
    HyperbolicNumbers,
    HyperbolicWave,
    hyperbolic_crest,
    hyperbolic_numbers,
)
from lie_rigid_body.motion.closed_form.samples import BLOCK, Sample, put, store


class Separatrix(NamedTuple):
    """Constants: the rate and the start of the wave's phase, the rate of half of ψ, the wave and the course."""

    rate: DoubleDouble
    start: DoubleDouble
    half_rate: DoubleDouble
    wave: HyperbolicNumbers
    course: Course


def separatrix_row(motion: GeneralMotion, wave: HyperbolicWave) -> list[Number]:
    """The constants in a row, of one motion or of many."""
    clock, half_turn = motion.polhode_clock, motion.half_turn_clock
    polynomials = [*wave.sn, *wave.cn, *wave.dn, *wave.denominator, *wave.sine, *wave.cosine]
    return [*clock.rate, *clock.start, *half_turn.rate, 0.0, *polynomials, *course_row(motion)]


@kernel
def separatrix(row: Sequence[Number]) -> Separatrix:
    """The constants from their row."""
    rate, start = (row[0], row[1]), (row[2], row[3])
    return Separatrix(rate, start, (row[4], row[5]), hyperbolic_numbers(row, 6), course(row, 31))


@kernel
def separatrix_state(constants: Separatrix, time: DoubleDouble) -> Sample:
    """The state at a time in ns."""
    crest = hyperbolic_crest(constants.wave, endless_phase(constants.rate, constants.start, time))
    return state(constants.course, crest, turns_from_zero(constants.half_rate, time))


def fill(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of many; see `samples.SIGNATURE`."""
    for b in range(len(members)):
        constants = separatrix(table[:, b])
        for begin in range(0, len(t_ns), BLOCK):
            times = t_ns[begin : begin + BLOCK]
            for i in range(len(times)):
                put(columns, i, separatrix_state(constants, from_integer(times[i])))
            store(columns, len(times), attitude[members[b]], rate[members[b]], first + begin)
