"""Runs of numbers: what they lack and have twice is that of Python's own lists."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.certificate import stamps
from lie_rigid_body.certificate.stamps import GAP, NumberRuns, StampTally, without_lost
from lie_rigid_body.foundation.arrays import runs_of
from lie_rigid_body.simulation import SampleClock

PAGE = 7
NUMBERS = st.one_of(st.integers(-3, 12), st.integers(PAGE - 3, PAGE + 3), st.integers(30, 34), st.just(2**50))
SPAN = st.tuples(st.integers(-5, 40), st.integers(-5, 40)).map(sorted)


def numbers_of(begins, ends) -> list[int]:
    return [k for a, b in zip(begins.tolist(), ends.tolist(), strict=True) for k in range(a, b + 1)]


@given(st.lists(st.lists(NUMBERS, min_size=1), min_size=1, max_size=4), SPAN, st.sets(st.integers(-5, 40)))
def test_missing_and_doubled_numbers_are_those_of_a_list(batches, span, lost):
    numbers, found = [k for batch in batches for k in batch], NumberRuns()
    for batch in batches:
        found.add(np.array(batch, dtype=np.int64))
    first, last = span
    begins, ends = found.missing(first, last)
    missing = sorted({*range(first, last + 1)} - {*numbers})
    assert numbers_of(begins, ends) == missing
    count, least = found.doubled()
    assert count == len(numbers) - len({*numbers})
    assert not count or least == min(k for k in numbers if numbers.count(k) > 1)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(stamps, "_PAGE", PAGE)
        for at_most in (stamps.MAX_MISSING, PAGE):
            patched.setattr(stamps, "MAX_MISSING", at_most)
            kept = numbers_of(*without_lost(begins, ends, lambda some: np.isin(some, [*lost])))
            assert kept == (missing if len(missing) > at_most else [k for k in missing if k not in lost])


@given(st.lists(st.booleans(), max_size=9))
def test_runs_are_those_of_a_list(which):
    begins, ends = runs_of(4, np.array(which, dtype=np.bool_))
    assert numbers_of(begins, ends) == [4 + i for i, of in enumerate(which) if of]
    assert (begins[1:] > ends[:-1] + 1).all()


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_samples_between_lost_ones_take_some_bytes_each(share):
    clock, count = SampleClock(0, 1000.0), 500_000
    there = np.random.default_rng(5).random(count) >= share
    tracemalloc.start()
    try:
        tally = StampTally(clock)
        for i in range(0, count, 2**16):
            numbers = i + np.flatnonzero(there[i : i + 2**16])
            tally.add(1_000_000 * numbers)
        kept, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert kept < 20 * count * share * (1 - share) + 500_000
    gaps = [fault.count for fault in tally.faults("imu", 0, count - 1) if fault.kind == GAP]
    assert sum(gaps) == count - np.count_nonzero(there)
