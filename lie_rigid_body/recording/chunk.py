"""Chunks of an MCAP file laid out as arrays: messages of a topic have one size, so that many are laid out at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from mcap.opcode import Opcode
from mcap.records import McapRecord
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.messages.batch import Messages
from lie_rigid_body.messages.template import Template
from lie_rigid_body.recording.message_table import HEAD, MessageTable
from lie_rigid_body.recording.records import RECORD_HEAD, record_bytes

_CHANNEL, _TIMES = 9, 15
"""Bytes of a message record where the channel begins, and where the two times do."""


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
    first, begin = dict[str, int](), 0
    for messages, count in zip(topics, lengths, strict=True):
        channel, own = channels[messages.topic], places[begin : begin + count]
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
    return payload.behind(head.tobytes(), [(_CHANNEL - 2, 1), (_TIMES, 2)])


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
        self._chunk_size, self._full = size, full
        self._begin()

    def _begin(self) -> None:
        self._chunk, self._size = RawChunk([], []), 0

    def add(self, record: McapRecord) -> None:
        """Add a schema or a channel."""
        self._append(record_bytes(record))

    def add_messages(self, data: NDArray[np.uint8], bounds: Integers) -> None:
        """Add messages that begin, and the last of which ends, at some bytes of the data."""
        begin, count = 0, len(bounds) - 1
        while begin < count:
            # the first that ends beyond the size is the last of the chunk
            room = self._chunk_size - self._size
            end = int(np.searchsorted(bounds, bounds[begin] + room, side="right"))
            end = min(max(end, begin + 1), count)
            self._chunk.starts.append(bounds[begin:end] + (self._size - bounds[begin]))
            self._append(data[bounds[begin] : bounds[end]])
            begin = end

    def _append(self, data: bytes | NDArray[np.uint8]) -> None:
        self._chunk.pieces.append(data)
        self._size += len(data)
        if self._size > self._chunk_size:
            self.finish()

    def so_far(self) -> RawChunk | None:
        """The present chunk as far as it is; None without messages."""
        return RawChunk([*self._chunk.pieces], [*self._chunk.starts]) if self._chunk.starts else None

    def finish(self) -> None:
        """End the present chunk, if it has messages."""
        if chunk := self.so_far():
            self._begin()
            self._full(chunk)
