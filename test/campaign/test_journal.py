"""The journal of a campaign: rows that were cut off, do not fit on the disk, are damaged or taken away."""

from __future__ import annotations

import errno
import json
import os
import resource
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from campaigns import NEEDS_DASK, finished, refused, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.journal import Journal
from lie_rigid_body.campaign.run import Row
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.foundation.errors import BagError

pytestmark = NEEDS_DASK


@pytest.fixture
def journal(out: Path, tmp_path: Path) -> Iterator[Journal]:
    copy = shutil.copytree(out, tmp_path / "copy")
    with Journal(Campaign.from_file(written(tmp_path)), copy) as journal:
        yield journal


def test_a_row_that_a_kill_cut_off_is_done_anew(out: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    whole = (copy / "runs.jsonl").read_text()
    (copy / "runs.jsonl").write_text(whole[:-9])
    campaign, rows, last = Campaign.from_file(written(tmp_path)), list[Row](), finished(out)[-1]
    with Journal(campaign, out) as journal:
        rows += journal.rows()
    with Journal(campaign, copy) as journal:
        assert list(journal.rows()) == rows[:last] + rows[last + 1 :]
        journal.add(rows[last])
    assert (copy / "runs.jsonl").read_text() == whole


def test_a_row_that_does_not_fit_on_the_disk_is_told_and_done_anew(journal: Journal, tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    whole, rows = journal.path.read_text(), list(journal.rows())
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 20, before[1]))
    try:
        with pytest.raises(BagError):
            journal.add(rows[0])
        journal.__exit__(None, None, None)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert len(journal.path.read_text()) == len(whole) + 20
    with Journal(Campaign.from_file(written(tmp_path)), journal.folder) as again:
        assert list(again.rows()) == rows
    assert journal.path.read_text() == whole


@pytest.mark.parametrize("name", ["runs.jsonl", ".part"])
def test_a_table_that_is_not_synced_replaces_none(
    journal: Journal, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Neither where the rows are not on the disk, nor the table itself; the same command makes it."""
    before, sync = (journal.folder / "runs.parquet").read_bytes(), os.fsync

    def fail(descriptor: int) -> None:
        if os.readlink(f"/proc/self/fd/{descriptor}").endswith(name):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        sync(descriptor)

    names = sorted(os.listdir(journal.folder))
    monkeypatch.setattr(os, "fsync", fail)
    with refused("not written", why="Input/output error"):
        journal.write_table()
    assert sorted(os.listdir(journal.folder)) == names
    assert (journal.folder / "runs.parquet").read_bytes() == before
    monkeypatch.undo()
    journal.write_table()
    assert (journal.folder / "runs.parquet").read_bytes() == before


def test_rows_that_cannot_be_read_again_are_told(journal: Journal, monkeypatch: pytest.MonkeyPatch) -> None:
    class Broken:
        def seek(self, place: int) -> None:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(journal, "_file", Broken())
    with refused("not read", why="Input/output error"):
        journal.write_table()


def test_a_campaign_that_ended_before_its_journal_began_is_begun_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a kill, or where no more files can be opened."""
    campaign = Campaign.from_file(written(tmp_path))

    def fail(path: str, flags: int) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), path)

    monkeypatch.setattr("lie_rigid_body.campaign.journal.open_itself", fail)
    with refused("not written", why="No space left on device"):
        Journal(campaign, tmp_path / "new")
    monkeypatch.undo()
    with Journal(campaign, tmp_path / "new") as journal:
        assert len(journal) == 0


@pytest.mark.parametrize("length", [1, 20, -1])
def test_a_campaign_that_ended_within_its_first_line_is_begun_again(journal: Journal, length: int) -> None:
    line = journal.path.read_bytes().partition(b"\n")[0] + b"\n"
    out = journal.folder.with_name("new")
    out.mkdir()
    (out / "runs.jsonl").write_bytes(line[:length])
    with Journal(journal._campaign, out) as again:
        assert len(again) == 0
    assert (out / "runs.jsonl").read_bytes() == line


