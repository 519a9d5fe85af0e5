"""Files that cannot be written, or not to the end, and older ones that must not suffer from it."""

from __future__ import annotations

import errno
import os
import resource
import struct
from contextlib import suppress
from io import BufferedWriter
from pathlib import Path
from typing import Any

import pytest
import zstandard
from bags import MakeBag, write_samples
from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from refused_bags import KEPT, refused

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.output_file import OutputFile, write_file

pytestmark = pytest.mark.filterwarnings("ignore:This process.*is multi-threaded:DeprecationWarning")  # of libraries
SCENARIO = Scenario.from_parameters({"motion": "closed_form"})


def message_topics_before_the_cut(path: Path) -> list[str]:
    """What a recovering reader finds: every message of every whole chunk."""
    topics: dict[int, str] = {}
    found = []
    with open(path, "rb") as stream, suppress(McapError, zstandard.ZstdError, struct.error):
        for record in StreamReader(stream).records:
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            if isinstance(record, Message):
                found.append(topics[record.channel_id])
    return found


def test_what_was_synced_is_there_before_the_end(tmp_path: Path) -> None:
    """As after a kill: `test_killed_recordings`."""
    path, simulation = tmp_path / "killed.mcap", Simulation(SCENARIO)
    with BagWriter(path, stamped_twist=True) as bag:
        bag.begin_segment(simulation.segment)
        write_samples(bag, SCENARIO, simulation.take(150))
        bag.flush()
        bag.wait()
        write_samples(bag, SCENARIO, simulation.take(150))
        found = message_topics_before_the_cut(path)
        assert [found.count(topic) for topic in ("/pose", "/twist", "/lie_rigid_body/scenario")] == [150, 150, 1]
        with refused("killed", count=301):
            read_bag(path)


def test_a_failed_run_keeps_the_bag_it_was_to_replace_and_nothing_else(make_bag: MakeBag) -> None:
    path = make_bag()
    before = path.read_bytes()
    with pytest.raises(ZeroDivisionError), BagWriter(path, stamped_twist=True, overwrite=True):
        raise ZeroDivisionError
    assert path.read_bytes() == before
    assert os.listdir(path.parent) == [path.name]


@pytest.mark.parametrize("old", [b"", b"the older file"])
def test_a_full_disk_is_told_in_one_line(tmp_path: Path, old: bytes) -> None:
    path, simulation, limits = tmp_path / "full.mcap", Simulation(SCENARIO), resource.getrlimit(resource.RLIMIT_FSIZE)
    if old:
        path.write_bytes(old)

    def written() -> None:
        with BagWriter(path, stamped_twist=True, overwrite=True) as bag:
            bag.begin_segment(simulation.segment)
            for _ in range(20):
                write_samples(bag, SCENARIO, simulation.take(500))

    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, limits[1]))
    try:
        with pytest.raises(BagError, match=f"full.mcap .*: {os.strerror(errno.EFBIG)}; ") as caught:
            written()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    said = str(caught.value)
    assert "\n" not in said
    if old:
        assert path.read_bytes() == old
        assert KEPT in said
        assert os.listdir(tmp_path) == [path.name]
    else:
        assert "lie-rigid-body recover" in said
        assert message_topics_before_the_cut(path).count("/pose") > 500


def test_replacing_follows_links_and_keeps_permissions(make_bag: MakeBag) -> None:
    path = make_bag()
    path.chmod(0o640)
    link = path.with_name("link.mcap")
    link.symlink_to(path)
    with BagWriter(link, stamped_twist=True, overwrite=True):
        pass
    assert link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o640
    with refused("no message", topic="/pose"):
        read_bag(path)


