"""Estimators of a campaign that are compared: what is told of them is what is known of their errors."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from campaigns import NEEDS_PARQUET, written

from lie_rigid_body import Estimate, InputError
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.comparison import Comparison, EstimatorSummary, Point, compare
from lie_rigid_body.campaign.definition import EstimatorSpec
from lie_rigid_body.campaign.results import Results
from lie_rigid_body.campaign.run import CURVE, ERROR, MORE_SCORES, SCORES, Row, _bias_series, _run_score
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.evaluation.differences import of_runs
from lie_rigid_body.evaluation.ensemble_consistency import NOT_SHOWN
from lie_rigid_body.report import campaign_scores
from lie_rigid_body.runs import simulate
from one_python import asked_here
from said import numbers

pytestmark = [NEEDS_PARQUET, pytest.mark.usefixtures("asked_here")]
RUNS = 24
DEVIATION = 0.01
TEXT = f"""
runs: {RUNS}
seed: 7
duration: 0.5
scenario: tumbling_cubesat
parameters:
  {{rate: 50.0, imu_rate: 50.0, magnetometer_rate: 50.0, sensor_grade: mems, accelerometer_mode: pivot_gravity,
    motion: closed_form}}
vary:
  sensor_seed: {{distribution: run}}
  epoch_ns: {{distribution: run}}
  gyro_noise_density: {{distribution: loguniform, low: 1.0e-5, high: 1.0e-3}}
"""
COMPARED = (
    TEXT
    + """
estimators:
  two: {function: "compared_estimators:turned", parameters: {degrees: 2.0}}
  lost: {function: "compared_estimators:lost", parameters: {in_runs: [3, 5]}}
  tuned: {function: "compared_estimators:tuned", grid: {degrees: [5.0, 1.0, 3.0]}}
  honest: {function: "compared_estimators:noisy"}
  proud: {function: "compared_estimators:noisy", parameters: {share: 0.5}}
  deviations: {function: "compared_estimators:noisy", parameters: {power: 1}}
"""
)
MODULE = f"""
from functools import cache

import numpy as np
from lie_rigid_body import Campaign, Estimate, simulate
from lie_rigid_body.lie import quaternion

def seed(run):
    return int(run.t_ns[0])

def true(run):  # a filter that can do that has the campaign's file
    return simulated(seed(run))

@cache
def simulated(number):
    campaign = Campaign.from_file("campaign.yaml")
    return simulate(campaign.scenario_of(number), duration=campaign.duration)

def turned(run, degrees):
    return quaternion.multiply(quaternion.exp(np.radians([0.0, 0.0, degrees])), true(run).truth.attitude_xyzw)

def lost(run, *, in_runs):
    if seed(run) in in_runs:
        raise RuntimeError("it is lost")
    return turned(run, 1.0)

def tuned(run, degrees):
    return turned(run, degrees if seed(run) % 2 == 0 else 10.0 - degrees)

def noisy(run, share=1.0, power=2):
    draws = np.random.default_rng(seed(run))
    errors = {DEVIATION} * draws.standard_normal((len(run.t_ns), 3))
    biases = true(run).gyro_bias_at(run.t_ns) + {DEVIATION} * draws.standard_normal((len(run.t_ns), 3))
    attitude = quaternion.multiply(quaternion.exp(errors), true(run).truth.attitude_xyzw)
    P = share * {DEVIATION}**power * np.eye(3)
    return Estimate(attitude, covariance=P, gyro_bias=biases, gyro_bias_covariance={DEVIATION}**2 * np.eye(3))
