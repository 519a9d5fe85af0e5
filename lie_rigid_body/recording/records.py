"""Records of an MCAP file, found in one way in a file and in a chunk, and parsed within their bounds."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from lie_rigid_body.bounded_input import (
    LARGEST_ATTACHMENT,
    LARGEST_DEFINITION,
    LARGEST_METADATA,
    LONGEST_NAME,
    open_file,
)
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording.output_file import reason

MAGIC: Final = b"\x89MCAP0\r\n"
"""The first and the last bytes of an MCAP file, as mcap.writer has them, which takes long to load."""
RECORD_HEAD: Final = struct.Struct("<BQ")
"""Opcode of a record and length of its content."""
_KINDS: Final[dict[int, type[McapRecord]]] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.METADATA: Metadata,
    Opcode.ATTACHMENT: Attachment,
    Opcode.STATISTICS: Statistics,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
}


class ContradictionError(ValueError):
    """A file that does not hold what it says of itself. The message says what."""

    sentence: ClassVar = "is damaged at byte {at}: {what}: restore a copy, or record again"


class ExcessError(ContradictionError):
    """A file that holds more than is read. The message says what."""

    sentence: ClassVar = "has at byte {at} {what}, more than is read: record it again"


class UnknownCompressionError(ContradictionError):
    """A chunk that is compressed in a way that is not known here. The message names it."""

    sentence: ClassVar = "is compressed with {what}, which is unknown here: rewrite it with 'mcap compress'"


def require(holds: bool, otherwise: str) -> None:
    """Raise what is otherwise a contradiction."""
    if not holds:
        raise ContradictionError(otherwise)


class Place(NamedTuple):
    """Opcode of a record, where it starts, and where its content begins and ends."""

    opcode: int
    start: int
    begin: int
    end: int


class FileBytes:
    """Bytes of a file, of which a slice is read when it is taken. Use it as a context, which closes the file.

    Parameters
    ----------
    path : Path

    Raises
    ------
    BagError
        If the file cannot be opened, or later not be read.
    """

    def __init__(self, path: Path) -> None:
        try:
            self.path, self._stream = path, open_file(path)
        except InputError as error:
            raise BagError(str(error)) from None
        except FileNotFoundError:
            raise BagError(f"{path} does not exist: give the path of an MCAP file") from None
        except (OSError, ValueError) as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: give another file") from None
        self._size = self.state()[2]

    def state(self) -> tuple[int, ...]:
        """Identity of the file, its size, and when it was written to: what changes when it does."""
        status = os.fstat(self._stream.fileno())
        return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, part: slice) -> bytes:
        begin, end, _ = part.indices(self._size)
        try:
            self._stream.seek(begin)
            return self._stream.read(max(0, end - begin))
        except OSError as error:
            raise BagError(f"{self.path} cannot be read: {reason(error)}: copy it to a better place") from None

    def __enter__(self) -> FileBytes:
        return self

    def __exit__(self, *error: object) -> None:
        self._stream.close()


def records(data: bytes | FileBytes, position: int = 0, end: int | None = None) -> Iterator[Place]:
    """Whole records that follow each other from a byte on, until none stands there that ends before the end."""
    end = len(data) if end is None else end
    while position + RECORD_HEAD.size <= end:
        opcode, length = RECORD_HEAD.unpack(data[position : position + RECORD_HEAD.size])
        start, begin, position = position, position + RECORD_HEAD.size, position + RECORD_HEAD.size + length
        if opcode == 0 or position > end:
            return
        yield Place(opcode, start, begin, position)


class _Content(BytesIO):
    """Content of a record: what is said to reach beyond its end is a contradiction, and not cut off there."""

    def read(self, size: int | None = -1, /) -> bytes:
        found = super().read(size)
        require(size is None or len(found) >= size, "a length in a record reaches beyond its end")
        return found


def parsed(opcode: int, content: bytes) -> Any:
    """Record of the `mcap` library of some kind and content; None of a kind that it does not know."""
    kind: Any = _KINDS.get(opcode)
    record = kind and kind.read(ReadDataStream(_Content(content)))
    for name, value in vars(record).items() if record else ():
        limit = _limit(record, value)
        if limit is not None and (size := size_of(value)) > limit:
            raise ExcessError(f"a {name} of {size} bytes in a {kind.__name__.lower()}")
        if isinstance(value, dict) and isinstance(record, ChunkIndex | Statistics):  # maps of numbers are read beyond
            is_same = content.startswith(record_bytes(record)[RECORD_HEAD.size :])
            require(is_same, f"the {name} of a {kind.__name__.lower()} have another length than is said")
    return record


def _limit(record: McapRecord, value: object) -> int | None:
    """Largest size of a field of a record, bytes; None where the record's own is enough."""
    if isinstance(value, str):
        return LONGEST_NAME
    if isinstance(record, Schema | Attachment) and isinstance(value, bytes):
        return LARGEST_DEFINITION if isinstance(record, Schema) else LARGEST_ATTACHMENT
    return LARGEST_METADATA if isinstance(record, Channel | Metadata) and isinstance(value, dict) else None


def size_of(value: object) -> int:
    """Size of a name, a definition or metadata: of texts the characters, 0 of a number."""
    if isinstance(value, dict):
        return sum(len(name) + size_of(text) for name, text in value.items())
    return len(value) if isinstance(value, str | bytes) else 0


def record_bytes(*records: McapRecord) -> bytes:
    """The bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
