"""An estimator that a campaign names is scored in each run, and what it does wrong costs its score alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import SCORES, judgements

MODULE = """
import numpy as np
from lie_rigid_body.lie import quaternion

def turned(run):
    return quaternion.multiply(quaternion.exp(np.radians([0.0, 0.0, 2.0])), run.truth.attitude_xyzw)

def late(run):
    t_ns = run.imu.t_ns[50:]
    return t_ns, run.attitude().at(t_ns)

def rates(run):
    return run.imu.gyro

def few(run):
    return run.truth.attitude_xyzw[:7]

def nothing(run):
    return None

def lost(run):
    return np.nan * run.truth.attitude_xyzw

def three(run):
    return 1, 2, 3

def leaves(run):
    raise SystemExit(3)

def halves(run):
    raise RuntimeError("half a character: " + chr(0xd800))

def interrupts(run):
    raise KeyboardInterrupt("enough")
"""


@pytest.fixture
def scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    (tmp_path / "some_estimators.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)

    def of(function: str) -> dict[str, Any]:
        parameters = {"rate": 50.0, "imu_rate": 50.0}
        campaign = Campaign(1, 7, 2.0, "tumbling_cubesat", parameters, {}, f"some_estimators:{function}")
        [judgement] = judgements(campaign, campaign.scenario_of(0))
        scores: dict[str, Any] = judgement["scores"]
        return scores

    return of


def test_a_heading_that_is_off_is_the_heading_error(scored: Any) -> None:
    found = scored("turned")
    assert found.pop("estimator_error") is None
    assert found == {
        "total_rms_deg": pytest.approx(2.0, rel=1e-12),
        "heading_rms_deg": pytest.approx(2.0, rel=1e-12),
        "inclination_rms_deg": pytest.approx(0.0, abs=1e-12),
        "converged_s": 0.0,
        "nees_mean": None,
        "gyro_bias_rms_rad_s": None,
    }


def test_an_estimate_may_have_stamps_of_its_own(scored: Any) -> None:
    found = scored("late")
    assert found["estimator_error"] is None
    assert found["total_rms_deg"] < 1e-9


@pytest.mark.parametrize(
    ("function", "words"),
    [
        ("rates", "(100, 3)"),
        ("few", "7 rows goes neither with"),
        ("nothing", "not numbers"),
        ("three", "shape (3,) is not (N, 4)"),
        ("lost", "finite"),
        ("leaves", "SystemExit: 3"),
        ("interrupts", "KeyboardInterrupt: enough"),
        ("halves", "RuntimeError: half a character: \\ud800"),
        ("missing", "no function 'missing'"),
    ],
)
def test_what_is_no_estimate_costs_the_score(function: str, words: str, scored: Any) -> None:
    found = scored(function)
    assert [found[name] for name in SCORES] == [None] * 4
    assert words in found["estimator_error"]
    assert 0 < len(found["estimator_error"]) <= 200
