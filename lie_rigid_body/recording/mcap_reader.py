"""Reading an MCAP file: every record framed, every checksum compared, nothing guessed.

The `mcap` library's own reader takes the end of a file for the end of a record; a cut would go unnoticed there.
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.chunk import HEAD, MAGIC
from lie_rigid_body.recording.inflation import LARGEST_CHUNK, ZSTD_MAGIC, inflated_unverified, most_records
from lie_rigid_body.recording.inventory import Inventory, require_in_chunk
from lie_rigid_body.recording.mcap_contents import (
    FileSpan,
    Found,
    McapContents,
    Progress,
    RawMessages,
    RawTrack,
    TrackKey,
    Wanted,
    opened,
    state_of,
)
from lie_rigid_body.recording.mcap_part import McapPart, UnknownCompressionError
from lie_rigid_body.recording.message_table import (
    RECORD_HEAD,
    ContradictionError,
    ExcessError,
    MessageTable,
    parsed,
    require,
)
from lie_rigid_body.recording.output_file import reason, rescue
from lie_rigid_body.wording import counted

_MOST_LOOSE_BYTES: Final = 2**20
"""Number of bytes of messages outside of chunks that are taken together."""
_PARSERS: Final[dict[int, Callable[..., Any]]] = {
    Opcode.HEADER: Header.read,
    Opcode.FOOTER: Footer.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
    Opcode.SUMMARY_OFFSET: SummaryOffset.read,
}
_PROFILES: Final = ("ros2", "")
LARGEST_RECORD: Final = LARGEST_CHUNK + 2**16
"""Largest size of a record, bytes."""
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": "it is an SQLite bag: record with 'ros2 bag record -s mcap', or convert it",
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}


@dataclass(frozen=True)
class McapOutline:
    """Places of the messages in an MCAP file that was found whole.

    Parameters
    ----------
    path : Path
    state : tuple of int
        Which file it was, and what it would not be any more if it changed.
    parts : array of int
        Bytes where each part with messages begins and ends, by turns.
    channels : dict of TrackKey to list of int
    parts_of : dict of TrackKey to array of int
        Numbers of the parts that have messages of a track.
    """

    path: Path
    state: tuple[int, ...]
    parts: array[int]
    channels: dict[TrackKey, list[int]]
    parts_of: dict[TrackKey, array[int]]

    def read(self, keys: Collection[TrackKey], progress: Progress) -> Iterator[Found]:
        """Read the messages of some tracks, part by part; see `Outline.read`."""
        numbers = sorted({number for key in keys for number in self.parts_of.get(key, ())})
        channels = {key: self.channels[key] for key in keys if key in self.channels}
        with opened(self.path) as stream:
            try:
                self._require_same(stream)
                before = 0
                for number in numbers:
                    begin, end = self.parts[2 * number : 2 * number + 2]
                    stream.seek(begin)
                    table, _ = McapPart.of(stream.read(end - begin), inflated_unverified).messages(LARGEST_CHUNK)
                    yield _by_track(table, channels)
                    progress(end - before)
                    before = end
                self._require_same(stream)
            except OSError as error:
                raise _unreadable(self.path, error) from None
            except Exception as error:  # the libraries' parsers fail in many ways on changed bytes
                what = f"{self.path} changed while it was read: try again when nobody writes it"
                raise BagError(what) from error

    def _require_same(self, stream: BinaryIO) -> None:
        require(state_of(stream) == self.state, "it is another file")


def read_file(path: Path, contents: McapContents, wanted: Wanted) -> Iterator[tuple[int, Found]]:
    """Read a file, and count its messages.

    Parameters
    ----------
    path : Path
    contents : McapContents
        What it holds is added there.
    wanted : callable
        Which messages are given out. See `Wanted`.

    Yields
    ------
    position : int
        Bytes that were read.
    found : Found
        Messages that are wanted of the last part.

    Raises
    ------
    BagError
        If the file cannot be read, is no MCAP file, is cut off or damaged.
    """
    with opened(path) as stream:
        try:
            yield from _FileReader(path, stream, contents, wanted).read()
        except OSError as error:
            raise _unreadable(path, error) from None


def _unreadable(path: Path, error: OSError) -> BagError:
    return BagError(f"{path} cannot be read: {reason(error)}: copy it to a better place")


class _Named:
    """Context whose errors name the file and the byte where a record begins.

    It is no generator: one that raises another error than it was given keeps that, and its frames, in a circle.

    Parameters
    ----------
    path : Path
    position : int
    """

    def __init__(self, path: Path, position: int) -> None:
        self._path, self._position = path, position

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> None:
        if isinstance(error, Exception) and not isinstance(error, BagError | ModuleNotFoundError | OSError):
            raise BagError(f"{self._path} {self._what(error)}") from None

    def _what(self, error: Exception) -> str:
        """Words for an error; the library's parsers fail in many ways on damaged bytes."""
        if isinstance(error, UnknownCompressionError):
            return f"is compressed with {error}, which is unknown here: rewrite it with 'mcap compress'"
        if isinstance(error, ExcessError):
            return f"has at byte {self._position} {error}, more than is read: record it again"
        is_told = isinstance(error, ContradictionError)
        what = str(error) if is_told else ": ".join(filter(None, (type(error).__name__, str(error))))
        return f"is damaged at byte {self._position}: {what}: restore a copy, or record again"


