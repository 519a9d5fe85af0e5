"""Every length that a file says is held against a bound: each is set to its largest, and the memory is measured."""

from __future__ import annotations

import struct
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from forged import Record, honest
from refused_bags import refused

from foreign_bags import decode, file_of, sized
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.decoding import decode_framed, decode_string
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.mcap_contents import nothing
from lie_rigid_body.system.bounded_input import load_json

MIB = 2**20
FIELDS = {
    1: "SS", 2: "884", 3: "2SSM", 4: "22SSM", 5: "2488M", 6: "", 7: "2M", 8: "8888M8S88", 9: "88SSD4",
    10: "88888SS", 11: "82444488M", 12: "SM", 13: "88S", 14: "188", 15: "4",
}  # fmt: skip
"""Fields of the records of MCAP by opcode: numbers of some bytes, a text S, and a map or bytes M or D, whose length has
4 bytes or 8. A message is all data behind its numbers, and a chunk is made of other records."""


def length_places(opcode: int, content: bytes) -> Iterator[tuple[int, int]]:
    """Where each length stands in the content of a record, and of how many bytes it is; those in maps as well."""
    at = 0
    for kind in FIELDS[opcode]:
        if kind.isdecimal():
            at += int(kind)
            continue
        size = 8 if kind == "D" else 4
        if at + size > len(content):
            return
        length = int.from_bytes(content[at : at + size], "little")
        yield at, size
        if kind == "M" and opcode in (4, 12) and length:
            yield at + 4, 4
            yield at + 8 + int.from_bytes(content[at + 4 : at + 8], "little"), 4
        at += size + length


def forged_lengths() -> Iterator[tuple[int, list[Record]]]:
    records = honest()
    for i, (opcode, content) in enumerate(records):
        for at, size in length_places(opcode, content):
            for value in (2 ** (8 * size) - 1, 2 ** (8 * size - 1), len(content)):
                changed = content[:at] + value.to_bytes(size, "little") + content[at + size :]
                if changed != content:
                    yield opcode, [*records[:i], (opcode, changed), *records[i + 1 :]]


def test_every_length_of_a_record_at_its_largest_is_refused_or_of_no_account(tmp_path: Path) -> None:
    """Those of indexes, of the summary and of attachments tell of no message."""
    path, refusals = tmp_path / "x.mcap", 0
    path.write_bytes(file_of(honest()))
    whole = BagFiles(path).contents(nothing)
    for _, forged in forged_lengths():
        path.write_bytes(file_of(forged))
        tracemalloc.start()
        try:
            found = BagFiles(path).contents(nothing)
        except BagError:
            refusals += 1
        else:
            assert found.tracks == whole.tracks
        finally:
            assert tracemalloc.get_traced_memory()[1] < 16 * MIB
            tracemalloc.stop()
    assert refusals > 10


HEADER = b"\0\1\0\0" + bytes(8)
STRINGS: dict[str, tuple[Callable[[bytes], object], bytes]] = {
    "frame of a pose": (lambda data: decode([data], 7, stamped=True), HEADER),
    "text": (lambda data: decode_string(data), b"\0\1\0\0"),
    "frame of an odometry": (lambda data: decode_framed([data], 85, counted=False), HEADER),
    "child frame": (lambda data: decode_framed([data], 85, counted=False), HEADER + sized(b"w\0") + bytes(2)),
    "transforms": (lambda data: decode_framed([data], 7, counted=True), b"\0\1\0\0"),
    "frame of a transform": (lambda data: decode_framed([data], 7, counted=True), b"\0\1\0\0\1\0\0\0" + bytes(8)),
}


@pytest.mark.parametrize("name", STRINGS)
@pytest.mark.parametrize("length", [2**32 - 1, 2**31, 2**20 + 1])
def test_every_length_of_a_message_at_its_largest_is_refused(name: str, length: int) -> None:
    read, before = STRINGS[name]
    for behind in (b"", bytes(500)):
        with refused("field"):
            read(before + struct.pack("<I", length) + behind)


@pytest.mark.parametrize("content", ["[" * 100_000, '{"a":' * 100_000, "1" * 10_000, "nul", "\ud800", ""])
def test_json_is_refused_in_one_error(content: str) -> None:
    with refused("no JSON"):
        load_json(content, "x")
