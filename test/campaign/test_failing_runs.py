"""Runs that fail, or get no score, leave nothing behind, and many of them end a campaign in one line."""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from campaigns import NEEDS_DASK, SCORES, finished, refused, table_of, written

from lie_rigid_body.campaign import Campaign, cluster
from lie_rigid_body.campaign.cluster import MOST_FAILURES, RUNS_AHEAD
from lie_rigid_body.campaign.journal import RESUMED, Journal
from lie_rigid_body.campaign.run import MORE_SCORES, BagFolder, Judgement, Row, carry_out
from lie_rigid_body.cli import campaign_runs
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.foundation.errors import BagError

pytestmark = NEEDS_DASK


@pytest.mark.usefixtures("asked_here")
def test_runs_that_fail_one_after_another_end_a_campaign(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a million too, as where the disk is full: here of what no run can be, found as late as that."""
    monkeypatch.setattr(campaign_runs, "MOST_TRIED", 0)
    path = written(tmp_path, "runs: 1000000\nseed: 1\nduration: 1.0\nparameters: {rate: -3.0}")
    given = [str(path), "--out", str(tmp_path / "out"), "--scheduler", scheduler]
    assert main(given) == 2
    [_, line] = capsys.readouterr().err.splitlines()
    most = MOST_FAILURES + RUNS_AHEAD
    assert f"{most} of 1000000 " in line
    assert not finished(tmp_path / "out")


def test_the_line_about_failed_runs_has_the_cause(tmp_path: Path) -> None:
    campaign, out = Campaign(runs=40, seed=1, duration=0.02), tmp_path / "out"
    with Journal(campaign, out) as journal:
        (out / "bags" / "000002.mcap").mkdir()
        with pytest.raises(BagError) as failed:
            carry_out(campaign, 2, journal.bags)
        line = str(campaign_runs._failure(campaign, journal, {2: failed.value}))
    assert str(failed.value) in line
    assert line.endswith(RESUMED)


@pytest.mark.usefixtures("asked_here")
def test_what_is_in_the_way_of_a_bag_from_elsewhere_costs_that_run_only(
    scheduler: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = written(tmp_path, "runs: 6\nseed: 1\nduration: 0.1"), tmp_path / "out"
    given = [str(path), "--out", str(out), "--scheduler", scheduler]
    with Journal(Campaign.from_file(path), out):
        (out / "bags" / "000002.mcap").mkdir()
    assert main(given) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2
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
            carry_out(campaign, 0, BagFolder.of(tmp_path))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert [bag.read_bytes() for bag in (tmp_path / "bags").iterdir()] == older


def test_a_run_that_fails_removes_nothing_that_it_did_not_write(tmp_path: Path) -> None:
    """Here a link, which is not followed: no bag is begun."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "bags").symlink_to(elsewhere)
    (elsewhere / "000000.mcap").symlink_to(tmp_path / "nowhere")
    with pytest.raises(BagError):
        carry_out(Campaign(runs=1, seed=1, duration=1.0), 0, BagFolder.of(tmp_path))
    assert (elsewhere / "000000.mcap").is_symlink()


def test_no_bag_is_replaced_in_a_folder_that_took_the_place_of_the_own(tmp_path: Path) -> None:
    campaign, out, others = Campaign(runs=1, seed=1, duration=1.0), tmp_path / "out", tmp_path / "others"
    precious = others / "bags" / "000000.mcap"
    precious.parent.mkdir(parents=True)
    precious.write_bytes(b"precious")
    with Journal(campaign, out) as journal:
        out.rename(tmp_path / "moved")
        out.symlink_to(others)
        with refused("moved"):
            carry_out(campaign, 0, journal.bags)
    assert (precious.read_bytes(), os.listdir(precious.parent)) == (b"precious", ["000000.mcap"])


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files to others")
def test_rows_that_another_user_wrote_are_not_believed(tmp_path: Path) -> None:
    campaign = Campaign(runs=1, seed=1, duration=1.0)
    with Journal(campaign, tmp_path / "out") as journal:
        journal.add(Row(0, certified=True))
    os.chown(journal.path, 65534, 65534)
    with refused("another user"), Journal(campaign, tmp_path / "out"):
        pass
    os.chown(journal.path, 0, 0)
    with Journal(campaign, tmp_path / "out") as journal:
        assert len(journal) == 1


@pytest.mark.usefixtures("asked_here")
@pytest.mark.parametrize("said_there", ["it is lost", "estimator 'a:b' cannot be imported: it is lost: mend it"])
def test_an_estimator_without_any_score_is_an_error(
    out: Path, tmp_path: Path, said_there: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also one that cannot be imported on the workers, whose reason ends with a remedy itself."""
    copy, scores = shutil.copytree(out, tmp_path / "copy"), dict.fromkeys((*SCORES, *MORE_SCORES))
    failed = vars(Judgement({**scores, "estimator_error": said_there}))
    with Journal(Campaign.from_file(written(tmp_path)), out) as journal:
        rows = [replace(row, judgements=[failed]) for row in journal.rows()]
    heading = (copy / "runs.jsonl").read_text().partition("\n")[0]
    (copy / "runs.jsonl").write_text("\n".join([heading, *(json.dumps(vars(row)) for row in rows), ""]))
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 2
    said = capsys.readouterr()
    assert said_there in said.out
    [line] = said.err.splitlines()
    assert line.count(said_there.partition(": mend")[0]) == 1
    assert table_of(copy)["estimator_error"].to_pylist() == [said_there] * 6


@pytest.mark.usefixtures("asked_here")
def test_an_estimator_without_a_score_in_the_first_runs_ends_a_campaign(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "always_lost.py").write_text("def estimate(run): raise RuntimeError('it is lost')")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, "runs: 99\nseed: 1\nduration: 0.02\nestimator: always_lost:estimate")
    assert main([str(path), "--out", "out", "--no-bags", "--scheduler", scheduler]) == 2
    [_, line] = capsys.readouterr().err.splitlines()
    assert f" {MOST_FAILURES} " in line
    assert "RuntimeError: it is lost" in line
    assert len(finished(tmp_path / "out")) == MOST_FAILURES


def test_an_estimator_that_goes_elsewhere_costs_nothing_and_bags_that_are_deleted_are_told(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "wanderer.py").write_text(
        "import os\ndef estimate(run):\n    os.chdir(os.sep)\n    return run.truth.attitude_xyzw\n"
    )
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.chdir(tmp_path)
    campaign = Campaign.from_file(written(tmp_path, "runs: 3\nseed: 1\nduration: 0.02\nestimator: wanderer:estimate"))
    with Journal(campaign, tmp_path / "out") as journal:
        asked: dict[str, Any] = {"bags": True, "elsewhere": False, "alone": print}
        with cluster.client_of(None, scheduler) as client:
            for _, row in cluster.finished(client, campaign, range(3), journal.bags, **asked):
                assert isinstance(row, Row), row
                journal.add(row)
        monkeypatch.chdir(tmp_path)
        given = argparse.Namespace(no_bags=False, report=None)
        assert campaign_runs._report(campaign, journal, {}, given) == 0
        Path("out/bags/000001.mcap").unlink()
        with refused("changed bags", count=1, of=3, which=1):
            campaign_runs._report(campaign, journal, {}, given)
        assert 1 not in journal
