"""The league: its cases, its table, and the verb, with the filters of the reference set and one of its own."""

from __future__ import annotations

import json
import re
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.cli.diagnose import given_estimator
from lie_rigid_body.cli.league import main
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.league import CASES, EDITION, Case, FilterRow, LeagueTable, reference, standing
from lie_rigid_body.league.cases import (
    BREAKS_S,
    DURATION_S,
    FAULTY,
    GRADES,
    GROUPS,
    MOTIONS,
    RANKED,
    REST_S,
    SETTLED_S,
    WIRING,
    readings_hash,
    run_of,
)
from lie_rigid_body.league.playing import play_case
from lie_rigid_body.league.table import CaseResult, rank_with_ties, rows_of
from lie_rigid_body.runs import Estimate
from lie_rigid_body.runs.ensemble import BlindRun
from said import refusals

refused = refusals({InputError: {"kind": r"^no row of the league \(a value is unknown, or of another kind\): give "}})
FILTERS = '''
"""Attitudes of gravity and field alone, in few lines of NumPy, and filters that fail."""
import numpy as np
from scipy.spatial.transform import Rotation


def axes(first, second):
    across = np.cross(first, second)
    columns = np.broadcast_arrays(first, across, np.cross(first, across))
    return np.stack([column / np.linalg.norm(column, axis=-1, keepdims=True) for column in columns], axis=-1)


def triad(run):
    field = np.array(run.scenario.parameters()["magnetic_field"])
    last = np.maximum(np.searchsorted(run.magnetometer.t_ns, run.imu.t_ns, side="right") - 1, 0)
    seen = axes(run.imu.specific_force, run.magnetometer.field[last])
    return Rotation.from_matrix(axes(np.array([0.0, 0.0, 1.0]), field) @ np.swapaxes(seen, -1, -2)).as_quat()


def cheat(run):
    return run.attitude().at(run.imu.t_ns)


def turned(run):
    return (Rotation.from_rotvec([0.0, 0.0, 2.0]) * Rotation.from_quat(triad(run))).as_quat()


def at_times(run):
    if run.scenario.parameters().get("magnetic_disturbance_interval", 0.0):
        raise ValueError("a passing field")
    return triad(run)
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("league")
    (made / "league_filters.py").write_text(FILTERS)
    return made


def row(name: str, error: float, **others: float) -> FilterRow:
    results = {str(case): CaseResult(error, error, error, 0.0) for case in CASES}
    return FilterRow(name, {**results, **{case: CaseResult(e, e, e) for case, e in others.items()}})


MEMS = Case("combined", "slow", rests=False, grade="mems")


def test_every_row_of_the_reference_set_has_every_case():
    table = reference()
    assert len({each.filter for each in table.rows}) > 30
    assert set(table.readings) == {str(case) for case in CASES}
    for each in table.rows:
        assert set(each.results) == set(table.readings)
    errors = [each.overall_deg for each in table.rows if each.is_wired]
    assert errors == sorted(errors)


def test_cases_are_every_group_speed_rest_grade_and_seed_once():
    assert len({*map(str, CASES)}) == len(CASES) == 106
    assert len(RANKED) == len(GROUPS) * 2 * 2 * len(GRADES) * 3
    assert (CASES[0].grade, len(FAULTY)) == ("perfect", 9)


@pytest.mark.parametrize("rests", [False, True])
@pytest.mark.parametrize("motion", MOTIONS)
def test_bodies_move_as_the_table_says_and_rest_when_they_should(motion: tuple[str, str], rests: bool) -> None:
    """The rates of a free body hardly leave those after its kicks; the sway is a sum of 16 harmonics an axis."""
    run: Any = run_of(Case(*motion, rests=rests, grade="mems", seed=3))
    rate, interval, acceleration, _ = MOTIONS[motion]
    rates = np.linalg.norm(run.truth.body_rate, axis=1)
    assert rates[run.t_s < REST_S].max() == 0.0
    assert 0.75 * rate < rates.max() < 1.2 * rate
    for begin, end in BREAKS_S:
        inside = (run.t_s >= begin) & (run.t_s < end)
        assert (rates[inside].max() == 0.0) == rests
    moving = DURATION_S - REST_S - rests * sum(end - begin for begin, end in BREAKS_S)
    assert len(run.kicks.t_ns) == pytest.approx(moving / interval, rel=0.25)
    if not rests:
        assert run.acceleration[run.t_s > REST_S + 2.0].std() == pytest.approx(acceleration, rel=0.25)


def test_rows_survive_a_file(tmp_path):
    mine = replace(row("mine", 1.0, **{str(MEMS): 3.0}), version="2", other_readings=(str(MEMS),))
    path = tmp_path / "rows.json"
    path.write_text(json.dumps({"edition": EDITION, "rows": [mine.to_json()]}))
    assert rows_of(path) == [mine]


def test_ranks_are_by_the_geometric_mean_of_groups_and_grades():
    table = LeagueTable((), {}, {}).with_rows([row("b", 2.0), row("a", 1.0), row("c", 2.0)])
    assert [(each.filter, table.rank(each)) for each in table.rows] == [("a", 1), ("b", 2), ("c", 2)]
    of_disturbed = {str(case): 16.0 for case in RANKED if case.group == "disturbed" and case.grade == "mems"}
    mixed = row("mixed", 1.0, **of_disturbed, **{str(case): 99.0 for case in FAULTY})
    assert mixed.group_deg("disturbed") == pytest.approx(4.0)  # the root of 16 * 1
    assert mixed.overall_deg == pytest.approx(2.0**0.5)  # the fourth root of 4 * 1 * 1 * 1
    with_mine = table.with_rows([mixed])
    assert (with_mine.rank_in(mixed, "disturbed"), with_mine.rank_in(mixed, "rotation")) == (4, 1)
    assert mixed.median(FAULTY) == 99.0


def test_a_filter_that_does_not_follow_perfect_sensors_stands_last():
    table = LeagueTable((), {}, {}).with_rows(
        [row("a", 10.0, **{str(WIRING): 1.0}), row("b", 1.0, **{str(WIRING): 6.0})]
    )
    assert [each.filter for each in table.rows] == ["a", "b"]
    assert table.rank(table.rows[1]) == 2


def test_rows_are_tied_with_neighbours_from_which_the_cases_show_no_difference():
    draws = np.random.default_rng(1)

    def scattered(name: str, size: float) -> FilterRow:
        factors = np.exp(0.2 * draws.normal(size=len(CASES)))
        errors = {str(case): size * factor for case, factor in zip(CASES, factors, strict=True)}
        return row(name, size, **{**errors, str(WIRING): 0.0})

    table = LeagueTable((), {}, {}).with_rows([scattered("b", 1.0), scattered("c", 1.001), scattered("a", 0.5)])
    near, far = table.rows[1:], table.rows[0]
    assert far.filter == "a"
    assert [[each.filter for each in table.tied(one)] for one in table.rows] == [[], [near[1].filter], [near[0].filter]]
    assert [rank_with_ties(table, one) for one in table.rows] == ["1", "2 (2 to 3)", "3 (2 to 3)"]
    assert table.nearest_other(near[1]) == [far]
    assert table.nearest_other(far) == [near[0]]
    content = near[1].to_json(table)
    assert (content["rank"], content["tied"], content["name"]) == (3, [near[0].name], near[1].name)
    assert content["overall"] == near[1].overall_deg
    assert content["median_deg"]["translation"]["mems"] == near[1].median_deg("translation", "mems")
    assert FilterRow.from_json(json.loads(json.dumps(content))) == near[1]


def test_of_two_rows_both_are_tied_or_none():
    """A scattered row differs from none by itself: it is tied only with such as do not differ among themselves."""
    draws = np.random.default_rng(3)
    widths = dict.fromkeys("abcdef", 0.01) | {"c": 2.0}
    rows = [
        row(name, 1.0, **{str(case): size * float(np.exp(width * draws.normal())) for case in RANKED})
        for size, (name, width) in zip(1.01 ** np.arange(6), widths.items(), strict=True)
    ]
    table = LeagueTable((), {}, {}).with_rows(rows)
    ties = {each.name: {other.name for other in table.tied(each)} for each in table.rows}
    assert all((one in ties[other]) == (other in ties[one]) for one in ties for other in ties)
    assert any(ties.values())
    assert len(ties["c"]) < 3


def test_a_hash_sees_more_than_round_off():
    run = run_of(MEMS)
    digest = readings_hash(run)
    assert digest == readings_hash(run_of(MEMS))

    class Changed:
        def __init__(self, by: float) -> None:
            self.imu, self.magnetometer = run.imu, Magnetometer(run, by)

    class Magnetometer:
        def __init__(self, run: Any, by: float) -> None:
            self.t_ns, self.field = run.magnetometer.t_ns, run.magnetometer.field.copy()
            self.field[1234, 1] += by * np.abs(self.field).max()

    assert readings_hash(Changed(1e-16)) == digest  # type: ignore[arg-type]
    assert readings_hash(Changed(2e-9)) != digest  # type: ignore[arg-type]
    assert readings_hash(run_of(replace(MEMS, seed=2))) != digest


def test_what_a_filter_is_given_tells_no_truth():
    blind: Any = BlindRun.without_truth(run_of(MEMS))
    assert blind.truth is None
    assert blind.faults == ()
    assert blind.imu.gyro_bias is None
    assert blind.imu.accelerometer_bias is None
    for ask in (blind.attitude, blind.cramer_rao_bound, lambda: blind.scenario.initial_body_rate):
        with pytest.raises(InputError):
            ask()


def test_a_filter_that_fails_is_lost_with_the_reason():
    case = WIRING
    assert play_case(lambda run: run.t_ns, case)[0].total_deg == 180.0
    assert play_case(lambda run: run.attitude(), case)[0].total_deg == 180.0
    lost = play_case(lambda run: 1 / 0, case)[0]
    assert lost.total_deg == 180.0
    assert "ZeroDivisionError" in lost.failure
    early = play_case(lambda run: (run.t_ns[:100], np.tile([0.0, 0.0, 0.0, 1.0], (100, 1))), case)[0]
    assert early.total_deg == 180.0


@pytest.mark.slow
def test_a_filter_of_ones_own_has_the_row_of_its_like(folder, tmp_path, monkeypatch, capsys):
    """ahrs solves the same problem of Wahba by other formulas, which round elsewhere."""
    monkeypatch.chdir(folder)
    rows = tmp_path / "rows.json"
    assert main(["league_filters:triad", "--json"]) == 0
    rows.write_text(capsys.readouterr().out)
    (mine,) = rows_of(rows)
    assert mine.constant == ""
    like = next(each for each in reference().rows if each.name == "ahrs TRIAD")
    if mine.other_readings:
        pytest.skip("this machine makes other readings than the reference")
    for case in CASES:
        if not case.fault:  # with lost readings the reference's filter holds the last one
            assert mine.results[str(case)].total_deg == pytest.approx(
                like.results[str(case)].total_deg, rel=1e-3, abs=1e-5
            )
    report = tmp_path / "league.html"
    assert main(["--with", str(rows), "--report", str(report)]) == 0
    out = capsys.readouterr().out
    assert "> league_filters:triad" in out
    assert f"is number {reference().with_rows([mine]).rank(mine)} " in " ".join(out.split())
    assert "league_filters:triad" in report.read_text(encoding="utf-8")


def test_an_estimated_bias_of_the_gyro_has_its_error_in_the_row():
    case = MEMS
    run: Any = run_of(case)

    def estimate(blind: Any, off: float) -> Estimate:
        bias = run.gyro_bias_at(blind.imu.t_ns) + np.array([0.0, 0.0, off])
        bias[blind.imu.t_s - blind.imu.t_s[0] < SETTLED_S] = 1.0  # which does not count
        return Estimate(run.attitude().at(blind.imu.t_ns), gyro_bias=bias)

    found = play_case(lambda blind: estimate(blind, 0.01), case)[0]
    assert found.gyro_bias_rms_rad_s == pytest.approx(0.01)
    without = play_case(lambda blind: estimate(blind, np.nan), case)[0]
    assert (without.total_deg < 1.0, without.gyro_bias_rms_rad_s) == (True, None)
    assert play_case(lambda blind: run.attitude().at(run.imu.t_ns), case)[0].gyro_bias_rms_rad_s is None


def test_few_attitudes_are_a_failure_and_a_large_error_is_no_convergence():
    case = MEMS
    run: Any = run_of(case)
    last = run.imu.t_ns[-1:]
    crowded = last - np.arange(4000)[::-1] * 1000
    few = play_case(lambda blind: Estimate(run.attitude().at(last), last), case)[0]
    crowd = play_case(lambda blind: Estimate(run.attitude().at(crowded), crowded), case)[0]
    assert [(each.total_deg, bool(each.failure)) for each in (few, crowd)] == [(180.0, True)] * 2
    still = play_case(lambda blind: np.tile([0.0, 0.0, 0.0, 1.0], (len(run.imu.t_ns), 1)), case)[0]
    assert (still.total_deg > 20.0, still.converged_s) == (True, None)


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf])
def test_what_is_no_attitude_is_no_answer(value: float) -> None:
    run: Any = run_of(MEMS)
    off = run.attitude().at(run.imu.t_ns) * 2.0
    off[5000::20] = value
    assert 0.0 < play_case(lambda blind: off, MEMS)[0].total_deg < 1e-6
    off[3000:] = value
    assert play_case(lambda blind: off, MEMS)[0].failure


@pytest.mark.slow
def test_the_constant_that_explains_most_of_an_error_is_named(folder, monkeypatch, capsys):
    """A turn of 2 rad about the vertical; without it the row is that of TRIAD."""
    monkeypatch.chdir(folder)
    assert main(["league_filters:turned", "--json"]) == 0
    mine = FilterRow.from_json(json.loads(capsys.readouterr().out)["rows"][0])
    assert "114.6" in mine.constant
    like = next(each for each in reference().rows if each.name == "ahrs TRIAD")
    assert mine.overall("without_constant_deg") == pytest.approx(like.overall_deg, rel=0.2)


@pytest.mark.slow
def test_what_fails_in_some_cases_is_said_and_what_fails_in_all_refused(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert main(["league_filters:at_times"]) == 0
    assert "a passing field" in " ".join(capsys.readouterr().out.split())
    monkeypatch.setattr("lie_rigid_body.league.playing.CASES", CASES[:2])
    assert main(["league_filters:cheat"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "truth" in line


MINE = row("x", 1.0).to_json()
NO_ROWS: list[Any] = [
    5,
    {"filter": "x", "results": {}},
    {"filter": "x"},
    {**MINE, "more": 1},
    {**MINE, "results": {"a": {"b": 1}}},
    row("x", float("nan")).to_json(),
]
NO_FILES = [None, b"name, rms", b"\xff\xfe", b"[" * 100_000, b"[]", b'{"edition": "1999.1", "rows": []}']


@pytest.mark.parametrize(
    "content", [*NO_FILES, *(json.dumps({"edition": EDITION, "rows": rows}).encode() for rows in ([], *zip(NO_ROWS)))]
)
def test_whoever_gives_no_rows_is_told_what_to_give_and_nothing_of_the_code(tmp_path, capsys, content):
    path = tmp_path / "rows.txt"
    if content is not None:
        path.write_bytes(content)
    assert main(["--with", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "rows.txt" in line
    assert not {"YAML", "char", "__init__()", "object", "None"} & set(re.findall(r"\w+(?:\(\))?", line))


def test_each_row_has_a_name_of_its_own(tmp_path, capsys):
    """Known before the filter is run."""
    path = tmp_path / "rows.json"
    path.write_text(json.dumps({"edition": EDITION, "rows": [row("my_filter:estimate", 1.0).to_json()]}))
    for command in (["--with", str(path), "--with", str(path)], ["my_filter:estimate", "--with", str(path)]):
        assert main(command) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "my_filter:estimate" in line


WRONG: dict[str, list[Any]] = {
    "filter": [-1, True, None, "", "a\nb | forged row"],
    "total_deg": [None, -1.0, True, float("nan"), float("inf"), "1", [], 10**400, 180.5],
    "converged_s": [-1.0, True],
    "sees_future": [None, 1],
    "other_readings": [5, str(MEMS), ["no case"]],
    "results": [{**row("x", 1.0).to_json()["results"], "a case of its own": vars(CaseResult(0.0, 0.0, 0.0))}],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_row_with_a_value_of_another_kind_is_refused(name, value):
    content = json.loads(json.dumps(row("x", 1.0).to_json()))
    assert FilterRow.from_json(content).filter == "x"
    first = content["results"][str(CASES[0])]
    (first if name in first else content)[name] = value
    with refused("kind"):
        FilterRow.from_json(content)


def test_other_readings_are_told():
    mine = replace(row("mine", 1.0), other_readings=(str(MEMS),))
    assert str(MEMS) in standing(reference().with_rows([mine]), mine)


@pytest.mark.parametrize("command", ["./my\N{NO-BREAK SPACE}filter", "./my\tfilter", "./\N{SOFT HYPHEN}filter"])
def test_the_name_of_any_command_can_be_read_again(command):
    name, _ = given_estimator(Namespace(estimator=None, command=command, node=None, timeout=60.0))
    assert FilterRow.from_json(row(name, 1.0).to_json()).filter == name


def test_a_row_tells_its_bias_and_the_error_of_one_that_is_upside_down():
    """Only of a filter that gives a bias; and no angle is told as a power of ten."""
    upside_down = row("mine", 178.0)
    assert "rad/s" not in standing(reference().with_rows([upside_down]), upside_down)
    with_bias = {case: replace(of, gyro_bias_rms_rad_s=0.0123) for case, of in upside_down.results.items()}
    mine = replace(upside_down, results=with_bias)
    told = standing(reference().with_rows([mine]), mine)
    assert "0.012 rad/s" in told
    assert "e+0" not in told


def test_the_reference_says_of_which_versions_it_is_and_which_filters_see_later_readings():
    assert all(each.version for each in reference().rows)
    smoothers = {each.filter for each in reference().rows if each.sees_future}
    assert smoothers == {"gtsam AHRSFactor (batch)", "vqf offlineVQF"}
