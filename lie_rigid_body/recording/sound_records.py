"""Whether a record of the right length stands at a byte of a damaged MCAP file: by what it says, or what follows it."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from typing import Final

import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from lie_rigid_body.recording.records import HEAD, LARGEST_RECORD, MAGIC, RECORD_HEAD, FileBytes, Place, records

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
_MESSAGE_HEAD: Final = re.compile(rb"\x05(?=.{4}\0{4})", re.DOTALL)
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


def whole_records(data: bytes, span_ns: tuple[int, int]) -> Iterator[Place]:
    """Records in the data of a damaged chunk that are whole: behind each of them another one begins, or the data end.

    Another one may have lost or won some bytes: then the search goes on where the next message of the chunk's times
    begins.

    Parameters
    ----------
    data : bytes
    span_ns : (int, int)
        The earliest and the latest log time of the chunk.
    """
    at = 0
    while at + RECORD_HEAD.size <= len(data):
        opcode, length = RECORD_HEAD.unpack_from(data, at)
        end = at + RECORD_HEAD.size + length
        is_other = any(data[end : end + RECORD_HEAD.size]) and _begins(data, _end(data, end), span_ns)
        if _begins(data, end, span_ns) or is_other:  # whose kind is damaged, or unknown
            yield Place(opcode, at, at + RECORD_HEAD.size, end)
            at = end
        else:
            heads = (found.start() for found in _MESSAGE_HEAD.finditer(data, at + 1))
            at = next((head for head in heads if _begins(data, head, span_ns)), len(data))


def _end(data: bytes, at: int) -> int:
    """Byte where the record ends that begins at a byte, be it there or not."""
    return at + RECORD_HEAD.size + int.from_bytes(data[at + 1 : at + RECORD_HEAD.size], "little")


def _begins(data: bytes, at: int, span_ns: tuple[int, int]) -> bool:
    """Whether a record may begin in or behind a chunk, if a message, of its times; or whether the data end there."""
    head = data[at : at + HEAD.itemsize]
    if head.startswith(b"\5") and len(head) == HEAD.itemsize:
        return span_ns[0] <= int.from_bytes(head[15:23], "little") <= span_ns[1]
    is_kind = b"\0" < head[:1] <= bytes([Opcode.DATA_END])
    return at == len(data) or (is_kind and _end(data, at) - at <= LARGEST_RECORD)
