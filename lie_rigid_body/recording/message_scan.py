"""The messages of a chunk, found and decoded by compiled loops. What these cannot do is left to the general way."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.compilation import Work, kernel
from lie_rigid_body.recording.inventory import MessageTable

_MESSAGE: Final = 5
_RECORD_HEAD: Final = 9
_HEAD: Final = 31
"""Bytes before the payload of a message record; see `chunk.HEAD`."""
_U: Final = tuple(np.uint64(k) for k in range(64))
"""Unsigned numbers: a compiler need not ask whether a place of that kind is negative."""
_SECOND: Final = np.uint64(1_000_000_000)
_MOST_FOUND: Final = 65_536
"""Messages that are found at once, so that a table stays small however large the chunk is."""
_ENOUGH: Final = 4_000_000
"""Number of messages from which on compiling pays: finding and decoding them takes some seconds otherwise."""
_ENOUGH_TO_LOAD: Final = 400_000
"""The same where it is compiled already."""


@kernel
def half_word(data: Any, at: Any) -> Any:
    """The unsigned integer of four bytes, little-endian; a compiler makes one load of it."""
    return (
        np.uint64(data[at])
        | np.uint64(data[at + _U[1]]) << _U[8]
        | np.uint64(data[at + _U[2]]) << _U[16]
        | np.uint64(data[at + _U[3]]) << _U[24]
    )


@kernel
def word(data: Any, at: Any) -> Any:
    """The integer of eight bytes, little-endian."""
    return np.int64(
        np.uint64(data[at])
        | np.uint64(data[at + _U[1]]) << _U[8]
        | np.uint64(data[at + _U[2]]) << _U[16]
        | np.uint64(data[at + _U[3]]) << _U[24]
        | np.uint64(data[at + _U[4]]) << _U[32]
        | np.uint64(data[at + _U[5]]) << _U[40]
        | np.uint64(data[at + _U[6]]) << _U[48]
        | np.uint64(data[at + _U[7]]) << _U[56]
    )


@kernel
def channel_at(data: Any, at: Any) -> Any:
    """The channel of the message whose record begins at a byte."""
    return np.int64(np.uint64(data[at + _U[9]]) | np.uint64(data[at + _U[10]]) << _U[8])


def find_messages(data: Any, place: Any, table: Any) -> None:
    """Fill a row for each message from a byte on, until something else follows, or the table is full.

    Parameters
    ----------
    data : ndarray of uint8
        The records of a chunk.
    place : ndarray of int64, shape (2,)
        The byte, moved behind the last message; and the number of messages found.
    table : ndarray of int64, shape (N, 5)
        Of each message where its record begins and ends, channel, log time and time of publishing, ns.
    """
    at, found, size = np.int64(place[0]), 0, np.int64(len(data))
    while found < len(table) and at + _HEAD <= size and data[np.uint64(at)] == _MESSAGE:
        here = np.uint64(at)
        length = word(data, here + _U[1])
        if length < _HEAD - _RECORD_HEAD or length > size - at - _RECORD_HEAD:
            break
        log_time, publish_time = word(data, here + _U[15]), word(data, here + _U[23])
        if log_time < 0 or publish_time < 0:
            break
        end = at + _RECORD_HEAD + length
        table[found, 0], table[found, 1], table[found, 2] = at, end, channel_at(data, here)
        table[found, 3], table[found, 4] = log_time, publish_time
        found += 1
        at = end
    place[0], place[1] = at, found


def take_messages(
    data: Any, channel: int, pattern: Any, same: int, start: int, place: Any, log_times: Any, stamps: Any, words: Any
) -> None:
    """Decode the messages of a channel, as long as they are laid out as one that is known.

    Parameters
    ----------
    data : ndarray of uint8
        The records of a chunk, which are sound.
    channel : int
    pattern : ndarray of uint8
        The payload of a message that is known.
    same : int
        Its bytes up to this one, but for those of the stamp, are the same in every message; 0: those of the
        encapsulation alone, as there is no header.
    start : int
        The byte of a payload where its numbers begin.
    place : ndarray of int64, shape (2,)
        The number of messages taken, and 1 if all are laid out so.
    log_times, stamps : ndarray of int64, shape (N,)
    words : ndarray of int64, shape (N, numbers)
        The bits of their numbers.
    """
    at, taken, size, alike = np.int64(0), 0, np.int64(len(data)), 1
    while alike == 1 and at + _RECORD_HEAD <= size:
        here = np.uint64(at)
        end = at + _RECORD_HEAD + word(data, here + _U[1])
        if data[here] == _MESSAGE and channel_at(data, here) == channel:
            payload = here + _U[31]
            if end - at - _HEAD != len(pattern):
                alike = 0
                break
            different = (data[payload] != pattern[0]) | (data[payload + _U[1]] != pattern[1])
            for k in range(12, same):
                different |= data[payload + np.uint64(k)] != pattern[np.uint64(k)]
            seconds, nanoseconds = half_word(data, payload + _U[4]), half_word(data, payload + _U[8])
            if different or (same > 0 and nanoseconds >= _SECOND):
                alike = 0
                break
            log_times[taken] = word(data, here + _U[15])
            # the seconds have a sign
            stamps[taken] = (np.int64(seconds << _U[32]) >> 32) * 1_000_000_000 + np.int64(nanoseconds)
            for k in range(words.shape[1]):
                words[taken, k] = word(data, payload + np.uint64(start + 8 * k))
            taken += 1
        at = end
    place[0], place[1] = taken, alike


_BYTES: Final = "Array(uint8, 1, 'C', True)"
FIND: Final = Work(find_messages, f"void({_BYTES}, int64[::1], int64[:,::1])", _ENOUGH, _ENOUGH_TO_LOAD)
"""`find_messages`, compiled as soon as that pays."""
TAKE: Final = Work(
    take_messages,
    f"void({_BYTES}, int64, {_BYTES}, int64, int64, int64[::1], int64[::1], int64[::1], int64[:,::1])",
    _ENOUGH,
    _ENOUGH_TO_LOAD,
)
"""`take_messages`, compiled as soon as that pays."""


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
        self._table = np.empty((min(len(data) // _HEAD + 1, _MOST_FOUND), 5), dtype=np.int64)

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
    take : callable
        `take_messages` compiled.
    payload : bytes
        Of a message that can be decoded, in little-endian order.
    start : int
        Where its numbers begin.
    frame_end : int
        Where the frame name of its header ends; 0: it has no header.
    """

    def __init__(self, take: Any, payload: bytes, start: int, frame_end: int) -> None:
        self._take, self._pattern = take, np.frombuffer(payload, dtype=np.uint8)
        self._start, self._same = start, frame_end

    def most_in(self, data: bytes) -> int:
        """How many messages of the topic a chunk may hold."""
        return len(data) // (_HEAD + len(self._pattern)) + 1

    def take(self, data: bytes, channel: int, log_times: Integers, stamps: Integers, values: Array) -> int | None:
        """Decode a channel's messages in a chunk; None if one is laid out otherwise.

        Parameters
        ----------
        data : bytes
        channel : int
        log_times, stamps : ndarray of int64, shape (`most_in`,) or longer
            Filled with times, ns.
        values : ndarray, shape (`most_in`, numbers) or longer
            Filled with the numbers.

        Returns
        -------
        int or None
            How many there are.
        """
        place = np.zeros(2, dtype=np.int64)
        content, words = np.frombuffer(data, dtype=np.uint8), values.view(np.int64)
        self._take(content, channel, self._pattern, self._same, self._start, place, log_times, stamps, words)
        taken, alike = place.tolist()
        return int(taken) if alike else None
