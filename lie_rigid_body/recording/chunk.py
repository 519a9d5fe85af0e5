"""Chunks of an MCAP file as arrays: the messages of a topic have one size, so that many are laid out at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import McapRecord
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.messages.batch import Messages
from lie_rigid_body.messages.template import Template

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
"""Fields before the payload of a message record."""
_CHANNEL: Final = 9
"""Byte of a message record where the channel begins; the sequence number and the two times follow it."""
OPCODE_AND_LENGTH: Final = 9
"""Number of bytes of a record that its length does not count."""


def record_bytes(*records: McapRecord) -> bytes:
    """The bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


Rows: TypeAlias = NDArray[np.integer]


@dataclass(frozen=True)
class Entries:
    """The messages of a channel in a chunk as its index has them.

    Parameters
    ----------
    channel : int
    rows : ndarray of int64 or uint64, shape (N, 2)
        Log time, ns, and offset in the uncompressed chunk, in the order of the chunk.
    first_ns, last_ns : int
        The earliest and the latest log time.
    """

    channel: int
    rows: Rows
    first_ns: int
    last_ns: int


@dataclass(frozen=True)
class MessageRecords:
    """Message records one after the other.

    Parameters
    ----------
    data : ndarray of uint8
    bounds : ndarray of int64, shape (N + 1,)
        Where in the data each begins, and the last ends.
    topics : list of (int, ndarray of int64, shape (M, 2))
        Of each topic the channel, and log times, ns, and places in the data of its messages, in the order of the data;
        also of those beyond the bounds.
    """

    data: NDArray[np.uint8]
    bounds: Integers
    topics: list[tuple[int, Rows]]

    def __len__(self) -> int:
        return len(self.bounds) - 1

    def __getitem__(self, some: slice) -> MessageRecords:
        begin, end, _ = some.indices(len(self))
        return MessageRecords(self.data, self.bounds[begin : end + 1], self.topics)

    def first_of(self, channel: int) -> int:
        """The number of the first message of a channel that is one of the topics'."""
        place = next(int(rows[0, 1]) for number, rows in self.topics if number == channel)
        return int(np.searchsorted(self.bounds, place))

    def entries(self, pieces: Integers, offset: int) -> Iterator[list[Entries]]:
        """Index entries of each piece of the data.

        Parameters
        ----------
        pieces : ndarray of int64, shape (K + 1,)
            Where each begins, and the last ends.
        offset : int
            Where the first begins in its chunk; the others begin theirs.
        """
        if len(pieces) == 2 and len(self) == sum(len(rows) for _, rows in self.topics):
            splits = [[0, len(rows)] for _, rows in self.topics]
        else:
            splits = [np.searchsorted(rows[:, 1], pieces).tolist() for _, rows in self.topics]
        for k, begin in enumerate(pieces[:-1].tolist()):
            parts = ((topic, at[k], at[k + 1]) for topic, at in zip(self.topics, splits, strict=True))
            yield [_entries(*topic, first, end, begin - offset) for topic, first, end in parts if first < end]
            offset = 0

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
        sizes = [HEAD.itemsize + messages.payloads.template.size for messages in topics]
        order = np.argsort(np.concatenate([messages.times_ns for messages in topics]), kind="stable")
        bounds = np.zeros(len(order) + 1, dtype=np.int64)
        np.cumsum(np.repeat(sizes, lengths)[order], out=bounds[1:])
        places = np.empty_like(order)
        places[order] = bounds[:-1]
        data = np.empty(bounds[-1], dtype=np.uint8)
        found, begin = [], 0
        for messages, count in zip(topics, lengths, strict=True):
            channel, own = channels[messages.topic], places[begin : begin + count]
            template = _record(channel, messages.payloads.template)
            template.put(data, own, _record_words(channel, counts[messages.topic], messages))
            found.append((channel, _rows(messages.times_ns, own)))
            begin += count
        return cls(data, bounds, found)


@lru_cache(maxsize=64)
def _record(channel: int, payload: Template) -> Template:
    """The records of a topic's messages."""
    size = HEAD.itemsize + payload.size
    head = np.array((Opcode.MESSAGE, size - OPCODE_AND_LENGTH, channel, 0, 0, 0), dtype=HEAD)
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


def _rows(times_ns: Integers, places: Integers) -> Rows:
    """Log times and places of a topic's messages, in the order of the places."""
    rows = np.empty((len(places), 2), dtype="<i8")
    rows[:, 0], rows[:, 1] = times_ns, places
    goes_back = len(places) > 1 and (places[1:] < places[:-1]).any()
    return rows[np.argsort(places)] if goes_back else rows


def _entries(channel: int, rows: Rows, first: int, end: int, begin: int) -> Entries:
    """Some of a topic's messages, for a chunk that begins at a place."""
    own = rows[first:end].copy()
    own[:, 1] -= begin
    return Entries(channel, own, int(own[0, 0]), int(own[-1, 0]))


@dataclass(frozen=True)
class RawChunk:
    """A chunk before it is compressed.

    Parameters
    ----------
    pieces : list of bytes or ndarray of uint8
        Its data.
    messages : list of Entries
        Of one message at least. Of a channel that has several, in their order.
    """

    pieces: list[bytes | NDArray[np.uint8]]
    messages: list[Entries]

    @cached_property
    def data(self) -> bytes | NDArray[np.uint8]:
        """All of its bytes."""
        return self.pieces[0] if len(self.pieces) == 1 else b"".join(self.pieces)

    def log_times_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time, ns."""
        first_ns = min(entries.first_ns for entries in self.messages)
        return first_ns, max(entries.last_ns for entries in self.messages)

    def indexes(self) -> dict[int, Rows]:
        """For each channel its rows, shape (M, 2); in order of first messages."""
        found: dict[int, list[Rows]] = {}
        for entries in sorted(self.messages, key=_first_offset):
            found.setdefault(entries.channel, []).append(entries.rows)
        return {channel: rows[0] if len(rows) == 1 else np.concatenate(rows) for channel, rows in found.items()}


def _first_offset(entries: Entries) -> int:
    return int(entries.rows[0, 1])


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
        self._messages: list[Entries] = []

    def add(self, record: McapRecord) -> None:
        """Add a schema or a channel."""
        self._append(record_bytes(record))

    def add_messages(self, records: MessageRecords) -> None:
        """Add messages."""
        if not len(records):
            return
        pieces = records.bounds[self._ends(records.bounds)]
        entries = records.entries(pieces, self._size)
        for (begin, end), messages in zip(pairwise(pieces.tolist()), entries, strict=True):
            self._messages += messages
            self._append(records.data[begin:end])

    def _ends(self, bounds: Integers) -> list[int]:
        """The numbers of the messages with which pieces for one chunk each begin, and behind the last."""
        ends, room = [0], self._chunk_size - self._size
        while ends[-1] < len(bounds) - 1:
            # the first that ends beyond the size is the last of the chunk
            beyond = int(np.searchsorted(bounds, bounds[ends[-1]] + room, side="right"))
            ends.append(min(max(beyond, ends[-1] + 1), len(bounds) - 1))
            room = self._chunk_size
        return ends

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
