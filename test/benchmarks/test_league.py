"""The league: its cases, its wiring, and its page."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from league import page
from league.contender import DEFAULTS, Filter, filters
from league.readings import Readings, held
from league.tournament import Result, bound, score
from lie_rigid_body import Run
from lie_rigid_body.evaluation import attitude_error
from lie_rigid_body.league import cases, playing
from lie_rigid_body.league.cases import CASES, Case
from lie_rigid_body.league.table import CaseResult, reference

SLOW = Case("slow_tumble", "perfect")


@pytest.fixture(scope="module", autouse=True)
def short_runs():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, "DURATION_S", 2.0)
        cases.run_of.cache_clear()
        yield
    cases.run_of.cache_clear()


def read(case: Case, seed: int = 1) -> tuple[Run, Readings]:
    run = cases.run_of(case, seed)
    return run, Readings.of(run)


def test_readings_are_those_of_the_run() -> None:
    run, given = read(Case("fast_tumble", "mems"), 5)
    assert run.magnetometer is not None
    assert np.array_equal(given.gyro, run.imu.gyro)
    assert np.array_equal(given.mag, run.magnetometer.field)
    assert len(given.t_ns) == len(run.imu.t_ns) == 200


def test_a_missing_reading_is_held() -> None:
    stamps = np.array([0, 10, 20, 50, 60]) * 1_000_000
    assert held(stamps, np.arange(7) * 10_000_000, 100.0).tolist() == [0, 1, 2, 2, 2, 3, 4]


def test_the_first_readings_tell_the_attitude() -> None:
    run, given = read(SLOW)
    error = attitude_error(given.first_attitude.as_quat()[None], run.truth.attitude_xyzw[:1])
    assert error.total[0] < 1e-12


def test_a_filter_that_knows_the_truth_is_perfect_and_one_that_fails_is_lost(monkeypatch) -> None:
    def truth(given: Readings) -> Rotation:
        return Rotation.from_quat(cases.run_of(SLOW, 1).truth.attitude_xyzw)

    def broken(given: Readings) -> Rotation:
        raise ZeroDivisionError

    wired = (Filter("ours", "truth", truth), Filter("ours", "broken", broken))
    monkeypatch.setattr("league.tournament.filters", lambda: wired)
    monkeypatch.setattr(playing, "SETTLED_S", 1.0)
    monkeypatch.setattr("league.tournament.SETTLED_S", 1.0)
    knows, fails = (score(number, SLOW, DEFAULTS) for number in (0, 1))
    assert knows.total < 1e-6
    assert not knows.trouble
    assert fails.total == 180.0
    assert "ZeroDivisionError" in fails.trouble


@pytest.mark.parametrize("name", ["Madgwick", "EKF", "QUEST", "SAAM", "TRIAD"])
def test_conventions_are_right(name: str) -> None:
    run, given = read(SLOW)
    one = next(each for each in filters() if (each.library, each.name) == ("ahrs", name))
    error = attitude_error(one.estimate(given).as_quat(), run.truth.attitude_xyzw)
    assert np.degrees(error.total[-50:].max()) < 5.0


def test_the_bound_lies_below_what_gravity_and_field_alone_tell() -> None:
    run, given = read(Case("slow_tumble", "mems"))
    found = run.cramer_rao_bound()
    assert found is not None
    static = [given.attitude_of(k).as_quat() for k in range(len(given.t_ns))]
    error = attitude_error(static, run.truth.attitude_xyzw).total
    assert 0.0 < found.rms(found.filtered[100:]) < np.sqrt(np.mean(error[100:] ** 2))
    assert bound(SLOW) is None


@pytest.mark.slow
def test_the_page_ranks_and_marks(monkeypatch) -> None:
    def results(name: str, error: float) -> list[Result]:
        return [Result(f"ahrs {name}", case, DEFAULTS, CaseResult(error, error, error, 1.0), 2.0) for case in CASES]

    def nothing(given: Readings) -> Rotation:
        raise NotImplementedError

    named = (Filter("ahrs", "bad", nothing), Filter("ahrs", "good", nothing, sees_future=True))
    monkeypatch.setattr("league.tournament.filters", lambda: named)
    plain = results("bad", 9.0) + results("good", 0.5)
    rows, bounds = page.ranking(plain, plain), {str(case): 0.1 for case in CASES}
    assert [each.name for each, _, _ in rows] == ["good", "bad"]
    text = page.replaced(f"a\n{page.BEGIN}\nold\n{page.END}\nb", rows, bounds)
    assert text.startswith("a\n")
    assert text.endswith("\nb")
    assert "old" not in text
    assert "| ahrs `good` * | 0.5 |" in text
    assert "9°" in text
    assert page.heat_map(rows, bounds).axes
    table = page.reference(plain, plain, bounds)
    assert [(row.filter, row.sees_future) for row in table.rows] == [("ahrs good", True), ("ahrs bad", False)]
    assert [row.overall_deg for row in table.rows] == pytest.approx([0.5, 9.0])
    assert page.change(table, table) == []
    worse = page.reference(results("bad", 9.0) + results("good", 0.6), plain, bounds)
    assert len(page.change(table, worse)) == len(CASES)


def test_what_a_new_reference_set_changes_is_told() -> None:
    table = reference()
    case, first = str(CASES[0]), table.rows[0]
    rows = (replace(first, version="99"), *table.rows[1:])
    bounds = {name: 2.0 * bound for name, bound in table.bound_deg.items()}
    changed = replace(table, rows=rows, readings={**table.readings, case: "0"}, bound_deg=bounds)
    told = page.change(table, changed)
    assert told[0].startswith(f"{case}: ")
    assert len(told) == 2 + len(bounds)
    assert told[-1].startswith(f"{first.name}: ")
    assert "99" in told[-1].split()
    assert page.change(table, table) == []
