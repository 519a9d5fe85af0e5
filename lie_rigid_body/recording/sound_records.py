"""Whether a record of the right length stands at a byte of a damaged MCAP file: by what it says, or what follows it."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Final

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from lie_rigid_body.recording.records import MAGIC, RECORD_HEAD, FileBytes, Place, records

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
"""Fields of a record in their order: how many bytes they take, or, below 0, those of a size that stands before them."""
OUTSIDE: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT)
"""Records that stand outside of chunks and are written as they are."""
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
        may_be_longer = by_next and place.opcode in (*OUTSIDE, Opcode.CHUNK)  # than its fields
        is_right = says_twice(given, at) or (may_be_longer and sound(given, place.end, by_next=False) is not None)
    return place if is_right else None


def says_twice(given: FileBytes, at: int) -> bool:
    """Whether the record at a byte, be it finished or not, is as long as its fields say; none of these is read."""
    opcode, length = RECORD_HEAD.unpack(given[at : at + RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0"))
    place = begin = at + RECORD_HEAD.size
    for size in _LAYOUTS.get(opcode, ()):
        place += int.from_bytes(given[place : place - size], "little") - size if size < 0 else size
    return opcode in _LAYOUTS and place == begin + length


def goes_on(data: bytes | FileBytes, end: int) -> bool:
    """Whether some data end, or another record begins, where a record ends, which then is whole.

    Where a disk lost power, zeros or other data may stand from the midst of a record on.
    """
    head = data[end : end + RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0")
    opcode, length = RECORD_HEAD.unpack(head)
    return end >= len(data) or 0 < opcode <= Opcode.DATA_END or 0 < length <= len(data) - end - RECORD_HEAD.size


def begins_well(data: bytes, size: int) -> bool:
    """Whether some data, if any, may be the beginning of another record in a chunk of some size."""
    opcode, length = RECORD_HEAD.unpack(data[: RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0"))
    return not data or (opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE) and length <= size)
