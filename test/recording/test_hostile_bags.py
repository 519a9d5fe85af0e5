"""Bags made to take memory or time: refused before they get either."""

from __future__ import annotations

import os
import struct
from dataclasses import replace
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from mcap.records import Chunk
from refused_bags import refused

from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.inflation import decompress
from lie_rigid_body.recording.records import DamageError
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation.segment import Segment

PACK = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}
SKIPPABLE = struct.pack("<II", 0x184D2A50, 4) + b"abcd"
"""A frame that decompressors leave out."""


@pytest.mark.parametrize("size", [0, 1, 1000, 131_072, 131_073, 500_000])
def test_frames_of_every_kind_are_read(size: int) -> None:
    """One or several, with padding, of blocks compressed, as they are, or runs of one byte; with and without sizes."""
    for data in (np.random.default_rng(1).bytes(size), bytes(size), (b"some text " * size)[:size]):
        frames = [
            ("zstd", zstandard.ZstdCompressor(write_content_size=known, write_checksum=summed).compress(data))
            for known in (True, False)
            for summed in (True, False)
        ]
        for compression, pack in PACK.items():
            several = pack(data[: size // 3]) + pack(data[size // 3 :])
            behind = [pack(data) + padding for padding in (bytes(16), b"garbage", SKIPPABLE)]
            frames += [(compression, frame) for frame in (pack(data), several, SKIPPABLE + pack(data), *behind)]
        for compression, frame in frames:
            assert decompress(Chunk(compression, frame, 0, 0, 0, size)) == data


@pytest.mark.parametrize("compression", ["", *PACK])
@pytest.mark.parametrize("size", [0, 999, 1001, 10_000])
def test_what_does_not_have_its_size_or_its_checksum_is_damage(compression: str, size: int) -> None:
    data = PACK.get(compression, bytes)(bytes(range(250)) * 4)
    if size > 1000 or not compression:
        with pytest.raises(DamageError):
            decompress(Chunk(compression, data, 0, 0, 0, size))
    with pytest.raises(DamageError):
        decompress(Chunk(compression, data, 0, 0, 1, min(size, 1000)))


def test_a_pipe_is_no_bag_nor_is_a_name_too_long(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.mcap")
    for given, error in (("x.mcap", "pipe"), (".", "pipe"), (300 * "a", "name too long")):
        with refused(error, name="x.mcap"):
            read_bag(tmp_path / given)


def test_many_resets_take_little_time() -> None:
    """What takes most of it, a scenario, is made once."""
    start = Segment(Scenario.from_parameters(), 0, 0)
    texts = [replace(start, first_sample=i, start_ns=i * 10_000_000).to_json() for i in range(3)]
    first, second, _ = (Segment.from_json(text) for text in texts)
    assert first.scenario is second.scenario
    assert (second.first_sample, second.start_ns) == (1, 10_000_000)
