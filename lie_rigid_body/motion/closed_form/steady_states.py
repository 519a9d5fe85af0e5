"""States of a `SteadyMotion`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from lie_rigid_body.arithmetic.double_double import DoubleDouble, from_integer
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, sqrt
from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.closed_form.clock import turns_from_zero
from lie_rigid_body.motion.closed_form.course import quadruple, triple
from lie_rigid_body.motion.closed_form.placement import multiply
from lie_rigid_body.motion.closed_form.samples import BLOCK, Sample, put, store
from lie_rigid_body.motion.closed_form.steady_motion import SteadyMotion


class Steady(NamedTuple):
    """Constants: the rate of half of the turn, q₀, the quaternion q₀ ⊗ axis, and ω."""

    half_rate: DoubleDouble
    attitude: Quadruple
    across: Quadruple
    body_rate: Triple


def steady_row(motion: SteadyMotion) -> list[Number]:
    """The constants in a row, of one motion or of many."""
    x, y, z = motion.axis
    return [*motion.half_turn.rate, *motion.attitude, *multiply(motion.attitude, (x, y, z, 0.0)), *motion.rate]


@kernel
def steady(row: Sequence[Number]) -> Steady:
    """The constants from their row."""
    return Steady((row[0], row[1]), quadruple(row, 2), quadruple(row, 6), triple(row, 10))


@kernel
def steady_state(constants: Steady, time: DoubleDouble) -> Sample:
    """The state at a time in ns."""
    s, c = sine_cosine(turns_from_zero(constants.half_rate, time))
    p, q, (u, v, w) = constants.attitude, constants.across, constants.body_rate
    x, y, z, r = p[0] * c + q[0] * s, p[1] * c + q[1] * s, p[2] * c + q[2] * s, p[3] * c + q[3] * s
    size = 1.0 / sqrt((x * x + y * y) + (z * z + r * r))
    return x * size, y * size, z * size, r * size, u, v, w


def fill(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of many; see `samples.SIGNATURE`."""
    for b in range(len(members)):
        constants = steady(table[:, b])
        for begin in range(0, len(t_ns), BLOCK):
            times = t_ns[begin : begin + BLOCK]
            for i in range(len(times)):
                put(columns, i, steady_state(constants, from_integer(times[i])))
            store(columns, len(times), attitude[members[b]], rate[members[b]], first + begin)
