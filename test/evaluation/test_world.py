"""A world that is turned about any axis is told with its turn, and nothing else is told as one."""

from __future__ import annotations

import re

import numpy as np
import pytest
from motions import turns

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import Finding, SampledTruth, evaluate
from lie_rigid_body.lie import quaternion

T_NS = np.arange(600) * 50_000_000
TRUE_XYZW = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0.3, 0.5, -0.4])).at(T_NS).attitude_xyzw
T = np.linspace(0.0, 1.0, 600)[:, np.newaxis]
"""From the begin to the end of the run."""


def worlds(estimate_xyzw: np.ndarray, true_xyzw: np.ndarray = TRUE_XYZW) -> list[Finding]:
    stamps = T_NS[: len(estimate_xyzw)]
    found = evaluate(stamps, estimate_xyzw, SampledTruth(stamps, true_xyzw)).findings
    return [finding for finding in found if finding.code == "world_turned"]


@pytest.mark.parametrize("vector", [[0.9, 0.0, 0.0], [0.0, 1.5, -1.0], [-0.2, 0.0, 0.3], [0.0, 2.9, 0.0]])
def test_a_turn_is_told_with_its_axis_also_after_a_filter_has_converged_to_it(vector):
    turned = quaternion.exp(vector * (1.0 - np.exp(-30.0 * T)))
    estimate = quaternion.multiply(quaternion.multiply(turned, TRUE_XYZW), turns(0.5, 3, 600))
    [finding] = worlds(estimate)
    [angle, axis] = re.findall(r"turned by (\S+)° about \((.*?)\) of the world", finding.message)[0]
    told = np.radians(float(angle)) * np.array([float(v) for v in axis.split(", ")])
    assert np.linalg.norm(told - vector) < 0.01
    assert worlds(quaternion.multiply(estimate, quaternion.exp([0.5, 0.0, 0.0]))) == []


@pytest.mark.parametrize(
    "vectors",
    [
        T * [1.2, 0.0, 0.0],  # drifts
        T**0.5 * [0.0, 0.8, 0.5],
        np.where(T < 0.6, 0.0, 1.0) * [1.0, 0.0, 0.0],  # in part of the run only
        np.ones((600, 1)) * [0.0, 0.0, 1.0],  # a heading
        np.ones((600, 1)) * [0.1, 0.0, 0.0],  # small
        np.ones((600, 1)) * [0.0, 3.1, 0.0],  # upside down, which is NED with a heading
    ],
)
def test_what_is_not_constant_or_no_tilt_is_none(vectors):
    assert worlds(quaternion.multiply(quaternion.exp(vectors), TRUE_XYZW)) == []


def test_a_body_that_hardly_turns_is_no_evidence():
    slow = quaternion.exp(T * [0.2, 0.0, 0.1])
    assert worlds(np.tile(quaternion.exp([1.0, 0.4, 0.0]), (600, 1)), slow) == []
    assert worlds(slow[:5], slow[:5]) == []
