"""Reading an MCAP file into raw messages by topic: every record framed, every checksum compared, nothing guessed.

The `mcap` library's own reader takes the end of a file for the end of a record; a cut would go unnoticed there.
"""

from __future__ import annotations

import struct
import zlib
from array import array
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO, Final, TypeVar

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.chunk import HEAD, MAGIC
from lie_rigid_body.recording.inflation import COMPRESSIONS, LARGEST_CHUNK, ZSTD_MAGIC, inflated, most_records
from lie_rigid_body.recording.inventory import Inventory, require_in_chunk
from lie_rigid_body.recording.mcap_contents import (
    FileSpan,
    McapContents,
    Outline,
    RawMessages,
    RawTrack,
    Wanted,
    opened,
    state_of,
)
from lie_rigid_body.recording.message_loops import FIND
from lie_rigid_body.recording.message_scan import FoundMessages
from lie_rigid_body.recording.message_table import ContradictionError, MessageRuns, MessageTable, RecordContent
from lie_rigid_body.recording.output_file import reason, rescue
from lie_rigid_body.wording import counted

T = TypeVar("T")
_HEAD: Final = struct.Struct("<BQ")
_MOST_LOOSE_BYTES: Final = 2**20
"""Messages of a file without chunks are taken in pieces of this size."""
_SUMMARY: Final[dict[int, Callable[[ReadDataStream], object]]] = {
    Opcode.STATISTICS: Statistics.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
    Opcode.SUMMARY_OFFSET: SummaryOffset.read,
}
_PROFILES: Final = ("ros2", "")
LARGEST_RECORD: Final = LARGEST_CHUNK + 2**16
"""Largest size of a record, bytes."""
_COUNTED_AT_ONCE: Final = 10_000
"""Messages after which it is asked anew whether compiled code pays."""
_SMALL_SHARE: Final = 4
"""Messages that take less than this part of a chunk are copied out of it, so that the rest is not kept."""
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": "it is an SQLite bag: record with 'ros2 bag record -s mcap', or convert it",
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}


def read_file(path: Path, wanted: Wanted, into: McapContents) -> Iterator[int]:
    """Add a file's messages to the tracks, chunk by chunk.

    Parameters
    ----------
    path : Path
    wanted : callable
        Which messages are kept until they are taken. See `Wanted`.
    into : McapContents

    Yields
    ------
    int
        The bytes that were read, after each chunk.

    Raises
    ------
    BagError
        If the file cannot be read, is no MCAP file, is cut off or damaged.
    """
    with opened(path) as stream:
        try:
            yield from _FileReader(path, stream, wanted, into).read()
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: copy it to a better place") from None


