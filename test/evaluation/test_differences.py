"""Ratios of errors over paired runs, held against SciPy and against filters whose ratio is known."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy import stats

import paired_runs
from lie_rigid_body.evaluation.differences import MAX_EXACT, MAX_MEANS, fewest_runs, of_pairs, of_runs
from said import numbers


def pair(number, runs=25, diverging=0.0):
    return paired_runs.drawn(np.random.default_rng(number), runs, 2, diverging)


@pytest.mark.parametrize("runs", [12, 40, 200])
def test_the_value_p_is_that_of_scipy_and_the_interval_is_its_inversion(runs):
    """The ratio 1 is in the interval if and only if the test of one pair is above 5 %."""
    shown = []
    for number in range(20):
        first, second = pair(number, runs)
        ratio = 1.0 - 0.02 * number
        found = of_runs(ratio * first, second)
        logarithms = np.log(ratio * first / second)
        assert found.p == pytest.approx(stats.wilcoxon(logarithms).pvalue)
        means = [0.5 * (a + b) for i, a in enumerate(logarithms) for b in logarithms[i:]]
        assert found.ratio == pytest.approx(np.exp(np.median(means)))
        if abs(found.p - 0.05) > 0.005:
            assert found.is_shown == (not found.low <= 1.0 <= found.high)
        assert found.factor == pytest.approx(np.sqrt(found.high / found.low))
        shown.append(found.is_shown)
    assert {*shown} == {True, False}


@pytest.mark.parametrize("diverging", [0.0, 0.05])
def test_intervals_hold_the_ratio_as_often_as_they_say(diverging):
    held = 0
    for number in range(150):
        first, second = pair(number, 15, diverging)
        found = of_runs(0.7 * first, second)
        held += found.low <= 0.7 <= found.high
    assert stats.binomtest(held, 150, 0.95).pvalue > 1e-3


def test_one_pair_of_equal_filters_among_many_is_hardly_ever_shown():
    draws = np.random.default_rng(3)
    any_shown = 0
    for _ in range(60):
        found = of_pairs([*combinations(paired_runs.drawn(draws, 12, 4, 0.05), 2)])
        any_shown += any(each.is_shown for each in found)
    assert stats.binomtest(any_shown, 60, 0.05, alternative="greater").pvalue > 1e-3


def test_the_values_of_several_pairs_are_adjusted_by_holm():
    ratios = (0.75, 0.8, 0.9, 1.0)
    pairs = [(ratio * first, second) for ratio, (first, second) in zip(ratios, map(pair, range(4)), strict=True)]
    raw = np.array([of_runs(*each).p for each in pairs])
    order = np.argsort(raw)
    wanted = np.minimum(1.0, np.maximum.accumulate(raw[order] * [4, 3, 2, 1]))
    found = of_pairs(pairs)
    assert [found[at].p for at in order] == pytest.approx(wanted)
    assert [each.pairs for each in found] == [4] * 4
    assert of_pairs(pairs, 10)[order[0]].p == pytest.approx(min(1.0, 10 * raw.min()))
    wider = [of_pairs(pairs)[0], of_pairs(pairs, 10)[0]]
    assert wider[0].low > wider[1].low
    assert wider[0].high < wider[1].high


@pytest.mark.parametrize(("pairs", "runs"), [(1, 6), (6, 8), (15, 10)])
def test_fewer_runs_than_can_show_anything_have_no_interval(pairs, runs):
    assert fewest_runs(pairs) == runs
    errors = np.linspace(1.0, 2.0, runs)
    several = [(errors * 0.5 * np.linspace(1.0, 1.1, runs), errors)] * pairs
    enough = of_pairs(several)[0]
    assert (enough.is_shown, enough.low > 0.0) == (True, True)
    few = of_pairs([(first[1:], second[1:]) for first, second in several])[0]
    assert (few.low, few.high, few.factor) == (0.0, np.inf, np.inf)
    said = few.sentence("a", "b")
    assert numbers(said) == [runs - 1, runs, pairs]


def test_a_run_without_an_answer_counts_as_half_a_turn():
    first, second = pair(1)
    lost = np.where(np.arange(25) < 3, np.nan, first)
    turned = np.where(np.arange(25) < 3, 180.0, first)
    found = of_runs(lost, second)
    assert found.without_answer == (3, 0)
    other = of_runs(turned, second)
    assert (found.ratio, found.p) == (other.ratio, other.p)
    assert numbers(found.sentence("a", "b"))[-2:] == [3, 180]
    none = np.full(25, np.nan)
    assert of_runs(none, np.full(25, 18.0)).ratio == pytest.approx(10.0)
    assert (of_runs(none, none).p, of_runs(none, none).ratio) == (1.0, 1.0)


def test_a_difference_that_is_shown_is_told_as_a_ratio():
    first, second = pair(2)
    found = of_runs(0.5 * first, second)
    assert found.is_shown
    assert numbers(found.sentence("a", "b")) == pytest.approx([found.ratio, found.low, found.high], rel=5e-3)
    swapped = of_runs(second, 0.5 * first)
    assert [swapped.ratio, swapped.low] == pytest.approx([1.0 / found.ratio, 1.0 / found.high])


def test_equal_errors_and_round_off_are_no_difference():
    first, _ = pair(3)
    for other in (first, first * (1.0 + 1e-13)):
        found = of_runs(first, other)
        assert (found.p, found.ratio, found.factor) == (1.0, 1.0, 1.0)
    assert of_runs(np.zeros(25), np.zeros(25)).p == 1.0
    assert of_runs(np.zeros(25), first).is_shown


def test_more_runs_than_are_exact_have_the_same_interval():
    """The normal distribution of the ranks, and quantiles in place of all logarithms."""
    draws = np.random.default_rng(5)
    logarithms = draws.normal(-0.1, 0.5, 2 * MAX_MEANS)
    found = of_runs(np.exp(logarithms), np.ones(len(logarithms)))
    half = 1.96 * np.sqrt(np.pi / 3.0) * 0.5 / np.sqrt(len(logarithms))  # of normal errors: efficiency 3/π
    assert np.log(found.factor) == pytest.approx(half, rel=0.1)
    exact, normal = (of_runs(np.exp(logarithms[:n]), np.ones(n)) for n in (MAX_EXACT, MAX_EXACT + 1))
    assert np.log(exact.factor) == pytest.approx(np.log(normal.factor), rel=0.1)
    assert of_runs([], []).factor == np.inf


def test_lists_are_read_as_arrays_are():
    first, second = pair(8)
    assert of_runs(first.tolist(), second.tolist()) == of_runs(first, second)
