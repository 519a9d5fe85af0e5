"""A lag or another rate of the clock is told where it is one all along the run, and nothing else feigns it."""

from __future__ import annotations

import re
import tracemalloc
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from motions import CLOCK, FAULTS, MOTIONS, STAMPS, turns

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import ExactTruth, SampledTruth
from lie_rigid_body.evaluation.causes import CAUSES
from lie_rigid_body.evaluation.clock import other_clock
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.evaluation.score import Finding
from lie_rigid_body.lie import quaternion
from sampled import sampled
from untyped import evaluate, simulate

TEN = np.arange(201) * 50_000_000
"""Ten seconds at 20 Hz."""


def of_ten(motion: str) -> tuple[np.ndarray, SampledTruth]:
    """An estimate with noise of a degree on each axis, and the truth."""
    fine = np.arange(1001) * 10_000_000
    truth = SampledTruth(fine, MOTIONS[motion].at(fine).attitude_xyzw)  # costs less than the motion itself
    return quaternion.multiply(truth.at(TEN), turns(1.0, 5, len(TEN))), truth


def told(score) -> dict[str, str]:
    return {finding.code: finding.message for finding in score.findings if finding.code != "gaps"}


@pytest.mark.parametrize(
    ("motion", "times", "said"),
    [
        ("slow_tumble", 0.1, "10 times as slow"),
        ("fast_tumble", 0.99, "1.0101 times as slow"),
        ("dzhanibekov", 10.0, "10 times as fast"),
        ("precession", 1000 / 1024, "1.024 times as slow"),
    ],
)
def test_a_clock_of_another_rate_is_told_with_the_factor(motion, times, said):
    estimate, truth = of_ten(motion)
    score = evaluate(np.round(times * TEN).astype(np.int64), estimate, truth)
    [(code, message)] = told(score).items()
    assert code == "clock_rate"
    [(factor, word)] = re.findall(CLOCK, message)
    assert word == said.split()[-1]
    assert float(factor) == pytest.approx(float(said.split()[0]), rel=2e-3)
    assert score.lag_s is None
    assert score.findings[0].rms_deg_after == pytest.approx(np.sqrt(3.0), rel=0.15)


@pytest.mark.parametrize(("motion", "shift_s"), sampled(product(MOTIONS, [-7.0, -5.0, 3.0, 5.0]), every=3))
def test_stamps_that_are_off_by_half_of_the_run_are_a_lag_and_nothing_else(motion, shift_s):
    estimate, truth = of_ten(motion)
    score = evaluate(TEN + round(shift_s * 1e9), estimate, truth)
    assert list(told(score)) == ["lagging" if shift_s > 0.0 else "leading"]
    assert score.lag_s == pytest.approx(shift_s, abs=0.02)
    assert abs(score.lag_s - shift_s) < 4.0 * score.lag_standard_error_s


def test_many_wrong_stamps_ask_for_no_more_memory():
    estimate, truth = of_ten("slow_tumble")
    stamps = np.concatenate([TEN[:70] - 10**16, TEN[70:]])
    tracemalloc.start()
    other_clock(Matched(stamps, estimate, truth), 1.0, rates=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6


def test_a_clock_whose_fit_leaves_the_truth_is_none():
    run = simulate("tumbling_cubesat", duration=4.0)
    truth = SampledTruth(run.t_ns[:74], run.truth.attitude_xyzw[:74])
    stamps = np.arange(370) * 10_000_000 + int(run.t_ns[0])
    assert set(told(evaluate(stamps, np.tile([0.0, 0.0, 0.0, 1.0], (370, 1)), truth))) <= {"stuck"}


@pytest.mark.parametrize("every", [10, 50])
def test_an_estimate_at_another_rate_than_the_truth_is_by_the_same_clock(every):
    run = simulate("dzhanibekov", duration=10.0, rate=100.0)
    assert run.score(run.truth.attitude_xyzw[::every], run.t_ns[::every]).findings == ()


def test_a_truth_is_asked_within_its_times_only():
    estimate, sampled = of_ten("dzhanibekov")
    asked = []

    def attitude(t_ns: np.ndarray) -> np.ndarray:
        asked.extend([t_ns.min(), t_ns.max()])
        return sampled.at(t_ns)

    truth = ExactTruth(attitude, sampled.first_ns, sampled.last_ns)
    assert other_clock(Matched(2 * TEN, estimate, truth), 1.0, rates=True) is not None
    assert truth.first_ns <= min(asked) <= max(asked) <= truth.last_ns


@pytest.mark.parametrize("factor", [0.5, 1.05])
def test_a_spin_does_not_tell_a_clock_from_the_scale_of_a_gyro(factor):
    def spin(rate: float) -> ClosedForm:
        return ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0, 0, rate]))

    truth = ExactTruth(lambda t_ns: spin(1.0).at(t_ns).attitude_xyzw, 0, int(TEN[-1]))
    found = told(evaluate(TEN, spin(factor).at(TEN).attitude_xyzw, truth))
    assert set(found) <= {"turn_rate"}


def smooth(rng: np.random.Generator) -> np.ndarray:
    few = quaternion.normalize(rng.normal(size=(4, 4)))
    weights = np.stack([np.interp(TEN, np.linspace(0, TEN[-1], 4), row) for row in np.eye(4)], axis=1)
    return quaternion.normalize(weights @ few)


