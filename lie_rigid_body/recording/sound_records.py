"""Whether a record of the right length stands at a byte of a damaged MCAP file: by what it says, or what follows it."""

from __future__ import annotations

import re
import struct
from contextlib import suppress
from typing import Final

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from lie_rigid_body.recording.records import (
    LARGEST_RECORD,
    MAGIC,
    RECORD_HEAD,
    FileBytes,
    Place,
    parsed,
    record_bytes,
    records,
    require,
)

HEADS: Final = {
    Opcode.CHUNK: re.compile(rb"\x06(?=(.{8}).{28}(?:\0{4}|\x03\0{3}lz4|\x04\0{3}zstd)(.{8}))", re.DOTALL),
    Opcode.MESSAGE_INDEX: re.compile(rb"\x07(?=(.{8}).{2}(.{4}))", re.DOTALL),
}
"""Beginnings of records that say their length twice: that of the record, and that of its last field."""
HEAD_SIZE: Final = 64
"""Bytes of which the longest of these takes less."""
_DATA_END_SIZE: Final = 4
"""Bytes of the checksum that ends the data."""
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
    end = place.end
    if place.opcode == Opcode.FOOTER:
        is_right = given[end : end + len(MAGIC) + 1] == MAGIC
    elif place.opcode == Opcode.DATA_END:
        is_right = end - place.begin == _DATA_END_SIZE
    elif place.opcode in HEADS:
        is_right = says_twice(given, at, place.opcode)
    elif place.opcode == Opcode.MESSAGE:
        is_right = goes_on(given, end)
    else:
        is_right = _is_exact(given, place) or (by_next and sound(given, end, by_next=False) is not None)
    return place if is_right else None


def says_twice(given: FileBytes, at: int, opcode: int) -> bool:
    """Whether a record of some kind begins at a byte, and says the same length twice."""
    found = HEADS[Opcode(opcode)].match(given[at : at + HEAD_SIZE])
    length, size = (int.from_bytes(each, "little") for each in found.groups()) if found else (0, 0)
    return found is not None and found.end(2) + size == RECORD_HEAD.size + length


def _is_exact(given: FileBytes, place: Place) -> bool:
    """Whether a record is as long as its fields are."""
    with suppress(*DAMAGE):
        require(place.end - place.begin <= LARGEST_RECORD, "a record is larger than what is read")
        record = parsed(place.opcode, given[place.begin : place.end])
        return len(record_bytes(record)) == place.end - place.start
    return False


def goes_on(data: bytes | FileBytes, end: int) -> bool:
    """Whether some data end, or another record may begin, where a record ends, which then is whole.

    Where a disk lost power, zeros or other data may stand from the midst of a record on.
    """
    head = data[end : end + RECORD_HEAD.size].ljust(RECORD_HEAD.size, b"\0")
    opcode, length = RECORD_HEAD.unpack(head)
    return end >= len(data) or 0 < opcode <= Opcode.DATA_END or 0 < length <= len(data) - end - RECORD_HEAD.size
