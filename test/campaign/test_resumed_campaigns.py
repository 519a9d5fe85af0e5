"""A campaign that is given again: what is finished is not done twice, and what is missing or damaged is made.

Its rows are a file each, which may be damaged, unreadable, or without room on the disk.
"""

from __future__ import annotations

import errno
import json
import os
import resource
import shutil
from pathlib import Path
from typing import Any

import pytest
from campaigns import CAMPAIGN, ESTIMATED, NEEDS_PARQUET, bytes_of, finished, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.results import RESUMED, Results
from lie_rigid_body.campaign.run import Row
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.foundation.errors import BagError, InputError

pytestmark = [NEEDS_PARQUET, pytest.mark.usefixtures("asked_here")]


def times(out: Path) -> dict[str, int]:
    """When each file of a finished run was written."""
    return {path.stem + path.suffix: path.stat().st_mtime_ns for path in out.glob("*/0*")}


def bags_cut(out: Path) -> None:
    (out / "bags/000002.mcap").unlink()
    os.truncate(out / "bags/000001.mcap", 5000)


def made_without(out: Path) -> None:
    shutil.rmtree(out / "bags")
    for path in (out / "runs").iterdir():
        path.write_text(json.dumps({**json.loads(path.read_text()), "bag": None, "bag_bytes": None}))


def never_done(out: Path) -> None:
    for run in (3, 5):
        (out / f"runs/00000{run}.json").unlink()


@pytest.mark.parametrize(
    ("happen", "runs"), [(bags_cut, [1, 2]), (made_without, [*range(6)]), (never_done, [3, 5]), (str, [])]
)
def test_what_is_missing_is_made_again_and_nothing_else(
    out: Path, tmp_path: Path, happen: Any, runs: list[int]
) -> None:
    bags, table = bytes_of(out), (out / "runs.parquet").read_bytes()
    happen(out)
    before = times(out)
    assert main([str(written(tmp_path)), "--out", str(out), "--workers", "1"]) == 0
    assert bytes_of(out) == bags
    assert (out / "runs.parquet").read_bytes() == table
    changed = {name for name, time_ns in times(out).items() if before.get(name) != time_ns}
    assert changed == {f"{run:06d}.{kind}" for run in runs for kind in ("json", "mcap")}


def test_bags_that_are_there_are_kept_where_none_are_wanted(out: Path, tmp_path: Path) -> None:
    before = bytes_of(out)
    assert main([str(written(tmp_path)), "--out", str(out), "--no-bags"]) == 0
    assert bytes_of(out) == before


@pytest.mark.parametrize(
    ("written_once", "written_now"),
    [("mass: 8.0", "mass: 8"), ("rate: 100.0", "rate: 1.0e2"), ("low: 1e-5, high: 1.0e-3", "low: 0.1e-4, high: 0.001")],
)
def test_a_number_may_be_written_otherwise(
    out: Path, tmp_path: Path, written_once: str, written_now: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table keeps the bytes that it had."""
    before = (out / "runs.parquet").read_bytes()
    path = written(tmp_path, ESTIMATED.replace(written_once, written_now))
    assert main([str(path), "--out", str(out)]) == 0, capsys.readouterr().err
    assert (out / "runs.parquet").read_bytes() == before


@pytest.mark.parametrize(("one", "other"), [("2.0", "2.5"), ("9007199254740993", "9007199254740992")])
def test_numbers_that_are_not_equal_are_of_another_campaign(one: str, other: str, tmp_path: Path) -> None:
    campaigns = [Campaign(1, 1, 1.0, parameters={"rate": json.loads(text)}) for text in (one, other)]
    Results(campaigns[0], tmp_path / "out").add(Row(0))
    assert [Results.is_begun(campaign, tmp_path / "out") for campaign in campaigns] == [True, False]
    with pytest.raises(InputError):
        Results(campaigns[1], tmp_path / "out")


def test_a_folder_without_a_run_is_free_for_another_campaign(tmp_path: Path) -> None:
    """As that of one that was interrupted at its beginning."""
    Results(Campaign(6, 7, 0.25), tmp_path / "out")
    written(tmp_path, CAMPAIGN.replace("runs: 6", "runs: 2"))
    given = [str(tmp_path / "campaign.yaml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main(given) == 0
    assert finished(tmp_path / "out") == [0, 1]
    written(tmp_path, CAMPAIGN)
    assert main(given) == 2


@pytest.fixture
def results(out: Path, tmp_path: Path) -> Results:
    return Results(Campaign.from_file(written(tmp_path)), out)


def test_a_row_that_does_not_fit_on_the_disk_is_told_and_done_anew(results: Results, tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    rows = [*results.rows()]
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, before[1]))
    (results.folder / "runs/000000.json").unlink()
    try:
        with pytest.raises(BagError, match=f"000000.json cannot be written: .*{RESUMED}"):
            results.add(rows[0])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    results.held.close()
    assert 0 not in Results(Campaign.from_file(tmp_path / "campaign.yaml"), results.folder).finished


def test_a_table_that_is_not_synced_replaces_none(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    before, sync = (results.folder / "runs.parquet").read_bytes(), os.fsync

    def fail(descriptor: int) -> None:
        if os.readlink(f"/proc/self/fd/{descriptor}").endswith(".part"):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        sync(descriptor)

    names = sorted(os.listdir(results.folder))
    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(BagError, match=r"runs\.parquet cannot be written: "):
        results.write_table()
    assert sorted(os.listdir(results.folder)) == names
    assert (results.folder / "runs.parquet").read_bytes() == before
    monkeypatch.undo()
    results.write_table()
    assert (results.folder / "runs.parquet").read_bytes() == before


@pytest.mark.parametrize("text", ["nonsense", "3", '{"run": 1, "speed": 2}', ""])
def test_a_damaged_row_is_told_and_done_again_where_it_is_deleted(
    out: Path, tmp_path: Path, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, table = out / "runs/000001.json", (out / "runs.parquet").read_bytes()
    path.write_text(text)
    given = [str(written(tmp_path)), "--out", str(out), "--workers", "1"]
    assert main(given) == 2
    assert f"{path} is damaged: delete it" in capsys.readouterr().err
    path.unlink()
    assert main(given) == 0
    assert (out / "runs.parquet").read_bytes() == table


def test_a_row_that_cannot_be_read_is_told(results: Results) -> None:
    path = results.folder / "runs/000001.json"
    path.unlink()
    path.mkdir()
    with pytest.raises(BagError, match=r"000001\.json cannot be read: "):
        results.write_table()


def test_bags_of_runs_that_are_not_finished_are_removed(results: Results) -> None:
    (results.folder / "runs/000004.json").unlink()
    bags = results.folder / "bags"
    for name in ("another.mcap", ".lie_rigid_body-1.part"):
        (bags / name).touch()
    results.held.close()
    Results(results._campaign, results.folder).remove_parts()
    kept = [f"{run:06d}.mcap" for run in range(6) if run != 4]
    assert sorted(os.listdir(bags)) == [*kept, "another.mcap"]
