"""The messages of a chunk, found and decoded by compiled loops. What these cannot do is left to the general way."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.messages.layout import FRAME
from lie_rigid_body.recording.message_loops import HEAD
from lie_rigid_body.recording.message_table import MessageTable

_MOST_FOUND: Final = 65_536
"""Messages that are found at once, so that a table stays small however large the chunk is."""


class FoundMessages:
    """The messages of a chunk that follow each other without a gap, found by the compiled loop.

    Parameters
    ----------
    find : callable
        `find_messages` compiled.
    data : bytes
        The chunk.
    """

    def __init__(self, find: Any, data: bytes) -> None:
        self._find, self._data, self._bytes = find, data, np.frombuffer(data, dtype=np.uint8)
        self._table = np.empty((min(len(data) // HEAD + 1, _MOST_FOUND), 5), dtype=np.int64)

    def at(self, position: int) -> MessageTable | None:
        """The messages that follow each other from a byte on, if one begins there."""
        place = np.array([position, 0])
        self._find(self._bytes, place, self._table)
        if not place[1]:
            return None
        starts, ends, channels, log_times, publish_times = self._table[: place[1]].T.copy()
        return MessageTable(self._data, starts, ends, channels.astype(np.uint16), log_times, publish_times)


class Layout:
    """How the messages of a topic are laid out, by one of them.

    Parameters
    ----------
    payload : bytes
        Of a message that can be decoded, in little-endian order.
    start : int
        Where its numbers begin.
    frame_end : int
        Where the frame name of its header ends; 0: it has no header.
    varying : ndarray of bool, shape (numbers,)
        Which of its numbers are wanted; the others are the same in all messages that are laid out so.

    Attributes
    ----------
    size, stamped : int
    alike, places : ndarray of int64
        As `take_messages` wants them.
    """

    def __init__(self, payload: bytes, start: int, frame_end: int, varying: Booleans) -> None:
        self.size, self.stamped = len(payload), int(frame_end > 0)
        alike = np.zeros(len(payload), dtype=np.uint8)
        alike[:2] = alike[FRAME - 4 : frame_end] = 255
        alike[start : start + 8 * len(varying)] = np.repeat(np.where(varying, 0, 255), 8)
        self.alike = _words(np.frombuffer(payload, dtype=np.uint8), alike)
        self.places = start + 8 * np.flatnonzero(varying)


def _words(payload: NDArray[np.uint8], which: NDArray[np.uint8]) -> Integers:
    """The bytes of a payload that a mask has, by eights: where they begin, the bits, and the mask; shape (K, 3)."""
    starts = [*range(0, len(payload) - 8, 8), len(payload) - 8]
    rows = [(at, *(int(part[at : at + 8].copy().view("<i8")[0]) for part in (payload, which))) for at in starts]
    return np.array([row for row in rows if row[2]], dtype=np.int64).reshape(-1, 3)
