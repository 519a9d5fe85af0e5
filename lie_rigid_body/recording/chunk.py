"""Chunks of an MCAP file as arrays: the messages of a topic have one size, so that many are laid out at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
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
"""What comes before the payload in a message record."""
_CHANNEL, _TIMES = 9, 15
"""Bytes of it where the channel begins, and where the two times do."""
OPCODE_AND_LENGTH: Final = 9
"""Bytes of a record that its length does not count."""


def record_bytes(*records: McapRecord) -> bytes:
    """The bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


Columns: TypeAlias = tuple[int, NDArray[np.integer], Integers]
"""Of messages of a channel, in the order in which they lie: the channel, their log times, ns, and where they begin."""


@dataclass(frozen=True)
class MessageRecords:
    """Message records one after the other.

    Parameters
    ----------
    data : ndarray of uint8
    bounds : ndarray of int64, shape (N + 1,)
        Where in the data each begins, and the last ends.
    topics : list of Columns
        Of each topic, also of messages beyond the bounds.
    """

    data: NDArray[np.uint8]
    bounds: Integers
    topics: list[Columns]

    def __len__(self) -> int:
        return len(self.bounds) - 1

    def __getitem__(self, some: slice) -> MessageRecords:
        begin, end, _ = some.indices(len(self))
        return MessageRecords(self.data, self.bounds[begin : end + 1], self.topics)

    def first_of(self, channel: int) -> int:
        """The number of the first message of a channel that is one of the topics'."""
        place = next(places[0] for number, _, places in self.topics if number == channel)
        return int(np.searchsorted(self.bounds, place))

    def columns(self, offset: int) -> list[Columns]:
        """Of each topic the messages within the bounds, if the first of all begins at an offset in a chunk."""
        bounds = self.bounds[[0, -1]]
        found = []
        for channel, times_ns, places in self.topics:
            begin, end = places.searchsorted(bounds)
            if begin < end:
                found.append((channel, times_ns[begin:end], places[begin:end] + (offset - bounds[0])))
        return found

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
        columns: list[Columns] = []
        for messages, own, size in zip(topics, np.split(places, np.cumsum(lengths)[:-1]), sizes, strict=True):
            channel, times_ns, payloads = channels[messages.topic], messages.times_ns, messages.payloads
            _head(channel, size).put(data, own, _head_words(channel, counts[messages.topic], times_ns))
            payloads.template.put(data, own + HEAD.itemsize, payloads.words)
            # both rise already, but where a time is before that of the message before
            columns.append((channel, np.sort(times_ns, kind="stable"), np.sort(own, kind="stable")))
        return cls(data, bounds, columns)


@lru_cache(maxsize=64)
def _head(channel: int, size: int) -> Template:
    """What comes before the payloads in records of so many bytes."""
    head = np.array((Opcode.MESSAGE, size - OPCODE_AND_LENGTH, channel, 0, 0, 0), dtype=HEAD)
    return Template(head.tobytes(), [(_CHANNEL - 2, 1), (_TIMES, 2)])


def _head_words(channel: int, first: int, times_ns: Integers) -> Integers:
    """The words of the heads of messages with the numbers from ``first`` on."""
    words = np.empty((len(times_ns), 3), dtype=np.int64)
    # two bytes of the length, which are 0, the channel, and the sequence number, which goes on with 0 behind the last
    words[:, 0] = np.arange(first, first + len(times_ns)) << 32 | channel << 16
    words[:, 1] = words[:, 2] = times_ns
    return words


@dataclass(frozen=True)
class RawChunk:
    """A chunk before it is compressed. What is computed of it is computed when it is asked for.

    Parameters
    ----------
    pieces : list of bytes or ndarray of uint8
        Its data.
    messages : list of Columns
        Of one message at least. Of a channel that has several, in their order.
    """

    pieces: list[bytes | NDArray[np.uint8]]
    messages: list[Columns]

    @cached_property
    def data(self) -> bytes | NDArray[np.uint8]:
        """All of its bytes."""
        return self.pieces[0] if len(self.pieces) == 1 else b"".join(self.pieces)

    def log_times_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time, ns."""
        first = min(int(times.min()) for _, times, _ in self.messages)
        return first, max(int(times.max()) for _, times, _ in self.messages)

    def indexes(self) -> dict[int, NDArray[np.uint64]]:
        """For each channel the log times and offsets of its messages, shape (M, 2); in order of first messages."""
        found: dict[int, list[NDArray[np.uint64]]] = {}
        for channel, times_ns, offsets in sorted(self.messages, key=_first_offset):
            entries = np.empty((len(offsets), 2), dtype="<u8")
            entries[:, 0], entries[:, 1] = times_ns, offsets
            found.setdefault(channel, []).append(entries)
        return {channel: parts[0] if len(parts) == 1 else np.concatenate(parts) for channel, parts in found.items()}


def _first_offset(messages: Columns) -> int:
    return int(messages[2][0])


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
            self._messages += some.columns(self._size)
            self._append(some.data[start : some.bounds[-1]])

    def _append(self, data: bytes | NDArray[np.uint8]) -> None:
        self._data.append(data)
        self._size += len(data)
        if self._size > self._chunk_size:
            self.finish()

    def finish(self) -> None:
        """End the present chunk, if it has messages."""
        if self._messages:
            chunk = RawChunk(self._data, self._messages)
            self._begin()
            self._full(chunk)
