"""Whether a record of the right length stands at a byte of a damaged MCAP file: by what it says, or what follows it."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import dropwhile
from typing import Final

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from lie_rigid_body.recording.records import (
    HEAD,
    LARGEST_RECORD,
    LAST_TIME,
    MAGIC,
    RECORD_HEAD,
    FileBytes,
    Place,
    records,
)

_LAYOUTS: Final[Mapping[int, tuple[int, ...]]] = {
    Opcode.HEADER: (-4, -4),
    Opcode.SCHEMA: (2, -4, -4, -4),
    Opcode.CHANNEL: (4, -4, -4, -4),
    Opcode.CHUNK: (28, -4, -8),
    Opcode.MESSAGE_INDEX: (2, -4),
    Opcode.CHUNK_INDEX: (32, -4, 8, -4, 16),
    Opcode.ATTACHMENT: (16, -4, -4, -8, 4),
    Opcode.ATTACHMENT_INDEX: (40, -4, -4),
    Opcode.STATISTICS: (42, -4),
    Opcode.METADATA: (-4, -4),
    Opcode.METADATA_INDEX: (16, -4),
    Opcode.SUMMARY_OFFSET: (17,),
    Opcode.DATA_END: (4,),
}
"""Sizes of the fields of a record, bytes. Of a size -n a number of n bytes stands before the field, and gives it."""
OUTSIDE: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT)
"""Records that stand outside of chunks and are written as they are."""
_MAY_BE_LONGER: Final = (*OUTSIDE, Opcode.CHUNK)
"""Records that may be longer than their fields, which the format allows."""
_NOTHING: Final = Place(0, 0, 0, 0)
_HEAD_IN_CHUNK: Final = re.compile(re.escape(MAGIC) + rb"\x01|[\x03\x04\x05](?=.{4}\0{4})", re.DOTALL)
"""Beginning of a record in a chunk, or of a file that is in a message."""
ENDING: Final = re.compile(rb"(\x02\x14\0{7}.{20})?" + re.escape(MAGIC), re.DOTALL)
"""Magic, behind a footer if it ends a file."""
DAMAGE: Final = (
    ArithmeticError,
    EOFError,
    LookupError,
    McapError,
    RuntimeError,
    ValueError,
    struct.error,
    zstandard.ZstdError,
)
"""Errors that the parsers and decompressors raise on damaged bytes."""


def sound(given: FileBytes, at: int, *, by_next: bool = True) -> Place | None:
    """Record at a byte, if its length is right: by what it says itself, or else by what follows, if that counts."""
    place = next(records(given, at), None)
    if place is None or place.opcode > Opcode.DATA_END:  # of a kind that is unknown nothing is right
        return None
    if place.opcode == Opcode.FOOTER:
        is_right = given[place.end : place.end + len(MAGIC) + 1] == MAGIC
    elif place.opcode == Opcode.MESSAGE:
        is_right = goes_on(given, place.end)
    else:
        is_right = says_twice(given, at)
        if not is_right and by_next and place.opcode in _MAY_BE_LONGER:
            behind = next(records(given, place.end), _NOTHING)
            may_begin = behind.opcode in _MAY_BE_LONGER and says_twice(given, place.end, or_more=True)
            is_right = may_begin or sound(given, place.end, by_next=False) is not None
    return place if is_right else None


def says_twice(given: bytes | FileBytes, at: int, *, or_more: bool = False) -> bool:
    """Whether the record at a byte, be it finished or not, is as long as its fields say, or longer if that will do.

    None of these is read.
    """
    opcode, length = RECORD_HEAD.unpack(given[at : at + RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0"))
    place = begin = at + RECORD_HEAD.size
    for size in _LAYOUTS.get(opcode, ()):
        place += int.from_bytes(given[place : place - size], "little") - size if size < 0 else size
    return opcode in _LAYOUTS and (place == begin + length or (or_more and place < begin + length))


def goes_on(data: bytes | FileBytes, end: int) -> bool:
    """Whether some data end, or another record begins, where a record ends, which then is whole.

    Where a disk lost power, zeros or other data may stand from the midst of a record on.
    """
    head = data[end : end + RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0")
    opcode, length = RECORD_HEAD.unpack(head)
    return end >= len(data) or 0 < opcode <= Opcode.DATA_END or 0 < length <= len(data) - end - RECORD_HEAD.size


def whole_records(data: bytes, span_ns: tuple[int, int], *, is_cut: bool) -> Iterator[Place]:
    """Records in the data of a damaged chunk that are whole: behind each of them another one begins, or the data end.

    Another one may have lost or won some bytes: then the search goes on where the next definition begins, or message
    of the chunk's times.

    Parameters
    ----------
    data : bytes
    span_ns : (int, int)
        The earliest and the latest log time of the chunk.
    is_cut : bool
        Whether the data may end amid a record.
    """
    begins_at, at = partial(begins, data, span_ns=span_ns, is_cut=is_cut), 0
    endings = (found.end() for found in ENDING.finditer(data) if found[1])
    while at + RECORD_HEAD.size <= len(data):
        end = _end(data, at)
        # of the next record the kind may be damaged, or unknown
        if begins_at(end) or (any(data[end : end + RECORD_HEAD.size]) and begins_at(_end(data, end))):
            yield Place(data[at], at, at + RECORD_HEAD.size, end)
            at = end
        else:
            at = next(filter(begins_at, _heads(data, at + 1, endings)), len(data))


def _heads(data: bytes, at: int, endings: Iterator[int]) -> Iterator[int]:
    """Bytes from one on where what looks like a record begins, and not within another file."""
    while found := _HEAD_IN_CHUNK.search(data, at):
        at = found.end()
        if len(found[0]) == 1:
            yield found.start()
        else:
            at = next(dropwhile(at.__ge__, endings), at)


def _end(data: bytes | FileBytes, at: int) -> int:
    """Byte where the record ends that begins at a byte, be it there or not."""
    return at + RECORD_HEAD.size + int.from_bytes(data[at + 1 : at + RECORD_HEAD.size], "little")


def begins(data: bytes | FileBytes, at: int, span_ns: tuple[int, int] = (0, LAST_TIME), *, is_cut: bool = True) -> bool:
    """Whether a record begins in or behind a chunk, if a message, of some times; or whether the data end there."""
    head = data[at : at + HEAD.itemsize]
    if head.startswith(b"\5") and len(head) == HEAD.itemsize:
        return span_ns[0] <= int.from_bytes(head[15:23], "little") <= span_ns[1]
    if at >= len(data) or _end(data, at) <= len(data):
        return at == len(data) or says_twice(data, at)
    return is_cut and 0 < head[0] <= Opcode.DATA_END and _end(data, at) - at <= LARGEST_RECORD