"""
LOST = "the filter failed, compared_estimators.py line 24: RuntimeError: it is lost: correct that first"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder in which the estimators are, and the working directory."""
    folder = tmp_path_factory.mktemp("compared")
    (folder / "compared_estimators.py").write_text(MODULE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        patch.chdir(folder)
        yield folder


@pytest.fixture(scope="module")
def said(folder: Path) -> list[str]:
    """What the verb prints of the campaign in ``out``, with a page."""
    import io
    from contextlib import redirect_stderr, redirect_stdout

    printed = io.StringIO()
    given = [str(written(folder, COMPARED)), "--out", "out", "--no-bags", "--report", "page.html"]
    with asked_here(folder), redirect_stdout(printed), redirect_stderr(io.StringIO()):
        assert main([*given, "--workers", "1"]) == 0
    return printed.getvalue().splitlines()


@pytest.fixture(scope="module")
def comparison(folder: Path, said: list[str]) -> Comparison:
    campaign = Campaign.from_table(folder / "out" / "runs.parquet")
    return compare(campaign, Results(campaign, folder / "out").rows())


def named(comparison: Comparison) -> dict[str, EstimatorSummary]:
    return {one.name: one for one in comparison.summaries}


@pytest.fixture(scope="module")
def scores(folder: Path, said: list[str]) -> Any:
    from pyarrow import parquet

    return parquet.read_table(folder / "out" / "scores.parquet")


def test_the_table_of_scores_has_a_row_for_each_run_estimator_and_point(scores: Any, folder: Path) -> None:
    from pyarrow import parquet

    assert scores.column_names == ["run", "estimator", "parameters", *SCORES, ERROR, *MORE_SCORES]
    assert scores.column_names[-3:] == ["estimator_error", "nees_mean", "gyro_bias_rms_rad_s"]
    rows = scores.to_pylist()
    assert [(row["run"], row["estimator"], json.loads(row["parameters"])) for row in rows[:8]] == [
        (0, "deviations", {"power": 1}),
        (0, "honest", {}),
        (0, "lost", {"in_runs": [3, 5]}),
        (0, "proud", {"share": 0.5}),
        *((0, "tuned", {"degrees": degrees}) for degrees in (5.0, 1.0, 3.0)),
        (0, "two", {"degrees": 2.0}),
    ]
    assert len(rows) == 8 * RUNS
    for row in rows:
        failed = row["estimator"] == "lost" and row["run"] in (3, 5)
        assert row["estimator_error"] == (LOST if failed else None)
        assert (row["total_rms_deg"] is None) == failed
        if row["estimator"] == "two":
            assert row["heading_rms_deg"] == pytest.approx(2.0, rel=1e-9)
            assert row["nees_mean"] is row["gyro_bias_rms_rad_s"] is None
        if row["estimator"] == "honest":
            assert row["nees_mean"] == pytest.approx(3.0, rel=0.5)
            assert row["gyro_bias_rms_rad_s"] == pytest.approx(np.sqrt(3.0) * DEVIATION, rel=0.4)
    runs = parquet.read_table(folder / "out" / "runs.parquet")
    assert "total_rms_deg" not in runs.column_names
    assert Campaign.from_table(folder / "out" / "scores.parquet") == Campaign.from_table(
        folder / "out" / "runs.parquet"
    )


def test_the_best_point_is_chosen_on_even_runs_and_scored_on_odd_ones(comparison: Comparison) -> None:
    tuned = named(comparison)["tuned"]
    assert tuned.entry.parameters == {"degrees": 1.0}
    assert [point.mean_deg for point in tuned.points] == pytest.approx([5.0, 1.0, 3.0])
    assert tuned.runs.tolist() == [*range(1, RUNS, 2)]
    assert tuned.scores["total_rms_deg"] == pytest.approx(np.full(RUNS // 2, 9.0))


def test_pairs_are_compared_on_the_runs_that_both_have(comparison: Comparison) -> None:
    found = {(first.name, second.name): pair for first, second, pair in comparison.differences}
    assert len(found) == 15
    pair = found["lost", "two"]
    assert pair.ratio == pytest.approx(0.5)
    assert (pair.runs, pair.without_answer) == (RUNS, (2, 0))
    assert pair.is_shown
    pair = found["tuned", "two"]
    assert pair.ratio == pytest.approx(4.5)
    assert (pair.runs, pair.without_answer) == (RUNS // 2, (0, 0))
    assert pair.is_shown
    pair = found["lost", "tuned"]
    assert (pair.runs, pair.without_answer) == (RUNS // 2, (2, 0))
    pair = found["honest", "proud"]  # the same errors
    assert (pair.ratio, pair.is_shown, pair.factor) == (1.0, False, 1.0)


def test_pairs_are_a_matrix_and_no_sentences(comparison: Comparison, said: list[str]) -> None:
    head = next(number for number, line in enumerate(said) if line.startswith("Errors of the row"))
    names = [one.name for one in comparison.summaries]
    assert said[head + 1].split() == names[1:]
    assert [line.split()[0] for line in said[head + 2 : head + 7]] == names[:-1]
    row = said[head + 2 + names.index("lost")]
    assert numbers(row)[-1] == pytest.approx(2.0, abs=1.5)
    assert "0.5 (" in row


def test_covariances_are_judged_over_the_runs(comparison: Comparison) -> None:
    found = named(comparison)
    for name, verdict, cause in (
        ("honest", NOT_SHOWN, ""),
        ("proud", "overconfident", "factor"),
        ("deviations", "conservative", "standard_deviation"),
    ):
        one = found[name]
        assert one.covariance is not None
        assert (one.covariance.verdict, one.covariance.cause) == (verdict, cause)
        assert one.gyro_bias is not None
        assert one.gyro_bias.verdict == NOT_SHOWN
    assert found["two"].covariance is None


def test_failures_of_a_point_that_is_not_the_best_are_told_with_their_first_reason() -> None:
    grid = {"g": {"function": "a:b", "grid": {"k": [1, 2]}}}
    campaign = Campaign(runs=4, seed=1, duration=1.0, estimators=grid)
    right = {**dict.fromkeys((*SCORES, *MORE_SCORES), 1.0), ERROR: None}
    lost = [{**dict.fromkeys(right), ERROR: f"in run {run}"} for run in range(4)]
    rows = [Row(run, run_scores=[{"scores": right, "reading_s": 1e-6}, {"scores": lost[run]}]) for run in range(4)]
    found = compare(campaign, rows)
    [one] = found.summaries
    assert [(point.failures, point.reason) for point in one.points] == [(0, ""), (2, "in run 0")]
    assert one.entry.parameters == {"k": 1}
    assert one.reason == ""
    told = [line for line in campaign_scores.as_text(found).splitlines() if "in run 0" in line]
    assert [numbers(line)[:2] for line in told] == [[1, 2]]


def test_failures_are_counted_with_their_first_reason(comparison: Comparison) -> None:
    lost = named(comparison)["lost"]
    assert np.flatnonzero(lost.failed).tolist() == [3, 5]
    assert lost.reason == LOST
    assert lost.worst(2) == [3, 5]
    assert [one.reason for one in comparison.summaries if one is not lost] == [""] * 5


def test_the_bound_of_one_run_is_told(comparison: Comparison, said: list[str]) -> None:
    """A covariance may be right about an error that is many times as large."""
    campaign = Campaign.from_file("campaign.yaml")
    bound = simulate(campaign.scenario_of(1), duration=0.5).cramer_rao_bound()
    assert bound is not None
    assert comparison.bound is not None
    assert comparison.bound.run == 1
    squares = np.trace(bound.filtered, 0, 1, 2)
    assert comparison.bound.rms_deg == pytest.approx(np.degrees(np.sqrt(squares.mean())))
    ends = comparison.bound.curve_deg[[0, -1]]
    assert ends == pytest.approx(np.degrees(np.sqrt(np.minimum(squares[[0, -1]], np.pi**2 / 3.0 + 2.0))))
    [sentence] = [line for line in said if f" {comparison.bound.rms_deg:.3g}° " in line]
    assert f"two {2.0 / comparison.bound.rms_deg:.3g}" in " ".join(said)
    assert "Run 1: " in sentence


def test_curves_hold_the_error_over_time(comparison: Comparison) -> None:
    assert comparison.t_s[[0, -1]] == pytest.approx([0.0, 0.5])
    found = named(comparison)
    for name, count, error in (("two", RUNS, 2.0), ("lost", RUNS - 2, 1.0), ("tuned", RUNS // 2, 9.0)):
        one = found[name]
        assert one.curve_deg.shape == (count, CURVE)
        known = one.curve_deg[~np.isnan(one.curve_deg)]
        assert known == pytest.approx(np.full(len(known), error))
        assert len(known) > 0.4 * one.curve_deg.size


def test_without_another_seed_in_each_run_nothing_is_said_of_covariances(folder: Path, said: list[str]) -> None:
    """It is the seed that makes errors of one run independent of another's."""
    campaign = Campaign.from_table(folder / "out" / "runs.parquet")
    rows = [*Results(campaign, folder / "out").rows()]
    found = compare(replace(campaign, vary={}, parameters={}), rows)
    assert (found.independent, found.has_covariances) == (False, True)
    assert [one.covariance for one in found.summaries] == [None] * 6
    again = [replace(row, parameters={**row.parameters, "sensor_seed": row.run // 2}) for row in rows]
    assert not compare(campaign, again).independent
    assert compare(campaign, rows).independent


def test_a_best_point_at_the_edge_of_a_grid_is_told(said: list[str]) -> None:
    assert [line for line in said if line.startswith("tuned: degrees ")]
    grid = EstimatorSpec("one", "a:b", grid={"gain": [0.1, 0.3, 1.0], "kind": ["a", "b"]})
    shown = of_runs(np.linspace(1.0, 1.1, 9), np.full(9, 2.0))
    alike = of_runs(np.linspace(1.0, 1.1, 9), np.full(9, 1.05))
    for difference, hints in ((shown, [[0.1], [], [1.0]]), (alike, [[], [], []])):
        for gain, hint in zip((0.1, 0.3, 1.0), hints, strict=True):
            best = {"gain": gain, "kind": "a"}
            every = [{"gain": value, "kind": kind} for value in (0.1, 0.3, 1.0) for kind in "ab"]
            points = [Point(each, 1.0, 0, "", None if each == best else difference) for each in every]
            summary = SimpleNamespace(entry=replace(grid, parameters=best), name="one", points=points)
            found = [numbers(sentence) for sentence in campaign_scores._at_the_edge(cast(Any, summary))]
            assert found == ([hint] if hint else [])


def test_a_grid_whose_points_differ_by_luck_alone_has_none_that_is_better(folder: Path) -> None:
    """Chosen after a look at six points, the best of equal ones is shown to be better in few campaigns."""
    campaign = Campaign(
        runs=40, seed=1, duration=1.0, estimators={"g": {"function": "a:b", "grid": {"k": [*range(6)]}}}
    )
    right = {**dict.fromkeys((*SCORES, *MORE_SCORES), 1.0), ERROR: None}
    shown = []
    for number in range(20):
        errors = np.exp(0.3 * np.random.default_rng(number).normal(size=(40, 6)))
        scores = [[{"scores": {**right, SCORES[0]: float(e)}, "reading_s": 1e-6} for e in each] for each in errors]
        rows = [Row(run, run_scores=of_run) for run, of_run in enumerate(scores)]
        [one] = compare(campaign, rows).summaries
        shown.append(any(point.difference.is_shown for point in one.points if point.difference))
    assert sum(shown) <= 4
    assert {point.difference.pairs for point in one.points if point.difference} == {15}


def test_the_table_and_the_page_name_every_estimator(folder: Path, said: list[str]) -> None:
    page = (folder / "page.html").read_text()
    for name in ("two", "lost", "tuned", "honest", "proud", "deviations"):
        assert any(line.startswith(name) for line in said)
        assert f"<td>{name}</td>" in page
    headings = re.findall(r"<h[23]>(.*?)</h[23]>", page)
    parts = ("Estimators", "Error over time", "of the row", "Covariance", "tuned", "density", "Worst")
    found = [[at for at, heading in enumerate(headings) if part in heading] for part in parts]
    assert found == [[at] for at in sorted(at for [at] in found)]
    assert not [heading for heading in headings if "sensor_seed" in heading or "residual" in heading.lower()]
    assert "24 of 24 runs CERTIFIED" in page
    assert "bound, run 1" in page
    worst = page[page.index(">Worst runs<") :]
    commands = re.findall(r"lie-rigid-body record (\d+)\.mcap", worst)
    assert sorted({*commands}) == commands  # each run once
    assert "no answer" in worst
    assert "lie-rigid-body record 000003.mcap --duration 0.5 --scenario tumbling_cubesat" in page
    assert "sensor_seed:=3" in page


def test_a_finished_campaign_says_the_same_again(
    folder: Path, said: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    kept = {name: (folder / "out" / name).read_bytes() for name in ("scores.parquet", "runs.parquet")}
    assert main([str(written(folder, COMPARED)), "--out", "out", "--no-bags"]) == 0
    again = capsys.readouterr().out.splitlines()
    assert again == [line for line in said if not line.startswith("wrote ")]
    assert kept == {name: (folder / "out" / name).read_bytes() for name in kept}


def test_an_estimator_that_fails_in_every_run_is_named_after_the_table(
    folder: Path, said: list[str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others run on, also after as many runs as end a campaign in which nobody has a score."""
    monkeypatch.setattr("lie_rigid_body.cli.campaign_runs.MAX_FAILURES", 2)
    text = TEXT.replace(f"runs: {RUNS}", "runs: 3") + (
        'estimators:\n  right: {function: "compared_estimators:turned", parameters: {degrees: 1}}\n'
        '  never: {function: "compared_estimators:lost", parameters: {in_runs: [0, 1, 2]}}\n'
    )
    assert main([str(written(folder, text)), "--out", "third", "--no-bags", "--workers", "1"]) == 2
    printed = capsys.readouterr()
    assert "'never'" in printed.err.splitlines()[-1]
    assert any(line.startswith("never ") and " 3/3" in line for line in printed.out.splitlines())
    assert (folder / "third" / "scores.parquet").exists()


def test_the_page_draws_errors_over_the_norm_of_a_vector_that_varies(comparison: Comparison) -> None:
    shown = [(one, "black") for one in comparison.summaries]
    varied = {run: {"initial_body_rate": [0.1 * run, 0.0, 1.0], "inertia": [1.0] * 6} for run in range(100)}
    page = "".join(campaign_scores._figures(shown, varied))
    assert "initial_body_rate" in page
    assert "inertia" not in page


@pytest.mark.parametrize("P", [-np.eye(3), np.eye(3) + np.eye(3, k=1)])
def test_a_covariance_of_the_bias_that_is_none_is_refused(P: np.ndarray) -> None:
    run = simulate(duration=1.0, imu_rate=10.0)
    stamps, biases = run.imu.t_ns, np.zeros((len(run.imu.t_ns), 3))
    found = Estimate(run.attitude().at(stamps), stamps, gyro_bias=biases, gyro_bias_covariance=P)
    with pytest.raises(InputError):
        _bias_series(found, run, np.arange(3))


def test_a_covariance_of_the_bias_that_is_0_beside_an_error_is_told() -> None:
    """In the score of a run, and in a campaign, where it is no failure."""
    run = simulate(duration=1.0, imu_rate=10.0)
    assert run.imu is not None
    stamps = run.imu.t_ns
    attitude = run.attitude().at(stamps)
    biases = np.asarray(run.imu.gyro_bias)
    told = []
    for off, P in ((0.01, np.zeros((3, 3))), (0.0, np.zeros((3, 3))), (0.01, 1e-4 * np.eye(3))):
        found = Estimate(attitude, stamps, gyro_bias=biases + off, gyro_bias_covariance=P)
        score = run.score(found)
        assert score.gyro_bias is not None
        told.append((score.gyro_bias.claimed_exact, _run_score(found, run, series=True).bias_claimed_exact))
        assert ("is 0 in 10 of 10" in str(score)) == bool(told[-1][0])
    assert told == [(10, True), (0, False), (0, False)]
