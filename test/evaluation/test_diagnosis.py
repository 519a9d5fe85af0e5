"""Every mistaken convention, constant turn and shift of time is found in noise; where there is none, none is found."""

from __future__ import annotations

import re

import numpy as np
import pytest
from motions import (
    FAULTS,
    FRD,
    MOTIONS,
    NED,
    PERIOD_NS,
    PLACES,
    STAMPS,
    UNTOLD,
    about_up,
    attitude,
    codes,
    correlated,
    truth_of,
    turns,
)

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import ExactTruth, SampledTruth
from lie_rigid_body.evaluation.causes import undone
from lie_rigid_body.evaluation.explanations import FORMS, Explanation, matrix
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.lie import quaternion
from said import numbers
from sampled import sampled
from untyped import evaluate

NOISE_DEG = 1.0
motions = pytest.mark.parametrize("motion", MOTIONS)
SAMPLES_LATE = [-1.0, -3.0, 0.123, 30.0]
two_motions = pytest.mark.parametrize("motion", ["dzhanibekov", pytest.param("slow_tumble", marks=pytest.mark.slow)])


def lasting(time_s):
    return correlated(np.random.default_rng(11), len(STAMPS), np.exp(-PERIOD_NS / 1e9 / time_s))


def noisy(motion, lag_s=0.0, size_deg=NOISE_DEG, seed=3):
    return quaternion.multiply(attitude(motion, lag_s), turns(size_deg, seed))


def one_of_each(values):
    """Each value with one motion, and each motion with one value; the rest of the pairs takes long."""
    return [
        pytest.param(motion, value, marks=pytest.mark.slow if (i - j) % len(MOTIONS) else ())
        for i, motion in enumerate(MOTIONS)
        for j, value in enumerate(values)
    ]


@pytest.mark.parametrize(("motion", "fault"), one_of_each(FAULTS))
def test_a_fault_is_named_with_what_is_left(motion, fault):
    score = evaluate(STAMPS, FAULTS[fault](noisy(motion)), truth_of(motion))
    assert codes(score) == [fault]
    assert score.findings[0].rms_deg_after == pytest.approx(NOISE_DEG * np.sqrt(3), rel=0.05)


@two_motions
@pytest.mark.parametrize(
    ("faults", "named"),
    sampled(
        [
            (("heading_offset", "inverted"), ["inverted", "heading_offset"]),
            (("body_mounting", "scalar_first"), ["scalar_first", "body_mounting"]),
            (("inverted", "scalar_first"), ["scalar_first", "inverted"]),
            (("heading_offset", "body_mounting"), ["body_mounting", "heading_offset"]),
            (("heading_offset", "ned_world"), ["ned_world", "heading_offset"]),
        ],
        every=2,
    ),
)
def test_two_faults_at_once_are_both_named_the_larger_first(motion, faults, named):
    estimate = noisy(motion)
    for fault in faults:
        estimate = FAULTS[fault](estimate)
    score = evaluate(STAMPS, estimate, truth_of(motion))
    assert codes(score) == named
    assert score.findings[-1].rms_deg_after == pytest.approx(NOISE_DEG * np.sqrt(3), rel=0.05)


@motions
def test_the_declination_is_measured_beside_the_convergence_of_a_filter(motion):
    wrong = np.outer(np.exp(-STAMPS / 3e9), np.radians([15.0, -10.0, 10.0]))
    estimate = quaternion.multiply(quaternion.exp(wrong), noisy(motion, size_deg=0.3))
    score = evaluate(STAMPS, quaternion.multiply(about_up(4.09), estimate), truth_of(motion))
    assert codes(score) == ["heading_offset"]
    angle = float(score.findings[0].message.split("turned by ")[1].split("°")[0])
    assert angle == pytest.approx(4.09, abs=0.25)


