"""Writing an MCAP file chunk by chunk: its header, indexes, checksums, statistics and summary."""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, BinaryIO, Final

import zstandard
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lie_rigid_body.recording.chunk import MAGIC, OPCODE_AND_LENGTH, RawChunk, Rows, record_bytes
from lie_rigid_body.recording.indexes import attachment_index, chunk_index

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_MESSAGE_INDEX: Final = struct.Struct("<BQHI")
_LENGTH: Final = struct.Struct("<Q")
_FOOTER: Final = struct.Struct("<BQQQ")


ZSTD_LEVEL: Final = -1
"""Level of zstd; level 3 of the `mcap` library's writer takes nearly twice as long, and makes a bag 3 % smaller."""


Compress = Callable[[Any], bytes]


def compressor(compression: str) -> Compress:
    """A function that compresses chunks, for one thread.

    Parameters
    ----------
    compression : str
        ``zstd``, ``lz4``, or nothing, as MCAP names them.
    """
    if compression == "zstd":
        return zstandard.ZstdCompressor(ZSTD_LEVEL).compress
    if compression == "lz4":
        from lz4.frame import compress

        function: Compress = compress
        return function
    return bytes


def compressed(raw: RawChunk, compression: str, compress: Compress) -> Chunk:
    """A chunk as it is written.

    Parameters
    ----------
    raw : RawChunk
    compression : str
    compress : callable
        The `compressor` of that name.
    """
    first_ns, last_ns = raw.log_times_ns()
    return Chunk(
        compression=compression,
        data=compress(raw.data),
        message_start_time=first_ns,
        message_end_time=last_ns,
        uncompressed_crc=zlib.crc32(raw.data),
        uncompressed_size=len(raw.data),
    )


def _head_of(chunk: Chunk) -> bytes:
    """The record of a chunk up to its data, which are not copied."""
    head = bytearray(record_bytes(replace(chunk, data=b"")))
    size = len(chunk.data)
    _LENGTH.pack_into(head, 1, len(head) - OPCODE_AND_LENGTH + size)
    _LENGTH.pack_into(head, len(head) - _LENGTH.size, size)
    return bytes(head)


class McapFile:
    """An MCAP file that grows by chunks.

    Its schemas and channels may be records in chunks: whoever makes those adds them to the attributes.

    Parameters
    ----------
    stream : binary file
    header : Header

    Attributes
    ----------
    schemas : dict of int to Schema
    channels : dict of int to Channel
        For the summary.
    message_count : int
    """

    def __init__(self, stream: BinaryIO, header: Header) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self._stream = stream
        self._position = 0
        self._crc = 0
        self._times: tuple[int, int] | None = None
        self._counts: dict[int, int] = defaultdict(int)
        # as bytes: those of a day's chunks take a few megabytes
        self._indexes = {kind: bytearray() for kind in (ChunkIndex, AttachmentIndex, MetadataIndex)}
        self._index_counts = dict.fromkeys(self._indexes, 0)
        self._write(MAGIC)
        self._write(record_bytes(header))

    @property
    def message_count(self) -> int:
        """Number of messages that were written."""
        return sum(self._counts.values())

    @property
    def log_times_ns(self) -> tuple[int, int] | None:
        """The earliest and the latest log time, ns; None without messages."""
        return self._times

    def _write(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._stream.write(data)
        self._position += len(data)

    def add_chunk(self, chunk: Chunk, messages: Mapping[int, Rows]) -> None:
        """Write a chunk and the indexes of its messages.

        Parameters
        ----------
        chunk : Chunk
        messages : mapping of int to ndarray
            See `RawChunk.indexes`.
        """
        head = _head_of(chunk)
        start, length = self._position, len(head) + len(chunk.data)
        offsets, end = dict[int, int](), start + length
        parts: list[ReadableBuffer] = [head, chunk.data]
        for channel, entries in messages.items():
            offsets[channel] = end
            self._counts[channel] += len(entries)
            size = entries.nbytes
            parts += _MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size), entries
            end += _MESSAGE_INDEX.size + size
        self._write(b"".join(parts))
        self._note_times(chunk)
        self._note(chunk_index(chunk, start, length, offsets, end - start - length))

    def _note_times(self, chunk: Chunk) -> None:
        first, last = self._times or (chunk.message_start_time, chunk.message_end_time)
        self._times = min(first, chunk.message_start_time), max(last, chunk.message_end_time)

    def _note(self, index: ChunkIndex | AttachmentIndex | MetadataIndex) -> None:
        self._indexes[type(index)] += record_bytes(index)
        self._index_counts[type(index)] += 1

    def add(self, record: Schema | Channel | Metadata | Attachment) -> None:
        """Write a record outside of chunks."""
        data = record_bytes(record)
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Metadata):
            self._note(MetadataIndex(offset=self._position, length=len(data), name=record.name))
        else:
            self._note(attachment_index(record, self._position, len(data)))
        self._write(data)

    def finish(self) -> None:
        """Write the summary. The stream stays open."""
        self._write(record_bytes(DataEnd(self._crc)))
        start, groups, offsets = self._position, bytearray(), b""
        for opcode, group in self._groups():
            offsets += record_bytes(SummaryOffset(opcode, start + len(groups), len(group)))
            groups += group
        end = start + len(groups)
        summary = bytes(groups) + offsets
        crc = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, start, end), zlib.crc32(summary))
        self._write(summary + record_bytes(Footer(start, end, crc)) + MAGIC)

    def _groups(self) -> Iterable[tuple[Opcode, bytes | bytearray]]:
        yield Opcode.SCHEMA, record_bytes(*self.schemas.values())
        yield Opcode.CHANNEL, record_bytes(*self.channels.values())
        yield Opcode.STATISTICS, record_bytes(self._statistics())
        yield Opcode.CHUNK_INDEX, self._indexes[ChunkIndex]
        yield Opcode.ATTACHMENT_INDEX, self._indexes[AttachmentIndex]
        yield Opcode.METADATA_INDEX, self._indexes[MetadataIndex]

    def _statistics(self) -> Statistics:
        first, last = self._times or (0, 0)
        return Statistics(
            attachment_count=self._index_counts[AttachmentIndex],
            channel_count=len(self.channels),
            channel_message_counts=self._counts,
            chunk_count=self._index_counts[ChunkIndex],
            message_count=self.message_count,
            message_start_time=first,
            message_end_time=last,
            metadata_count=self._index_counts[MetadataIndex],
            schema_count=len(self.schemas),
        )
