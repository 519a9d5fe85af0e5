"""A lag is told where it is one all along the run, and not where errors that grow feign it."""

from __future__ import annotations

import numpy as np
import pytest
from motions import MOTIONS, STAMPS, turns

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import ExactTruth, Score, evaluate
from lie_rigid_body.lie import quaternion

INNER = STAMPS[200:-200:4]
REPEAT_S = 2.64
"""The fast tumble is nearly the same so much earlier."""


TOP = ClosedForm(RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], [3.0, 0.5, -0.9]))


def late(motion: ClosedForm, lag_s: np.ndarray | float) -> Score:
    stamps = INNER - np.round(np.asarray(lag_s) * 1e9).astype(np.int64)
    estimate = quaternion.multiply(motion.at(stamps).attitude_xyzw, turns(0.5, 3, len(INNER)))
    truth = ExactTruth(lambda t_ns: motion.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    return evaluate(INNER, estimate, truth)


DISC = ClosedForm(RigidBody([0.5, 0.5, 0.96]), State([0, 0, 0, 1], [2.0, 0.0, 40.0]))
"""A disc in flight: it precesses in 0.08 s, by which any lag and mounting have another like them."""
NED, FRD = [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
WRITTEN = {
    "ned_world": lambda q: quaternion.multiply(NED, q),
    "inverted": quaternion.conjugate,
    "heading_offset": lambda q: quaternion.multiply(quaternion.exp([0.0, 0.0, 0.3]), q),
    "body_mounting": lambda q: quaternion.multiply(q, FRD),
}

GROWING = np.linspace(0.0, 1.0, len(INNER))


def test_a_lag_that_grows_from_nearly_none_is_not_told_and_one_that_changes_a_little_is():
    """As the scale of a gyro makes it, which the fit takes for a lag of half of the last."""
    score = late(TOP, 0.02 + 0.18 * GROWING)
    assert (score.lag_s, score.lag_standard_error_s) == (None, None)
    assert not {"lagging", "leading"} & {finding.code for finding in score.findings}
    score = late(TOP, 0.1 + 0.02 * GROWING)
    assert score.lag_s == pytest.approx(0.11, abs=0.005)
    assert score.lag_standard_error_s is not None
    assert score.lag_standard_error_s < 0.01


def test_a_far_lag_is_that_of_each_quarter():
    whole, part = (late(MOTIONS["fast_tumble"], lag_s) for lag_s in (0.7, np.where(GROWING < 0.7, 0.7, 0.7 - REPEAT_S)))
    assert [finding.code for finding in whole.findings if finding.code != "gaps"] == ["lagging"]
    assert not {"lagging", "leading"} & {finding.code for finding in part.findings}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cause", "lag_s"), [("ned_world", 0.04), ("inverted", -0.08), ("heading_offset", -0.08), ("body_mounting", 0.02)]
)
def test_of_a_top_the_nearest_lag_is_named_with_the_fewest_causes(cause, lag_s):
    truth = ExactTruth(lambda t_ns: DISC.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    stamps = STAMPS[::2]
    score = evaluate(stamps, WRITTEN[cause](DISC.at(stamps - round(lag_s * 1e9)).attitude_xyzw), truth)
    assert {finding.code for finding in score.findings} == {cause, "lagging" if lag_s > 0.0 else "leading"}
    assert score.lag_s == pytest.approx(lag_s, abs=1e-6)
    assert score.findings[-1].rms_deg_after < 1e-3


@pytest.mark.parametrize("lag_s", [0.0, 0.025])
@pytest.mark.parametrize("motion", ["dzhanibekov", "precession", "slow_tumble", "fast_tumble"])
def test_a_tilt_of_the_world_is_no_lag_and_a_lag_beside_it_is_told_within_its_error(motion: str, lag_s: float) -> None:
    """A tilt of 3° is none of the names, as sensors err by more, and to a body that turns evenly it is nearly a lag."""
    stamps = INNER - round(lag_s * 1e9)
    tilt = quaternion.exp(np.radians([2.0, -2.0, 1.0]))
    estimate = quaternion.multiply(tilt, MOTIONS[motion].at(stamps).attitude_xyzw)
    truth = ExactTruth(lambda t_ns: MOTIONS[motion].at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    score = evaluate(INNER, quaternion.multiply(estimate, turns(0.2, 3, len(INNER))), truth)
    if score.lag_s is not None:
        assert score.lag_standard_error_s is not None
        assert abs(score.lag_s - lag_s) <= 3.0 * score.lag_standard_error_s
    assert lag_s or not {"lagging", "leading"} & {finding.code for finding in score.findings}