def test_a_new_file_runs_never_as_its_owner(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.touch()
    path.chmod(0o6750)
    write_file(path, b"new", overwrite=True)
    assert path.stat().st_mode & 0o7777 == 0o750


@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("target", ["nowhere/a.mcap", "missing.mcap", "link.mcap"])
def test_a_link_that_leads_to_no_file_is_named(tmp_path: Path, target: str, overwrite: bool) -> None:
    (tmp_path / "link.mcap").symlink_to(target)
    with refused("dangling link", name="link.mcap"):
        BagWriter(tmp_path / "link.mcap", stamped_twist=True, overwrite=overwrite)
    assert os.listdir(tmp_path) == ["link.mcap"]


@pytest.mark.parametrize(
    ("given", "name"),
    [
        (".", "folder"),
        ("none/a.mcap", "no folder"),
        ("file/a.mcap", "file as folder"),
        ("n" * 300, "name too long"),
        ("nul\0l", "null"),
        ("fifo", "not regular"),
        ("/proc/a.mcap", "no place"),
        ("/dev/null", "not regular"),
    ],
)
def test_a_place_where_nothing_can_be_written_is_refused(tmp_path: Path, given: str, name: str) -> None:
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "file").touch()
    with refused(name) as caught:
        BagWriter(tmp_path / given, stamped_twist=True, overwrite=True)
    assert "\n" not in str(caught.value)
    assert sorted(os.listdir(tmp_path)) == ["fifo", "file"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    with refused("cannot be created", why="Permission denied"):
        BagWriter(tmp_path / "a.mcap", stamped_twist=True)


@pytest.mark.parametrize(
    ("number", "advice"),
    [(errno.ENOSPC, "make room"), (errno.EDQUOT, "make room"), (errno.EIO, "look after"), (errno.EROFS, "look after")],
)
def test_a_disk_that_is_not_full_needs_no_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, advice: str
) -> None:
    bag = BagWriter(tmp_path / "a.mcap", stamped_twist=True)
    bag.begin_segment(Simulation(Scenario.from_parameters()).segment)

    def fail(descriptor: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", fail)
    with refused("disk", name="a.mcap", why=os.strerror(number), advice=advice):
        bag.finish()


def test_what_is_committed_is_not_taken_back(tmp_path: Path) -> None:
    """As by an interruption after the last byte."""
    out = OutputFile(tmp_path / "a", overwrite=False)
    out.commit()
    out.discard()
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("old", [b"", b"the older file"])
@pytest.mark.parametrize("call", ["close", "replace"])
def test_a_disk_that_fails_at_the_end_leaves_nothing_beside_the_older_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, old: bytes
) -> None:
    """As a disk elsewhere that tells only then that what was written is lost."""
    path = tmp_path / "a"
    if old:
        path.write_bytes(old)

    out = OutputFile(path, overwrite=True)

    def fail(*names: Path) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    out.stream.write(b"new")
    if call == "close":
        out.stream = Unclosed(out.stream)
    monkeypatch.setattr(os, call, fail) if call == "replace" else None
    if old or call == "close":
        with pytest.raises(OSError) as failure:
            out.commit()
        assert failure.value.errno == errno.EIO
        out.discard()
    else:
        out.commit()
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [old or b"new"] * bool(old or call == "replace")


class Unclosed(BufferedWriter):
    """A stream that tells only when it is closed that a disk elsewhere has lost what was written."""

    def __init__(self, stream: Any) -> None:
        super().__init__(stream.detach())

    def close(self) -> None:
        super().close()
        raise OSError(errno.EIO, os.strerror(errno.EIO))


@pytest.mark.parametrize("old", [b"", b"the older file"])
def test_the_folder_is_synced_after_the_file_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: bytes
) -> None:
    """Else a loss of power could leave the older file, or none, under the name."""
    path, synced, sync = tmp_path / "a", list[str](), os.fsync
    if old:
        path.write_bytes(old)

    def spied(descriptor: int) -> None:
        name = os.readlink(f"/proc/self/fd/{descriptor}")
        synced.append(f"{Path(name).suffix or Path(name).name}: {path.read_text() if path.exists() else ''}")
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", spied)
    write_file(path, b"new", overwrite=True)
    assert synced == [f".part: {old.decode()}", f"{tmp_path.name}: new"]
