"""Phases that grow in proportion to time, reduced without loss at any time of 64-bit nanoseconds.

A periodic phase is kept in turns. Whole turns per nanosecond change nothing at whole nanoseconds, so the rate is first
reduced to at most half a turn. The rate times the time, plus the start, less the nearest integer, all in double-double,
is the phase in [−½, ½]. It is wrong by at most 2⁻¹⁰¹ of the turns gone through, and of one turn.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.decimals import NANOSECOND, PI
from lie_rigid_body.arithmetic.double_double import (
    DoubleDouble,
    add,
    fast_two_sum,
    from_decimal,
    multiply,
    remainder,
)
from lie_rigid_body.arithmetic.numbers import Number, magnitude, nearest

_MAX_RATE: Final = Decimal("1e12")
"""Cap on the phase rate of an `EndlessClock`, 1/ns; the phase saturates within 1 ns anyway."""


class PhaseClock(NamedTuple):
    """A phase modulo a period.

    Attributes
    ----------
    rate, start : DoubleDouble
        In turns per nanosecond and in turns, in [−½, ½].
    period : DoubleDouble
        One turn, in the unit of the phase.
    """

    rate: DoubleDouble
    start: DoubleDouble
    period: DoubleDouble

    @classmethod
    def of(cls, rate: Decimal, start: Decimal, period: Decimal) -> PhaseClock:
        """A clock from a rate in units per second, a start and a period in the same units."""
        return cls(_reduced(NANOSECOND * rate / period), _reduced(start / period), from_decimal(period))

    def initial_phase(self) -> float:
        """The phase at the start, in its unit."""
        return float(multiply(self.start, self.period)[0])

    def turns(self, time: DoubleDouble) -> DoubleDouble:
        """The phase at a time in ns since the start, in turns in [−½, ½]."""
        return remainder(add(multiply(self.rate, time), self.start))

    def folded_phase(self, time: DoubleDouble) -> tuple[DoubleDouble, Number]:
        """The phase less the nearest multiple of half a period, in its unit; −1 where that is an odd one, else 1."""
        turns = self.turns(time)
        half = 0.5 * nearest(2.0 * turns[0])
        # exact: what is left of half a turn
        folded = fast_two_sum(turns[0] - half, turns[1])
        return multiply(folded, self.period), 1.0 - 4.0 * magnitude(half)


class EndlessClock(NamedTuple):
    """A phase that never returns, as on the separatrix; rate per nanosecond and start in the unit of the phase."""

    rate: DoubleDouble
    start: DoubleDouble

    @classmethod
    def of(cls, rate: Decimal, start: Decimal) -> EndlessClock:
        """A clock from a positive rate in units per second and a start in the same units."""
        return cls(from_decimal(min(NANOSECOND * rate, _MAX_RATE)), from_decimal(start))

    def initial_phase(self) -> float:
        """The phase at the start, in its unit."""
        return float(self.start[0])

    def folded_phase(self, time: DoubleDouble) -> tuple[DoubleDouble, Number]:
        """The phase at a time in ns since the start, and 1, as it is never folded."""
        return add(multiply(self.rate, time), self.start), 1.0


def half_turn_rate(rate: Decimal) -> DoubleDouble:
    """Half of an angular rate in rad/s, in turns per nanosecond, less the nearest integer."""
    return _reduced(NANOSECOND * rate / (4 * PI))


def turns_from_zero(rate: DoubleDouble, time: DoubleDouble) -> DoubleDouble:
    """The phase at a time in ns, in turns in [−½, ½], from a rate in turns per nanosecond and a start at 0."""
    return remainder(multiply(rate, time))


def _reduced(turns: Decimal) -> DoubleDouble:
    return from_decimal(turns - turns.to_integral_value())
