"""The league: its cases, its wiring, and its page."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from league import kept, page, recordings
from league.contender import DEFAULTS, Filter, filters
from league.readings import Readings, held
from league.tournament import TUNING, UNSEEN, Entry, Job, Result, Settings, bound, entry, improved, score
from lie_rigid_body import Run, simulate
from lie_rigid_body.evaluation import attitude_error
from lie_rigid_body.league import cases, playing
from lie_rigid_body.league.cases import CASES, RANKED, WIRING, Case
from lie_rigid_body.league.table import CaseResult, reference
from lie_rigid_body.report.filters import draw_league

MEMS = Case("rotation", "fast", rests=False, grade="mems")


@pytest.fixture(scope="module", autouse=True)
def short_runs():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cases, "DURATION_S", 12.0)
        patch.setattr(playing, "SETTLED_S", 10.0)
        cases.run_of.cache_clear()
        yield
    cases.run_of.cache_clear()


def read(case: Case) -> tuple[Run, Readings]:
    run = cases.run_of(case)
    return run, Readings.of(run)


def test_readings_are_those_of_the_run() -> None:
    run, given = read(MEMS)
    assert run.magnetometer is not None
    assert np.array_equal(given.gyro, run.imu.gyro)
    assert np.array_equal(given.mag, run.magnetometer.field)
    assert len(given.t_ns) == len(run.imu.t_ns) == 1200


def test_a_missing_reading_is_held() -> None:
    stamps = np.array([0, 10, 20, 50, 60]) * 1_000_000
    assert held(stamps, np.arange(7) * 10_000_000, 100.0).tolist() == [0, 1, 2, 2, 2, 3, 4]


def test_the_first_readings_tell_the_attitude() -> None:
    run, given = read(WIRING)
    error = attitude_error(given.first_attitude.as_quat()[None], run.truth.attitude_xyzw[:1])
    assert error.total[0] < 1e-12


def test_a_filter_that_knows_the_truth_is_perfect_and_one_that_fails_is_lost(monkeypatch) -> None:
    def truth(given: Readings) -> Rotation:
        return Rotation.from_quat(cases.run_of(WIRING).truth.attitude_xyzw)

    def turned(given: Readings) -> Rotation:
        return Rotation.from_rotvec([0.0, 0.0, 0.5]) * truth(given)

    def broken(given: Readings) -> Rotation:
        raise ZeroDivisionError

    wired = tuple(Filter("ours", each.__name__, each) for each in (truth, turned, broken))
    monkeypatch.setattr("league.tournament.filters", lambda: wired)
    knows, off, fails = (score(Job(number, WIRING, DEFAULTS)) for number in range(3))
    assert knows["errors"]["total_deg"] < 1e-6
    assert off["errors"]["total_deg"] == pytest.approx(np.degrees(0.5))
    assert off["errors"]["without_constant_deg"] < 1e-6
    assert fails["errors"]["total_deg"] == 180.0
    assert "ZeroDivisionError" in fails["errors"]["failure"]


@pytest.mark.parametrize("name", ["Madgwick", "EKF", "QUEST", "SAAM", "TRIAD"])
def test_conventions_are_right(name: str) -> None:
    run, given = read(WIRING)
    one = next(each for each in filters() if (each.library, each.name) == ("ahrs", name))
    error = attitude_error(one.estimate(given).as_quat(), run.truth.attitude_xyzw)
    assert np.degrees(error.total[-50:].max()) < 5.0


def test_the_bound_lies_below_what_gravity_and_field_alone_tell() -> None:
    run, given = read(MEMS)
    found = run.cramer_rao_bound()
    assert found is not None
    static = [given.attitude_of(k).as_quat() for k in range(len(given.t_ns))]
    error = attitude_error(static, run.truth.attitude_xyzw).total
    assert 0.0 < found.rms(found.filtered[100:]) < np.sqrt(np.mean(error[100:] ** 2))
    assert bound(WIRING) is None


def result(error: float) -> Result:
    return Result(CaseResult(error, error, error, 1.0), 2.0)


def entry_of(name: str, error: float, *, sees_future: bool = False) -> Entry:
    found = {case: result(error) for case in CASES}
    return Entry(Filter("ahrs", name, lambda given: given.first_attitude, sees_future=sees_future), found, {}, found)


def test_the_page_ranks_and_marks(monkeypatch) -> None:
    monkeypatch.setattr("league.page.version", lambda library: "0")  # the library may not be there
    entries = [entry_of("bad", 9.0), entry_of("good", 0.5, sees_future=True)]
    hashes, bounds = dict.fromkeys(CASES, "0"), {str(case): 0.1 for case in CASES}
    league = page.reference(entries, hashes, bounds, {"ahrs good": 1.5, "ahrs bad": 3.0, "none": 1.0})
    assert [(row.filter, row.sees_future) for row in league.rows] == [("ahrs good", True), ("ahrs bad", False)]
    assert [row.overall_deg for row in league.rows] == pytest.approx([0.5, 9.0])
    assert league.real_deg == {"ahrs good": 1.5, "ahrs bad": 3.0}
    table = page.table(entries, league)
    assert "| ahrs `good` * | 1 | 0.5 | 0.5 | 0.5 | 0.5 | 0.5 | 1.5 |" in table
    assert table.index("good") < table.index("bad")
    text = page.replaced(f"a\n{page.BEGIN}\nold\n{page.END}\nb", table)
    assert (text.startswith("a\n"), text.endswith("\nb"), "old" in text) == (True, True, False)
    assert draw_league(page.plain(league), 8.0).axes
    assert page.change(league, league) == []
    worse = page.reference([entries[0], entry_of("good", 0.6)], hashes, bounds, {})
    assert len(page.change(league, worse)) == len(CASES)


def test_a_setting_is_advised_only_where_cases_that_it_was_not_chosen_on_show_it(monkeypatch) -> None:
    """The other one is better in the cases on which it was chosen alone."""
    point = {"gain": 0.5}
    monkeypatch.setattr(
        "league.tournament.filters",
        lambda: (Filter("ahrs", "one", lambda given: given.first_attitude, {"gain": [0.5]}),),
    )
    draws = np.random.default_rng(2)
    plain = {case: result(float(np.exp(draws.normal()))) for case in CASES}
    better = {case: result(0.7 * plain[case].errors.total_deg) for case in UNSEEN}
    same = {case: result(0.7 * plain[case].errors.total_deg) for case in RANKED if case not in UNSEEN}
    same |= {case: result(float(np.exp(draws.normal()))) for case in UNSEEN}
    for tuned, shown in ((better, True), (same, False)):
        found: dict[Any, Result] = {(0, case, ()): one for case, one in plain.items()}
        found |= {(0, case, (("gain", 0.5),)): tuned.get(case, plain[case]) for case in CASES}
        chosen: Settings = {(0, "mems"): point}
        for own in (True, False):
            chosen = improved(chosen, found, own=own)
        assert bool(chosen) == shown
        made = entry(0, {grade: setting for (_, grade), setting in chosen.items()}, found)
        assert [*made.advice] == ["mems"] * shown
        changed = [case for case in RANKED if made.tuned[case] is not plain[case] and tuned.get(case)]
        assert {case.grade for case in changed} == {"mems"} if shown else not changed


def test_settings_are_chosen_on_other_cases_and_seeds_than_they_are_judged_on() -> None:
    kinds = [{(case.group, case.speed, case.rests, case.grade) for case in some} for some in (TUNING, UNSEEN)]
    assert not kinds[0] & kinds[1]
    assert kinds[0] | kinds[1] == {(case.group, case.speed, case.rests, case.grade) for case in RANKED}
    assert not {case.seed for case in TUNING} & {case.seed for case in RANKED}


def test_a_result_is_made_once(tmp_path) -> None:
    with ThreadPoolExecutor(1) as pool:
        first = kept.each(pool, lambda job: [job], [1, 2], ["a", "b"], "first", tmp_path / "kept" / "some.jsonl")
        again = kept.each(pool, lambda job: [-job], [2, 3], ["b", "c"], "again", tmp_path / "kept" / "some.jsonl")
    assert (first, again) == ([[1], [2]], [[2], [-3]])


def test_a_recording_is_read_from_each_format_alike(tmp_path) -> None:
    """Names of arrays as its authors publish them, and a rest before, which tells the field of the world."""
    run: Any = simulate(duration=6.0, imu_rate=2000.0 / 7.0, magnetometer_rate=2000.0 / 7.0, rate=2000.0 / 7.0)
    moves = run.t_s > 2.0
    attitude = run.truth.attitude_xyzw[:, [3, 0, 1, 2]].copy()
    attitude[100] = np.nan
    named = {
        "imu_gyr": run.imu.gyro,
        "imu_acc": run.imu.specific_force,
        "imu_mag": 1e6 * run.magnetometer.field,
        "opt_quat": attitude,
        "movement": moves,
    }
    (tmp_path / "mat").mkdir()
    (tmp_path / "npz").mkdir()
    savemat(tmp_path / "mat" / "one.mat", named)
    names = ("gyro", "specific_force", "magnetic_field", "attitude_wxyz", "movement")
    np.savez(tmp_path / "npz" / "one.npz", **dict(zip(names, named.values(), strict=True)))
    [[mat], [npz]] = ([*recordings.read(tmp_path / kind)] for kind in ("mat", "npz"))
    assert mat.digest == npz.digest
    assert mat.counted.sum() == npz.counted.sum() > 300
    truth = Filter("ours", "truth", lambda given: mat.truth)
    assert recordings.error_deg(truth, {}, npz) == 0.0

    def fails(given: Readings) -> Rotation:
        raise ValueError("no attitude")

    assert recordings.error_deg(Filter("ours", "fails", fails), {}, npz) == 180.0


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
