"""An estimator that a campaign names is scored in each run, and what it does wrong costs its score alone."""

from __future__ import annotations

import os
import resource
import signal
import sys
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import LONGEST_S, SCORES, judged, judgements
from lie_rigid_body.runs import simulate
from lie_rigid_body.system.interpreters import STARTING_S, Interpreter
from said import numbers

MODULE = """
import os
import resource
import subprocess
import time

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

def writes_in_its_readings(run):
    run.imu.gyro[:] = 0.0

def makes_itself_right(run):
    true = run.truth.attitude_xyzw
    true.flags.writeable = True
    true[:] = [0.0, 0.0, 0.0, 1.0]
    return true

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

def number(run):
    return dict(run.scenario.sensor_parameters)["sensor_seed"]

def exits_in_the_second(run):
    if number(run) == 1:
        os._exit(3)
    return run.truth.attitude_xyzw

def hangs_in_the_second(run):
    while number(run) == 1:
        time.sleep(1.0)
    return run.truth.attitude_xyzw

def comes_back_twice(run):
    off = 0.0 if os.fork() else 90.0
    time.sleep(0.2 * bool(off))
    return quaternion.multiply(quaternion.exp(np.radians([off, 0.0, number(run)])), run.truth.attitude_xyzw)

def starts_a_program(run):
    with open("pids", "a") as file:
        print(subprocess.Popen(["sleep", "600"]).pid, file=file)
    return run.truth.attitude_xyzw

def spoils_its_process(run):
    np.asarray = np.sqrt = np.arcsin = np.arctan2 = None
    return run.truth.attitude_xyzw

def moves_away(run):
    os.chdir("/")
    return run.truth.attitude_xyzw

def lowers_a_limit(run):
    resource.setrlimit(resource.RLIMIT_NOFILE, (30, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    return run.truth.attitude_xyzw
"""


@pytest.fixture
def campaign_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, int], Campaign]:
    (tmp_path / "some_estimators.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "some_estimators", raising=False)

    def of(function: str, runs: int = 1) -> Campaign:
        parameters, vary = {"rate": 50.0, "imu_rate": 50.0}, {"sensor_seed": {"distribution": "run"}}
        return Campaign(runs, 7, 2.0, "tumbling_cubesat", parameters, vary, f"some_estimators:{function}")

    return of


def here(campaign: Campaign, run: int) -> dict[str, Any]:
    """Scores of its only estimator in a run, called in this process."""
    return judged(campaign.entries[0], simulate(campaign.scenario_of(run), duration=campaign.duration)).scores


@pytest.fixture
def scored(campaign_of: Callable[[str], Campaign]) -> Callable[[str], dict[str, Any]]:
    """Scores of an estimator that is called in this process."""

    def of(function: str) -> dict[str, Any]:
        campaign = campaign_of(function)
        return here(campaign, 0)

    return of


@pytest.fixture
def asked(campaign_of: Callable[[str, int], Campaign]) -> Callable[[str, int], list[dict[str, Any]]]:
    """Scores of an estimator in runs one after the other, as a worker asks for them."""

    def of(function: str, runs: int) -> list[dict[str, Any]]:
        campaign = campaign_of(function, runs)
        return [judgements(campaign, run)[0]["scores"] for run in range(runs)]

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


def test_an_estimator_that_changes_its_run_is_scored_by_the_true_one(scored: Any) -> None:
    found = scored("makes_itself_right")
    assert found["estimator_error"] is None
    assert found["total_rms_deg"] > 30.0


def test_an_estimate_may_have_stamps_of_its_own(scored: Any) -> None:
    found = scored("late")
    assert found["estimator_error"] is None
    assert found["total_rms_deg"] < 1e-9


@pytest.mark.parametrize(
    ("function", "told"),
    [
        ("rates", "(100, 3)"),
        ("few", "7 rows"),
        ("nothing", "(N, 4)"),
        ("three", "(3,)"),
        ("lost", "100 of 100 rows"),
        ("writes_in_its_readings", "ValueError: "),
        ("leaves", "SystemExit: 3"),
        ("interrupts", "KeyboardInterrupt: enough"),
        ("halves", "RuntimeError: half a character: \\ud800"),
        ("missing", "'missing'"),
    ],
)
def test_what_is_no_estimate_costs_the_score(function: str, told: str, scored: Any) -> None:
    found = scored(function)
    assert [found[name] for name in SCORES] == [None] * 4
    assert told in found["estimator_error"]
    assert 0 < len(found["estimator_error"]) <= 200


def test_an_estimator_that_exits_costs_the_score_of_its_run_only(asked: Any) -> None:
    found = asked("exits_in_the_second", runs=3)
    assert [numbers(each["estimator_error"] or "") for each in found] == [[], [3], []]
    assert found[0]["total_rms_deg"] == found[2]["total_rms_deg"] < 1e-9


def test_an_estimator_that_hangs_costs_the_score_of_its_run_only(asked: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    limits, ask = list[float](), Interpreter.ask

    def sooner(interpreter: Interpreter, question: Callable[[], object], limit_s: float) -> Any:
        """The second hangs for ever: how long that is waited for changes nothing."""
        limits.append(limit_s)
        return ask(interpreter, question, 0.5 if len(limits) == 2 else limit_s)

    monkeypatch.setattr(Interpreter, "ask", sooner)
    found = asked("hangs_in_the_second", runs=3)
    assert [numbers(each["estimator_error"] or "") for each in found] == [[], [0.5], []]
    assert limits == [STARTING_S + LONGEST_S] * 3


def test_an_estimator_that_spoils_its_process_costs_its_own_scores_only(campaign_of: Any) -> None:
    """Others are called, and scored, in a process of their own; so is what is true of the next run."""
    names = {"a": "spoils_its_process", "b": "moves_away", "c": "turned"}
    entries = {name: {"function": f"some_estimators:{function}"} for name, function in names.items()}
    alone = campaign_of("turned", 2)
    beside = replace(alone, estimator=None, estimators=entries)
    for run in range(2):
        _, moving, right = judgements(beside, run)
        assert right["scores"] == here(alone, run)
        assert moving["scores"]["estimator_error"] is None


def test_what_has_no_effect_in_a_run_is_no_warning_of_python(campaign_of: Any) -> None:
    campaign = campaign_of("turned", 1)
    idle = replace(campaign, parameters={**campaign.parameters, "sun_sensor_noise": 0.1})
    assert idle.scenario_of(0).without_effect
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert judgements(idle, 0)[0]["scores"]["estimator_error"] is None


def test_a_copy_of_the_process_that_comes_back_ends_there(asked: Any) -> None:
    """Its answer would be taken for that of the next run."""
    found = asked("comes_back_twice", runs=3)
    assert [each["total_rms_deg"] for each in found] == [pytest.approx(run, abs=1e-9) for run in range(3)]


def test_a_program_that_an_estimator_started_may_go_on_to_its_next_run(asked: Any, tmp_path: Path) -> None:
    assert [each["estimator_error"] for each in asked("starts_a_program", runs=2)] == [None, None]
    for pid in map(int, (tmp_path / "pids").read_text().split()):
        os.kill(pid, signal.SIGKILL)  # which raises an error where there is none


def test_a_limit_that_an_estimator_lowers_is_that_of_its_own_process(asked: Any) -> None:
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert [each["estimator_error"] for each in asked("lowers_a_limit", runs=2)] == [None, None]
    assert resource.getrlimit(resource.RLIMIT_NOFILE) == before
