"""Runs that fail, or get no score, leave nothing behind, and many of them end a campaign in one line."""

from __future__ import annotations

import argparse
import json
import resource
import sys
from pathlib import Path
from typing import Any

import pytest
from campaigns import NEEDS_PARQUET, SCORES, finished, table_of, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.results import RESUMED, Results
from lie_rigid_body.campaign.run import ERROR, carry_out
from lie_rigid_body.cli import campaign_runs
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.cli.campaign_runs import MAX_FAILURES
from lie_rigid_body.foundation.errors import BagError

pytestmark = [NEEDS_PARQUET, pytest.mark.usefixtures("asked_here")]


def test_runs_that_fail_one_after_another_end_a_campaign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a million too, as where the disk is full: here of what no run can be, found as late as that."""
    monkeypatch.setattr(campaign_runs, "MAX_TRIED", 0)
    path = written(tmp_path, "runs: 1000000\nseed: 1\nduration: 1.0\nparameters: {rate: -3.0}")
    assert main([str(path), "--out", str(tmp_path / "out"), "--workers", "1"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"{MAX_FAILURES} of 1000000 " in line
    assert finished(tmp_path / "out") == []


def test_what_is_in_the_way_of_a_bag_costs_that_run_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path, "runs: 6\nseed: 1\nduration: 0.1"), tmp_path / "out"
    given = [str(path), "--out", str(out), "--workers", "2"]
    Results(Campaign.from_file(path), out)
    (out / "bags" / "000002.mcap").mkdir()
    assert main(given) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "1 of 6 runs failed (2), first: " in line
    assert "000002.mcap is a folder" in line
    assert line.endswith(RESUMED)
    assert table_of(out)["run"].to_pylist() == [0, 1, 3, 4, 5]
    (out / "bags" / "000002.mcap").rmdir()
    assert main(given) == 0
    assert len(finished(out)) == 6


@pytest.mark.parametrize("older", [[], [b"an older bag"]])
def test_a_run_that_fails_leaves_no_part_of_its_bag_and_the_older_one(tmp_path: Path, older: list[bytes]) -> None:
    campaign, before = Campaign(runs=1, seed=1, duration=1.0), resource.getrlimit(resource.RLIMIT_FSIZE)
    (tmp_path / "bags").mkdir()
    for content in older:
        (tmp_path / "bags" / "000000.mcap").write_bytes(content)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, before[1]))
    try:
        with pytest.raises(BagError):
            carry_out(campaign, 0, tmp_path, keep=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [bag.read_bytes() for bag in (tmp_path / "bags").iterdir()] == older


@pytest.mark.parametrize("reason", ["it is lost", "estimator 'a:b' cannot be imported: it is lost: correct it"])
def test_an_estimator_without_any_score_is_an_error(
    out: Path, tmp_path: Path, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also one that cannot be imported on the workers, whose reason ends with a remedy itself."""
    for path in (out / "runs").iterdir():
        row = json.loads(path.read_text())
        row["run_scores"][0]["scores"] |= {**dict.fromkeys(SCORES), ERROR: reason}
        path.write_text(json.dumps(row))
    assert main([str(written(tmp_path)), "--out", str(out)]) == 2
    printed = capsys.readouterr()
    assert reason in printed.out
    [line] = printed.err.splitlines()
    assert line.count(reason.removesuffix(": correct it")) == 1
    assert table_of(out)["estimator_error"].to_pylist() == [reason] * 6


@pytest.mark.slow
def test_an_estimator_without_a_score_in_the_first_runs_ends_a_campaign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "always_lost.py").write_text("def estimate(run): raise RuntimeError('it is lost')")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    path = written(
        tmp_path, "runs: 99\nseed: 1\nduration: 0.1\nestimator: always_lost:estimate\nparameters: {imu_rate: 10.0}"
    )
    assert main([str(path), "--out", "out", "--no-bags", "--workers", "1"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f" {MAX_FAILURES} " in line
    assert "RuntimeError: it is lost" in line
    assert len(finished(tmp_path / "out")) == MAX_FAILURES


def test_bags_that_are_deleted_meanwhile_are_told(out: Path, tmp_path: Path) -> None:
    results = Results(Campaign.from_file(written(tmp_path)), out)
    (out / "bags/000001.mcap").unlink()
    given: Any = argparse.Namespace(no_bags=False, report=None)
    with pytest.raises(BagError, match=rf"1 of 6 bags were deleted or changed meanwhile \(1\): .*{RESUMED}"):
        campaign_runs._answer(results._campaign, results, given)
    assert 1 not in results.finished