@pytest.mark.parametrize(("motion", "samples_late"), one_of_each(SAMPLES_LATE))
def test_a_lag_is_measured_to_a_fraction_of_a_sample(motion, samples_late):
    lag_s = samples_late * PERIOD_NS / 1e9
    rate = np.sqrt(np.mean(np.sum(MOTIONS[motion].at(STAMPS).body_rate ** 2, axis=-1)))
    size_deg = min(np.degrees(0.15 * abs(lag_s) * rate), 10.0)
    score = evaluate(STAMPS, noisy(motion, lag_s, size_deg), truth_of(motion))
    # a right filter is ahead by up to a sample: that is told as a number, and is no mistake
    assert codes(score) == (["lagging"] if lag_s > 0 else ["leading"] if samples_late < -1.0 else [])
    # of N samples with noise of 0.15 lag on each axis; at most √10 times more by what is fitted beside it
    assert score.lag_s == pytest.approx(lag_s, abs=4 * np.sqrt(10) * 0.15 * abs(lag_s) / np.sqrt(len(STAMPS)))


@pytest.mark.parametrize("samples_late", [1, pytest.param(-2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("motion", ["dzhanibekov", pytest.param("fast_tumble", marks=pytest.mark.slow)])
def test_a_lag_beside_errors_as_large_is_named_if_it_is_sure(motion, samples_late):
    """As that of a filter with tactical sensors, which converges in seconds and then errs by a sample's turn."""
    lag_s = samples_late * PERIOD_NS / 1e9
    turn = abs(lag_s) * np.sqrt(np.mean(np.sum(MOTIONS[motion].at(STAMPS).body_rate ** 2, axis=-1)))
    errors = turn * (0.5 * lasting(0.05) + np.outer(np.exp(-STAMPS / 3e9), [0.5, -0.5, 0.5]))
    score = evaluate(STAMPS, quaternion.multiply(attitude(motion, lag_s), quaternion.exp(errors)), truth_of(motion))
    [finding] = score.findings
    assert finding.code == ("lagging" if lag_s > 0 else "leading")
    assert UNTOLD not in finding.message
    assert score.lag_s == pytest.approx(lag_s, abs=4.0 * score.lag_standard_error_s)
    assert score.lag_standard_error_s < abs(lag_s) / 8.0
    assert finding.rms_deg_after < score.total_deg.rms


@pytest.mark.parametrize(
    "motion", ["fast_tumble", *(pytest.param(m, marks=pytest.mark.slow) for m in MOTIONS if m != "fast_tumble")]
)
def test_a_lag_without_noise_is_exact_to_nanoseconds(motion):
    for lag_s in (0.0, 0.00321, -0.4):
        assert evaluate(STAMPS, attitude(motion, lag_s), truth_of(motion)).lag_s == pytest.approx(lag_s, abs=2e-9)


@two_motions
def test_a_lag_is_measured_beside_a_misalignment_in_samples_of_the_truth(motion):
    estimate = FAULTS["heading_offset"](noisy(motion, lag_s=0.033, size_deg=0.1))
    score = evaluate(STAMPS, estimate, SampledTruth(STAMPS, attitude(motion)))
    assert codes(score) == ["heading_offset", "lagging"]
    assert score.lag_s == pytest.approx(0.033, abs=1e-3)


def test_a_mounting_by_half_a_right_angle_is_not_told_as_other_axes():
    few = STAMPS[::10]
    estimate = quaternion.multiply(attitude("dzhanibekov")[::10], quaternion.exp([0.15, -0.2, -0.68]))
    [finding] = evaluate(few, estimate, truth_of("dzhanibekov")).findings
    assert finding.code == "body_mounting"
    assert PLACES not in finding.message


@pytest.mark.parametrize("form", FORMS, ids=lambda form: " ".join(f"{code}{number or ''}" for code, number in form))
def test_what_is_undone_is_the_truth_again(form):
    """Of every chain of conventions, by its causes one after the other, and by its one matrix."""
    q = written = attitude("dzhanibekov")
    for code, number in reversed(form):
        written = FAULTS[code](quaternion.multiply(written, FRD) if number else written)
    parts = Explanation(form, (), np.zeros(3), np.zeros(0)).parts
    one_by_one = undone(Matched(STAMPS, written, truth_of("dzhanibekov")), parts).attitude_xyzw
    for back in (one_by_one, written @ matrix(form).T):
        np.testing.assert_allclose(np.abs(np.sum(back * q, axis=-1)), 1.0, atol=1e-15)


WALK = np.cumsum(np.random.default_rng(12).normal(size=(len(STAMPS), 3)), axis=0) / np.sqrt(len(STAMPS))
HONEST = {
    "nothing": 0.0 * WALK,
    "round-off of single precision": 1e-7 * lasting(1e-3),
    "white": 0.02 * lasting(1e-3),
    "correlated": 0.02 * lasting(1.0),
    "drift": np.outer(STAMPS / STAMPS[-1], [0.05, 0.1, -0.2]),
    "heading drift": np.outer(STAMPS / STAMPS[-1], [0.0, 0.0, 0.3]),
    "random walk": 0.1 * WALK,
    "convergence": np.outer(np.exp(-STAMPS / 3e9), [0.3, 0.2, 0.1]) + 0.005 * lasting(0.1),
    "nonsense": 100.0 * WALK,
}


@pytest.mark.parametrize("error", sampled(HONEST, every=2))
@pytest.mark.parametrize(
    ("motion", "axes"),
    [
        ("dzhanibekov", "world"),
        pytest.param("precession", "body", marks=pytest.mark.slow),
        pytest.param("fast_tumble", "world", marks=pytest.mark.slow),
    ],
)
def test_honest_errors_are_not_explained(motion, error, axes):
    turn, q = quaternion.exp(HONEST[error]), attitude(motion)
    estimate = quaternion.multiply(turn, q) if axes == "world" else quaternion.multiply(q, turn)
    assert evaluate(STAMPS, estimate, truth_of(motion)).findings == ()


@two_motions
def test_signs_of_quaternions_do_not_matter(motion):
    signs = np.where(np.random.default_rng(1).random(len(STAMPS)) < 0.5, -1.0, 1.0)[:, np.newaxis]
    estimate = FAULTS["inverted"](noisy(motion))
    plain, flipped = (evaluate(STAMPS, e, truth_of(motion)).to_dict() for e in (estimate, signs * estimate))
    assert plain == flipped


def test_few_samples_are_not_explained():
    for count in (1, 2, 5, 7, 12):
        truth = SampledTruth(STAMPS[:count], attitude("fast_tumble")[:count])
        estimate = quaternion.multiply(attitude("fast_tumble")[:count], turns(2.0, 1, count))
        assert evaluate(STAMPS[:count], estimate, truth).findings == ()


def test_what_a_motion_does_not_tell_apart_is_said():
    spin = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0, 0, 1.0]))
    truth = ExactTruth(lambda t_ns: spin.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    estimate = quaternion.multiply(about_up(4.0), spin.at(STAMPS).attitude_xyzw)
    score = evaluate(STAMPS, estimate, truth)
    (finding,) = score.findings
    assert finding.code == "heading_offset"
    assert UNTOLD in finding.message
    assert score.lag_s is None


def test_a_body_at_rest_tells_no_lag():
    truth = ExactTruth(lambda t_ns: np.tile([0.0, 0.0, 0.6, 0.8], (len(t_ns), 1)), 0, int(STAMPS[-1]))
    score = evaluate(STAMPS, quaternion.multiply([0.0, 0.0, 0.6, 0.8], turns(1.0, 5)), truth)
    assert score.lag_s is None
    assert score.findings == ()


def followed(estimate, findings):
    """The estimate after doing what each finding says, to the letter."""
    for finding in findings:
        told = numbers(finding.message)
        if finding.code == "scalar_first":
            estimate = np.roll(estimate, -1, axis=-1)
        elif finding.code == "inverted":
            estimate = quaternion.conjugate(estimate)
        elif finding.code == "heading_offset":
            estimate = quaternion.multiply(about_up(told[1]), estimate)
        else:
            estimate = quaternion.multiply(estimate, told[4:8])
    return estimate


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2))])
def test_following_the_findings_to_the_letter_leaves_what_the_last_one_tells(seed):
    """A turn of the world and one of the body are fitted together: one alone is pulled by the other."""
    rng, few = np.random.default_rng(seed), STAMPS[::5]
    heading, mounting = rng.uniform(-180.0, 180.0), quaternion.exp(rng.normal(size=3))
    truth = truth_of("dzhanibekov")
    q = quaternion.multiply(quaternion.multiply(about_up(heading), truth.at(few)), mounting)
    estimate = quaternion.multiply(q, turns(0.01, seed, len(few)))
    estimate = quaternion.conjugate(estimate) if seed & 1 else estimate
    estimate = np.roll(estimate, 1, axis=-1) if seed & 2 else estimate
    found = evaluate(few, estimate, truth).findings
    assert {"heading_offset", "body_mounting"} <= {finding.code for finding in found}
    left = evaluate(few, followed(estimate, found), truth, diagnosed=False)
    assert left.total_deg.rms == pytest.approx(found[-1].rms_deg_after, abs=1e-3)
    assert left.total_deg.rms < 0.05
    told = [re.findall(r"median error (\S+)° before and (\S+)° after", finding.message) for finding in found]
    assert all(float(after) <= float(before) for pairs in told for before, after in pairs)


