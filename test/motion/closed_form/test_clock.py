"""Phases of clocks against exact fractions, at any time and on both sides of where they are folded."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.arithmetic import double_double
from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.motion.closed_form.clock import EndlessClock, PhaseClock

PERIODS = st.sampled_from(["1", "6.28318530717958647692528676655900576839433879875021", "1e-3", "137.25"])
RATES = st.decimals("-1e4", "1e4", places=30, allow_nan=False)
STARTS = st.decimals("-1e3", "1e3", places=30, allow_nan=False)
STAMPS = st.integers(-(2**63), 2**63 - 1)
HALF = Fraction(1, 2)


def made(rate: str | Decimal, start: str | Decimal, period: str) -> PhaseClock:
    with working_precision(80):
        return PhaseClock.of(Decimal(rate), Decimal(start), Decimal(period))


def exact_turns(rate, start, period, t_ns: int) -> Fraction:
    """In [−½, ½)."""
    exact = (Fraction(rate) * t_ns / 10**9 + Fraction(start)) / Fraction(period)
    return (exact + HALF) % 1 - HALF


def seconds(t_ns: int) -> double_double.DoubleDouble:
    return double_double.from_integers(np.array([t_ns], dtype=np.int64))


def apart(difference: Fraction) -> Fraction:
    """The distance from a whole number of turns."""
    return abs((difference + HALF) % 1 - HALF)


def tolerance(rate, period, t_ns: int) -> Fraction:
    """Of a phase as a pair, in turns: 2⁻¹⁰¹ of the turns gone through, at most ½ in a nanosecond, and of one."""
    each = min(abs(Fraction(rate)) / 10**9 / Fraction(period), HALF)
    return (each * abs(t_ns) + 1) * Fraction(2) ** -101


def require(rate, start, period, t_ns: int) -> None:
    clock, exact = made(rate, start, period), exact_turns(rate, start, period, t_ns)
    allowed = tolerance(rate, period, t_ns)
    phase_in_turns: Any = clock.turns(seconds(t_ns))
    [hi], [lo] = phase_in_turns
    assert abs(hi) <= 0.5
    assert apart(Fraction(float(hi)) + Fraction(float(lo)) - exact) <= allowed
    allowed += Fraction(2) ** -53
    folded_and_parity: Any = clock.folded_phase(seconds(t_ns))
    ([phase], _), [parity] = folded_and_parity
    folded = Fraction(float(phase)) / Fraction(period)
    assert abs(folded) <= Fraction(1, 4) + allowed
    assert parity in (-1.0, 1.0)
    assert apart(folded + (0 if parity > 0.0 else HALF) - exact) <= allowed
    assert parity == (1.0 if abs(exact) < 0.25 else -1.0) or abs(abs(exact) - Fraction(1, 4)) <= allowed


@given(RATES, STARTS, PERIODS, STAMPS)
def test_a_phase_is_right_at_any_time(rate: Decimal, start: Decimal, period: str, t_ns: int):
    require(rate, start, period, t_ns)


@pytest.mark.parametrize("side", ["0", "1e-17", "-1e-17", "1e-15", "-1e-15", "1e-9", "-1e-9"])
@pytest.mark.parametrize("quarter", ["0", "0.25", "-0.25", "0.5", "-0.5"])
def test_a_phase_is_right_beside_each_quarter_of_a_turn(quarter: str, side: str):
    for rate in ("0", "1", "-3e9", "123456789.123456789", "-499999999.9"):
        for t_ns in (0, 1, -1, 10**9, 2**63 - 1, -(2**63)):
            require(rate, Decimal(quarter) + Decimal(side), "1", t_ns)


@given(RATES, STARTS, STAMPS)
def test_a_phase_without_a_period_grows_for_ever(rate: Decimal, start: Decimal, t_ns: int):
    with working_precision(80):
        clock = EndlessClock.of(rate, start)
    grown_phase: Any = clock.folded_phase(seconds(t_ns))[0]
    [phase], _ = grown_phase
    grown, begun = Fraction(rate) * t_ns / 10**9, Fraction(start)
    assert (
        abs(Fraction(float(phase)) - grown - begun)
        <= abs(grown + begun) * Fraction(2) ** -53 + (abs(grown) + abs(begun)) * Fraction(2) ** -100
    )
