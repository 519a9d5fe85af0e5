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
from bags import MakeBag
from mcap.records import Chunk
from refused_bags import refused

from foreign_bags import Message, bag_of
from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING
from lie_rigid_body.recording import bag_files
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.inflation import decompress
from lie_rigid_body.recording.mcap_contents import of_types
from lie_rigid_body.recording.records import DamageError
from lie_rigid_body.recording.segments import MAX_SEGMENTS, declared_segments
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


def test_messages_far_larger_than_their_file_are_not_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", 2**16)
    large = Message("/chatter", STRING, b"", 0, 0, bytes(2**20))
    (tmp_path / "x.mcap").write_bytes(bag_of([large] * 8))
    with refused("too much"):
        BagFiles(tmp_path / "x.mcap").contents(of_types([STRING]))


def test_each_file_of_a_bag_allows_for_its_own_messages(
    make_bag: MakeBag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "folder"
    path.mkdir()
    for i in range(3):
        make_bag(f"folder/folder_{i}.mcap", count=200)
    contents = BagFiles(path / "folder_0.mcap").contents(of_types([POSE_STAMPED]))
    [key] = [track.key for track in contents.tracks.values() if track.message_type == POSE_STAMPED]
    first = contents.messages(key)
    one = len(first.data) + 100 * len(first)
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", one)
    monkeypatch.setattr(bag_files, "_KEPT_PER_BYTE", 0)
    whole = BagFiles(path).contents(of_types([POSE_STAMPED])).messages(key)
    assert (len(whole), len(whole.data)) == (600, 3 * len(first.data))
    monkeypatch.setattr(bag_files, "_KEPT_AT_LEAST", one - 1)
    with refused("too much of one file", size=one):
        BagFiles(path).contents(of_types([POSE_STAMPED]))


def test_a_pipe_is_no_bag_nor_is_a_name_too_long(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.mcap")
    for given, error in (("x.mcap", "pipe"), (".", "pipe"), (300 * "a", "name too long")):
        with refused(error, name="x.mcap"):
            read_bag(tmp_path / given)


def test_many_resets_take_little_time(make_bag: MakeBag) -> None:
    """What takes most of it, a scenario, is made once; and there is a limit."""
    start = Segment(Scenario.from_parameters(), 0, 0)
    texts = [replace(start, first_sample=i, start_ns=i * 10_000_000).to_json() for i in range(3)]
    first, second, _ = (Segment.from_json(text) for text in texts)
    assert first.scenario is second.scenario
    assert (second.first_sample, second.start_ns) == (1, 10_000_000)
    recording = replace(read_bag(make_bag()), scenario_texts=[(i, str(i)) for i in range(MAX_SEGMENTS + 1)])
    with refused("segments", count=MAX_SEGMENTS + 1, most=MAX_SEGMENTS):
        declared_segments(text for _, text in recording.scenario_texts)
