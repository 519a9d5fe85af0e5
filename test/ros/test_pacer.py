"""Samples are due when their stamps are reached: neither drift nor loss, whatever the clock does."""

from __future__ import annotations

import random

import pytest

from lie_rigid_body.ros.pacer import Pacer
from lie_rigid_body.simulation import SampleClock

RATES = [0.01, 1.0, 3.0, 29.97, 100.0, 200.0, 999.9, 1e3, 1e6, 1e9]
EPOCH = 1_700_000_000_123_456_789
OFFSET = 987_654_321 - EPOCH


@pytest.mark.parametrize("rate", RATES)
def test_a_sample_is_due_at_its_stamp_and_not_before(rate: float) -> None:
    clock = SampleClock(EPOCH, rate)
    pacer = Pacer(clock, OFFSET)
    for number in (0, 1, 2, 7, 1000, 10**6):
        [stamp] = clock.stamps_ns(number, 1).tolist()
        # ties are rounded to even in stamps: one nanosecond of freedom
        assert pacer.samples_due(number, stamp + OFFSET - 2) == 0
        assert pacer.samples_due(number, stamp + OFFSET + 1) >= 1
        assert abs(pacer.lateness_ns(number, stamp + OFFSET)) <= 1


@pytest.mark.parametrize("rate", RATES)
def test_as_many_are_due_as_stamps_have_passed(rate: float) -> None:
    clock = SampleClock(EPOCH, rate)
    pacer = Pacer(clock, OFFSET)
    for count in (1, 2, 3, 500):
        stamps = clock.stamps_ns(40, count)
        assert pacer.samples_due(40, int(stamps[-1]) + OFFSET + (0 if rate == 1e9 else 1)) == count


def test_nothing_is_lost_whatever_the_wakings() -> None:
    """Random stalls, many wakings at one time: every number comes once."""
    randomness = random.Random(1)
    clock = SampleClock(EPOCH, 333.3)
    pacer = Pacer(clock, OFFSET)
    now, taken = EPOCH + OFFSET, 0
    for _ in range(5000):
        now += randomness.choice([0, 1, 1000, 3_000_000, 2_000_000_000])
        taken += pacer.samples_due(taken, now)
        assert pacer.samples_due(taken, now) == 0
        assert pacer.lateness_ns(taken, now) < 0
    last, following = clock.stamps_ns(taken - 1, 2).tolist()
    assert last <= now - OFFSET < following


def test_no_drift_in_a_year() -> None:
    clock = SampleClock(0, 1000.0 / 3.0)
    year = 365 * 86_400
    due = Pacer(clock, 0).samples_due(0, year * 10**9)
    assert abs(due - 1 - year * clock.rate) <= 1.0


def test_before_the_epoch_nothing_is_due() -> None:
    assert Pacer(SampleClock(EPOCH, 100.0), OFFSET).samples_due(0, EPOCH + OFFSET - 10**12) == 0
