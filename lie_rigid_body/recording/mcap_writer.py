"""Writing an MCAP file: messages laid out as arrays, many at once, in chunks, with their indexes and a summary."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import BinaryIO, Final

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    Schema,
    SummaryOffset,
)
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.messages.batch import Messages
from lie_rigid_body.messages.layout import Template
from lie_rigid_body.recording.records import HEAD, MAGIC, RECORD_HEAD, MessageTable, record_bytes
from lie_rigid_body.recording.summary import Summary

_CHANNEL: Final = 9
"""Byte of a message record where the channel begins; the sequence number and the two times follow it."""
_MESSAGE_INDEX: Final = struct.Struct("<BQHI")
_FOOTER: Final = struct.Struct("<BQQQ")
ZSTD_LEVEL: Final = -1
"""Level of zstd; level 3 of the `mcap` library's writer takes nearly twice as long, and makes a bag 3 % smaller."""


def laid_out(
    topics: Sequence[Messages], channels: Mapping[str, int], counts: Mapping[str, int]
) -> tuple[NDArray[np.uint8], Integers, dict[str, int]]:
    """The records of the messages of several topics in the order of their times, each logged and published at its own.

    Where times are equal they come in the order of the topics.

    Parameters
    ----------
    topics : sequence of Messages
    channels, counts : mapping of str to int
        Channel of each topic, and how many messages it has had before.

    Returns
    -------
    data : ndarray of uint8
    bounds : ndarray of int64, shape (N + 1,)
        Where in the data each begins, and the last ends.
    first : dict of str to int
        Number of the first message of each topic.
    """
    lengths = [len(messages.payloads) for messages in topics]
    sizes = [HEAD.itemsize + messages.payloads.template.size for messages in topics]
    order = np.argsort(np.concatenate([messages.times_ns for messages in topics]), kind="stable")
    bounds = np.zeros(len(order) + 1, dtype=np.int64)
    np.cumsum(np.repeat(sizes, lengths)[order], out=bounds[1:])
    places = np.empty_like(order)
    places[order] = bounds[:-1]
    data = np.empty(bounds[-1], dtype=np.uint8)
    first = dict[str, int]()
    begin = 0
    for messages, count in zip(topics, lengths, strict=True):
        channel = channels[messages.topic]
        own = places[begin : begin + count]
        template = _record(channel, messages.payloads.template)
        template.put(data, own, _record_words(channel, counts[messages.topic], messages))
        first[messages.topic] = int(np.searchsorted(bounds, own.min()))
        begin += count
    return data, bounds, first


@lru_cache(maxsize=64)
def _record(channel: int, payload: Template) -> Template:
    """The records of a topic's messages."""
    size = HEAD.itemsize + payload.size
    head = np.array((Opcode.MESSAGE, size - RECORD_HEAD.size, channel, 0, 0, 0), dtype=HEAD)
    return payload.behind(head.tobytes(), [(_CHANNEL - 2, 3)])


def _record_words(channel: int, first: int, messages: Messages) -> Integers:
    """The words of the records of messages with the numbers from ``first`` on."""
    payload = messages.payloads.words
    words = np.empty((len(payload), 3 + payload.shape[1]), dtype="<i8")
    # two bytes of the length, which are 0, the channel, and the sequence number, which goes on with 0 behind the last
    words[:, 0] = np.arange(first, first + len(words)) << 32 | channel << 16
    words[:, 1] = words[:, 2] = messages.times_ns
    words[:, 3:] = payload
    return words


@dataclass(frozen=True)
class RawChunk:
    """A chunk before it is compressed.

    Parameters
    ----------
    pieces : list of bytes or ndarray of uint8
        Its data.
    starts : list of ndarray of int64
        Where its messages begin.
    """

    pieces: list[bytes | NDArray[np.uint8]]
    starts: list[Integers]

    @cached_property
    def table(self) -> MessageTable:
        """Its messages, which are laid out here."""
        return MessageTable(b"".join(self.pieces), np.concatenate(self.starts))

    def __len__(self) -> int:
        return sum(map(len, self.pieces))


