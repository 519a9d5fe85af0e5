"""The verdict about a covariance over many runs, with errors drawn from known covariances."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import covariances
from lie_rigid_body.evaluation.ensemble_consistency import COVERAGES, ensemble_consistency, mean_bounds
from lie_rigid_body.foundation.errors import InputError


@pytest.mark.parametrize(
    "kind", ["stationary", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("constant", "growing"))]
)
@pytest.mark.parametrize(
    ("wrong", "verdicts", "cause"),
    [
        ("honest", {"honest"}, ""),
        ("variance × 1.5", {"conservative"}, "factor"),
        ("variance ÷ 1.5", {"overconfident"}, "factor"),
        ("about the body's axes", {"overconfident"}, "axes"),
        ("standard deviations", {"conservative"}, "standard_deviation"),
        ("degrees", {"conservative"}, "degrees"),
        ("cross-covariances negated", {"overconfident"}, "cross_covariances"),
        ("too small from 40 s on", {"overconfident", "changing"}, ""),
    ],
)
def test_what_is_wrong_is_named(kind, wrong, verdicts, cause):
    found = [covariances.judged(kind, wrong, 1000 + number) for number in range(3)]
    right = [each.verdict in verdicts and each.cause == cause for each in found]
    assert sum(right) >= 2, found  # of the benchmark's 100 campaigns 95 are
    if not cause and wrong != "honest":
        begins = [interval.begin_s for each in found for interval in each.outside]
        assert np.median(begins) == pytest.approx(covariances.LATE, abs=2.0)


def test_the_interval_of_a_mean_has_its_probability():
    draws = np.random.default_rng(5)
    for freedom in (3, 30):
        inside = 0
        for _ in range(400):
            low, high = mean_bounds(draws.chisquare(freedom, 40), 0.05)
            inside += low < freedom < high
        assert stats.binomtest(inside, 400, 0.95).pvalue > 1e-3


def test_coverage_is_that_of_chi_square():
    errors, covariance = covariances.drawn("stationary", np.random.default_rng(3))
    found = ensemble_consistency(covariances.TIMES, errors, covariance)
    for share in COVERAGES:
        assert found.coverage[share] == pytest.approx(share, abs=0.04)
    assert found.passed is (found.verdict == "honest")


def test_one_dimension_is_judged_as_well():
    draws = np.random.default_rng(8)
    errors = draws.normal(size=(50, 20, 1))
    assert ensemble_consistency(np.arange(20.0), errors, np.full((50, 20, 1, 1), 1.0)).passed
    found = ensemble_consistency(np.arange(20.0), errors, np.full((50, 20, 1, 1), 4.0))
    assert (found.verdict, found.cause) == ("conservative", "factor")
    assert found.factor_bounds[0] < 0.25 < found.factor_bounds[1]


def test_what_cannot_be_judged_is_refused():
    errors, covariance = covariances.drawn("constant", np.random.default_rng(1))
    with pytest.raises(InputError):
        ensemble_consistency(covariances.TIMES, errors[:9], covariance[:9])
    with pytest.raises(InputError):
        ensemble_consistency(covariances.TIMES, errors, -covariance)
    with pytest.raises(InputError):
        ensemble_consistency(covariances.TIMES, errors, covariance, axes="earth")


@pytest.mark.filterwarnings("error")
def test_what_has_no_number_or_another_shape_is_refused():
    errors, covariance = covariances.drawn("stationary", np.random.default_rng(1))
    times, attitude = covariances.TIMES, np.tile([0.0, 0.0, 0.0, 1.0], (*errors.shape[:2], 1))
    for value in (np.nan, np.inf, 1e300):  # the square of the last overflows
        wrong = errors.copy()
        wrong[3, 5, 1] = value
        with pytest.raises(InputError, match=r"^errors: "):
            ensemble_consistency(times, wrong, covariance)
    for name, t_s, e, P, q in (
        ("errors", times, errors[0], covariance, attitude),
        ("covariance", times, errors, covariance[0], attitude),
        ("t_s", times[1:], errors, covariance, attitude),
        ("t_s", times[np.newaxis], errors, covariance, attitude),
        ("attitude_xyzw", times, errors, covariance, attitude[0]),
    ):
        with pytest.raises(InputError, match=f"^{name}: "):
            ensemble_consistency(t_s, e, P, q)


def test_lists_and_one_covariance_of_all_are_read():
    errors, covariance = covariances.drawn("stationary", np.random.default_rng(1))
    assert ensemble_consistency(
        covariances.TIMES.tolist(), errors.tolist(), covariance[0, 0].tolist()
    ) == ensemble_consistency(covariances.TIMES, errors, covariance)
