"""Loops over the records of a chunk, compiled where that pays.

They stand by themselves: the name of compiled code follows from every file that its own imports.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from lie_rigid_body.compilation import Work, kernel

_MESSAGE: Final = 5
_RECORD_HEAD: Final = 9
HEAD: Final = 31
"""Bytes before the payload of a message record; see `chunk.HEAD`."""
_U: Final = tuple(np.uint64(k) for k in range(64))
"""Unsigned numbers: a compiler need not ask whether a place of that kind is negative."""
_SECOND: Final = np.uint64(1_000_000_000)
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
    while found < len(table) and at + HEAD <= size and data[np.uint64(at)] == _MESSAGE:
        here = np.uint64(at)
        length = word(data, here + _U[1])
        if length < HEAD - _RECORD_HEAD or length > size - at - _RECORD_HEAD:
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
    data: Any, layouts: Any, alike: Any, places: Any, taken: Any, log_times: Any, stamps: Any, words: Any
) -> None:
    """Decode the messages of some topics, as long as each is laid out as one of its topic that is known.

    Parameters
    ----------
    data : ndarray of uint8
        The records of a chunk, which are sound.
    layouts : ndarray of int64, shape (topics, 9)
        Of each topic its channel, or -1 if none is to be taken; size of each payload, bytes; whether a header with a
        stamp comes first; its first row of ``alike`` and the one behind its last; the same of ``places``; and where
        its times and its words begin.
    alike : ndarray of int64, shape (K, 3)
        Eight bytes each that are the same in all messages: where they begin in a payload, the bits, and which of them.
    places : ndarray of int64, shape (numbers,)
        Where in a payload the numbers begin that are wanted.
    taken : ndarray of int64, shape (topics, 2)
        How many messages were taken before, moved on; and 1, set to 0 if one is laid out otherwise.
    log_times, stamps : ndarray of int64, shape (N,)
    words : ndarray of int64, shape (M,)
        The bits of their numbers.
    """
    at, length = np.int64(0), np.int64(len(data))
    while at + _RECORD_HEAD <= length:
        here = np.uint64(at)
        end = at + _RECORD_HEAD + word(data, here + _U[1])
        channel = channel_at(data, here) if data[here] == _MESSAGE else np.int64(-2)
        for k in range(len(layouts)):
            topic = np.uint64(k)
            if layouts[topic, 0] != channel or taken[topic, 1] == 0:
                continue
            payload, different = here + _U[31], np.int64(0)
            if end - at - HEAD != layouts[topic, 1]:
                taken[topic, 1] = 0
                break
            for n in range(np.uint64(layouts[topic, 3]), np.uint64(layouts[topic, 4])):
                different |= (word(data, payload + np.uint64(alike[n, 0])) ^ alike[n, 1]) & alike[n, 2]
            seconds, nanoseconds = half_word(data, payload + _U[4]), half_word(data, payload + _U[8])
            if different != 0 or (layouts[topic, 2] > 0 and nanoseconds >= _SECOND):
                taken[topic, 1] = 0
                break
            begin, behind = np.uint64(layouts[topic, 5]), np.uint64(layouts[topic, 6])
            row, row_words = np.uint64(taken[topic, 0]), np.uint64(layouts[topic, 8])
            row_words += row * (behind - begin) - begin
            row += np.uint64(layouts[topic, 7])
            log_times[row] = word(data, here + _U[15])
            # the seconds have a sign
            stamps[row] = (np.int64(seconds << _U[32]) >> 32) * 1_000_000_000 + np.int64(nanoseconds)
            for n in range(begin, behind):
                words[row_words + n] = word(data, payload + np.uint64(places[n]))
            taken[topic, 0] += 1
            break
        at = end


_BYTES: Final = "Array(uint8, 1, 'C', True)"
FIND: Final = Work(find_messages, f"void({_BYTES}, int64[::1], int64[:,::1])", _ENOUGH, _ENOUGH_TO_LOAD)
"""`find_messages`, compiled as soon as that pays."""
TAKE: Final = Work(
    take_messages,
    f"void({_BYTES}, int64[:,::1], int64[:,::1], int64[::1], int64[:,::1], int64[::1], int64[::1], int64[::1])",
    _ENOUGH,
    _ENOUGH_TO_LOAD,
)
"""`take_messages`, compiled as soon as that pays."""


def expect(messages: int) -> None:
    """Take notice that so many messages will be read, so that all of that is done compiled if it pays."""
    FIND.compiled_for(messages)
    TAKE.compiled_for(messages)


def are_compiled() -> bool:
    """Whether both loops are compiled and loaded."""
    return FIND.compiled_for(0) is not None and TAKE.compiled_for(0) is not None
