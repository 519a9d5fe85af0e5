"""A score: association by stamps, what is remarked or refused, limits, and its JSON."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from motions import MOTIONS, STAMPS, attitude, codes, correlated, truth_of, turns

from lie_rigid_body.evaluation import Limits, SampledTruth, attitude_error
from lie_rigid_body.evaluation.causes import BY_CODE, fit
from lie_rigid_body.evaluation.clock import standard_error
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.lie import quaternion
from said import numbers
from untyped import evaluate, simulate

MOTION = "slow_tumble"
NOISY = quaternion.multiply(attitude(MOTION), turns(0.5, seed=2))


def test_the_json_has_the_promised_entries():
    score = evaluate(STAMPS, NOISY, truth_of(MOTION), limits=Limits.parse("0.1deg"), covariance=np.eye(3) * 1e-4)
    assert abs(score.lag_s) < 4.0 * score.lag_standard_error_s < 0.05
    found = json.loads(json.dumps(score.to_dict(), allow_nan=False))
    assert {"samples", "total_deg", "heading_deg", "inclination_deg", "lag_s", "findings", "passed"} <= set(found)
    for name in ("total_deg", "heading_deg", "inclination_deg"):
        assert list(found[name]) == ["rms", "median", "p95", "max", "final"]
    assert found["samples"] == len(STAMPS)
    assert found["lag_standard_error_s"] == score.lag_standard_error_s
    assert found["passed"] is False
    assert found["nees"] == {
        "mean": score.consistency.mean,
        "expected": 3.0,
        "inside": score.consistency.share_inside,
        "remark": "",
    }
    assert evaluate(STAMPS, NOISY, truth_of(MOTION), limits=Limits.parse("1deg", "10s:3deg"), diagnosed=False).passed


def test_the_series_are_in_the_json_on_request():
    score = evaluate(STAMPS, NOISY, truth_of(MOTION), covariance=np.eye(3) * 1e-4, diagnosed=False)
    assert "series" not in score.to_dict()
    series = json.loads(json.dumps(score.to_dict(series=True)))["series"]
    assert list(series) == ["stamps_ns", "total_deg", "heading_deg", "inclination_deg", "nees"]
    assert series["stamps_ns"] == STAMPS.tolist()
    assert max(series["total_deg"]) == score.total_deg.max


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "memory", "in_world"),
    [(MOTION, 0.0, False), (MOTION, 0.95, False), (MOTION, 0.98, True), ("fast_tumble", 0.98, True)],
)
def test_the_standard_error_of_the_lag_is_its_spread(motion, memory, in_world):
    """Also of errors that last for a second, far above the time between samples."""
    true, inner = attitude(motion, 0.03), slice(20, -20)
    causes = [BY_CODE[code] for code in ("heading_offset", "body_mounting", "lagging")]
    off, claimed = [], []
    for seed in range(24):
        draws = np.random.default_rng(seed)
        error = quaternion.exp(np.radians(0.5) * correlated(draws, len(STAMPS), memory))
        estimate = quaternion.multiply(error, true) if in_world else quaternion.multiply(true, error)
        track = Matched(STAMPS[inner], estimate[inner], truth_of(motion))
        fitted = fit([track], [(cause, np.zeros(cause.price)) for cause in causes])
        off.append(fitted[-1][1][0] - 0.03)
        claimed.append(standard_error(track, fitted))
    assert 0.6 < np.sqrt(np.mean(np.square(off)) / np.mean(np.square(claimed))) < 1.5


def test_far_errors_hardly_count_in_a_fit():
    """A tenth of the samples is 60° off, as while a filter converges; least squares would be off by degrees."""
    true = attitude(MOTION)
    far = quaternion.exp(np.where(np.arange(len(STAMPS))[:, np.newaxis] % 10, 0.0, [0.3, 0.2, 1.0]))
    estimate = quaternion.multiply(quaternion.exp([0.0, 0.0, 0.2]), quaternion.multiply(far, true))
    noisy = quaternion.multiply(estimate, turns(0.1, 5, len(STAMPS)))
    [(_, heading)] = fit([Matched(STAMPS, noisy, truth_of(MOTION))], [(BY_CODE["heading_offset"], np.zeros(1))])
    assert heading[0] == pytest.approx(0.2, abs=np.radians(0.02))


def test_statistics_are_those_of_the_error_at_the_stamps():
    t = np.sort(np.random.default_rng(0).choice(STAMPS[-1], 700, replace=False))
    truth = MOTIONS[MOTION].at(t).attitude_xyzw
    estimate = quaternion.multiply(truth, turns(2.0, 9, len(t)))
    score = evaluate(t, estimate, truth_of(MOTION), diagnosed=False)
    assert score.total_deg.max == np.degrees(attitude_error(estimate, truth).total.max())
    assert score.heading_deg.final == np.degrees(attitude_error(estimate, truth).heading[-1])
    assert score.t_s[-1] == (t[-1] - t[0]) / 1e9


@pytest.mark.parametrize("ratio", [10, 1])
def test_an_estimate_ten_times_as_fast_as_the_truth_is_compared_at_its_own_stamps(ratio):
    truth = SampledTruth(STAMPS[::ratio], attitude(MOTION)[::ratio])
    score = evaluate(STAMPS, NOISY, truth)
    exact = evaluate(STAMPS, NOISY, truth_of(MOTION), diagnosed=False)
    assert score.samples == len(STAMPS)
    assert abs(score.total_deg.max - exact.total_deg.max) <= score.truth_uncertainty_deg * 1.05 + 1e-12
    assert codes(score) == []


def test_samples_outside_the_truth_are_counted_and_a_late_begin_is_named():
    truth = SampledTruth(STAMPS[:1200], attitude(MOTION)[:1200])
    score = evaluate(STAMPS[600:], NOISY[600:], truth)
    assert (score.samples, score.outside) == (600, 301)
    late, outside = score.findings
    assert late.code == outside.code == "gaps"
    assert late.rms_deg_after == score.total_deg.rms
    early = evaluate(STAMPS[:900], NOISY[:900], truth_of(MOTION))
    assert codes(early) == ["gaps"]


def test_an_estimate_that_has_what_the_truth_lacks_does_not_begin_late():
    """As beside poses whose rate rises: the slower part is full of gaps."""
    given = np.r_[0:600:5, 600:1501]
    score = evaluate(STAMPS[:-1] + 1, NOISY[:-1], SampledTruth(STAMPS[given], attitude(MOTION)[given]))
    [finding] = score.findings
    assert finding.code == "gaps"
    assert numbers(finding.message) == [600, 1500]


def test_gaps_doubles_and_norms_are_named_and_the_rest_is_scored():
    kept = np.r_[0:400, 399, 500:1501]
    score = evaluate(STAMPS[kept], 1.02 * NOISY[kept], truth_of(MOTION))
    assert codes(score) == ["gaps", "gaps", "not_unit"]
    assert score.samples == 1401


def test_covariances_go_with_their_stamps():
    kept = np.r_[0:400, 399, 400:1501]
    P = np.tile(np.eye(3) * np.radians(0.5) ** 2, (len(kept), 1, 1))
    P[400] *= 1e9
    truth = SampledTruth(STAMPS[:1000], attitude(MOTION)[:1000])
    score = evaluate(STAMPS[kept], NOISY[kept], truth, covariance=P, diagnosed=False)
    assert score.consistency.remark == ""
    assert score.consistency.nees.shape == (1000,)


def test_no_lag_is_told_of_what_does_not_follow_the_truth():
    """Readings of a gyro that is at the end of its range, added up: some lag fits best, and explains nothing."""
    given: dict[str, Any] = {"sensor_grade": "tactical", "gyro_rate": "integrated", "motion": "closed_form"}
    run = simulate("thrown_disc", duration=20.0, imu_rate=50.0, **given)
    attitude = [run.truth.attitude_xyzw[0]]
    for turn in quaternion.exp(run.imu.gyro[1:] / 50.0):
        attitude.append(quaternion.multiply(attitude[-1], turn))
    score = run.score(attitude)
    assert score.total_deg.median > 60.0
    assert score.lag_s is None


def test_a_finding_that_would_leave_larger_errors_is_not_told():
    """The median of a small offset, beside errors of something else that undoing it makes larger."""
    large = np.arange(len(STAMPS)) % 5 < 2
    turn = np.radians(np.where(large, -100.0, 3.0))
    q = quaternion.multiply(quaternion.exp(turn[:, None] * [0.0, 0.0, 1.0]), NOISY)
    score = evaluate(STAMPS, q, truth_of(MOTION))
    assert [finding.code for finding in score.findings if finding.rms_deg_after > score.total_deg.rms] == []
    alone = evaluate(STAMPS[~large], q[~large], truth_of(MOTION))
    assert "heading_offset" in [finding.code for finding in alone.findings]


def test_no_digits_are_printed_below_round_off_and_the_nanoseconds_of_stamps():
    """Of an exact estimate: angles of some 1e-14 degrees, and a lag of far less than a nanosecond."""
    score = evaluate(STAMPS, attitude("slow_tumble"), truth_of("slow_tumble"))
    assert score.lag_s == pytest.approx(0.0, abs=1e-9)
    lines = {line.split()[0]: line.split()[1:] for line in str(score).splitlines() if line}
    assert lines["inclination"] == ["0"] * 5
    assert lines["lag"][0] == "+0"


@pytest.mark.parametrize("turn_deg", [0.5, 12.0])
def test_without_a_limit_an_estimate_settles_to_its_error_and_is_not_said_to_converge(turn_deg):
    wrong = quaternion.multiply(attitude(MOTION), quaternion.exp(np.radians([0.0, turn_deg, 0.0])))
    score = evaluate(STAMPS, wrong, truth_of(MOTION), diagnosed=False)
    assert score.settled_deg == pytest.approx(turn_deg)
    assert (score.time_to_converge_s, score.to_dict()["settled_deg"]) == (0.0, score.settled_deg)
    assert re.search(rf"^settles +to {turn_deg:g}° ", str(score), re.MULTILINE)
    limited = evaluate(STAMPS, wrong, truth_of(MOTION), diagnosed=False, converged_deg=1.0)
    assert limited.settled_deg is None
    assert (limited.time_to_converge_s is None) == (turn_deg > 1.0)
    assert re.search(r"^converged ", str(limited), re.MULTILINE)
