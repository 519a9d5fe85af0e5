"""Records of an MCAP file, and the messages among them as a table: where they stand, of which channel, and when."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from typing import Final, NamedTuple, TypeVar

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers, windows
from lie_rigid_body.recording.chunk import HEAD, OPCODE_AND_LENGTH, Entries

T = TypeVar("T")
LAST_TIME: Final = 2**63 - 1
"""Largest time of a message, ns: ROS 2 counts in 64 bits with a sign."""
RECORD_HEAD: Final = struct.Struct("<BQ")
"""Opcode of a record and length of its content."""
NO_HINTS: Final = np.empty(0, dtype=np.int64)


class ContradictionError(ValueError):
    """A file that does not hold what it says of itself. The message says what."""


class ExcessError(ValueError):
    """A file that holds more than is read. The message says what."""


class Place(NamedTuple):
    """Opcode of a record, and where its content begins and ends."""

    opcode: int
    begin: int
    end: int


class RecordContent(BytesIO):
    """Content of a record: what is said to reach beyond its end is a contradiction, and not cut off there."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes, all of so many."""
        found = super().read(size)
        require(size is None or len(found) >= size, "a length in a record reaches beyond its end")
        return found


def parsed(read: Callable[[ReadDataStream], T], content: bytes) -> T:
    """Parse the content of a record with a function of the `mcap` library."""
    return read(ReadDataStream(RecordContent(content)))


def require(holds: bool, otherwise: str) -> None:
    """Raise what is otherwise a contradiction."""
    if not holds:
        raise ContradictionError(otherwise)


def records(data: bytes, position: int = 0, end: int | None = None) -> Iterator[Place]:
    """Whole records that follow each other from a byte on, until one would reach beyond the end."""
    end = len(data) if end is None else end
    while position + RECORD_HEAD.size <= end:
        opcode, length = RECORD_HEAD.unpack_from(data, position)
        begin, position = position + RECORD_HEAD.size, position + RECORD_HEAD.size + length
        if position > end:
            return
        yield Place(opcode, begin, position)


@dataclass(frozen=True)
class MessageTable:
    """Messages among the records of a chunk, in file order.

    Parameters
    ----------
    data : bytes
        The records.
    starts, ends : ndarray of int64, shape (N,)
        Where each message's record begins and ends.
    heads : ndarray of `chunk.HEAD`, shape (N,)
        Their first bytes.
    """

    data: bytes
    starts: Integers
    ends: Integers
    heads: NDArray[np.void]

    @classmethod
    def of(cls, data: bytes, starts: Integers, ends: Integers) -> MessageTable:
        """Table of the messages between these places.

        Raises
        ------
        ContradictionError
            If a message is too short to be one.
        """
        require(bool((ends - starts >= HEAD.itemsize).all()), "a message record is too short")
        return cls(data, starts, ends, _heads(data, starts))

    @property
    def log_times(self) -> Integers:
        """Times when the messages were logged, ns, shape (N,)."""
        return self.heads["log_time"].view(np.int64)

    @cached_property
    def counts(self) -> dict[int, int]:
        """Number of messages of each channel that has any."""
        counts = np.bincount(self.heads["channel"])
        return {channel: int(counts[channel]) for channel in np.flatnonzero(counts).tolist()}

    @cached_property
    def entries(self) -> dict[int, Entries]:
        """Entries of the index of each channel, in file order."""
        order = np.argsort(self.heads["channel"], kind="stable")
        rows = np.empty((len(order), 2), dtype="<u8")
        rows[:, 0], rows[:, 1] = self.heads["log_time"][order], self.starts[order]
        parts = np.split(rows, np.cumsum([*self.counts.values()])[:-1])
        return {
            channel: Entries(channel, own, int(own[:, 0].min()), int(own[:, 0].max()))
            for channel, own in zip(self.counts, parts, strict=False)
        }

    def require_times(self) -> None:
        """Refuse times beyond 64 bits with a sign."""
        for name in ("log_time", "publish_time"):
            latest = int(self.heads[name].max(initial=0))
            require(latest <= LAST_TIME, f"the {name} of a message is {latest} ns, beyond {LAST_TIME}")


def _heads(data: bytes, starts: Integers) -> NDArray[np.void]:
    """First bytes of message records."""
    if not len(starts):
        return np.empty(0, dtype=HEAD)
    heads: NDArray[np.void] = windows(data, HEAD.itemsize)[starts].reshape(-1).view(HEAD)
    return heads


def find_messages(data: bytes, hints: Integers, most: int) -> tuple[MessageTable, list[Place]]:
    """Find the messages among records, and the other records.

    Parameters
    ----------
    data : bytes
        Records one after the other.
    hints : ndarray of int64
        Bytes where messages may begin, as indexes say: of those there, no record has to be looked at one by one.
        Wrong ones cost time only.
    most : int
        Largest number of records that may be found.

    Raises
    ------
    ContradictionError
        If a record reaches beyond the data, or a message is too short to be one.
    ExcessError
        If there are more records.
    """
    hinted = _hinted(data, hints)
    others, messages, left = list[Place](), array("q"), most - len(hinted.starts)
    before, behind = np.append(0, hinted.ends), np.append(hinted.starts, len(data))
    for gap in np.flatnonzero(before != behind).tolist():
        position = int(before[gap])
        for place in records(data, position, int(behind[gap])):
            position, left = place.end, left - 1
            if left < 0:
                raise ExcessError("too many records in chunks for its size")
            if place.opcode == Opcode.MESSAGE:
                messages.extend((place.begin - OPCODE_AND_LENGTH, place.end))
            else:
                others.append(place)
        if position != behind[gap] and len(hinted.starts):
            return find_messages(data, NO_HINTS, most)
        require(position == behind[gap], "a record is longer than its chunk")
    if not messages:
        return hinted, others
    found = np.frombuffer(messages, dtype=np.int64).reshape(-1, 2)
    starts, ends = (
        np.sort(np.concatenate(pair)) for pair in ((hinted.starts, found[:, 0]), (hinted.ends, found[:, 1]))
    )
    return MessageTable.of(data, starts, ends), others


def _hinted(data: bytes, hints: Integers) -> MessageTable:
    """Table of the messages to which hints point, perhaps within each other; empty if what stands there is none."""
    starts = np.sort(hints)
    if len(starts) and starts[0] >= 0 and starts[-1] <= len(data) - HEAD.itemsize:
        heads = _heads(data, starts)
        ends = starts + OPCODE_AND_LENGTH + np.minimum(heads["length"], len(data)).astype(np.int64)
        are_messages = (heads["opcode"] == Opcode.MESSAGE) & (ends >= starts + HEAD.itemsize)
        if are_messages.all():
            return MessageTable(data, starts, ends, heads)
    return MessageTable.of(data, NO_HINTS, NO_HINTS)
