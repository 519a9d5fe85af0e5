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
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, McapRecord, Metadata, Schema
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Integers, items
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.wording import program
from lie_rigid_body.system.bounded_input import MAX_CHUNK_BYTES, open_file
from lie_rigid_body.system.output_file import reason

MAGIC: Final = b"\x89MCAP0\r\n"
"""The first and the last bytes of an MCAP file, as mcap.writer has them, which takes long to load."""
RESCUE: Final = f"'{program('recover')} BROKEN -o FIXED'"
"""The command that makes a whole bag of one that was cut off. ``ros2 bag reindex`` is none: it corrects nothing."""
CHANGED: Final = "changed while it was read: try again when nobody writes it"
"""Words behind the path of a file that another process changed."""
METADATA: Final = "lie_rigid_body"
"""Name of the metadata record that ends a finished bag, with the number of its samples."""
CUT_OFF: Final = "lie_rigid_body_cut_off"
"""Name of the metadata record that ends a bag recovered of a file that was cut off, with the place where it was."""
REWRITTEN: Final = "; rewritten by lie_rigid_body "
"""Part of the writer's name of a bag that this package rewrote from a recorder's; the recorder's name stands before."""
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
MAX_TIME: Final = 2**63 - 1
"""Largest time of a message, ns: ROS 2 counts in 64 bits with a sign."""
MAX_RECORD_BYTES: Final = MAX_CHUNK_BYTES + 2**16
"""Largest size of a record."""
NO_HINTS: Final = np.empty(0, dtype=np.int64)
WITH_MESSAGES: Final = (Opcode.CHUNK, Opcode.MESSAGE)
"""Records that are messages or contain them."""
_TOGETHER: Final[dict[tuple[int, int], int]] = {
    (Opcode.CHUNK, Opcode.MESSAGE_INDEX): MAX_RECORD_BYTES,
    (Opcode.MESSAGE, Opcode.MESSAGE): 2**20,
}
"""Reach in bytes, by kinds of records: records of these kinds within it are read together with the first."""
MAX_DEFINITIONS: Final = 2 * 2**16
"""Largest number of schemas and channels of a chunk: each has a number of 16 bits."""
_INDEX_HEAD: Final = struct.Struct("<HI")
"""Channel of a message index, and bytes of its rows."""
_KINDS: Final[dict[int, type[McapRecord]]] = {
    Opcode.HEADER: Header,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.METADATA: Metadata,
    Opcode.ATTACHMENT: Attachment,
}
UNREADABLE: Final = (EOFError, LookupError, McapError, OverflowError, ValueError, struct.error)
"""Errors that the `mcap` library's parsers raise on damaged bytes."""
Rows: TypeAlias = NDArray[np.uint64]
"""Log time, ns, and place in the uncompressed chunk of each message, shape (N, 2), as an index has them."""


class DamageError(ValueError):
    """A file that does not hold what it says of itself. The message says what."""

    sentence: ClassVar = f"is damaged at byte {{at}}: {{what}}: rescue what is whole with {RESCUE}"


class ExcessError(DamageError):
    """A file that holds more than is read. The message says what."""

    sentence: ClassVar = "has at byte {at} {what}, more than is read: record it again"


class UnknownCompressionError(DamageError):
    """A chunk that is compressed in a way that is not known here. The message names it."""

    sentence: ClassVar = "is compressed with {what}, which is unknown here: rewrite it with 'mcap compress'"


def require(holds: bool, otherwise: str) -> None:
    """Raise what is otherwise a damage."""
    if not holds:
        raise DamageError(otherwise)


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
        self.path = path
        try:
            self._stream = open_file(path)
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
        start = position
        begin = start + RECORD_HEAD.size
        position = begin + length
        if opcode == 0 or position > end:
            return
        yield Place(opcode, start, begin, position)


def parts(file: FileBytes) -> Iterator[Place]:
    """Whole records of a file up to its footer, some together: a chunk with its indexes, and messages in no chunk.

    The opcode is that of the first record of a part, and its content begins where that of the first one does.
    """
    part: Place | None = None
    for place in records(file, len(MAGIC)):
        if part is not None and place.end - part.start <= _TOGETHER.get((part.opcode, place.opcode), 0):
            part = part._replace(end=place.end)
            continue
        if part is not None:
            yield part
        part = place
        if place.opcode == Opcode.FOOTER:
            break
    if part is not None:
        yield part