WRONG = {
    "smooth": smooth,
    "constant": lambda rng: np.tile(quaternion.normalize(rng.normal(size=4)), (len(TEN), 1)),
    "any": lambda rng: quaternion.normalize(rng.normal(size=(len(TEN), 4))),
    "another body": lambda rng: (
        ClosedForm(
            RigidBody(np.sort(rng.uniform(1.0, 2.0, 3))),
            State(quaternion.normalize(rng.normal(size=4)), rng.normal(size=3)),
        )
        .at(TEN)
        .attitude_xyzw
    ),
}


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 30))])
@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.slow if k != "another body" else ()) for k in WRONG]
)
def test_an_estimate_of_something_else_has_no_cause(kind, seed):
    rng = np.random.default_rng(seed)
    _, truth = of_ten(("slow_tumble", "fast_tumble")[seed % 2])
    assert set(told(evaluate(TEN, WRONG[kind](rng), truth))) <= {"stuck"}


def test_every_code_is_in_the_table_of_the_docs():
    package = Path(__file__).parents[2] / "lie_rigid_body" / "evaluation"
    source = "".join((package / f"{name}.py").read_text() for name in ("remarks", "scoring"))
    codes = set(re.findall(r'Remark\(\s*"(\w+)"', source))
    codes |= {cause.code for cause in CAUSES}
    documented = (package.parents[1] / "docs" / "estimators.md").read_text().split("| code | what is wrong |")[1]
    table = documented.split("\n\n")[0].splitlines()
    told = {code for line in table for code in re.findall(r"`(\w+)`", line[: line.find("|", 1)])}
    assert told == codes
    assert set(re.findall(r"``(\w+)``", str(Finding.__doc__))) == told


def test_a_body_that_turns_little_is_no_evidence_of_a_mounting():
    """What a fixed attitude leaves beside a body that turns by 50° is small, and no mounting."""
    slow = ClosedForm(RigidBody([1.0, 1.5, 2.0]), State([0, 0, 0, 1], [0.05, 0.06, 0.04]))
    truth = ExactTruth(lambda t_ns: slow.at(t_ns).attitude_xyzw, 0, int(TEN[-1]))
    fixed = np.tile(quaternion.exp([1.0, 1.0, -0.5]), (len(TEN), 1))
    assert set(told(evaluate(TEN, fixed, truth))) <= {"stuck"}


INNER = STAMPS[200:-200:4]
REPEAT_S = 2.64
"""The fast tumble is nearly the same so much earlier."""


TOP = ClosedForm(RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], [3.0, 0.5, -0.9]))


def late(motion: ClosedForm, lag_s: np.ndarray | float) -> Any:
    stamps = INNER - np.round(np.asarray(lag_s) * 1e9).astype(np.int64)
    estimate = quaternion.multiply(motion.at(stamps).attitude_xyzw, turns(0.5, 3, len(INNER)))
    truth = ExactTruth(lambda t_ns: motion.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    return evaluate(INNER, estimate, truth)


DISC = ClosedForm(RigidBody([0.5, 0.5, 0.96]), State([0, 0, 0, 1], [2.0, 0.0, 40.0]))
"""A disc in flight: it precesses in 0.08 s, by which any lag and mounting have another like them."""

GROWING = np.linspace(0.0, 1.0, len(INNER))


def test_a_lag_that_grows_from_nearly_none_is_not_told_and_one_that_changes_a_little_is():
    """As the scale of a gyro makes it, which the fit takes for a lag of half of the last."""
    score = late(TOP, 0.02 + 0.18 * GROWING)
    assert (score.lag_s, score.lag_standard_error_s) == (None, None)
    assert not {"lagging", "leading"} & {finding.code for finding in score.findings}
    score = late(TOP, 0.1 + 0.02 * GROWING)
    assert score.lag_s == pytest.approx(0.11, abs=0.005)
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
    score = evaluate(stamps, FAULTS[cause](DISC.at(stamps - round(lag_s * 1e9)).attitude_xyzw), truth)
    assert {finding.code for finding in score.findings} == {cause, "lagging" if lag_s > 0.0 else "leading"}
    assert score.lag_s == pytest.approx(lag_s, abs=1e-6)
    assert score.findings[-1].rms_deg_after < 1e-3


@pytest.mark.parametrize(("motion", "lag_s"), sampled(product(MOTIONS, [0.0, 0.025]), every=3))
def test_a_tilt_of_the_world_is_no_lag_and_a_lag_beside_it_is_told_within_its_error(motion: str, lag_s: float) -> None:
    """A tilt of 3° is none of the names, as sensors err by more, and to a body that turns evenly it is nearly a lag."""
    stamps = INNER - round(lag_s * 1e9)
    tilt = quaternion.exp(np.radians([2.0, -2.0, 1.0]))
    estimate = quaternion.multiply(tilt, MOTIONS[motion].at(stamps).attitude_xyzw)
    truth = ExactTruth(lambda t_ns: MOTIONS[motion].at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    score = evaluate(INNER, quaternion.multiply(estimate, turns(0.2, 3, len(INNER))), truth)
    if score.lag_s is not None:
        assert abs(score.lag_s - lag_s) <= 3.0 * score.lag_standard_error_s
    assert lag_s or not {"lagging", "leading"} & {finding.code for finding in score.findings}
