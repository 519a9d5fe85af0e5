"""Stamps are due when simulated time reaches them: neither drift nor loss, whatever the clock and the factor do."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.ros.timing.pace import Scaled, UpTo, pace_of
from lie_rigid_body.ros.timing.sink import FOREVER

FACTORS = [0.1, 0.3, 1 / 3, 0.7, 0.999, 1.0, 1.1, 2.0, 3.3, 29.97, 1000.0]
EPOCH = 1_700_000_000_123_456_789
START = 987_654_321
FAR = 10**18
"""ns: 1e9 s."""

factors = st.floats(0.1, 1000.0)
spans = st.integers(0, FAR)


def steady(factor: float) -> Scaled:
    made = pace_of(factor, EPOCH, START)
    assert isinstance(made, Scaled)
    return made


def reached(factor: float, span: int) -> Fraction:
    """When a stamp so long after the first is reached, in exact arithmetic; a factor is its shortest decimal."""
    return START + span / Fraction(repr(factor))


@given(factors, spans)
def test_a_stamp_is_due_exactly_when_it_is_reached(factor: float, span: int) -> None:
    exact, here = reached(factor, span), steady(factor)
    first = START + here.wait_ns(EPOCH + span, START)
    assert 0 <= first - exact < 1
    assert here.due_ns(first) >= EPOCH + span
    assert here.due_ns(first - 1) < EPOCH + span


@pytest.mark.parametrize("factor", FACTORS)
def test_no_drift_in_a_thousand_million_seconds(factor: float) -> None:
    here = steady(factor)
    assert 0 <= EPOCH + FAR * Fraction(repr(factor)) - here.due_ns(START + FAR) < 1
    assert abs(here.wait_ns(EPOCH + FAR, START + FAR) - (reached(factor, FAR) - START - FAR)) < 1


@given(factors, spans, st.integers(0, 10**10))
def test_what_is_due_never_becomes_less(factor: float, elapsed: int, later: int) -> None:
    here = steady(factor)
    now = START + elapsed
    assert here.due_ns(now) <= here.due_ns(now + later)
    assert here.due_ns(now + later) - here.due_ns(now) <= later * Fraction(repr(factor)) + 1


@pytest.mark.parametrize("factor", FACTORS)
def test_waiting_as_told_reaches_each_stamp_whatever_the_wakings(factor: float) -> None:
    """Random stalls, many wakings at one time: after the wait the stamp is due, and never before."""
    randomness, here = random.Random(1), steady(factor)
    now, stamp, period = START, EPOCH, 3_003_003
    for _ in range(3000):
        wait = here.wait_ns(stamp, now)
        assert (wait <= 0) == (stamp <= here.due_ns(now))
        now += max(0, wait) + randomness.choice([0, 0, 1, 1000, 3_000_000, 2_000_000_000])
        assert here.wait_ns(stamp, now) <= 0
        stamp += period


def test_a_stamp_is_overdue_by_as_long_as_it_was_due() -> None:
    here = steady(0.5)
    assert here.wait_ns(EPOCH + 50, START) == 100
    assert here.wait_ns(EPOCH + 50, START + 100) == 0
    assert here.wait_ns(EPOCH + 50, START + 140) == -40


def test_before_the_first_stamp_nothing_is_due() -> None:
    for factor in FACTORS:
        assert steady(factor).due_ns(START - 10**12) < EPOCH


def test_without_a_limit_everything_is_due_at_once() -> None:
    here = pace_of(0.0, EPOCH, START)
    assert here == UpTo(FOREVER)
    for now in (0, START, FAR):
        assert here.due_ns(now) >= FOREVER
        assert here.wait_ns(EPOCH + FAR, now) == 0


def test_what_is_halted_never_reaches_a_later_stamp() -> None:
    here = UpTo(EPOCH)
    for now in (0, START, START + FAR):
        assert here.due_ns(now) == EPOCH
        assert (here.wait_ns(EPOCH, now), here.wait_ns(EPOCH + 1, now)) == (0, FOREVER)