def parsed(opcode: int, content: bytes) -> Any:
    """Record of the `mcap` library of some kind and content; None of a kind of which nothing is read.

    Bytes behind its fields belong to versions of the format to come.

    Raises
    ------
    DamageError
        If it is none of its kind.
    """
    kind: Any = _KINDS.get(opcode)
    if kind is None:
        return None
    name = kind.__name__.lower()
    try:
        record = kind.read(ReadDataStream(BytesIO(content)))
    except UNREADABLE:
        raise DamageError(f"a record that is no {name}") from None
    # the library takes the end of the content for that of a field; data of a chunk have a size of their own
    is_whole = kind in (Chunk, Attachment) or content.startswith(record_bytes(record)[RECORD_HEAD.size :])
    require(is_whole, f"the fields of a {name} have other lengths than they say")
    return record


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
    definitions : tuple of Place
        The schemas and channels among them, where they were looked for.
    """

    data: bytes
    starts: Integers
    definitions: tuple[Place, ...] = ()

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
        """The earliest and the latest log time, ns; `MAX_TIME` and 0 without messages."""
        times = self.heads["log_time"]  # from 2^63 on as well: a damaged one may be anything
        return int(times.min(initial=MAX_TIME)), int(times.max(initial=0))

    @cached_property
    def index(self) -> dict[int, Rows]:
        """Rows of each channel that has messages, in their order; the channels in that of their first messages."""
        order = np.argsort(self.heads["channel"], kind="stable")
        rows = np.empty((len(order), 2), dtype="<u8")
        rows[:, 0] = self.heads["log_time"][order]
        rows[:, 1] = self.starts[order]
        counts = np.bincount(self.heads["channel"])
        channels = np.flatnonzero(counts)
        parts = zip(channels.tolist(), np.split(rows, np.cumsum(counts[channels])[:-1]), strict=False)
        return dict(sorted(parts, key=lambda part: int(part[1][0, 1])))


def chunk_of(raw: bytes) -> tuple[Chunk | None, Integers]:
    """Chunk of a part of a file, and the places that the indexes behind it name; None and no places of messages."""
    if raw[0] != Opcode.CHUNK:
        return None, NO_HINTS
    first, *behind = records(raw)
    hints = [_index(raw[place.begin : place.end]) for place in behind]
    return parsed(Opcode.CHUNK, raw[first.begin : first.end]), np.concatenate([NO_HINTS, *hints])


def _index(content: bytes) -> Integers:
    """Places in a message index, as far as it is whole."""
    _, size = _INDEX_HEAD.unpack(content[: _INDEX_HEAD.size].ljust(_INDEX_HEAD.size, b"\0"))
    rows = content[_INDEX_HEAD.size : _INDEX_HEAD.size + size]
    return np.frombuffer(rows[: len(rows) // 16 * 16], "<i8")[1::2]


def find_messages(data: bytes, hints: Integers = NO_HINTS) -> MessageTable:
    """Find the messages and definitions among records; those of other kinds are left to others.

    Parameters
    ----------
    data : bytes
        Records one after the other.
    hints : ndarray of int64, optional
        Bytes where messages may begin, as indexes say: of those there, no record has to be looked at one by one.
        Wrong ones cost time only.

    Returns
    -------
    MessageTable
        Its data end where the whole records end.

    Raises
    ------
    DamageError
        If a message is too short to be one.
    """
    hinted = _hinted(data, hints)
    definitions = list[Place]()
    starts = array("q")
    end = len(data)
    before = np.append(0, hinted.ends)
    behind = np.append(hinted.starts, end)
    for gap in np.flatnonzero(before != behind).tolist():
        position = int(before[gap])
        for place in records(data, position, int(behind[gap])):
            position = place.end
            if place.opcode == Opcode.MESSAGE:
                require(place.end - place.start >= HEAD.itemsize, "a message record is too short")
                starts.append(place.start)
            elif place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                require(len(definitions) < MAX_DEFINITIONS, f"a chunk of over {MAX_DEFINITIONS} definitions")
                definitions.append(place)
        if position != behind[gap] and len(hinted.starts):
            return find_messages(data)
        if position != behind[gap]:
            end = position
    found = np.sort(np.concatenate([hinted.starts, np.frombuffer(starts, dtype=np.int64)]), kind="stable")
    return MessageTable(data[:end], found, tuple(definitions))


def _hinted(data: bytes, hints: Integers) -> MessageTable:
    """Table of the messages to which hints point, perhaps within each other; empty if what stands there is none."""
    table = MessageTable(data, np.sort(hints, kind="stable"))  # which merges what is in order already
    is_within = len(hints) and table.starts[0] >= 0 and table.starts[-1] <= len(data) - HEAD.itemsize
    least = HEAD.itemsize - RECORD_HEAD.size
    if is_within and ((table.heads["opcode"] == Opcode.MESSAGE) & (table.heads["length"] >= least)).all():
        return table
    return MessageTable(data, NO_HINTS)
