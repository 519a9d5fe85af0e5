"""Chunks of any size are read in parts: the messages are those of small chunks."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag
from test_bag_reader import rewrite

from lie_rigid_body.messages.definitions import IMU
from lie_rigid_body.recording import topic_messages
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.mcap_contents import RawMessages
from lie_rigid_body.recording.topic_messages import topic_messages as decoded


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A bag of one chunk, with other messages between those of the body."""
    return rewrite(write_bag(tmp_path / "bag.mcap", count=400), tmp_path / "large.mcap", chunk_size=2**24)


def test_what_is_decoded_little_by_little_is_the_same(large: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = read_bag(large)
    monkeypatch.setattr(topic_messages, "_AT_ONCE", 7)
    for little in (read_bag(large), read_bag(large.parent / "bag.mcap")):
        np.testing.assert_array_equal(little.poses.stamps_ns, whole.poses.stamps_ns)
        np.testing.assert_array_equal(little.poses.values[:, 3:], whole.poses.values[:, 3:])
        np.testing.assert_array_equal(little.twists.values[:, 3:], whole.twists.values[:, 3:])
        assert little.poses.frame_ids == whole.poses.frame_ids


def test_decoding_takes_little_more_than_what_is_kept() -> None:
    payload = b"\0\1\0\0" + struct.pack("<iII4s37d", 1, 2, 4, b"imu\0", *range(37))
    count, size = 60_000, len(payload)
    raw = RawMessages(memoryview(payload * count), np.full(count, size), np.arange(count))
    tracemalloc.start()
    try:
        found = decoded(Path("bag"), ("/imu", IMU), [raw])
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert (len(found), found.kinds[0][0]) == (count, "imu")
    assert found.values[-1].tolist() == [0, 1, 2, 3, 13, 14, 15, 25, 26, 27]
    assert peak < size * count