class _FileReader:
    """One file, read from its start to its end."""

    def __init__(self, path: Path, stream: BinaryIO, contents: McapContents, wanted: Wanted) -> None:
        self._path, self._stream, self._contents, self._wanted = path, stream, contents, wanted
        self._size = stream.seek(0, 2)
        self._records_left = most_records(self._size)
        self._schemas: dict[int, Schema] = {0: Schema(data=b"", encoding="", id=0, name="")}
        self._channels: dict[int, TrackKey] = {}
        self._outline = McapOutline(path, state_of(stream), array("q"), {}, {})
        self._inventory = Inventory()
        self._part: list[bytes] = []  # heads and contents of its records, if one has begun
        self._part_begin = 0
        self._before = contents.message_count
        self._crc = 0  # of the data section, then of the summary
        self._data_crc = 0
        self._bare_chunks = 0
        self._position = 0

    def read(self) -> Iterator[tuple[int, Found]]:
        """Read all records; see `read_file`."""
        self._require_magic()
        opcode = 0
        while opcode != Opcode.FOOTER:
            opcode, head, content = self._record()
            if self._part and not self._goes_on(opcode):
                yield self._position, self._end_part()
            with self._named(self._position):
                self._verify_section(opcode, head, content)
                self._inventory.record(opcode, self._position, len(content))
                if opcode in (Opcode.CHUNK, Opcode.MESSAGE, Opcode.MESSAGE_INDEX):
                    self._add_to_part(opcode, head, content)
                else:
                    self._take(opcode, content)
            self._position += len(head) + len(content)
        if self._stream.read() != MAGIC:
            raise self._cut_off()

    def _require_magic(self) -> None:
        self._stream.seek(0)
        start = self._stream.read(16)
        if not start:
            raise BagError(f"{self._path} is empty: record it again, it holds nothing to rescue")
        if not start.startswith(MAGIC):
            hint = next((text for magic, text in _OTHER_FORMATS.items() if start.startswith(magic)), "")
            raise BagError(f"{self._path} is not an MCAP file: {hint or f'it begins with {start[:8]!r}: give a bag'}")
        self._position, self._crc = self._stream.seek(len(MAGIC)), zlib.crc32(MAGIC)

    def _record(self) -> tuple[int, bytes, bytes]:
        """Opcode, head and content of the next record."""
        head = self._stream.read(RECORD_HEAD.size)
        if len(head) < RECORD_HEAD.size:
            raise self._cut_off()
        opcode, length = RECORD_HEAD.unpack(head)
        too_long = length > self._size - self._position - RECORD_HEAD.size
        with self._named(self._position):
            require(not too_long or not self._ends_well(), "a record is longer than the file")
            if too_long or opcode == 0:
                raise self._cut_off()
            if length > LARGEST_RECORD:
                raise ExcessError(f"a record of {length} bytes")
        return opcode, head, self._stream.read(length)

    def _verify_section(self, opcode: int, head: bytes, content: bytes) -> None:
        if opcode == Opcode.DATA_END:
            self._compare(content, 0, "data section")
            self._data_crc = int.from_bytes(content[:4], "little")
            self._crc = 0
        elif opcode == Opcode.FOOTER:
            self._crc = zlib.crc32(content[:16], zlib.crc32(head, self._crc))
            self._compare(content, 16, "summary")
        else:
            self._crc = zlib.crc32(content, zlib.crc32(head, self._crc))

    def _compare(self, content: bytes, at: int, what: str) -> None:
        declared = int.from_bytes(content[at : at + 4], "little")
        require(declared in (0, self._crc), f"the checksum of its {what} is {self._crc:08x}, not {declared:08x}")

    def _take(self, opcode: int, content: bytes) -> None:
        """Take a record that is no part of one with messages; records of unknown kinds are left to others."""
        take: dict[int, Callable[[Any, int], object]] = {
            Opcode.HEADER: self._header,
            Opcode.FOOTER: self._footer,
            Opcode.SCHEMA: self._schema,
            Opcode.CHANNEL: self._channel,
            Opcode.METADATA: self._metadata,
            Opcode.ATTACHMENT: self._attachment,
        }
        if opcode in _PARSERS:
            take.get(opcode, self._inventory.summary)(parsed(_PARSERS[opcode], content), len(content))

    def _header(self, header: Header, length: int) -> None:
        require(header.profile in _PROFILES, f"its profile is {header.profile!r:.40}, that of a bag of ROS 2 is 'ros2'")
        self._contents.library = self._contents.library or header.library

    def _schema(self, schema: Schema, length: int) -> None:
        self._inventory.repeatable(schema)
        self._schemas[schema.id] = schema

    def _channel(self, channel: Channel, length: int) -> None:
        self._inventory.repeatable(channel)
        schema = self._schemas[channel.schema_id]
        key, definition = (channel.topic, schema.name), (schema.encoding, schema.data)
        track = self._contents.tracks.setdefault(key, RawTrack(*key, channel.message_encoding, definition))
        alike = (track.encoding, track.definition) == (channel.message_encoding, definition)
        require(alike, f"topic {channel.topic} has messages of two encodings or definitions")
        self._channels[channel.id] = key

    def _metadata(self, record: Metadata, length: int) -> None:
        self._inventory.metadata(record, self._position, length)
        self._contents.metadata[record.name] = record.metadata

    def _attachment(self, record: Attachment, length: int) -> None:
        self._inventory.attachment(record, self._position, length)
        self._contents.attachments += 1

    def _footer(self, footer: Footer, length: int) -> None:
        self._inventory.finish(footer, self._position)
        for number, key in self._channels.items():
            self._outline.channels.setdefault(key, []).append(number)
        self._contents.files.append(FileSpan(self._path.name, *self._inventory.span))
        self._contents.outlines.append(self._outline)
        if not self._data_crc:
            self._contents.without_checksum += self._bare_chunks or not self._inventory.chunk_count

    def _goes_on(self, opcode: int) -> bool:
        """Whether a record of some kind continues the present part."""
        if opcode == Opcode.MESSAGE:
            is_small = self._position - self._part_begin <= _MOST_LOOSE_BYTES
            return self._part[0][0] == Opcode.MESSAGE and is_small
        return opcode == Opcode.MESSAGE_INDEX and self._part[0][0] == Opcode.CHUNK

    def _add_to_part(self, opcode: int, *record: bytes) -> None:
        require(bool(self._part) or opcode != Opcode.MESSAGE_INDEX, "a message index follows no chunk")
        self._part_begin = self._part_begin if self._part else self._position
        self._part += record
        if self._position - self._part_begin > 2 * LARGEST_RECORD:
            raise ExcessError("message indexes of more bytes")

    def _end_part(self, *, is_whole: bool = True) -> Found:
        """Take the present part; return the messages of it that are wanted."""
        begin, raw, self._part = self._part_begin, b"".join(self._part), []
        with self._named(begin):
            part = McapPart.of(raw)
            table, others = part.messages(self._records_left if part.chunk else len(raw))
            for place in others:
                require_in_chunk(place.opcode)
                self._take(place.opcode, part.data[place.begin : place.end])
            if part.chunk is not None:
                self._records_left -= len(table.starts) + len(others)
                self._bare_chunks += not part.chunk.uncompressed_crc
                self._inventory.chunk(part.chunk, table, begin, part.size)
        for place in part.indexes:
            at = begin + place.begin - RECORD_HEAD.size
            with self._named(at):
                self._inventory.message_index(raw[place.begin : place.end], table, at)
        with self._named(begin):
            if part.indexes and is_whole:
                self._inventory.require_indexes(table)
            return self._count(table, begin, begin + len(raw))

    def _count(self, table: MessageTable, begin: int, end: int) -> Found:
        """Count the messages of a part that stands between two bytes; return those that are wanted."""
        table.require_times()
        self._inventory.messages(table)
        channels: dict[TrackKey, list[int]] = {}
        for channel, count in table.counts.items():
            require(
                channel in self._channels, f"it has a message of channel {channel}, which is not declared before it"
            )
            channels.setdefault(self._channels[channel], []).append(channel)
            self._contents.tracks[self._channels[channel]].count += count
        number = len(self._outline.parts) // 2
        self._outline.parts.extend((begin, end))
        otherwise = table.heads["channel"][table.heads["log_time"] != table.heads["publish_time"]]
        for key, own in channels.items():
            self._outline.parts_of.setdefault(key, array("q")).append(number)
            if len(otherwise):
                self._contents.tracks[key].published_otherwise += int(np.isin(otherwise, own).sum())
        return _by_track(table, {key: own for key, own in channels.items() if self._wanted(*key)})

    def _ends_well(self) -> bool:
        self._stream.seek(-len(MAGIC), 2)
        return self._stream.read() == MAGIC

    def _named(self, position: int) -> _Named:
        return _Named(self._path, position)

    def _cut_off(self) -> BagError:
        if self._part:
            self._end_part(is_whole=False)
        count = self._contents.message_count - self._before
        holds = f"it holds at least {counted(count, 'whole message')}" if count else "it may hold whole messages"
        return BagError(f"{self._path} was cut off, or is still being written: {holds}: rescue them with {rescue()}")


def _by_track(table: MessageTable, channels: Mapping[TrackKey, Sequence[int]]) -> Found:
    """Messages of some tracks, each of which has several channels where there were several publishers or recorders."""
    found, starts = Found(), table.starts + HEAD.itemsize
    for key, own in channels.items():
        is_own = np.full(2**16, fill_value=False)
        is_own[own] = True
        rows = np.flatnonzero(is_own[table.heads["channel"]])
        found[key] = RawMessages.of(table.data, starts[rows], table.ends[rows], table.log_times[rows])
    return found
