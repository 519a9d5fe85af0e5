"""Small files that would take all memory or time: each verb refuses them in a line, within bounds that are measured."""

from __future__ import annotations

import json
import os
import resource
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard
from bags import rewrite, write_bag
from forged import chunk, framed
from lz4.frame import BLOCKSIZE_MAX4MB, LZ4FrameCompressor
from mcap.writer import MCAP0_MAGIC as MAGIC

from foreign_bags import record, text
from lie_rigid_body.messages import encode_string
from lie_rigid_body.system import console
from lie_rigid_body.system.bounded_input import MAX_CHUNK_BYTES

GIB = 2**30
MIB = 2**20
MEMORY = 4 * MAX_CHUNK_BYTES
"""What a verb may take: its libraries, the largest chunk twice, and the places of 8 million messages in it."""
SECONDS = 120
"""Time on a processor after which a verb is taken to hang."""
RUN = """
import sys
from lie_rigid_body.__main__ import main
verb, out, *paths = sys.argv[1:]
for path in paths:
    print("status", main([verb, path, *(["-o", out, "--force"] if out else [])]))
    print("\\0", file=sys.stderr)
"""
SCHEMA = record(3, struct.pack("<H", 1) + text("std_msgs/msg/String") + text("ros2msg") + text("string data"))
CHANNEL = record(4, struct.pack("<HH", 1, 1) + text("/x") + text("cdr") + struct.pack("<I", 0))
NO_NUMBERS = struct.pack("<HIQQ", 1, 0, 0, 0)
"""Beginning of a message: channel, number and times."""


def zstd_zeros(size: int) -> bytes:
    """A frame of blocks that repeat a byte, 4 bytes for 128 kB: https://datatracker.ietf.org/doc/html/rfc8878."""
    block = 2**17
    header = b"\x28\xb5\x2f\xfd" + b"\xc0\x38" + struct.pack("<Q", size)
    blocks = b"".join(
        (block << 3 | 1 << 1 | (at + block >= size)).to_bytes(3, "little") + b"\0" for at in range(0, size, block)
    )
    return header + blocks


def lz4_zeros(size: int) -> bytes:
    """A frame of equal blocks of 4 MiB."""
    compressor = LZ4FrameCompressor(block_size=BLOCKSIZE_MAX4MB, block_linked=False)
    begin, block = compressor.begin(), compressor.compress(bytes(4 * MIB))
    return begin + block * (size // (4 * MIB)) + compressor.flush()


def full_of(one: bytes) -> bytes:
    """A chunk, of the largest size, with a schema, a channel, and the same record over and over."""
    data = SCHEMA + CHANNEL + one * ((MAX_CHUNK_BYTES - 1000) // len(one))
    return chunk("zstd", len(data), zstandard.ZstdCompressor(level=1).compress(data))


def sparse(folder: Path) -> Path:
    """A file that takes no room on the disk."""
    path = folder / "sparse.mcap"
    path.write_bytes(MAGIC + struct.pack("<BQ", 5, 2**35))
    with path.open("r+b") as stream:
        stream.truncate(2**36)
        stream.seek(0, os.SEEK_END)
        stream.write(MAGIC)
    return path


def with_scenario(folder: Path, change: Callable[[str], str]) -> bytes:
    """A bag of a few samples with another scenario message."""
    path = folder / "whole"
    if not path.exists():
        write_bag(path, count=5)

    def altered(number: int, topic: str, data: bytes) -> bytes:
        return encode_string(change(data[8:-1].decode())) if topic.endswith("/scenario") else data

    return rewrite(path, folder / "altered", change=altered).read_bytes()


BOMBS: dict[str, Callable[[Path], bytes | Path]] = {
    "zstd of 3 GiB": lambda d: framed(chunk("zstd", 3 * GIB, zstd_zeros(3 * GIB))),
    "a record of 32 GiB in a sparse file": sparse,
    "zstd of 3 GiB that claims less": lambda d: framed(chunk("zstd", MAX_CHUNK_BYTES, zstd_zeros(3 * GIB))),
    "lz4 of 1 GiB that claims less": lambda d: framed(chunk("lz4", MAX_CHUNK_BYTES, lz4_zeros(GIB))),
    "a message that is large": lambda d: framed(full_of(record(5, NO_NUMBERS + bytes(MAX_CHUNK_BYTES - 1000)))),
    "messages without end": lambda d: framed(full_of(record(5, NO_NUMBERS))),
    "channels without end": lambda d: framed(full_of(CHANNEL)),
    "a deep JSON": lambda d: with_scenario(d, lambda text: "[" * 60_000),
    "an IMU at 1e308 Hz": lambda d: with_scenario(d, lambda text: json.dumps({**json.loads(text), "imu_rate": 1e308})),
}


def made(folder: Path) -> list[Path]:
    """All of them as files."""
    for name, make in BOMBS.items():
        content, path = make(folder), folder / f"{name}.mcap"
        if isinstance(content, Path):
            content.rename(path)
        else:
            path.write_bytes(content)
        assert 512 * path.stat().st_blocks < 20 * MIB
    return sorted(folder.glob("*.mcap"))


@pytest.mark.slow
@pytest.mark.parametrize("verb", ["check", "recover"])
def test_none_takes_more_than_the_bound(
    tmp_path: Path, verb: str, record_property: Callable[[str, object], None]
) -> None:
    paths = made(tmp_path)
    out = "" if verb == "check" else str(tmp_path / "out")
    with subprocess.Popen(
        [sys.executable, "-c", RUN, verb, out, *map(str, paths)],
        stdout=-1,
        stderr=(tmp_path / "complaints").open("w"),
        text=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS)),
    ) as process:
        assert process.stdout is not None
        statuses = [int(line.split()[1]) for line in process.stdout if line.startswith("status ")]
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    complaints = (tmp_path / "complaints").read_text().split("\0\n")[:-1]
    record_property("files", len(paths))
    record_property("largest memory, MiB", used.ru_maxrss // 1024)
    record_property("s on the processor", round(used.ru_utime + used.ru_stime, 1))
    assert process.returncode == 0
    assert len(statuses) == len(complaints) == len(paths)
    assert {*statuses} == {"check": {1, 2}, "recover": {0, 2}}[verb]
    failures = (console.DEBUG, console.explanation(MemoryError()))
    assert [said for said in complaints if said.count("\n") > 1 or any(each in said for each in failures)] == []
    assert used.ru_maxrss * 1024 < MEMORY
