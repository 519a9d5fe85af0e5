"""Statistics, convergence and limits."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

from lie_rigid_body.evaluation import (
    AttitudeError,
    Estimate,
    Limits,
    SampledTruth,
    Statistics,
    bias_error,
    evaluate,
    time_to_converge,
)
from lie_rigid_body.evaluation.scoring import ScoreOptions, score_estimate
from lie_rigid_body.evaluation.statistics import Tally, largest_of_second_half, settling_limit
from said import numbers


def test_statistics_of_a_hundred_and_one_numbers():
    s = Statistics.of(np.arange(101.0)[::-1].copy())
    assert (s.median, s.p95, s.max, s.final) == (50.0, 95.0, 100.0, 0.0)
    assert s.rms == pytest.approx(np.sqrt(101 * 201 / 6 * 100 / 101))
    assert list(asdict(s)) == ["rms", "median", "p95", "max", "final"]


def test_tiny_errors_do_not_vanish_and_one_number_is_its_own_statistics():
    assert Statistics.of(np.array([3e-200, 4e-200])).rms == pytest.approx(np.sqrt(12.5) * 1e-200)
    assert set(asdict(Statistics.of(np.array([2.0]))).values()) == {2.0}
    assert Statistics.of(np.zeros(3)).rms == 0.0


def test_bias_error_is_the_norm():
    s = bias_error([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert (s.max, s.final) == (5.0, 1.0)
    assert bias_error([[3e200, 4e200, 0.0]], np.zeros((1, 3))).rms == pytest.approx(5e200)


@pytest.mark.parametrize(("limit", "time"), [(0.5, None), (1.0, 4.0), (3.0, 2.0), (9.0, 0.0)])
def test_time_to_converge_is_when_the_error_stays_below(limit, time):
    assert time_to_converge(10.0 + np.arange(5.0), np.array([8.0, 5.0, 2.0, 3.0, 1.0]), limit) == time


def test_what_is_not_known_has_not_converged():
    t = np.arange(4.0)
    assert time_to_converge(t, np.array([5.0, 4.0, 0.5, np.nan]), 1.5) is None
    assert time_to_converge(t, np.array([5.0, np.nan, 0.5, 0.5]), 1.5) == 2.0
    assert time_to_converge(t[:0], t[:0], 1.5) is None


def test_an_exponential_converges_to_its_noise_when_it_should():
    t = np.linspace(0.0, 60.0, 6001)
    errors = 20.0 * np.exp(-t / 2.0) + np.abs(np.random.default_rng(1).normal(size=t.size)) * 0.1
    limit = settling_limit(largest_of_second_half(t, errors))
    assert limit == pytest.approx(1.5 * 0.36, rel=0.1)
    assert time_to_converge(t, errors, limit) == pytest.approx(2.0 * np.log(20.0 / limit), abs=2.0)


@pytest.mark.parametrize(
    ("text", "degrees"), [("1deg", 1.0), ("0.5°", 0.5), (" 1e-2 rad ", 0.5729577951308232), ("5mrad", 0.286478897565)]
)
def test_angles_are_read(text, degrees):
    assert Limits.parse(text).max_rms_deg == pytest.approx(degrees, rel=1e-11)


@pytest.mark.parametrize(("text", "seconds"), [("10s", 10.0), ("500ms", 0.5), ("1.5 min", 90.0), (".5s", 0.5)])
def test_times_are_read(text, seconds):
    [(start, _)] = Limits.parse(max_after=f"{text}:1deg").max_after
    assert start == pytest.approx(seconds)


def tally_of(limits: Limits, t_s: np.ndarray, total_deg: np.ndarray) -> Tally:
    tally, total = Tally(limits), np.radians(total_deg)
    for some in np.array_split(np.arange(len(t_s)), 2):  # as they come
        if len(some):
            tally.add(np.round(1e9 * t_s[some]).astype(np.int64), AttitudeError(total[some], total[some], total[some]))
    return tally


def test_limits_name_what_breaks_them():
    t, e = np.arange(5.0), np.array([9.0, 3.0, 1.0, 1.0, 1.5])

    def broken(limits: Limits) -> list[list[float]]:
        return [numbers(told) for told in tally_of(limits, t, e).broken()]

    assert broken(Limits.parse("5deg", ("1s:4deg", "2s:1.5001deg"))) == []
    assert broken(Limits()) == []
    assert broken(Limits.parse("4deg")) == [[4.342, 4]]
    assert broken(Limits.parse(max_after="0s:8deg")) == [[9, 0, 8, 0]]
    assert broken(Limits.parse(max_after="1min:8deg")) == [[4, 60]]


def test_a_limit_is_not_kept_where_little_was_compared():
    def broken(limits: Limits, compared: int, given: int, span_s: float, due_s: float) -> list[list[float]]:
        tally = tally_of(limits, np.linspace(0.0, span_s, compared), np.zeros(compared))
        return [numbers(told) for told in tally.broken(given, round(1e9 * due_s))]

    limits = Limits(1.0)
    assert broken(limits, 500, 1000, 10.0, 20.0) == []
    assert broken(Limits(), 1, 1000, 0.04, 20.0) == []
    assert broken(limits, 3, 1000, 0.04, 20.0) == [[3, 1000], [0.04, 20]]
    assert broken(limits, 1, 1, 0.0, 0.0) == []
    estimate = Estimate(np.tile([0.0, 0.0, 0.0, 1.0], (9, 1)), np.arange(9))
    truth = SampledTruth(estimate.t_ns[:4], estimate.attitude_xyzw[:4])
    options = ScoreOptions(limits, diagnosed=False)
    assert score_estimate(estimate, truth, ScoreOptions(diagnosed=False)).passed
    for score in (score_estimate(estimate, truth, options), score_estimate(estimate[:4], truth, options, left_out=5)):
        assert [numbers(told) for told in score.broken] == [[4, 9]]


def test_what_is_wrong_all_the_time_has_not_converged():
    stamps = np.arange(100) * 10_000_000
    truth = np.tile([0.0, 0.0, 0.0, 1.0], (100, 1))
    score = evaluate(stamps, np.roll(truth, 1, axis=1), SampledTruth(stamps, truth))
    assert score.time_to_converge_s is None
    assert score.converged_deg == 20.0
