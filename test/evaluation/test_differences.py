"""Intervals of differences between estimates, held against processes whose difference is known."""

from __future__ import annotations

import numpy as np
import pytest
from motions import correlated
from scipy import stats
from scipy.signal import lfilter

from lie_rigid_body.evaluation.differences import MAX_SAMPLES, blocks_of, of_run, of_runs
from said import numbers
from sampled import sampled


def sizes(draws: np.random.Generator, count: int, memory: float) -> np.ndarray:
    return np.linalg.norm(correlated(draws, count, memory), axis=1)


@pytest.mark.parametrize("memory", sampled([0.98, 0.9, 0.0], 3))
def test_errors_that_are_alike_differ_in_few_intervals(memory):
    draws, inside = np.random.default_rng(3), 0
    for number in range(60):
        found = of_run(sizes(draws, 3000, memory), sizes(draws, 3000, memory), number)
        inside += not found.is_sure
    assert stats.binomtest(inside, 60, 0.95).pvalue > 1e-3


def test_intervals_know_that_errors_are_correlated():
    draws = np.random.default_rng(4)
    width = {}
    for memory in (0.0, 0.98):
        found = of_run(sizes(draws, 3000, memory), sizes(draws, 3000, memory))
        width[memory] = found.high - found.low
    assert 4.0 < width[0.98] / width[0.0] < 14.0  # of the squares: the root of (1 + a²) / (1 - a²), 7


def test_a_difference_is_found_with_its_size():
    draws = np.random.default_rng(5)
    found = of_run(1.2 * sizes(draws, 2 * MAX_SAMPLES, 0.9), sizes(draws, 2 * MAX_SAMPLES, 0.9))
    assert found.is_sure
    assert 0.0 < found.low < 0.2 * np.sqrt(3.0) < found.high


def test_blocks_are_longer_the_longer_a_process_remembers():
    draws = np.random.default_rng(6)
    lengths = [blocks_of(lfilter([1.0], [1.0, -memory], draws.normal(size=5000)))[0] for memory in (0.0, 0.8, 0.95)]
    # of a process of first order Politis and White have (6 n a² / (1 - a²)²)^(1/3)
    assert lengths[0] <= 10
    assert lengths[1] == pytest.approx((6 * 5000 * 0.64 / 0.36**2) ** (1 / 3), rel=0.5)
    assert lengths[2] == pytest.approx((6 * 5000 * 0.9025 / 0.0975**2) ** (1 / 3), rel=0.5)
    assert blocks_of(np.ones(100)) == (1, 1.0)


def test_runs_in_which_either_failed_are_left_out():
    draws = np.random.default_rng(7)
    first = draws.gamma(4.0, 1.0, 100)
    second = first + draws.normal(0.3, 0.2, 100)
    first[:3], second[5] = np.nan, np.nan
    found = of_runs(first, second)
    both = np.isfinite(first - second)
    assert (found.runs, found.left_out) == (96, 4)
    assert found.better == int(np.sum((first < second)[both]))
    assert found.low < -0.3 < found.high
    assert numbers(found.sentence("a", "b"))[-2:] == [found.better, 96]
    same, few = of_runs(second, second + draws.normal(0.0, 0.2, 100)), of_runs(np.ones(3), np.zeros(3))
    assert [(each.is_sure, each.runs) for each in (same, few)] == [(False, 99), (False, 3)]
    assert few.low == -np.inf


def test_too_few_have_no_interval():
    assert not of_run(np.ones(5), 2.0 * np.ones(5)).is_sure
    assert not of_runs(np.ones(5), 2.0 * np.ones(5)).is_sure


@pytest.mark.parametrize("of", [of_run, of_runs])
def test_lists_are_read_as_arrays_are(of):
    draws = np.random.default_rng(8)
    first, second = draws.gamma(4.0, 1.0, (2, 50))
    assert of(first.tolist(), second.tolist()) == of(first, second)
