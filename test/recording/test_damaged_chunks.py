"""Chunks that nothing holds but their own records, as they have no checksum: what damage costs there at most."""

from __future__ import annotations

import random
import struct
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import CompressionType, IndexType, Writer

from lie_rigid_body.recording.recovery import recover
from sampled import sampled

RECORD = struct.Struct("<BQHIQQ")


def message_records(path: Path) -> list[bytes]:
    """The bytes of all messages in a file, by the `mcap` library."""
    with path.open("rb") as stream:
        found = [message for _, _, message in NonSeekingReader(stream).iter_messages(log_time_order=False)]
    return [
        RECORD.pack(5, 22 + len(one.data), one.channel_id, one.sequence, one.log_time, one.publish_time) + one.data
        for one in found
    ]


def written(path: Path, rng: random.Random, *, chunk_size: int, is_bare: bool) -> None:
    """Write 60 messages of one size, topic by topic, so that the times of chunks overlap."""
    bare: dict[str, Any] = (
        {"index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False} if is_bare else {}
    )
    with path.open("wb") as out:
        writer = Writer(
            out,
            chunk_size,
            CompressionType.NONE,
            enable_crcs=False,
            use_statistics=not is_bare,
            use_summary_offsets=not is_bare,
            **bare,
        )
        writer.start("ros2", "another recorder")
        for name in "ab":
            channel = writer.register_channel(f"/{name}", "cdr", 0)
            for k in range(30):
                writer.add_message(channel, 10**9 + 1000 * k, rng.randbytes(97), 1000 * k, k)
        writer.finish()


@pytest.mark.parametrize("end", ["whole", "bare", "cut"])
@pytest.mark.parametrize("chunk_size", [1500, 10**6])
@pytest.mark.parametrize("change", sampled([-100, -60, -9, -1, 1, 9, 60, 256, 500], every=3))
def test_bytes_that_a_chunk_lost_or_won_cost_the_messages_there_and_the_one_before(
    tmp_path: Path, change: int, chunk_size: int, end: str
) -> None:
    """The others stand whole in the file, in the chunk or behind its end; none is altered, or taken twice.

    What is won does not end as a message does, and is as long as some, so that one of them begins where the chunk ends.
    """
    broken, fixed, rng = tmp_path / "broken.mcap", tmp_path / "fixed.mcap", random.Random(change)
    written(broken, rng, chunk_size=chunk_size, is_bare=end != "whole")
    content, everything = broken.read_bytes(), message_records(broken)
    content = content[: content.index(everything[-1]) + 128] if end == "cut" else content
    assert {*map(len, everything)} == {128}
    for number in range(20):
        damaged = everything[-1 if number % 4 == 0 else rng.randrange(3, 60)]
        at = content.index(damaged) + rng.randrange(1, 128 - max(0, -change))
        broken.write_bytes(content[:at] + rng.randbytes(max(0, change)) + content[at + max(0, -change) :])
        recovery = recover(broken, fixed, overwrite=True)
        assert recovery.damaged or recovery.broken_at
        found, whole = message_records(fixed), {*everything} - {damaged}
        assert len(whole) - 1 <= len(found) == len({*found} & whole)


@pytest.mark.parametrize("is_bare", [False, True])
@pytest.mark.parametrize("place", ["amid the chunk", "behind the chunk"])
def test_a_sector_that_is_written_twice_costs_nothing(tmp_path: Path, place: str, is_bare: bool) -> None:
    """Of records that end where sectors do the chunk may add up, and be followed by what was in it."""
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    written(broken, random.Random(0), chunk_size=1500, is_bare=is_bare)
    content, everything = broken.read_bytes(), message_records(broken)
    at = content.index(everything[20])  # the last of its chunk is the one of number 23
    if place == "behind the chunk":
        at = content.index(everything[23]) + 128
    broken.write_bytes(content[:at] + content[at - 512 : at] + content[at:])
    assert recover(broken, fixed, overwrite=True).damaged
    found = message_records(fixed)
    assert {*found} == {*everything}


def test_a_chunk_that_was_displaced_into_an_attachment_is_found(tmp_path: Path) -> None:
    """As the summary tells how it begins."""
    broken, fixed, rng = tmp_path / "broken.mcap", tmp_path / "fixed.mcap", random.Random(0)
    with broken.open("wb") as out:
        writer = Writer(out, 500)
        writer.start("ros2", "another recorder")
        channel = writer.register_channel("/a", "cdr", 0)
        for k in range(40):
            writer.add_message(channel, 1000 * k, rng.randbytes(97), 1000 * k, k)
        writer.add_attachment(1, 2, "notes", "text/plain", rng.randbytes(4000))
        writer.finish()
    content, everything = broken.read_bytes(), message_records(broken)
    with broken.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    index = summary.chunk_indexes[3]
    first, last = index.chunk_start_offset, index.chunk_start_offset + index.chunk_length
    at = content.index(b"text/plain") + 1000
    chunk, notes = content[first:last], content[at : at + last - first]
    broken.write_bytes(content[:first] + notes + content[last:at] + chunk + content[at + last - first :])
    recover(broken, fixed, overwrite=True)
    assert sorted(message_records(fixed)) == sorted(everything)


@pytest.mark.parametrize("harm", ["length", "lost", "won"])
def test_messages_of_a_bag_that_a_message_holds_are_none_of_the_file(tmp_path: Path, harm: str) -> None:
    """Its times and channels are those of the chunk in which the message is, which is damaged."""
    inner, broken, fixed, rng = *(tmp_path / name for name in ("inner", "broken", "fixed")), random.Random(0)
    written(inner, rng, chunk_size=10**6, is_bare=False)
    with broken.open("wb") as out:
        writer = Writer(out, compression=CompressionType.NONE, enable_crcs=False)
        writer.start("ros2", "another recorder")
        channel = writer.register_channel("/bags", "cdr", 0)
        for k in range(60):
            data = inner.read_bytes() if k == 30 else rng.randbytes(50)
            writer.add_message(channel, 10**9 + 500 * k, data, 0, k)
        writer.finish()
    content, everything = broken.read_bytes(), message_records(broken)
    at = content.index(everything[30]) + (5 if harm == "length" else 28)
    instead = {"length": b"\xff", "lost": b"", "won": b"\xff\xff"}[harm]
    broken.write_bytes(content[:at] + instead + content[at + 1 :])
    recover(broken, fixed, overwrite=True)
    assert {*everything} - {*everything[29:31]} <= {*message_records(fixed)} <= {*everything}
