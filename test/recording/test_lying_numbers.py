"""Each number of the statistics, the indexes and the footer of a bag that lies alone is found, without any checksum."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

from lie_rigid_body import BagError, simulate
from lie_rigid_body.recording.bag_reader import read_bag

FOOTER, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = (
    2, 6, 7, 8, 11, 13, 14, 15,
)  # fmt: skip
FIXED = {
    FOOTER: "QQ",
    CHUNK: "QQQ",
    MESSAGE_INDEX: "HI",
    CHUNK_INDEX: "QQQQI",
    STATISTICS: "QHIIIIQQI",
    METADATA_INDEX: "QQ",
    SUMMARY_OFFSET: "BQQ",
}
"""Numbers at the begin of a record, of which the last of some is the length of a map or an array behind them."""
ENTRIES = {MESSAGE_INDEX: "QQ", CHUNK_INDEX: "HQ", STATISTICS: "HQ"}
"""Numbers of an entry of that map or array."""
CHECKSUMS = {FOOTER: 16, CHUNK: 24, DATA_END: 0}
"""Place of a checksum in a record; 0 says that there is none."""


def records(content: bytes) -> Iterator[tuple[int, int]]:
    """Opcode of each record, and the place of its content."""
    at = 8
    while at < len(content) - 8:
        opcode, length = struct.unpack_from("<BQ", content, at)
        yield opcode, at + 9
        at += 9 + length


def numbers(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, place and size of every number."""
    for opcode, at in records(content):
        if opcode == SUMMARY_OFFSET and not any(content[at + 9 : at + 17]):
            continue  # of a group that has no record
        end = at
        for kind in FIXED.get(opcode, ""):
            yield opcode, end, struct.calcsize(kind)
            end += struct.calcsize(kind)
        if opcode in ENTRIES:
            sizes = [struct.calcsize(kind) for kind in ENTRIES[opcode]]
            [length] = struct.unpack_from("<I", content, end - 4)
            last = end + length
            while end < last:
                for size in sizes:
                    yield opcode, end, size
                    end += size
            if opcode == CHUNK_INDEX:
                [name] = struct.unpack_from("<I", content, end + 8)
                yield from ((opcode, end, 8), (opcode, end + 8, 4), (opcode, end + 12 + name, 8))
                yield opcode, end + 20 + name, 8


def test_each_number_that_lies_is_found(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    simulate(duration=0.2, motion="closed_form", rate=20.0, imu_rate=10.0).to_bag(path)
    whole = bytearray(path.read_bytes())
    for opcode, at in records(bytes(whole)):
        if opcode in CHECKSUMS:
            whole[at + CHECKSUMS[opcode] : at + CHECKSUMS[opcode] + 4] = bytes(4)
    path.write_bytes(whole)
    read_bag(path)
    tried = set()
    for opcode, at, size in numbers(bytes(whole)):
        tried.add(opcode)
        honest = int.from_bytes(whole[at : at + size], "little")
        for lie in {0, honest + 1, honest - 1, honest ^ 0x40, 2 ** (8 * size) - 1} - {honest, -1, 2 ** (8 * size)}:
            content = bytearray(whole)
            content[at : at + size] = lie.to_bytes(size, "little")
            path.write_bytes(content)
            with pytest.raises(BagError):
                pytest.fail(f"record {opcode}, {honest} at byte {at} as {lie}: {read_bag(path)!r:.40}")
    assert tried == {*FIXED}