@pytest.mark.parametrize("text", [b'{"campaigns": 1', b'{"campaign": "mine', b'{"campaign": \n'])
def test_a_file_that_is_no_part_of_a_first_line_stays(journal: Journal, text: bytes) -> None:
    out = journal.folder.with_name("new")
    out.mkdir()
    (out / "runs.jsonl").write_bytes(text)
    with refused("another campaign"):
        Journal(journal._campaign, out)
    assert (out / "runs.jsonl").read_bytes() == text


def test_a_first_line_for_which_there_is_no_room_is_told(journal: Journal) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, before[1]))
    try:
        with refused("not written", why="File too large"):
            Journal(journal._campaign, journal.folder.with_name("new"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    with Journal(journal._campaign, journal.folder.with_name("new")) as again:
        assert len(again) == 0


@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_a_journal_that_is_no_file_is_refused_at_once(kind: str, tmp_path: Path) -> None:
    """Of a pipe nothing would ever come."""
    campaign, out = Campaign.from_file(written(tmp_path)), tmp_path / "out"
    out.mkdir()
    make: dict[str, Callable[[Path], None]] = {
        "pipe": os.mkfifo,
        "folder": Path.mkdir,
        "device": lambda path: path.symlink_to("/dev/zero"),
    }
    make[kind](out / "runs.jsonl")
    assert not Journal.is_begun(campaign, out)
    with refused("no file"):
        Journal(campaign, out)


@pytest.mark.parametrize("put", ["nothing", "another file"])
def test_a_folder_that_is_taken_away_is_told(journal: Journal, put: str) -> None:
    """Else all further rows would go where nobody finds them."""
    [first, *_] = journal.rows()
    journal.path.unlink()
    if put != "nothing":
        journal.path.write_text("other")
    with pytest.raises(BagError):
        journal.add(first)


@pytest.mark.usefixtures("asked_here")
@pytest.mark.parametrize("line", ["nonsense", "3", '{"run": 6}', '{"run": 1, "speed": 2}'])
def test_a_damaged_row_is_told(out: Path, tmp_path: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    place = (copy / "runs.jsonl").stat().st_size
    with (copy / "runs.jsonl").open("a") as file:
        file.write(f"{line}\n")
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 2
    assert f"byte {place} " in capsys.readouterr().err


OVERFLOWING = [{"scores": {"total_rms_deg": 1.0}, "reading_s": 1e-6, "curve_deg": [10**400]}]
TAMPERED: dict[str, list[object]] = {
    "parameters": [[], None, {}, {"rate": 5.0}],
    "attitude_accuracy_rad": ["x", None, float("nan"), -1.0],
    "certified": ["no", 1],
    "bag": ["../../secret.mcap", "bags/000005.mcap", 5],
    "run": [0.5, True, -1, 10**30],
    "residuals": [5, *({"frames": value} for value in ({"a": 1}, "xy", True, [1.0], [0, [1.0]]))],
    "judgements": [5, [], [5], [{}], [{"scores": {}}], [{"scores": None}], [{"scores": 5}], OVERFLOWING],
    "other": [1],
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in TAMPERED.items() for value in values])
def test_a_row_of_other_types_or_with_a_bag_elsewhere_is_told(
    out: Path, tmp_path: Path, name: str, value: object
) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    heading, first, *others = (copy / "runs.jsonl").read_text().splitlines(keepends=True)
    changed = json.dumps({**json.loads(first), name: value})
    (copy / "runs.jsonl").write_text("".join([heading, changed, "\n", *others]))
    with refused("no row"):
        Journal(Campaign.from_file(written(tmp_path)), copy)


@pytest.mark.parametrize("line", ["[" * 100_000, '"' + "x" * 2**21 + '"', "\x00"])
def test_a_line_without_end_is_told(out: Path, tmp_path: Path, line: str) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    text = (copy / "runs.jsonl").read_text()
    (copy / "runs.jsonl").write_text(f"{text}{line}\n")
    with refused("no row"):
        Journal(Campaign.from_file(written(tmp_path)), copy)
