"""The rows of a campaign: a file each, which may be damaged, unreadable, or without room on the disk."""

from __future__ import annotations

import errno
import os
import resource
from pathlib import Path

import pytest
from campaigns import NEEDS_PARQUET, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.results import RESUMED, Results
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.foundation.errors import BagError

pytestmark = NEEDS_PARQUET


@pytest.fixture
def results(out: Path, tmp_path: Path) -> Results:
    return Results(Campaign.from_file(written(tmp_path)), out)


def test_rows_are_read_as_they_were_added(results: Results) -> None:
    rows = [*results.rows()]
    assert [row.run for row in rows] == [*range(6)]
    path = results.folder / "runs/000003.json"
    before = path.read_bytes()
    path.unlink()
    results.add(rows[3])
    assert path.read_bytes() == before
    assert len(results) == 6


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


@pytest.mark.usefixtures("asked_here")
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
    Results(results._campaign, results.folder).remove_parts()
    kept = [f"{run:06d}.mcap" for run in range(6) if run != 4]
    assert sorted(os.listdir(bags)) == [*kept, "another.mcap"]
