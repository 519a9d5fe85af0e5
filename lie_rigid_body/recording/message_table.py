"""Messages among the records of a chunk as a table: where they stand, of which channel, and when."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers, windows
from lie_rigid_body.recording.records import RECORD_HEAD, ContradictionError, ExcessError, Place, records, require

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
LAST_TIME: Final = 2**63 - 1
"""Largest time of a message, ns: ROS 2 counts in 64 bits with a sign."""
_SHORTEST: Final = HEAD.itemsize - RECORD_HEAD.size
"""Length of the content of a message without payload."""
NO_HINTS: Final = np.empty(0, dtype=np.int64)
Rows: TypeAlias = NDArray[np.uint64]
"""Log time, ns, and place in the uncompressed chunk of each message, shape (N, 2), as an index has them."""


@dataclass(frozen=True)
class MessageTable:
    """Messages among some records, in their order.

    Parameters
    ----------
    data : bytes
        The records.
    starts : ndarray of int64, shape (N,)
        Where the record of each message begins.
    others : tuple of Place
        The records that are no messages, where they were looked for.
    """

    data: bytes
    starts: Integers
    others: tuple[Place, ...] = ()

    @cached_property
    def heads(self) -> NDArray[np.void]:
        """First bytes of the messages, of type `HEAD`, shape (N,)."""
        if not len(self.starts):
            return np.empty(0, dtype=HEAD)
        heads: NDArray[np.void] = windows(self.data, HEAD.itemsize)[self.starts].reshape(-1).view(HEAD)
        return heads

    @cached_property
    def ends(self) -> Integers:
        """Ends of the records of the messages, shape (N,); what reaches beyond the data ends somewhere there."""
        lengths: Integers = np.minimum(self.heads["length"], len(self.data)).astype(np.int64)
        return self.starts + RECORD_HEAD.size + lengths

    @property
    def log_times(self) -> Integers:
        """Times when the messages were logged, ns, shape (N,)."""
        times: Integers = self.heads["log_time"].view(np.int64)
        return times

    @property
    def span_ns(self) -> tuple[int, int]:
        """The earliest and the latest of them; `LAST_TIME` and 0 without messages."""
        return int(self.log_times.min(initial=LAST_TIME)), int(self.log_times.max(initial=0))

    @cached_property
    def index(self) -> dict[int, Rows]:
        """Rows of each channel that has messages, in their order; the channels in that of their first messages."""
        order = np.argsort(self.heads["channel"], kind="stable")
        rows = np.empty((len(order), 2), dtype="<u8")
        rows[:, 0], rows[:, 1] = self.heads["log_time"][order], self.starts[order]
        counts = np.bincount(self.heads["channel"])
        channels = np.flatnonzero(counts)
        parts = zip(channels.tolist(), np.split(rows, np.cumsum(counts[channels])[:-1]), strict=False)
        return dict(sorted(parts, key=lambda part: int(part[1][0, 1])))

    def require_times(self) -> None:
        """Refuse times beyond 64 bits with a sign."""
        for name in ("log_time", "publish_time"):
            latest = int(self.heads[name].max(initial=0))
            require(latest <= LAST_TIME, f"the {name} of a message is {latest} ns, beyond {LAST_TIME}")


def find_messages(data: bytes, hints: Integers, most: int) -> MessageTable:
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

    Returns
    -------
    MessageTable
        Its data end where the whole records end.

    Raises
    ------
    ContradictionError
        If a message is too short to be one.
    ExcessError
        If there are more records.
    """
    hinted = _hinted(data, hints)
    others, starts, left, end = list[Place](), array("q"), most - len(hinted.starts), len(data)
    before, behind = np.append(0, hinted.ends), np.append(hinted.starts, end)
    for gap in np.flatnonzero(before != behind).tolist():
        position = int(before[gap])
        for place in records(data, position, int(behind[gap])):
            position, left = place.end, left - 1
            if left < 0:
                raise ExcessError("too many records in chunks for its size")
            if place.opcode == Opcode.MESSAGE and place.end - place.begin < _SHORTEST:
                raise ContradictionError("a message record is too short")
            if place.opcode == Opcode.MESSAGE:
                starts.append(place.start)
            else:
                others.append(place)
        if position != behind[gap] and len(hinted.starts):
            return find_messages(data, NO_HINTS, most)
        if position != behind[gap]:
            end = position
    if not (starts or others) and end == len(data):
        return hinted
    found = np.sort(np.concatenate([hinted.starts, np.frombuffer(starts, dtype=np.int64)]))
    return MessageTable(data[:end], found, tuple(others))


def _hinted(data: bytes, hints: Integers) -> MessageTable:
    """Table of the messages to which hints point, perhaps within each other; empty if what stands there is none."""
    table = MessageTable(data, np.sort(hints))
    if len(hints) and table.starts[0] >= 0 and table.starts[-1] <= len(data) - HEAD.itemsize:
        are_messages = (table.heads["opcode"] == Opcode.MESSAGE) & (table.heads["length"] >= _SHORTEST)
        if are_messages.all():
            return table
    return MessageTable(data, NO_HINTS)
