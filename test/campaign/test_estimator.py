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
from lie_rigid_body.campaign.run import MAX_ESTIMATOR_S, SCORES, run_scores, score_estimator
from lie_rigid_body.system.interpreters import STARTING_S, Interpreter
from said import numbers

MODULE = """
import os
import resource
import subprocess
import time

import numpy as np
from lie_rigid_body.lie import quaternion

def number(run):
    return int(run.t_ns[0])

def right(run):  # attitudes of a sensor without an error
    return run.attitude_sensor.t_ns, run.attitude_sensor.attitude_xyzw

def turned(run):
    t_ns, attitude = right(run)
    return t_ns, quaternion.multiply(quaternion.exp(np.radians([0.0, 0.0, 2.0])), attitude)

def at_its_own_stamps(run):
    t_ns, attitude = right(run)
    return t_ns[50:], attitude[50:]

def rates(run):
    return run.imu.gyro

def writes_in_its_readings(run):
    run.imu.gyro[:] = 0.0

def spoils_the_readings_of_others(run):
    mine = run.attitude_sensor.attitude_xyzw
    true = mine.copy()
    mine.flags.writeable = True
    mine[:] = [0.0, 0.0, 0.0, 1.0]
    return run.attitude_sensor.t_ns, true

def lost(run):
    return np.nan * right(run)[1]

def leaves(run):
    raise SystemExit(3)

def halves(run):
    raise RuntimeError("half a character: " + chr(0xd800))

def reads_the_truth(run):
    return run.truth.attitude_xyzw

def asks_for_the_truth(run):
    return run.attitude()

def looks_at_the_start(run):
    return run.scenario.initial_body_rate

def begins_right(run):
    return np.tile(run.scenario.initial_attitude_xyzw, (len(run.imu.t_ns), 1))

def interrupts(run):
    if number(run) == 1:
        raise KeyboardInterrupt("enough")
    return right(run)

def exits_in_the_second(run):
    if number(run) == 1:
        os._exit(3)
    return right(run)

def hangs_in_the_second(run):
    while number(run) == 1:
        time.sleep(1.0)
    return right(run)

def comes_back_twice(run):
    off = 0.0 if os.fork() else 90.0
    time.sleep(0.2 * bool(off))
    t_ns, attitude = right(run)
    return t_ns, quaternion.multiply(quaternion.exp(np.radians([off, 0.0, number(run)])), attitude)

def starts_a_program(run):
    with open("pids", "a") as file:
        print(subprocess.Popen(["sleep", "600"]).pid, file=file)
    return right(run)

def spoils_its_process(run):
    np.asarray = np.sqrt = np.arcsin = np.arctan2 = None
    return right(run)

def moves_away(run):
    os.chdir("/")
    return right(run)

def lowers_a_limit(run):
    resource.setrlimit(resource.RLIMIT_NOFILE, (30, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
    return right(run)
"""


