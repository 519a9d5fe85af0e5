"""Phases that grow in proportion to time, at any time of 64-bit nanoseconds, without loss.

A phase is kept in turns. Whole turns in one nanosecond change nothing, so the rate is first reduced to at most half
a turn; what is left is multiplied by the time in double-double.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from lie_rigid_body.arithmetic.double_double import DoubleDouble, add, from_decimal, multiply, remainder
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import kernel

_SECONDS = Decimal("1e-9")

_FASTEST = Decimal("1e12")
"""Of an endless clock, per nanosecond: faster ones are at their end within one as well."""


@dataclass(frozen=True)
class Clock:
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
    def of(cls, rate: Decimal, start: Decimal, period: Decimal) -> Clock:
        """A clock from a rate in units per second, a start and a period in the same units."""
        turns = _SECONDS * rate / period, start / period
        rate_turns, start_turns = (from_decimal(x - x.to_integral_value()) for x in turns)
        return cls(rate_turns, start_turns, from_decimal(period))

    def begin(self) -> Number:
        """The phase at the start."""
        return multiply(self.start, self.period)[0]


@dataclass(frozen=True)
class EndlessClock:
    """A phase that never returns, as on the separatrix: a clock of infinite period."""

    rate: DoubleDouble
    start: DoubleDouble

    @classmethod
    def of(cls, rate: Decimal, start: Decimal) -> EndlessClock:
        """A clock from a positive rate in units per second and a start in the same units."""
        return cls(from_decimal(min(_SECONDS * rate, _FASTEST)), from_decimal(start))

    def begin(self) -> Number:
        """The phase at the start."""
        return self.start[0]


@kernel
def turns(rate: DoubleDouble, start: DoubleDouble, time: DoubleDouble) -> DoubleDouble:
    """The phase of a `Clock` at these nanoseconds since the start, in turns in [−½, ½]."""
    return remainder(add(multiply(rate, time), start))


@kernel
def turns_from_zero(rate: DoubleDouble, time: DoubleDouble) -> DoubleDouble:
    """The same for a clock that starts at 0."""
    return remainder(multiply(rate, time))


@kernel
def endless_phase(rate: DoubleDouble, start: DoubleDouble, time: DoubleDouble) -> DoubleDouble:
    """The phase of an `EndlessClock` at these nanoseconds since the start."""
    return add(multiply(rate, time), start)
