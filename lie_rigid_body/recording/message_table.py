"""The messages of a chunk as a table: where they stand, of which channel, and when they were logged and published."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from typing import Final

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.recording.chunk import HEAD, OPCODE_AND_LENGTH

LAST_TIME: Final = 2**63 - 1
"""Largest time of a message, ns: ROS 2 counts in 64 bits with a sign."""


class ContradictionError(Exception):
    """A file that does not hold what it says of itself. The message says what."""


class RecordContent(BytesIO):
    """The content of a record: what is said to reach beyond its end is a contradiction, and not cut off there."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes, all of so many."""
        found = super().read(size)
        require(size is None or len(found) >= size, "a length in a record reaches beyond its end")
        return found


@dataclass(frozen=True)
class MessageTable:
    """The messages of a chunk, in file order.

    Parameters
    ----------
    data : bytes
        The records of the chunk.
    starts, ends : ndarray of int64, shape (N,)
        Where each message's record begins and ends.
    channels : ndarray of uint16, shape (N,)
    log_times, publish_times : ndarray of int64, shape (N,)
        ns
    """

    data: bytes
    starts: Integers
    ends: Integers
    channels: NDArray[np.uint16]
    log_times: Integers
    publish_times: Integers

    @classmethod
    def of(cls, data: bytes, starts: Integers, ends: Integers) -> MessageTable:
        """The table of the messages between these places.

        Raises
        ------
        ContradictionError
            If a message is too short to be one, or its times are beyond 64 bits with a sign.
        """
        require(bool((ends - starts >= HEAD.itemsize).all()), "a message record is too short")
        return cls._of_heads(data, starts, ends, _heads(data, starts))

    @classmethod
    def _of_heads(cls, data: bytes, starts: Integers, ends: Integers, heads: NDArray[np.void]) -> MessageTable:
        for name in ("log_time", "publish_time"):
            latest = int(heads[name].max(initial=0))
            require(latest <= LAST_TIME, f"the {name} of a message is {latest} ns, beyond {LAST_TIME}")
        times = (heads[name].astype(np.int64) for name in ("log_time", "publish_time"))
        return cls(data, starts, ends, heads["channel"].copy(), *times)

    @cached_property
    def counts(self) -> dict[int, int]:
        """How many there are of each channel that has any."""
        counts = np.bincount(self.channels)
        return {channel: int(counts[channel]) for channel in np.flatnonzero(counts).tolist()}

    @cached_property
    def span(self) -> tuple[int, int]:
        """The first and the last log time, ns, of one message at least."""
        return int(self.log_times.min()), int(self.log_times.max())

    @classmethod
    def joined(cls, data: bytes, parts: list[MessageTable]) -> MessageTable:
        """The table of all messages of a chunk."""
        if len(parts) == 1:
            return parts[0]
        none = cls.of(data, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
        names = ("starts", "ends", "channels", "log_times", "publish_times")
        return cls(data, *(np.concatenate([getattr(part, name) for part in (none, *parts)]) for name in names))


def _heads(data: bytes, starts: Integers) -> NDArray[np.void]:
    """The first bytes of message records."""
    if not len(starts):
        return np.empty(0, dtype=HEAD)
    windows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, dtype=np.uint8), HEAD.itemsize)
    heads: NDArray[np.void] = windows[starts].reshape(-1).view(HEAD)
    return heads


class MessageRuns:
    """Messages of a chunk that follow each other without a gap, found from hints where they may begin.

    Parameters
    ----------
    data : bytes
        The chunk.
    hints : ndarray of int64
        Bytes where messages may begin; wrong ones cost time only.
    """

    def __init__(self, data: bytes, hints: Integers) -> None:
        hints = np.sort(hints[(hints >= 0) & (hints <= len(data) - HEAD.itemsize)])
        hints = hints[np.diff(hints, prepend=-1) > 0]
        self._data, self._starts, self._heads = data, hints, _heads(data, hints)
        lengths = self._heads["length"]
        sound = (self._heads["opcode"] == Opcode.MESSAGE) & (lengths <= len(data))
        self._ends = hints + OPCODE_AND_LENGTH + np.where(sound, lengths, 0).astype(np.int64)
        sound &= (self._ends <= len(data)) & (self._ends - hints >= HEAD.itemsize)
        self._sound = sound
        goes_on = sound[:-1] & sound[1:] & (self._ends[:-1] == hints[1:])
        self._last = np.append(np.flatnonzero(~goes_on), len(hints) - 1)

    def at(self, position: int) -> MessageTable | None:
        """The messages of the run that begins at a byte, if one does."""
        i = int(np.searchsorted(self._starts, position))
        if i == len(self._starts) or self._starts[i] != position or not self._sound[i]:
            return None
        run = slice(i, int(self._last[np.searchsorted(self._last, i)]) + 1)
        return MessageTable._of_heads(self._data, self._starts[run], self._ends[run], self._heads[run])


def require(holds: bool, otherwise: str) -> None:
    """Raise what is otherwise a contradiction."""
    if not holds:
        raise ContradictionError(otherwise)
