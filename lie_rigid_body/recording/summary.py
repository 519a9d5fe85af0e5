"""What the summary of an MCAP file says that the file holds, before anything of it is verified."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import Final

from mcap.records import Channel, ChunkIndex, Schema

from lie_rigid_body.recording.inflation import LARGEST_CHUNK
from lie_rigid_body.recording.mcap_contents import McapContents, Outline, RawTrack
from lie_rigid_body.recording.mcap_reader import opened, state_of

_NO_SCHEMA: Final = Schema(data=b"", encoding="", id=0, name="")


def add_foreseen(path: Path, into: McapContents) -> None:
    """Add the tracks, the metadata and the outline that a file's summary tells of.

    It may fail in any way where the summary is damaged, or leaves something out: then the file has to be read.
    """
    from mcap.reader import SeekingReader  # slow to import: not for a bag that is short

    with opened(path) as stream:
        reader = SeekingReader(stream, record_size_limit=LARGEST_CHUNK)
        summary, state = reader.get_summary(), state_of(stream)
        assert summary is not None
        assert summary.statistics is not None
        into.library = into.library or reader.get_header().library
        into.metadata |= {record.name: record.metadata for record in reader.iter_metadata()}
    tracks: dict[int, RawTrack] = {}
    channels: dict[tuple[str, str], list[int]] = {}
    for channel in summary.channels.values():
        track = _track(channel, summary.schemas.get(channel.schema_id, _NO_SCHEMA), into)
        tracks[channel.id] = track
        track.count += summary.statistics.channel_message_counts.get(channel.id, 0)
        channels.setdefault((track.topic, track.message_type), []).append(channel.id)
    into.outlines.append(_outline(path, state, summary.chunk_indexes, tracks, channels))


def _track(channel: Channel, schema: Schema, into: McapContents) -> RawTrack:
    key = channel.topic, schema.name
    new = RawTrack(*key, channel.message_encoding, (schema.encoding, schema.data))
    return into.tracks.setdefault(key, new)


def _outline(
    path: Path,
    state: tuple[int, ...],
    indexes: list[ChunkIndex],
    tracks: dict[int, RawTrack],
    channels: dict[tuple[str, str], list[int]],
) -> Outline:
    indexes = sorted(indexes, key=lambda index: index.chunk_start_offset)
    chunks_of: dict[tuple[str, str], array[int]] = {}
    for index in indexes:
        for key in dict.fromkeys((tracks[i].topic, tracks[i].message_type) for i in index.message_index_offsets):
            chunks_of.setdefault(key, array("q")).append(index.chunk_start_offset)
    largest = max(index.uncompressed_size for index in indexes)
    return Outline(path, state, array("q", (i.chunk_start_offset for i in indexes)), channels, chunks_of, largest)