SLOW = ClosedForm(RigidBody([0.04, 0.05, 0.06]), State([0, 0, 0, 1], [0.03, 0.04, -0.01]))
MINUTE = np.arange(600) * 100_000_000
SLOW_TRUTH = ExactTruth(lambda t_ns: SLOW.at(t_ns).attitude_xyzw, 0, int(MINUTE[-1]))
DRIFTS = {
    "heading drift": lambda q: quaternion.multiply(quaternion.exp(np.outer(MINUTE / 6e10, [0, 0, 0.05])), q),
    "roll drift": lambda q: quaternion.multiply(q, quaternion.exp(np.outer(MINUTE / 6e10, [0.05, 0, 0]))),
    "random walk": lambda q: quaternion.multiply(quaternion.exp(0.04 * WALK[::2][:600]), q),
}


@pytest.mark.parametrize("error", [pytest.param(e, marks=pytest.mark.slow if e[0] == "r" else ()) for e in DRIFTS])
def test_slow_errors_of_a_slow_body_are_no_lag(error):
    score = evaluate(MINUTE, DRIFTS[error](SLOW.at(MINUTE).attitude_xyzw), SLOW_TRUTH)
    assert score.findings == ()
    if score.lag_s is not None:
        assert abs(score.lag_s) < 3.0 * score.lag_standard_error_s