class ChunkBuilder:
    """Records on their way into chunks. A chunk ends with the record that makes it longer than its size.

    Parameters
    ----------
    size : int
        Bytes.
    full : callable
        Takes each `RawChunk`.
    """

    def __init__(self, size: int, full: Callable[[RawChunk], object]) -> None:
        self._size = size
        self._full = full
        self._chunk = RawChunk([], [])

    def add(self, record: McapRecord) -> None:
        """Add a schema or a channel."""
        self._append(record_bytes(record))

    def add_messages(self, data: NDArray[np.uint8], bounds: Integers) -> None:
        """Add messages that begin, and the last of which ends, at some bytes of the data."""
        begin = 0
        count = len(bounds) - 1
        while begin < count:
            # the first that ends beyond the size is the last of the chunk
            there = len(self._chunk)
            end = int(np.searchsorted(bounds, bounds[begin] + self._size - there, side="right"))
            end = min(max(end, begin + 1), count)
            self._chunk.starts.append(bounds[begin:end] + (there - bounds[begin]))
            self._append(data[bounds[begin] : bounds[end]])
            begin = end

    def _append(self, data: bytes | NDArray[np.uint8]) -> None:
        self._chunk.pieces.append(data)
        if len(self._chunk) > self._size:
            self.finish()

    def finish(self) -> None:
        """End the present chunk, if it has messages."""
        if self._chunk.starts:
            chunk = self._chunk
            self._chunk = RawChunk([], [])
            self._full(chunk)


def compressed(table: MessageTable, compression: str) -> Chunk:
    """A chunk of records with one message at least.

    Parameters
    ----------
    table : MessageTable
    compression : str
        ``zstd``, ``lz4``, or nothing, as MCAP names them.
    """
    data = table.data
    if compression == "zstd":
        data = zstandard.ZstdCompressor(ZSTD_LEVEL).compress(data)
    elif compression == "lz4":
        import lz4.frame

        data = lz4.frame.compress(data)
    first_ns, last_ns = table.span_ns
    return Chunk(
        compression=compression,
        data=data,
        message_start_time=first_ns,
        message_end_time=last_ns,
        uncompressed_crc=zlib.crc32(table.data),
        uncompressed_size=len(table.data),
    )


class McapFile:
    """An MCAP file that grows by chunks.

    Parameters
    ----------
    stream : binary file
    header : Header

    Attributes
    ----------
    summary : Summary
        Its schemas and channels may be records in chunks: whoever makes those adds them there.
    """

    def __init__(self, stream: BinaryIO, header: Header) -> None:
        self.summary = Summary()
        self._stream = stream
        self._position = self._crc = 0
        self._write(MAGIC + record_bytes(header))

    def _write(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._stream.write(data)
        self._position += len(data)

    def add_chunk(self, chunk: Chunk, table: MessageTable) -> None:
        """Write a chunk and the indexes of the messages in it."""
        # a chunk may be large: its record is not made as a whole
        head = record_bytes(replace(chunk, data=b""))[RECORD_HEAD.size : -8] + len(chunk.data).to_bytes(8, "little")
        length = len(head) + len(chunk.data)
        parts = [RECORD_HEAD.pack(Opcode.CHUNK, length) + head, chunk.data]
        indexes = dict[int, int]()
        end = self._position + RECORD_HEAD.size + length
        for channel, rows in table.index.items():
            indexes[channel], size = end, rows.nbytes
            parts += _MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size), rows.tobytes()
            end += _MESSAGE_INDEX.size + size
        self.summary.add_messages(table)
        self.summary.add_chunk(chunk, self._position, indexes, end)
        for part in parts:
            self._write(part)

    def add_messages(self, table: MessageTable) -> None:
        """Write messages outside of chunks."""
        self.summary.add_messages(table)
        self._write(table.data)

    def add(self, record: Schema | Channel | Metadata | Attachment) -> None:
        """Write another record outside of chunks."""
        data = record_bytes(record)
        if isinstance(record, Schema | Channel):
            self.summary.declare(record)
        else:
            self.summary.add_index(record, self._position, len(data))
        self._write(data)

    def finish(self) -> None:
        """Write the summary. The stream stays open."""
        self._write(record_bytes(DataEnd(self._crc)))
        start = self._position
        groups = b""
        offsets = b""
        for opcode, records in self.summary.groups().items():
            group = record_bytes(*records)
            offsets += record_bytes(SummaryOffset(opcode, start + len(groups), len(group)))
            groups += group
        end = start + len(groups)
        crc = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, start, end), zlib.crc32(groups + offsets))
        self._write(groups + offsets + record_bytes(Footer(start, end, crc)) + MAGIC)
