"""Damage at random places of files of other recorders, read by the `mcap` library before: what it may cost at most."""

from __future__ import annotations

import io
import random
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import breakup_chunk
from mcap.writer import CompressionType, IndexType, Writer

from lie_rigid_body.recording.recovery import NothingWholeError, recover

RECORD = struct.Struct("<BQ")
NO_SUMMARY: dict[str, Any] = {
    "repeat_channels": False,
    "repeat_schemas": False,
    "use_statistics": False,
    "use_summary_offsets": False,
}
Found = set[tuple[str, int, bytes]]


class Original(NamedTuple):
    """A file, its messages, and those that each of its records may cost, by where it begins and ends."""

    content: bytes
    is_chunked: bool
    everything: Found
    costs: dict[tuple[int, int], Found]


def original(path: Path, rng: random.Random) -> Original:
    is_chunked, has_summary = rng.random() < 0.6, rng.random() < 0.6
    index = {} if has_summary else {**NO_SUMMARY, "index_types": rng.choice((IndexType.NONE, IndexType.MESSAGE))}
    compression, size = rng.choice([*CompressionType]), rng.choice((300, 600, 2000))
    with path.open("wb") as out:
        writer = Writer(out, size, compression, use_chunking=is_chunked, **index)
        writer.start("ros2", "another recorder")
        schemas = [
            writer.register_schema(f"std_msgs/msg/T{i}", "ros2msg", b"string data\n" + bytes([65 + i]) * 20)
            for i in range(3)
        ]
        channels = [writer.register_channel(f"/t{i}", "cdr", schema) for i, schema in enumerate(schemas)]
        for k in range(120):
            if rng.random() < 0.03:
                writer.add_attachment(k, k, f"name{k}", "text/plain", rng.randbytes(rng.randrange(300)))
            if rng.random() < 0.03:
                writer.add_metadata(f"m{k}", {"a": "b" * rng.randrange(50)})
            writer.add_message(channels[k % 3], 1000 * k, rng.randbytes(rng.randrange(4, 60)), 1000 * k, k)
        writer.finish()
    content = path.read_bytes()
    with path.open("rb") as file:
        listed = [(channel, message) for _, channel, message in NonSeekingReader(file).iter_messages()]
    topics = {channel.id: channel.topic for channel, _ in listed}
    everything = {(channel.topic, message.log_time, message.data) for channel, message in listed}
    costs, is_first = dict[tuple[int, int], Found](), True
    for opcode, begin, end in records(content):
        inside = content[begin + RECORD.size : end]
        number = int.from_bytes(inside[:2], "little")
        found: Found = set()
        if opcode == Opcode.CHUNK:
            chunk = breakup_chunk(Chunk.read(ReadDataStream(io.BytesIO(inside))))
            found = {(topics[m.channel_id], m.log_time, m.data) for m in chunk if isinstance(m, Message)}
            # the definitions are in the first
            found, is_first = everything if is_first and not has_summary else found, False
        elif opcode == Opcode.MESSAGE:
            found = {(topics[number], int.from_bytes(inside[6:14], "little"), inside[22:])}
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL) and not has_summary:
            found = {one for one in everything if one[0] == f"/t{number - 1}"}
        costs[begin, end] = found
    return Original(content, is_chunked, everything, costs)


def records(content: bytes) -> Iterator[tuple[int, int, int]]:
    begin = 8
    while begin < len(content) - 8:
        opcode, length = RECORD.unpack_from(content, begin)
        yield opcode, begin, begin + RECORD.size + length
        begin += RECORD.size + length


def harmed(content: bytes, rng: random.Random) -> tuple[bytes, int, int]:
    """A file with damage, and between which bytes of the one before."""
    at, size = rng.randrange(8, len(content) - 8), rng.choice((1, 1, 1, 2, 5, 16, 40))
    size = min(size, len(content) - 8 - at)
    harm = rng.choice(("flip", "delete", "insert", "zeros", "others"))
    if harm == "insert":
        return content[:at] + rng.randbytes(size) + content[at:], at, at
    if harm == "flip":
        return content[:at] + bytes([content[at] ^ 1 << rng.randrange(8)]) + content[at + 1 :], at, at + 1
    instead = {"delete": b"", "zeros": bytes(size), "others": rng.randbytes(size)}[harm]
    return content[:at] + instead + content[at + size :], at, at + size


@pytest.mark.parametrize("seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(4, 60))])
def test_damage_costs_the_messages_of_its_records_at_most(tmp_path: Path, seed: int) -> None:
    """And of a message that is in no chunk the next one."""
    rng = random.Random(seed)
    given, broken, fixed = original(tmp_path / "whole.mcap", rng), tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    for _ in range(40):
        content, first, last = harmed(given.content, rng)
        broken.write_bytes(content)
        costs = [found for (begin, end), found in given.costs.items() if begin < max(last, first + 1) and end > first]
        found: Found = set()
        try:
            recovery = recover(broken, fixed, overwrite=True)
        except NothingWholeError:
            is_told = True
        else:
            is_told = bool(recovery.damaged or recovery.broken_at or recovery.is_altered)
            with fixed.open("rb") as file:
                found = {(channel.topic, m.log_time, m.data) for _, channel, m in make_reader(file).iter_messages()}
        lost = given.everything - found - set().union(*costs)
        assert len(lost) <= (0 if given.is_chunked else 1), (first, last)
        assert is_told or not lost


def moved(content: bytes, rng: random.Random) -> bytes:
    """A file of which a disk has mixed up sectors."""
    size, (first, last) = rng.choice((64, 512, 1024)), sorted(rng.randrange(8, len(content) - 8) for _ in "12")
    between = content[first:last]
    match rng.choice(("lost and won", "won and lost", "twice", "swapped", "copied")):
        case "lost and won":
            return content[:first] + between[size:] + bytes(min(size, len(between))) + content[last:]
        case "won and lost":
            return content[:first] + rng.randbytes(min(size, len(between))) + between[:-size] + content[last:]
        case "twice":
            return content[: first + size] + content[first:]
        case "swapped" if last - first >= size:
            one, other = content[first : first + size], content[last : last + size]
            return content[:first] + other + between[size:] + one + content[last + size :]
    return content[:first] + content[last : last + size] + content[first + size :]


@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 60))])
def test_what_stands_whole_anywhere_is_recovered(tmp_path: Path, seed: int) -> None:
    """If the summary does too, which tells how each chunk begins."""
    rng = random.Random(seed)
    given, broken, fixed = original(tmp_path / "whole.mcap", rng), tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    summary = given.content[next(end for opcode, _, end in records(given.content) if opcode == Opcode.DATA_END) :]
    for _ in range(40 if given.is_chunked and len(summary) > 100 else 0):
        content = moved(given.content, rng)
        broken.write_bytes(content)
        there = [found for (begin, end), found in given.costs.items() if given.content[begin:end] in content]
        if not content.endswith(summary):
            continue
        recover(broken, fixed, overwrite=True)
        with fixed.open("rb") as file:
            found = {(channel.topic, m.log_time, m.data) for _, channel, m in make_reader(file).iter_messages()}
        assert set().union(*there) <= found
