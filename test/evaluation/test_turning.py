"""What is wrong about how an estimate turns, or about its world, is told, and nothing else is."""

from __future__ import annotations

import json
import re
from itertools import accumulate

import numpy as np
import pytest
from motions import MOTIONS, STAMPS, attitude, codes, truth_of, turns

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import Finding, SampledTruth, evaluate
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, places
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.evaluation.remarks import DEGREE, Remark, Turns
from lie_rigid_body.lie import quaternion
from said import numbers
from sampled import sampled

FEW = STAMPS[:500]
SWAPPED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
CYCLED = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
UNCHANGED = np.eye(3)


def turns_of(stamps: np.ndarray, estimate: np.ndarray, q: np.ndarray) -> Turns:
    return Turns(Matched(stamps, estimate, SampledTruth(stamps, q)))


def integrated(q: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """What a gyro leads to that reads the turns of a body by a matrix, with noise of a twentieth of a step."""
    steps = quaternion.log(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:])) @ matrix.T
    found = np.array(list(accumulate(quaternion.exp(steps), quaternion.multiply, initial=q[0])))
    noise = 0.05 * float(np.degrees(np.median(np.abs(steps).max(axis=1))))
    return quaternion.multiply(found, turns(noise, 4, len(found)))


def remarks_on(matrix: np.ndarray) -> list[Remark]:
    """What is told of the turns of an estimate by a gyro that reads by a matrix."""
    q = attitude("slow_tumble")[:500]
    estimate = np.tile(q[0], (500, 1)) if not matrix.any() else integrated(q, matrix)
    found_of = turns_of(FEW, estimate, q)
    return [*filter(None, (found_of.stuck(), found_of.other()))]


@pytest.mark.parametrize(
    ("matrix", "code", "told"),
    [
        (DEGREE * UNCHANGED, "turn_rate", " 57.3 "),
        (-UNCHANGED, "turn_axes", " -x, -y, -z:"),
        (0.0 * UNCHANGED, "stuck", " 224.6°"),
        *((factor * UNCHANGED, "", "") for factor in (1.0, 1.1, 1.4)),
    ],
)
def test_a_gyro_of_another_unit_or_on_other_axes_is_told(matrix, code, told):
    """More of them are in the sentences of this room."""
    found = remarks_on(matrix)
    assert [remark.code for remark in found] == [code] * bool(code)
    assert all(told in remark.message for remark in found), found


def test_a_spin_tells_how_fast_the_estimate_turns_and_not_about_which_axes():
    spin = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0.0, 0.0, 1.0])).at(FEW).attitude_xyzw
    remark = turns_of(FEW, integrated(spin, DEGREE * UNCHANGED), spin).other()
    assert remark is not None
    assert remark.code == "turn_rate"
    assert turns_of(FEW, quaternion.conjugate(spin), spin).other() is None
    assert turns_of(FEW, integrated(spin, SWAPPED), spin).other() is None


def test_the_turns_of_an_estimate_are_in_its_score():
    estimate = integrated(attitude("slow_tumble")[:500], DEGREE * UNCHANGED)
    score = evaluate(FEW, estimate, truth_of("slow_tumble"))
    told = {finding.code: finding for finding in score.findings}
    assert set(told) == {"turn_rate", "gaps"}  # it ends before the truth
    assert told["turn_rate"].rms_deg_after == score.total_deg.rms


@pytest.mark.parametrize(
    ("first", "last", "told"),
    [(100, 500, [0.8, 3.992]), (400, 500, [3.2, 3.992]), (150, 250, [1.2, 1.992])],
)
def test_an_estimate_that_stands_still_for_a_while_is_told_when(first, last, told):
    q = attitude("slow_tumble")[:500]
    where = np.arange(500)
    where[first:last] = first
    stamps = np.arange(500) * 8_000_000
    [finding] = evaluate(stamps, q[where], SampledTruth(stamps, q)).findings
    assert finding.code == "stuck"
    assert numbers(finding.message)[:3] == [0.0, *told]


def test_an_estimate_that_waits_at_first_is_not_stuck():
    q = attitude("slow_tumble")[:500]
    assert turns_of(FEW, q[np.maximum(np.arange(500), 120)], q).stuck() is None


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_least_of_estimates_that_errs_by_much_has_a_score(count):
    stamps, wrong = STAMPS[:count], quaternion.multiply([1.0, 0.0, 0.0, 0.0], attitude("slow_tumble")[:count])
    score = evaluate(stamps, wrong, truth_of("slow_tumble"))
    assert score.total_deg.rms == pytest.approx(180.0)
    assert (score.samples, score.lag_s, set(codes(score))) == (count, None, {"gaps"})
    json.dumps(score.to_dict(), allow_nan=False)


@pytest.mark.parametrize("every", [2, 3, 10])
def test_the_attitudes_of_two_bodies_in_turns_are_told_as_such(every):
    q, other = attitude("slow_tumble"), attitude("slow_tumble")[::-1]
    estimate = q.copy()
    estimate[1::every] = other[1::every]
    [finding] = evaluate(STAMPS, estimate, truth_of("slow_tumble")).findings
    assert finding.code == "mixed"


