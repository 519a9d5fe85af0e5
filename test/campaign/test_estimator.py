"""An estimator that a campaign names is scored in each run, and what it does wrong costs its score alone."""

from __future__ import annotations

import os
import resource
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import SCORES, judgements

MODULE = """
import os
import resource
import subprocess
import time

import numpy as np
from lie_rigid_body.lie import quaternion

children = []

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

def leaves_a_copy(run):
    pid = os.fork()
    if pid == 0:
        time.sleep(600.0)
        os._exit(0)
    children.append(pid)
    return run.truth.attitude_xyzw

def comes_back_twice(run):
    children.append(os.fork())
    return run.truth.attitude_xyzw

def starts_a_program(run):
    children.append(subprocess.Popen(["sleep", "600"]).pid)
    return run.truth.attitude_xyzw

def lowers_a_limit(run):
    resource.setrlimit(resource.RLIMIT_NOFILE, (30, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    return run.truth.attitude_xyzw
"""


@pytest.fixture
def scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    (tmp_path / "some_estimators.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "some_estimators", raising=False)

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


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_copy_of_the_process_that_still_runs_is_ended_and_costs_the_score(scored: Any) -> None:
    pytest.importorskip("psutil")
    assert "leaves copies of its process running (1)" in scored("leaves_a_copy")["estimator_error"]
    [child] = sys.modules["some_estimators"].children
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_copy_of_the_process_that_comes_back_ends_there(scored: Any) -> None:
    """It would go on with the work of the process, on the same connections."""
    scored("comes_back_twice")
    [child] = sys.modules["some_estimators"].children
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) in (1, -signal.SIGKILL)


def test_a_program_that_an_estimator_started_may_go_on_to_its_next_run(scored: Any) -> None:
    assert scored("starts_a_program")["estimator_error"] is None
    [child] = sys.modules["some_estimators"].children
    assert os.waitpid(child, os.WNOHANG) == (0, 0)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def test_a_limit_that_an_estimator_lowers_is_set_back_and_costs_the_score(scored: Any) -> None:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    found = scored("lowers_a_limit")
    after = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, before)
    assert after == before
    assert "it lowers RLIMIT_NOFILE" in found["estimator_error"]