@pytest.mark.parametrize("lag_s", [1.5, pytest.param(-3.0, marks=pytest.mark.slow)])
def test_a_lag_is_found_as_far_as_it_is_looked_for(lag_s):
    shifted = np.clip(MINUTE - round(lag_s * 1e9), 0, MINUTE[-1])
    inside = shifted == MINUTE - round(lag_s * 1e9)
    stamps = MINUTE[inside]
    late = SLOW.at(shifted[inside]).attitude_xyzw
    score = evaluate(stamps, late, SLOW_TRUTH, longest_lag_s=5.0)
    assert score.lag_s == pytest.approx(lag_s, abs=1e-6)
    assert [code for code in codes(score) if code != "gaps"] == ["lagging" if lag_s > 0 else "leading"]
    assert evaluate(stamps, late, SLOW_TRUTH).lag_s == pytest.approx(lag_s, abs=1e-6)
    assert evaluate(stamps, late, SLOW_TRUTH, longest_lag_s=1.0).lag_s is None


def test_at_the_limit_of_the_search_neither_a_lag_nor_a_mounting_is_told():
    score = evaluate(MINUTE[15:], SLOW.at(MINUTE[:-15]).attitude_xyzw, SLOW_TRUTH, longest_lag_s=1.0)
    assert (score.lag_s, score.findings) == (None, ())


def test_what_leaves_most_of_a_large_error_is_no_cause():
    noise = quaternion.exp(np.radians(25.0) * lasting(0.1))
    turned = quaternion.multiply(quaternion.multiply(attitude("dzhanibekov"), quaternion.exp([2.2, 0, 0])), noise)
    assert evaluate(STAMPS, turned, truth_of("dzhanibekov")).findings == ()


def test_the_named_convention_wins_over_a_mounting_of_half_a_turn():
    slightly = quaternion.multiply(noisy("dzhanibekov", size_deg=0.1), quaternion.exp([0.0, np.radians(1.0), 0.0]))
    estimate = quaternion.multiply(quaternion.multiply(NED, slightly), FRD)
    first, second = evaluate(STAMPS, estimate, truth_of("dzhanibekov")).findings
    assert (first.code, second.code) == ("ned_world", "body_mounting")
    assert "(1, 0, 0, 0)" in first.message
    assert numbers(second.message)[0] == pytest.approx(1.0, abs=0.01)
