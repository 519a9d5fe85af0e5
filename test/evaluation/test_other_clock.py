"""An estimate by a clock of another rate is told so, with the factor, and one by the same clock is not."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from motions import CLOCK, MOTIONS, turns

from lie_rigid_body import ClosedForm, RigidBody, State, simulate
from lie_rigid_body.evaluation import ExactTruth, SampledTruth, evaluate
from lie_rigid_body.evaluation.causes import CAUSES
from lie_rigid_body.evaluation.clock import other_rate
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.evaluation.score import Finding
from lie_rigid_body.lie import quaternion

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
    assert other_rate(Matched(2 * TEN, estimate, truth)) is not None
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
    codes |= {cause.code for cause in CAUSES} - {"euler_order"}  # told where the estimator is a function
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