@pytest.fixture
def campaign_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, int], Campaign]:
    (tmp_path / "some_estimators.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "some_estimators", raising=False)

    def of(function: str, runs: int = 1) -> Campaign:
        parameters = {"rate": 50.0, "imu_rate": 50.0, "attitude_sensor_rate": 50.0}
        vary = {"epoch_ns": {"distribution": "run"}}
        return Campaign(runs, 7, 2.0, "tumbling_cubesat", parameters, vary, f"some_estimators:{function}")

    return of


def here(campaign: Campaign, run: int) -> dict[str, Any]:
    """Scores of its only estimator in a run, called in this process."""
    return score_estimator(campaign.entries[0], campaign, run).scores


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
        return [run_scores(campaign, run)[0]["scores"] for run in range(runs)]

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


def test_an_estimator_that_changes_its_run_is_given_a_copy(campaign_of: Any) -> None:
    names = {"a": "spoils_the_readings_of_others", "b": "right"}
    entries = {name: {"function": f"some_estimators:{function}"} for name, function in names.items()}
    campaign = replace(campaign_of("right", 1), estimator=None, estimators=entries)
    for entry in campaign.entries:
        assert float(score_estimator(entry, campaign, 0).scores["total_rms_deg"] or 9.0) < 1e-9


def test_an_estimate_may_have_stamps_of_its_own(scored: Any) -> None:
    found = scored("at_its_own_stamps")
    assert found["estimator_error"] is None
    assert found["total_rms_deg"] < 1e-9


def test_a_campaign_may_give_the_first_attitude(campaign_of: Any) -> None:
    blind = campaign_of("begins_right", 1)
    assert "initial_attitude_xyzw would tell the truth" in str(here(blind, 0)["estimator_error"])
    given = here(replace(blind, gives=["initial_attitude_xyzw"]), 0)
    assert given["estimator_error"] is None
    assert given["total_rms_deg"] > 1.0


@pytest.mark.parametrize(
    ("function", "told"),
    [
        ("rates", "(100, 3)"),
        ("lost", "100 of 100 rows"),
        ("writes_in_its_readings", "ValueError: "),
        ("leaves", "SystemExit: 3"),
        ("reads_the_truth", "the truth is withheld: estimate from what run.imu"),
        ("asks_for_the_truth", "run.attitude() would tell the truth, which this run withholds: estimate from"),
        ("looks_at_the_start", "scenario.initial_body_rate would tell the truth"),
        ("halves", "RuntimeError: half a character: \\ud800"),
        ("missing", "'missing'"),
    ],
)
def test_what_is_no_estimate_costs_the_score(function: str, told: str, scored: Any) -> None:
    found = scored(function)
    assert [found[name] for name in SCORES] == [None] * 4
    assert told in found["estimator_error"]
    assert "\n" not in found["estimator_error"]


@pytest.mark.slow
@pytest.mark.parametrize(("function", "told"), [("exits_in_the_second", "3"), ("interrupts", "KeyboardInterrupt: en")])
def test_an_estimator_that_ends_costs_the_score_of_its_run_only(function: str, told: str, asked: Any) -> None:
    first, second, third = asked(function, runs=3)
    assert told in second["estimator_error"]
    assert first["estimator_error"] is third["estimator_error"] is None
    assert first["total_rms_deg"] == third["total_rms_deg"] < 1e-9


@pytest.mark.slow
def test_an_estimator_that_hangs_costs_the_score_of_its_run_only(asked: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    limits, ask = list[float](), Interpreter.ask

    def sooner(interpreter: Interpreter, question: Callable[[], object], limit_s: float) -> Any:
        """The second hangs for ever: how long that is waited for changes nothing."""
        limits.append(limit_s)
        return ask(interpreter, question, 0.5 if len(limits) == 2 else limit_s)

    monkeypatch.setattr(Interpreter, "ask", sooner)
    found = asked("hangs_in_the_second", runs=3)
    assert [numbers(each["estimator_error"] or "") for each in found] == [[], [0.5], []]
    assert limits == [STARTING_S + MAX_ESTIMATOR_S] * 3


@pytest.mark.slow
def test_an_estimator_that_spoils_its_process_costs_its_own_scores_only(campaign_of: Any) -> None:
    """Others are called, and scored, in a process of their own."""
    names = {"a": "spoils_its_process", "b": "moves_away", "c": "turned"}
    entries = {name: {"function": f"some_estimators:{function}"} for name, function in names.items()}
    alone = campaign_of("turned", 2)
    beside = replace(alone, estimator=None, estimators=entries)
    for run in range(2):
        _, moving, right = run_scores(beside, run)
        assert moving["scores"]["estimator_error"] is None
        assert right["scores"] == here(alone, run)


def test_what_has_no_effect_in_a_run_is_no_warning_of_python(campaign_of: Any) -> None:
    campaign = campaign_of("turned", 1)
    idle = replace(campaign, parameters={**campaign.parameters, "sun_sensor_noise": 0.1})
    assert idle.scenario_of(0).without_effect
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run_scores(idle, 0)[0]["scores"]["estimator_error"] is None


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