@pytest.mark.parametrize("motion", MOTIONS)
def test_outliers_noise_and_resets_are_no_two_attitudes(motion):
    q, rng = attitude(motion), np.random.default_rng(5)
    random = quaternion.normalize(rng.normal(size=q.shape))
    outliers = np.where(rng.random((len(q), 1)) < 0.1, random, q)
    resets = np.where(np.arange(len(q))[:, np.newaxis] // 60 % 2, quaternion.multiply([0.0, 0.0, 1.0, 0.0], q), q)
    for estimate in (outliers, random, resets, quaternion.multiply(q, turns(30.0, 7))):
        assert turns_of(STAMPS, estimate, q).mixed() is None


def test_an_inverse_that_turns_as_about_mirrored_axes_for_a_while_is_no_more_than_that():
    body = RigidBody([0.1542, 0.0012, -0.0008, 0.12, 0.0021, 0.0509])
    few = np.arange(75, 150) * 40_000_000
    true = ClosedForm(body, State([0.5, -0.5, 0.5, 0.5], [0.4, 0.6, -0.3])).at(few).attitude_xyzw
    inverse = quaternion.conjugate(true)
    assert [finding.code for finding in evaluate(few, inverse, SampledTruth(few, true)).findings] == ["inverted"]


@pytest.mark.slow
@pytest.mark.parametrize("size_deg", [3.0, 30.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_noise_feigns_no_turns(motion, size_deg):
    q = attitude(motion)
    wandering = quaternion.exp(np.cumsum(np.random.default_rng(2).normal(size=(len(q), 3)), axis=0) * 0.05)
    for noise in (turns(size_deg, 7), wandering):
        for estimate in (quaternion.multiply(q, noise), quaternion.multiply(noise, q)):
            assert turns_of(STAMPS, estimate, q).other() is None


def test_a_body_of_other_axes_is_told_by_their_names():
    """Axes that are turned as a whole are a mounting: its words, and no others."""
    frd = np.diag([1.0, -1.0, -1.0])
    mounted = quaternion.multiply(attitude("slow_tumble"), quaternion.from_matrix(frd))[::15]
    few = STAMPS[::15]
    estimate = quaternion.multiply(mounted, turns(0.5, 1, len(few)))
    [finding] = evaluate(few, estimate, truth_of("slow_tumble")).findings
    assert finding.code == "body_mounting"
    for axes in SIGNED_PERMUTATIONS[np.linalg.det(SIGNED_PERMUTATIONS) > 0.0][1:]:
        slightly = quaternion.multiply(quaternion.from_matrix(axes.T), quaternion.exp([0.0, 0.0, np.radians(1.0)]))
        told = places(slightly)
        names = re.findall("-?[xyz]", told.split(" are ")[1])[:3]
        unit = {
            sign + name: float(sign + "1") * row
            for sign in ("", "-")
            for name, row in zip("xyz", UNCHANGED, strict=True)
        }
        np.testing.assert_array_equal([unit[name] for name in names], axes)
        assert numbers(told) == [1.0]
    assert places(quaternion.exp([0.0, 0.0, np.radians(1.0)])) == ""
    assert places(quaternion.exp([0.0, 0.0, np.radians(80.0)])) == ""


T_NS = np.arange(600) * 50_000_000
TRUE_XYZW = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0.3, 0.5, -0.4])).at(T_NS).attitude_xyzw
T = np.linspace(0.0, 1.0, 600)[:, np.newaxis]
"""From the begin to the end of the run."""


def worlds(estimate_xyzw: np.ndarray, true_xyzw: np.ndarray = TRUE_XYZW) -> list[Finding]:
    stamps = T_NS[: len(estimate_xyzw)]
    found = evaluate(stamps, estimate_xyzw, SampledTruth(stamps, true_xyzw)).findings
    return [finding for finding in found if finding.code == "world_turned"]


@pytest.mark.parametrize(
    "vector", sampled([[0.9, 0.0, 0.0], [0.0, 1.5, -1.0], [-0.2, 0.0, 0.3], [0.0, 2.9, 0.0]], every=3)
)
def test_a_turn_is_told_with_its_axis_also_after_a_filter_has_converged_to_it(vector):
    turned = quaternion.exp(vector * (1.0 - np.exp(-30.0 * T)))
    estimate = quaternion.multiply(quaternion.multiply(turned, TRUE_XYZW), turns(0.5, 3, 600))
    [finding] = worlds(estimate)
    [angle, axis] = re.findall(r"turned by (\S+)° about \((.*?)\) of the world", finding.message)[0]
    told = np.radians(float(angle)) * np.array([float(v) for v in axis.split(", ")])
    assert np.linalg.norm(told - vector) < 0.01
    mounted = quaternion.multiply(estimate, quaternion.exp([0.5, 0.0, 0.0]))
    found = evaluate(T_NS, mounted, SampledTruth(T_NS, TRUE_XYZW)).findings
    assert {finding.code for finding in found} == {"world_turned", "body_mounting"}
    assert found[-1].rms_deg_after < 30.0  # while it converges


@pytest.mark.parametrize(
    "vectors",
    sampled(
        [
            T * [1.2, 0.0, 0.0],  # drifts
            T**0.5 * [0.0, 0.8, 0.5],
            np.where(T < 0.6, 0.0, 1.0) * [1.0, 0.0, 0.0],  # in part of the run only
            np.ones((600, 1)) * [0.0, 0.0, 1.0],  # a heading
            np.ones((600, 1)) * [0.1, 0.0, 0.0],  # small
            np.ones((600, 1)) * [0.0, 3.1, 0.0],  # upside down, which is NED with a heading
        ],
        every=2,
    ),
)
def test_what_is_not_constant_or_no_tilt_is_none(vectors):
    assert worlds(quaternion.multiply(quaternion.exp(vectors), TRUE_XYZW)) == []


def test_a_body_that_hardly_turns_is_no_evidence():
    slow = quaternion.exp(T * [0.2, 0.0, 0.1])
    assert worlds(np.tile(quaternion.exp([1.0, 0.4, 0.0]), (600, 1)), slow) == []
    assert worlds(slow[:5], slow[:5]) == []
