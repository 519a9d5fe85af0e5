"""Chunks that nothing holds but their own records, as they have no checksum: what damage costs there at most."""

from __future__ import annotations

import random
import struct
from pathlib import Path

import pytest
from mcap.reader import NonSeekingReader
from mcap.writer import CompressionType, Writer

from lie_rigid_body.recording.recovery import recover

RECORD = struct.Struct("<BQHIQQ")


def message_records(path: Path) -> list[bytes]:
    """The bytes of all messages in a file, by the `mcap` library."""
    with path.open("rb") as stream:
        found = [message for _, _, message in NonSeekingReader(stream).iter_messages(log_time_order=False)]
    return [
        RECORD.pack(5, 22 + len(one.data), one.channel_id, one.sequence, one.log_time, one.publish_time) + one.data
        for one in found
    ]


@pytest.mark.parametrize("change", [-500, -60, -9, -1, 1, 9, 60, 500])
def test_bytes_that_a_chunk_lost_or_won_cost_the_messages_there_and_the_one_before(tmp_path: Path, change: int) -> None:
    """The others stand whole in the file, in the chunk or behind its end, and none is altered."""
    broken, fixed, rng = tmp_path / "broken.mcap", tmp_path / "fixed.mcap", random.Random(change)
    with broken.open("wb") as out:
        writer = Writer(out, compression=CompressionType.NONE, enable_crcs=False)
        writer.start("ros2", "another recorder")
        channels = [writer.register_channel(f"/{name}", "cdr", 0) for name in "ab"]
        for k in range(60):
            writer.add_message(channels[k % 2], 10**9 + 1000 * k, rng.randbytes(50), 1000 * k, k)
        writer.finish()
    content, everything = broken.read_bytes(), message_records(broken)
    for _ in range(20):
        at = rng.randrange(content.index(everything[0]), content.index(everything[-1]))
        broken.write_bytes(content[:at] + rng.randbytes(max(0, change)) + content[at + max(0, -change) :])
        assert recover(broken, fixed, overwrite=True).damaged
        found = message_records(fixed)
        whole = [one for one in everything if one in broken.read_bytes()]
        assert len(whole) - 1 <= len(found) == len({*found} & {*whole})
