"""Stamps are due when simulated time reaches them: neither drift nor loss, whatever the clock and the factor do."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.ros.timing.pace import Scaled, UpTo, pace_of
from lie_rigid_body.ros.timing.sink import FOREVER

EPOCH = 1_700_000_000_123_456_789
START = 987_654_321
FAR = 10**18
"""ns: 1e9 s."""

factors = st.floats(0.1, 1000.0) | st.sampled_from([0.1, 0.3, 1 / 3, 0.7, 0.999, 1.0, 1.1, 29.97, 1000.0])
spans = st.integers(0, FAR)


def steady(factor: float) -> Scaled:
    made = pace_of(factor, EPOCH, START)
    assert isinstance(made, Scaled)
    return made


def reached(factor: float, span: int) -> Fraction:
    """When a stamp so long after the first is reached, in exact arithmetic; a factor is its shortest decimal."""
    return START + span / Fraction(repr(factor))


@given(factors, spans, spans)
def test_a_stamp_is_due_exactly_when_it_is_reached(factor: float, span: int, elapsed: int) -> None:
    """At whatever time it is asked for, before and after: nothing drifts, and after the wait it is due."""
    exact, here, now = reached(factor, span), steady(factor), START + elapsed
    first = now + here.wait_ns(EPOCH + span, now)
    assert 0 <= first - exact < 1
    assert here.due_ns(first) >= EPOCH + span > here.due_ns(first - 1)


@given(factors, spans, st.integers(0, 10**10))
def test_what_is_due_never_becomes_less(factor: float, elapsed: int, later: int) -> None:
    here = steady(factor)
    now = START + elapsed
    assert here.due_ns(now) <= here.due_ns(now + later)
    assert here.due_ns(now + later) - here.due_ns(now) <= later * Fraction(repr(factor)) + 1


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
