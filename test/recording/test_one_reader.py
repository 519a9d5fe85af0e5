"""Messages are found in one way, whatever indexes say, and are the same when a bag is read again."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import MakeBag, rewrite
from forged import message
from refused_bags import refused

from foreign_bags import record
from lie_rigid_body.messages.definitions import STRING
from lie_rigid_body.recording import mcap_reader
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.mcap_contents import nothing
from lie_rigid_body.recording.records import MAGIC, NO_HINTS, DamageError, FileBytes, find_messages, records
from lie_rigid_body.runs import Run

POSE = ("/pose", "geometry_msgs/msg/PoseStamped")


RECORDS = [message(1), record(4, b"a channel"), message(2, b""), message(1, b"longer payload", 9), record(3, b"schema")]
DATA = b"".join(RECORDS)
STARTS = [sum(map(len, RECORDS[:i])) for i in range(len(RECORDS)) if RECORDS[i][0] == 5]


@pytest.mark.parametrize(
    "hints",
    [
        [],
        STARTS,
        STARTS[::-1],
        STARTS[:1],
        STARTS[1:],
        [STARTS[0], STARTS[0]],
        [STARTS[1] + 1],
        [-1],
        [len(DATA)],
        [2**62],
        [len(RECORDS[0])],
        [*STARTS, STARTS[1] + 9],
    ],
)
def test_hints_change_nothing_but_time(hints: list[int]) -> None:
    table = find_messages(DATA, np.array(hints, dtype=np.int64))
    assert table.starts.tolist() == STARTS
    assert [DATA[start:end] for start, end in zip(table.starts, table.ends, strict=True)] == [
        one for one in RECORDS if one[0] == 5
    ]
    assert table.heads["channel"].tolist() == [1, 2, 1]
    assert table.heads["log_time"].tolist() == [7, 7, 9]
    assert [(place.opcode, DATA[place.begin : place.end]) for place in table.definitions] == [
        (4, b"a channel"),
        (3, b"schema"),
    ]


def test_a_hint_into_a_payload_is_not_followed() -> None:
    """What stands there is a whole message, too, but within another."""
    data = message(1, message(2))
    inner = len(data) - len(message(2))
    for hints in ([inner], [0, inner], [inner, 0]):
        table = find_messages(data, np.array(hints))
        assert table.heads["channel"].tolist() == [1]


def test_what_is_too_short_to_be_a_message_is_damage() -> None:
    for hints in (NO_HINTS, np.array([0])):
        with pytest.raises(DamageError):
            find_messages(record(5, b"short") + DATA, hints)


@pytest.mark.parametrize(("data", "whole"), [(DATA[:-1], DATA[: -len(RECORDS[-1])]), (DATA + b"\5", DATA)])
def test_what_is_no_whole_record_ends_the_data(data: bytes, whole: bytes) -> None:
    for hints in (NO_HINTS, np.array(STARTS[:2])):
        table = find_messages(data, hints)
        assert (table.data, table.starts.tolist()) == (whole, STARTS)


def test_a_run_reads_its_file_once(make_bag: MakeBag, monkeypatch: pytest.MonkeyPatch) -> None:
    path, told = make_bag(count=300), list[int]()
    Bag(path, told.append, in_memory=True).load()
    assert sum(told) <= path.stat().st_size
    again = mcap_reader._read_again
    monkeypatch.setattr(mcap_reader, "_read_again", lambda *given: again(*texts_alone(*given)))
    assert len(Run.from_bag(path).t_ns) == 300


def texts_alone(*given: Any) -> tuple[Any, ...]:
    assert {kind for _, kind in given[3]} == {STRING}
    return given


def test_a_file_that_is_cut_while_it_is_read_has_changed(make_bag: MakeBag) -> None:
    path = make_bag(count=700)
    with closing(FileBytes(path)) as file, refused("changed"):
        for place in records(file, len(MAGIC)):
            os.truncate(path, place.end + 1)


def test_a_bag_that_changes_between_two_readings_is_refused(make_bag: MakeBag, tmp_path: Path) -> None:
    path = make_bag(count=700)
    whole, bag = path.read_bytes(), Bag(path)
    assert sum(len(poses.stamps_ns) for poses, _ in bag.batches()) == 700
    with path.open("r+b") as stream:
        stream.seek(5000)
        stream.write(b"changed")
    with refused("changed"):
        list(bag.batches())
    (tmp_path / "other.mcap").write_bytes(whole)
    os.replace(tmp_path / "other.mcap", path)
    with refused("changed"):
        list(bag.batches())


def test_a_message_that_is_no_pose_is_named(make_bag: MakeBag, tmp_path: Path) -> None:
    numbers = iter(range(1000))
    bag = Bag(
        rewrite(
            make_bag(count=700),
            tmp_path / "short.mcap",
            change=lambda number, topic, data: data[:-1] if topic == "/pose" and next(numbers) == 650 else data,
            chunk_size=5000,
        )
    )
    with refused("size of a message", topic="/pose", number=650):
        list(bag.batches())


def test_a_file_that_is_written_to_while_it_is_read_again_has_changed(make_bag: MakeBag) -> None:
    """Its bytes may be the ones that were read before, or not."""
    path = make_bag(count=3000)
    contents = BagFiles(path).contents(nothing)
    parts = contents.read([POSE])
    next(parts)
    os.utime(path, ns=(0, 0))
    with refused("changed"):
        list(parts)
