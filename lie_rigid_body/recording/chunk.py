"""Chunks of an MCAP file as arrays: the messages of a topic have one size, so that many are laid out at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import McapRecord
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.messages.batch import Messages

MAGIC: Final = b"\x89MCAP0\r\n"
"""The first and the last bytes of an MCAP file, as mcap.writer has them, which takes long to load."""

HEAD: Final = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""What comes before the payload in a message record."""
OPCODE_AND_LENGTH: Final = 9
"""Bytes of a record that its length does not count."""
_SEQUENCE_NUMBERS: Final = 2**32
"""MCAP counts the messages of a channel in 32 bits."""


def record_bytes(*records: McapRecord) -> bytes:
    """The bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


@dataclass(frozen=True)
class MessageRecords:
    """Message records one after the other.

    Parameters
    ----------
    data : ndarray of uint8
    bounds : ndarray of int64, shape (N + 1,)
        Where in the data each begins, and the last ends.
    channels : ndarray of uint16, shape (N,)
    log_times_ns : ndarray of int64, shape (N,)
    """

    data: NDArray[np.uint8]
    bounds: Integers
    channels: NDArray[np.uint16]
    log_times_ns: Integers

    def __len__(self) -> int:
        return len(self.channels)

    def __getitem__(self, some: slice) -> MessageRecords:
        begin, end, _ = some.indices(len(self))
        return MessageRecords(self.data, self.bounds[begin : end + 1], self.channels[some], self.log_times_ns[some])

    @classmethod
    def of(cls, topics: Sequence[Messages], channels: Mapping[str, int], counts: Mapping[str, int]) -> MessageRecords:
        """The messages of several topics in the order of their times, each logged and published at its own.

        Where times are equal they come in the order of the topics.

        Parameters
        ----------
        topics : sequence of Messages
        channels, counts : mapping of str to int
            Channel of each topic, and how many messages it has had before.
        """
        lengths = [len(messages.payloads) for messages in topics]
        sizes = [HEAD.itemsize + messages.payloads.rows.shape[1] for messages in topics]
        times_ns = np.concatenate([messages.times_ns for messages in topics])
        order = np.argsort(times_ns, kind="stable")
        bounds = np.zeros(len(order) + 1, dtype=np.int64)
        np.cumsum(np.repeat(sizes, lengths)[order], out=bounds[1:])
        places = np.empty_like(order)
        places[order] = bounds[:-1]
        data = np.empty(bounds[-1], dtype=np.uint8)
        numbers, begin = np.empty(len(order), dtype=np.uint16), 0
        for messages, count, size in zip(topics, lengths, sizes, strict=True):
            mine = slice(begin, begin + count)
            numbers[mine] = channels[messages.topic]
            heads = np.empty(count, dtype=HEAD)
            heads["opcode"], heads["length"] = Opcode.MESSAGE, size - OPCODE_AND_LENGTH
            heads["channel"] = channels[messages.topic]
            first = counts[messages.topic] % _SEQUENCE_NUMBERS
            heads["sequence"] = np.arange(first, first + count).astype(np.uint32)  # goes on with 0 behind the last
            heads["log_time"] = heads["publish_time"] = messages.times_ns
            _put(data, places[mine], heads.view(np.uint8).reshape(-1, HEAD.itemsize))
            _put(data, places[mine] + HEAD.itemsize, messages.payloads.rows)
            begin += count
        return cls(data, bounds, numbers[order], times_ns[order])


def _put(data: NDArray[np.uint8], places: Integers, rows: NDArray[np.uint8]) -> None:
    """Copy each row of bytes to its place, at any byte."""
    if len(rows):
        kind = f"V{rows.shape[1]}"
        # an item of that size at each byte of the data; they overlap
        items = np.ndarray(len(data) - rows.shape[1] + 1, dtype=kind, buffer=data, strides=(1,))
        items[places] = np.ascontiguousarray(rows).view(kind)[:, 0]


Columns = tuple[NDArray[np.uint16], NDArray[np.integer], Integers]
"""Of N messages the channels, the log times, ns, and the offsets in the uncompressed chunk, each of shape (N,)."""


@dataclass(frozen=True)
class RawChunk:
    """A chunk before it is compressed. What is computed of it is computed when it is asked for.

    Parameters
    ----------
    pieces : list of bytes or ndarray of uint8
        Its data.
    messages : list of Columns
        Of one message at least.
    """

    pieces: list[bytes | NDArray[np.uint8]]
    messages: list[Columns]

    @cached_property
    def data(self) -> bytes | NDArray[np.uint8]:
        """All of its bytes."""
        return self.pieces[0] if len(self.pieces) == 1 else b"".join(self.pieces)

    @cached_property
    def _columns(self) -> Columns:
        if len(self.messages) == 1:
            return self.messages[0]
        channels, log_times_ns, offsets = (np.concatenate(column) for column in zip(*self.messages, strict=True))
        return channels, log_times_ns, offsets

    def log_times_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time, ns."""
        times = self._columns[1]
        return int(times.min()), int(times.max())

    def indexes(self) -> dict[int, NDArray[np.uint64]]:
        """For each channel the log times and offsets of its messages, shape (M, 2); in order of first messages."""
        channels, log_times_ns, offsets = self._columns
        order = np.argsort(channels, kind="stable")
        entries = np.empty((len(channels), 2), dtype="<u8")
        entries[:, 0], entries[:, 1] = log_times_ns[order], offsets[order]
        ends = np.cumsum(np.bincount(channels)).tolist()
        parts = [(begin, end) for begin, end in pairwise([0, *ends]) if begin < end]
        parts.sort(key=lambda part: int(order[part[0]]))
        return {int(channels[order[begin]]): entries[begin:end] for begin, end in parts}


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
        self._chunk_size = size
        self._full = full
        self._begin()

    def _begin(self) -> None:
        self._data: list[bytes | NDArray[np.uint8]] = []
        self._size = 0
        self._messages: list[Columns] = []

    def add(self, record: McapRecord) -> None:
        """Add a schema or a channel."""
        self._append(record_bytes(record))

    def add_messages(self, records: MessageRecords) -> None:
        """Add messages."""
        while len(records):
            start = records.bounds[0]
            # the first that ends beyond the size is the last of the chunk
            beyond = int(np.searchsorted(records.bounds, start + self._chunk_size - self._size, side="right"))
            some, records = records[: max(beyond, 1)], records[max(beyond, 1) :]
            self._messages.append((some.channels, some.log_times_ns, some.bounds[:-1] - start + self._size))
            self._append(some.data[start : some.bounds[-1]])

    def _append(self, data: bytes | NDArray[np.uint8]) -> None:
        self._data.append(data)
        self._size += len(data)
        if self._size > self._chunk_size:
            self.finish()

    def so_far(self) -> RawChunk | None:
        """The present chunk as far as it is; None without messages."""
        return RawChunk([*self._data], [*self._messages]) if self._messages else None

    def finish(self) -> None:
        """End the present chunk, if it has messages."""
        if chunk := self.so_far():
            self._begin()
            self._full(chunk)