class _FileReader:
    """One file, read from its start to its end."""

    def __init__(self, path: Path, stream: BinaryIO, wanted: Wanted, into: McapContents) -> None:
        self._path, self._stream, self._wanted, self._into = path, stream, wanted, into
        self._size = stream.seek(0, 2)
        into.allow(self._size)
        self._records, self._most_records = 0, most_records(self._size)
        self._schemas: dict[int, Schema] = {0: Schema(data=b"", encoding="", id=0, name="")}
        self._channels: dict[int, RawTrack] = {}
        self._chunks_of: dict[tuple[str, str], array[int]] = {}
        self._inventory = Inventory()
        self._loose = bytearray()
        self._loose_ends = [0]
        self._before = into.message_count
        self._taken = self._counted = 0
        self._crc = 0  # of the data section, then of the summary
        self._data_crc = 0
        self._bare_chunks = 0
        self._position = 0
        self._length = 0  # of the record there, without its head

    def read(self) -> Iterator[int]:
        self._require_magic()
        self._stream.seek(len(MAGIC))
        self._position = len(MAGIC)
        self._crc = zlib.crc32(MAGIC)
        count = 0
        while self._read_record() != Opcode.FOOTER:
            if self._taken > count:
                count = self._taken
                yield self._position
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

    def _read_record(self) -> int:
        head = self._stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise self._cut_off()
        opcode, length = _HEAD.unpack(head)
        too_long = length > self._size - self._position - _HEAD.size
        if too_long and self._ends_well():
            raise self._damaged("a record is longer than the file")
        if too_long or opcode == 0:
            raise self._cut_off()
        if length > LARGEST_RECORD:
            raise self._too_large(f"a record of {length} bytes")
        content, self._length = self._stream.read(length), length
        self._verify_section(opcode, head, content)
        try:
            self._inventory.record(opcode, self._position, length)
            if opcode == Opcode.MESSAGE:
                self._loose_message(head + content)
            else:
                self._end_loose_messages()
                self._take(opcode, content)
        except (BagError, ModuleNotFoundError):
            raise
        except ContradictionError as contradiction:
            raise self._damaged(str(contradiction)) from None
        except Exception as error:  # the library's parsers fail in many ways on damaged bytes
            raise self._damaged(f"{type(error).__name__}: {error}" if str(error) else type(error).__name__) from None
        self._position += _HEAD.size + length
        return int(opcode)

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
        if declared not in (0, self._crc):
            raise self._damaged(f"the checksum of its {what} is {self._crc:08x}, not {declared:08x}")

    def _take(self, opcode: int, content: bytes) -> None:
        if opcode == Opcode.CHUNK:
            self._chunk(_parse(Chunk.read, content), len(content))
        elif opcode == Opcode.MESSAGE_INDEX:
            self._inventory.message_index(content, self._position)
        elif opcode == Opcode.SCHEMA:
            schema = _parse(Schema.read, content)
            self._inventory.schema(schema)
            self._schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            self._channel(_parse(Channel.read, content))
        elif opcode == Opcode.HEADER:
            self._header(_parse(Header.read, content))
        elif opcode == Opcode.METADATA:
            record = _parse(Metadata.read, content)
            self._inventory.metadata(record, self._position, len(content))
            self._into.metadata[record.name] = record.metadata
        elif opcode == Opcode.ATTACHMENT:
            self._inventory.attachment(_parse(Attachment.read, content), self._position, len(content))
            self._into.attachments += 1
        elif opcode in _SUMMARY:
            self._inventory.summary(_parse(_SUMMARY[opcode], content))
        elif opcode == Opcode.FOOTER:
            self._inventory.finish(_parse(Footer.read, content), self._position)
            self._into.files.append(FileSpan(self._path.name, *self._inventory.span))
            self._into.outlines.append(self._outline())
            if not self._data_crc:
                self._into.without_checksum += self._bare_chunks or not self._inventory.chunk_count

    def _outline(self) -> Outline:
        channels: dict[tuple[str, str], list[int]] = {}
        for number, track in self._channels.items():
            channels.setdefault((track.topic, track.message_type), []).append(number)
        places, largest = self._inventory.chunk_places, self._inventory.largest_chunk
        return Outline(self._path, state_of(self._stream), places, channels, self._chunks_of, largest)

    def _header(self, header: Header) -> None:
        if header.profile not in _PROFILES:
            raise ContradictionError(f"its profile is {header.profile!r:.40}, that of a bag of ROS 2 is 'ros2'")
        self._into.library = self._into.library or header.library

    def _channel(self, channel: Channel) -> None:
        self._inventory.channel(channel)
        schema = self._schemas[channel.schema_id]
        key, definition = (channel.topic, schema.name), (schema.encoding, schema.data)
        track = self._into.tracks.setdefault(key, RawTrack(*key, channel.message_encoding, definition))
        if (track.encoding, track.definition) != (channel.message_encoding, definition):
            raise ContradictionError(f"topic {channel.topic} has messages of two encodings or definitions")
        self._channels[channel.id] = track

    def _chunk(self, chunk: Chunk, length: int) -> None:
        if chunk.compression not in COMPRESSIONS:
            raise BagError(
                f"{self._path} is compressed with {chunk.compression!r}, which is unknown here: "
                "rewrite it with 'mcap compress'"
            )
        if chunk.uncompressed_size > LARGEST_CHUNK:
            raise self._too_large(f"a chunk of {chunk.uncompressed_size} bytes")
        try:
            data, position = inflated(chunk), 0
        except ValueError as error:
            raise self._damaged(str(error)) from None
        size = len(data)
        runs = self._runs(data)
        parts: list[MessageTable] = []
        places = array("q")  # begin and end of messages that no run has
        while position < size:
            run = runs.at(position)
            if run is not None:
                parts += [*_table(data, places), run]
                position = int(run.ends[-1])
                self._count_records(len(run.starts))
                continue
            self._count_records(1)
            opcode, record_length = _HEAD.unpack_from(data, position)
            end = position + _HEAD.size + record_length
            if end > size:
                raise self._damaged("a record is longer than its chunk")
            if opcode == Opcode.MESSAGE:
                places.extend((position, end))
            else:
                require_in_chunk(opcode)
                self._take(opcode, data[position + _HEAD.size : end])
            position = end
        parts += _table(data, places)
        table = MessageTable.joined(data, parts)
        self._inventory.chunk(chunk, table, self._position, length)
        self._bare_chunks += not chunk.uncompressed_crc
        self._messages(table)

    def _count_records(self, count: int) -> None:
        """Count records in chunks: small ones that repeat are inflated to far more than their file."""
        self._records += count
        if self._records > self._most_records:
            raise self._too_large(f"{self._records} records in chunks, in a file of {self._size} bytes")

    def _runs(self, data: bytes) -> MessageRuns | FoundMessages:
        new = self._taken - self._counted
        find = FIND.compiled_for(new if new > _COUNTED_AT_ONCE else 0)
        self._counted += new if new > _COUNTED_AT_ONCE else 0
        return MessageRuns(data, self._indexed_offsets()) if find is None else FoundMessages(find, data)

    def _indexed_offsets(self) -> Integers:
        """Where the message indexes that follow say that messages begin: hints, that nothing depends on but speed."""
        self._stream.seek(self._position + _HEAD.size + self._length)
        found = [np.empty(0, dtype=np.int64)]
        while (head := self._stream.read(_HEAD.size))[:1] == bytes([Opcode.MESSAGE_INDEX]) and len(head) == _HEAD.size:
            _, length = _HEAD.unpack(head)
            content = self._stream.read(min(length, LARGEST_RECORD))
            found.append(np.frombuffer(content[6 : 6 + (len(content) - 6) // 16 * 16], dtype="<i8")[1::2])
        self._stream.seek(self._position + _HEAD.size + self._length)
        return np.concatenate(found)

    def _loose_message(self, record: bytes) -> None:
        """Take a message that stands in no chunk: together with its neighbours, as one alone takes long."""
        self._loose += record
        self._loose_ends.append(len(self._loose))
        if len(self._loose) > _MOST_LOOSE_BYTES:
            self._end_loose_messages()

    def _end_loose_messages(self) -> None:
        if self._loose:
            table = MessageTable.of(bytes(self._loose), np.array(self._loose_ends[:-1]), np.array(self._loose_ends[1:]))
            self._loose, self._loose_ends = bytearray(), [0]
            self._messages(table)

    def _messages(self, table: MessageTable) -> None:
        self._inventory.messages(table)
        self._taken += len(table.starts)
        otherwise = table.log_times != table.publish_times
        any_otherwise = bool(otherwise.any())
        for key, channels in self._by_track(table.counts).items():
            track = self._into.tracks[key]
            track.count += sum(table.counts[channel] for channel in channels)
            self._note_place(key)
            wanted = self._wanted(*key)
            if not any_otherwise and not wanted:
                continue
            own = np.flatnonzero(np.isin(table.channels, channels) if channels[1:] else table.channels == channels[0])
            log_times = table.log_times[own]
            track.published_otherwise += int(np.count_nonzero(otherwise[own]))
            if wanted:
                piece = _piece(table.data, table.starts[own] + HEAD.itemsize, table.ends[own], log_times)
                track.pieces.append(piece)
                self._keep(len(piece.data), len(own))

    def _by_track(self, channels: Iterable[int]) -> dict[tuple[str, str], list[int]]:
        """The channels of each track: several, where several publishers or recorders had one each on a topic."""
        found: dict[tuple[str, str], list[int]] = {}
        for channel in channels:
            if channel not in self._channels:
                raise ContradictionError(f"it has a message of channel {channel}, which is not declared before it")
            track = self._channels[channel]
            found.setdefault((track.topic, track.message_type), []).append(channel)
        return found

    def _note_place(self, key: tuple[str, str]) -> None:
        """Note that the present chunk has messages of a topic."""
        places = self._chunks_of.setdefault(key, array("q"))
        if not places or places[-1] != self._position:
            places.append(self._position)

    def _keep(self, size: int, messages: int) -> None:
        if self._into.keep(size, messages):
            raise self._too_large(f"messages of {self._into.kept} bytes in a file of {self._size}")

    def _ends_well(self) -> bool:
        self._stream.seek(-len(MAGIC), 2)
        return self._stream.read() == MAGIC

    def _cut_off(self) -> BagError:
        count = self._into.message_count - self._before + len(self._loose_ends) - 1
        holds = f"it holds at least {counted(count, 'whole message')}" if count else "it may hold whole messages"
        return BagError(f"{self._path} was cut off, or is still being written: {holds}: rescue them with {rescue()}")

    def _too_large(self, what: str) -> BagError:
        return BagError(f"{self._path} has at byte {self._position} {what}, more than is read: record it again")

    def _damaged(self, what: str) -> BagError:
        return BagError(f"{self._path} is damaged at byte {self._position}: {what}: restore a copy, or record again")


def _table(data: bytes, places: array[int]) -> list[MessageTable]:
    """The table of messages that stand between some places, which are then forgotten; none if there are none."""
    bounds = np.array(places, dtype=np.int64).reshape(-1, 2)
    del places[:]
    return [MessageTable.of(data, bounds[:, 0], bounds[:, 1])] if len(bounds) else []


def _piece(data: bytes, starts: Integers, ends: Integers, log_times_ns: Integers) -> RawMessages:
    """Messages of a chunk, without the rest of it if that is much more."""
    sizes = ends - starts
    if _SMALL_SHARE * int(sizes.sum()) >= len(data):
        return RawMessages(data, starts, ends, log_times_ns)
    own = b"".join([data[start:end] for start, end in zip(starts.tolist(), ends.tolist(), strict=True)])
    behind = np.cumsum(sizes)
    return RawMessages(own, behind - sizes, behind, log_times_ns)


def _parse(read: Callable[[ReadDataStream], T], content: bytes) -> T:
    return read(ReadDataStream(RecordContent(content)))
