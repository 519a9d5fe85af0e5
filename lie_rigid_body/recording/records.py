"""Records of an MCAP file, found in one way in a file and in a chunk, parsed within bounds; messages as a table."""

from __future__ import annotations

import os
import struct
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple, TypeAlias

import numpy as np
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
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Integers, items
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.system.bounded_input import (
    LARGEST_ATTACHMENT,
    LARGEST_CHUNK,
    LARGEST_DEFINITION,
    LARGEST_METADATA,
    LONGEST_NAME,
    open_file,
)
from lie_rigid_body.system.output_file import reason

MAGIC: Final = b"\x89MCAP0\r\n"
"""The first and the last bytes of an MCAP file, as mcap.writer has them, which takes long to load."""
RESCUE: Final = "'lie-rigid-body recover BROKEN -o FIXED'"
"""The command that makes a whole bag of one that was cut off. ``ros2 bag reindex`` is none: it mends nothing."""
CHANGED: Final = "changed while it was read: try again when nobody writes it"
"""What is said of a file behind its path."""
RECORD_HEAD: Final = struct.Struct("<BQ")
"""Opcode of a record and length of its content."""
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
MESSAGE: Final = struct.Struct("<HIQQ")
"""Channel, sequence, log time and publish time at the beginning of the content of a message."""
LAST_TIME: Final = 2**63 - 1
"""Largest time of a message, ns: ROS 2 counts in 64 bits with a sign."""
LARGEST_RECORD: Final = LARGEST_CHUNK + 2**16
"""Largest size of a record, bytes."""
_CRC_SIZE: Final = 4
"""Bytes of the checksum at the end of an attachment."""
NO_HINTS: Final = np.empty(0, dtype=np.int64)
Rows: TypeAlias = NDArray[np.uint64]
"""Log time, ns, and place in the uncompressed chunk of each message, shape (N, 2), as an index has them."""
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
_LIMITS: Final = {
    (Schema, "data"): LARGEST_DEFINITION,
    (Channel, "metadata"): LARGEST_METADATA,
    (Metadata, "metadata"): LARGEST_METADATA,
    (Attachment, "data"): LARGEST_ATTACHMENT,
}
"""Largest sizes of the fields that are no names, bytes, where that of the record is not enough."""


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
    """Bytes of a file, of which a slice is read when it is taken.

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
            found = self._stream.read(max(0, end - begin))
        except OSError as error:
            raise BagError(f"{self.path} cannot be read: {reason(error)}: copy it to a better place") from None
        if len(found) < end - begin:
            raise BagError(f"{self.path} {CHANGED}")
        return found

    def close(self) -> None:
        """Close the file."""
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

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self._size = len(content)  # a view of the buffer would be a copy

    def read(self, size: int | None = -1, /) -> bytes:
        left = self._size - self.tell()
        require(size is None or size <= left, "a length in a record reaches beyond its end")
        return super().read(size)


def parsed(opcode: int, content: bytes) -> Any:
    """Record of the `mcap` library of some kind and content; None of a kind that it does not know."""
    kind: Any = _KINDS.get(opcode)
    record = kind and kind.read(ReadDataStream(_Content(content)))
    for name, value in vars(record).items() if record else ():
        limit = LONGEST_NAME if isinstance(value, str) else _LIMITS.get((kind, name), len(content))
        if (size := size_of(value)) > limit:
            raise ExcessError(f"a {name} of {size} bytes in a {kind.__name__.lower()}")
        if isinstance(value, dict):  # maps are read beyond their ends
            require(
                content.startswith(record_bytes(record)[RECORD_HEAD.size :]),
                f"the {name} of a {kind.__name__.lower()} have another length than is said",
            )
    if isinstance(record, Attachment):
        own = record_bytes(record)[RECORD_HEAD.size :]
        declared = content[len(own) - _CRC_SIZE : len(own)]
        require(declared in (bytes(_CRC_SIZE), own[-_CRC_SIZE:]), "the crc of an attachment is another one")
    return record


def size_of(value: object) -> int:
    """Size of a name, a definition or metadata: of texts the characters, 0 of a number."""
    if isinstance(value, dict):
        return sum(size_of(name) + size_of(text) for name, text in value.items())
    return len(value) if isinstance(value, str | bytes) else 0


def record_bytes(*records: McapRecord) -> bytes:
    """The bytes of records, one after the other."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


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
        The records that are no messages, or too short to be one, where they were looked for.
    """

    data: bytes
    starts: Integers
    others: tuple[Place, ...] = ()

    @cached_property
    def heads(self) -> NDArray[np.void]:
        """First bytes of the messages, of type `HEAD`, shape (N,)."""
        return items(self.data, self.starts, HEAD.itemsize).view(HEAD)

    @cached_property
    def ends(self) -> Integers:
        """Ends of the records of the messages, shape (N,); what reaches beyond the data ends somewhere there."""
        lengths = np.minimum(self.heads["length"], len(self.data)).astype(np.int64)
        return np.asarray(self.starts + RECORD_HEAD.size + lengths)

    @cached_property
    def span_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time, ns; `LAST_TIME` and 0 without messages."""
        times = self.heads["log_time"].view(np.int64)
        return int(times.min(initial=LAST_TIME)), int(times.max(initial=0))

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
            if place.opcode == Opcode.MESSAGE and place.end - place.begin >= MESSAGE.size:
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
    is_within = len(hints) and table.starts[0] >= 0 and table.starts[-1] <= len(data) - HEAD.itemsize
    if is_within and ((table.heads["opcode"] == Opcode.MESSAGE) & (table.heads["length"] >= MESSAGE.size)).all():
        return table
    return MessageTable(data, NO_HINTS)
