"""States of a `GeneralMotion` with a `CircularWave`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from lie_rigid_body.arithmetic.double_double import DoubleDouble, from_integer
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.circular_wave import (
    CircularNumbers,
    CircularWave,
    circular_crest,
    circular_numbers,
)
from lie_rigid_body.motion.closed_form.clock import turns, turns_from_zero
from lie_rigid_body.motion.closed_form.course import Course, course, course_row, state
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.samples import BLOCK, Sample, put, store


class Circular(NamedTuple):
    """Constants: the rate and the start of the wave's clock, the rate of half of ψ, the wave and the course."""

    rate: DoubleDouble
    start: DoubleDouble
    half_rate: DoubleDouble
    wave: CircularNumbers
    course: Course


def circular_row(motion: GeneralMotion, wave: CircularWave) -> list[Number]:
    """The constants in a row, of one motion or of many."""
    clock, half_turn = motion.polhode_clock, motion.half_turn_clock
    polynomials = [*wave.sn, *wave.cn, *wave.dn, *wave.denominator, *wave.sine, *wave.cosine]
    return [*clock.rate, *clock.start, *half_turn.rate, 2.0 * wave.nome, *polynomials, *course_row(motion)]


@kernel
def circular(row: Sequence[Number]) -> Circular:
    """The constants from their row."""
    rate, start, half_rate = (
        (row[0], row[1]),
        (row[2], row[3]),
        (row[4], row[5]),
    )
    return Circular(rate, start, half_rate, circular_numbers(row, 6), course(row, 31))


@kernel
def circular_state(constants: Circular, time: DoubleDouble) -> Sample:
    """The state at a time in ns."""
    s, c = sine_cosine(turns(constants.rate, constants.start, time))
    half_turn = turns_from_zero(constants.half_rate, time)
    return state(constants.course, circular_crest(constants.wave, s, c), half_turn)


def fill(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of many; see `samples.SIGNATURE`."""
    for b in range(len(members)):
        constants = circular(table[:, b])
        for begin in range(0, len(t_ns), BLOCK):
            times = t_ns[begin : begin + BLOCK]
            for i in range(len(times)):
                put(columns, i, circular_state(constants, from_integer(times[i])))
            store(columns, len(times), attitude[members[b]], rate[members[b]], first + begin)
