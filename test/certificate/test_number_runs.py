"""Runs of numbers: what they hold, lack and list is that of Python's own lists."""

from __future__ import annotations

import itertools
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from phrases import PHRASES

from lie_rigid_body.certificate.stamps import DUPLICATE, GAP, PAGE, Lost, NumberRuns, RunList, StampTally
from lie_rigid_body.foundation.arrays import runs_of
from lie_rigid_body.simulation import SampleClock

NUMBERS = st.one_of(
    st.integers(-3, 12), st.integers(PAGE - 3, PAGE + 3), st.integers(5 * PAGE, 5 * PAGE + 4), st.just(2**50)
)
SPAN = st.tuples(st.integers(-5, 6 * PAGE), st.integers(-5, 6 * PAGE)).map(sorted)


@given(st.lists(st.lists(NUMBERS, min_size=1), max_size=4), SPAN)
def test_numbers_are_counted_as_in_a_list(batches, span):
    numbers, found = [k for batch in batches for k in batch], NumberRuns()
    for batch in batches:
        found.add(np.array(batch, dtype=np.int64))
    first, last = span
    edges, times = found.counted(first, last)
    assert [edges[0], edges[-1]] == [first, last + 1]
    for k in {first, last, *(k + step for k in numbers for step in (-1, 0, 1) if first <= k + step <= last)}:
        assert times[np.searchsorted(edges, k, side="right") - 1] == numbers.count(k)
    runs = RunList(3)
    runs.add(edges[:-1][times == 0], edges[1:][times == 0] - 1)
    ends = [first - 1, *sorted({k for k in numbers if first <= k <= last}), last + 1]
    missing = [(a + 1, b - 1) for a, b in itertools.pairwise(ends) if a + 1 < b]
    assert (runs.count, runs.listed) == (len(missing), missing[:3])
    assert runs.total == sum(b - a + 1 for a, b in missing)
    assert runs.first() == [k for a, b in missing for k in range(a, min(a + 3, b + 1))][:3]


@given(st.lists(st.booleans(), max_size=9))
def test_runs_are_those_of_a_list(which):
    begins, ends = runs_of(4, np.array(which, dtype=np.bool_))
    kept = [k for a, b in zip(begins, ends, strict=True) for k in range(a, b + 1)]
    assert kept == [4 + i for i, of in enumerate(which) if of]
    assert (begins[1:] > ends[:-1] + 1).all()


@given(st.lists(NUMBERS.filter(lambda k: k < 2**50), min_size=1, max_size=30), st.sets(NUMBERS), st.integers(1, 7))
def test_lost_samples_are_no_gap_and_must_not_be_there(numbers, lost, batch):
    clock, last = SampleClock(0, 10.0), 5 * PAGE + 4
    tally = StampTally(clock)
    for i in range(0, len(numbers), batch):
        tally.add(np.array([clock.stamp_ns(k) for k in numbers[i : i + batch]]))
    which = Lost(0, PAGE + 2, lambda first, count: np.isin(np.arange(first, first + count), [*lost]))
    away = {k for k in lost if 0 <= k < PAGE + 2}
    assert which.count(0, last) == len(away)
    found = {(fault.kind, PHRASES["lost"] in fault.text): fault for fault in tally.faults("imu", 0, last, which)}
    due = set(range(last + 1)) - away - set(numbers)
    doubled = sorted(k for k in set(numbers) if numbers.count(k) > 1)
    for key, expected in (
        ((GAP, False), sorted(due)),
        ((DUPLICATE, True), sorted(away & set(numbers))),
        ((DUPLICATE, False), doubled),
    ):
        assert (key in found) == bool(expected)
        if expected:
            assert (found[key].count, found[key].sample) == (len(expected), expected[0])


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.9])
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
    assert sum(fault.count for fault in tally.faults("imu", 0, count - 1)) == count - np.count_nonzero(there)
