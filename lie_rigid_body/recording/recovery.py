"""Recovering the whole messages of an MCAP file that was cut off, into a new file that is whole."""

from __future__ import annotations

import re
import shutil
import struct
from bisect import bisect_right
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import replace
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Header, Metadata

from lie_rigid_body.bounded_input import LONGEST_NAME
from lie_rigid_body.errors import BagError
from lie_rigid_body.output_file import reason, require_other, written
from lie_rigid_body.recording.bag_files import BagFiles, left_out
from lie_rigid_body.recording.bag_writer import CUT_OFF
from lie_rigid_body.recording.inflation import NotOneFrameError, inflated, most_records, salvaged
from lie_rigid_body.recording.mcap_file import McapFile, compressed
from lie_rigid_body.recording.records import (
    LARGEST_RECORD,
    LAST_TIME,
    MAGIC,
    NO_HINTS,
    RECORD_HEAD,
    FileBytes,
    MessageTable,
    Place,
    find_messages,
    parsed,
    record_bytes,
    records,
    require,
)
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.system import real_path

_LOOSE_BYTES: Final = 256 * 1024
"""Size of the chunks into which messages are put that are in none."""
_MESSAGE: Final = struct.Struct("<HIQQ")
_OUTSIDE: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT)
"""Records that stand outside of chunks and are written as they are."""
_HEADS: Final = {
    Opcode.CHUNK: re.compile(rb"\x06(?=(.{8}).{28}(?:\0{4}|\x03\0{3}lz4|\x04\0{3}zstd)(.{8}))", re.DOTALL),
    Opcode.MESSAGE_INDEX: re.compile(rb"\x07(?=(.{8}).{2}(.{4}))", re.DOTALL),
}
"""Beginnings of records that say their length twice: that of the record, and that of its last field."""
_LOOSE_HEAD: Final = re.compile(rb"\x05(?=.{4}\0{4}(.{2}))", re.DOTALL)
"""Beginning of a message of less than 4 GiB, and its channel."""
_HEAD_SIZE: Final = 64
"""Bytes of which the longest of these takes less."""
_PIECE: Final = 2**12
"""Bytes that are looked through at a time."""
_FOOTER_SIZE: Final = RECORD_HEAD.size + 20 + len(MAGIC)
"""Bytes of the footer, and of what follows it."""
_DATA_END_SIZE: Final = 4
"""Bytes of the checksum that ends the data."""
_PRIVATE: Final = 0x80
"""Least opcode of records that others define."""
_DAMAGE: Final = (
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


class NothingWholeError(BagError):
    """Error for a file of which nothing can be recovered."""


@short_dataclass(frozen=True)
class Recovery:
    """Account of what was recovered of a file.

    Parameters
    ----------
    messages, topics : int
    log_times_ns : (int, int)
        The first and the last, ns.
    broken_at : int or None
        Where in the broken file the record begins that is unfinished; None if the file is whole.
    of_the_last : int
        How many of the messages come from that record.
    damaged : tuple of int
        Where records begin that are left out because their content is damaged.
    rewritten : tuple of int
        Where chunks begin that were more than one compressed frame; they are whole, and written without compression.
    """

    messages: int
    topics: int
    log_times_ns: tuple[int, int]
    broken_at: int | None
    of_the_last: int
    damaged: tuple[int, ...]
    rewritten: tuple[int, ...] = ()


def recover(broken: Path, fixed: Path, *, overwrite: bool) -> Recovery:
    """Write every whole message of a file into a new one, which is whole.

    Parameters
    ----------
    broken : Path
        It is only read.
    fixed : Path
    overwrite : bool
        Whether a file of that name may be replaced.

    Returns
    -------
    Recovery

    Raises
    ------
    NothingWholeError
        If the file cannot be opened, or holds no whole message of a topic that is declared.
    BagError
        If it cannot be read to its end, or the new one cannot be written.
    """
    try:
        opened = FileBytes(broken)
    except BagError as error:
        raise NothingWholeError(str(error)) from None
    with closing(opened) as file:
        header, begin = _header(file)
        require_other(fixed, [broken])
        with written(fixed, overwrite=overwrite) as out:
            return _Salvage(file, begin, McapFile(out, header)).run()


def _header(file: FileBytes) -> tuple[Header, int]:
    """Header of a file, and where the records begin: behind its fields, or at the header itself if none is there."""
    begin = len(MAGIC) + RECORD_HEAD.size
    if file[: len(MAGIC) + 1] == MAGIC + bytes([Opcode.HEADER]):
        with suppress(*_DAMAGE):
            header = parsed(Opcode.HEADER, file[begin : begin + 8 * LONGEST_NAME])
            end = len(MAGIC + record_bytes(header))
            return header, end if _goes_on(file, end) else len(MAGIC)
    raise NothingWholeError(f"{file.path} does not begin as an MCAP file: it holds nothing that can be recovered")


class _Salvage:
    """One file, read from its start to where it breaks off, and written anew."""

    def __init__(self, given: FileBytes, begin: int, file: McapFile) -> None:
        self._given, self._begin, self._file = given, begin, file
        self._records_left = most_records(len(given))
        self._loose, self._whole, self._has_chunks = bytearray(), 0, False
        self._damaged, self._rewritten = list[int](), list[int]()

    def run(self) -> Recovery:
        """Recover what there is."""
        end, is_whole = self._take_whole_records()
        found = self._file.summary
        before = found.counts.total()
        if not is_whole:
            self._take_part(end)
            self._file.add(Metadata(CUT_OFF, {"broken_at": str(end)}))
        if not found.counts:
            lost = "is damaged in the definitions of its topics" if self._whole else "holds no whole message"
            raise NothingWholeError(f"{self._given.path} {lost}: record it again")
        self._file.finish()
        return Recovery(
            found.counts.total(),
            len(found.channels),
            (found.first_ns, found.last_ns),
            None if is_whole else end,
            found.counts.total() - before,
            tuple(self._damaged),
            tuple(self._rewritten),
        )

    def _take_whole_records(self) -> tuple[int, bool]:
        """Take record after record; return where the last ends, and whether the file does."""
        end, opcode, data_ended = self._begin, 0, False
        for place in self._places():
            if place.start != end:
                self._leave_out(end)
            data_ended = place.opcode == Opcode.DATA_END or (data_ended and place.start == end)
            try:
                if not data_ended:
                    self._take(place)
            except _DAMAGE:
                self._leave_out(place.start)
            end, opcode = place.end, place.opcode
        self._close_loose()
        return end, opcode == Opcode.FOOTER

    def _places(self) -> Iterator[Place]:
        """Records whose lengths are right, each behind the one before; what stands between them is damaged."""
        place = Place(0, 0, 0, self._begin)
        while found := next(filter(None, map(self._sound, self._starts(place))), None):
            yield (place := found)

    def _starts(self, before: Place) -> Iterator[int]:
        """Byte behind a record; should no sound one begin there, where the next chunk or message may, and the footer.

        The summary tells where chunks begin; without one, what looks like a chunk is tried, or behind a message what
        looks like another. In an attachment, a message or an unfinished chunk no chunk of the file can stand.
        """
        yield (at := before.end)
        given, footer = self._given, len(self._given) - _FOOTER_SIZE
        if self._chunks:
            yield from self._chunks[bisect_right(self._chunks, at) :]
        elif given[at : at + 1] != bytes([Opcode.ATTACHMENT]) and not self._says_twice(at, Opcode.CHUNK):
            is_loose = bytes([Opcode.MESSAGE]) in (bytes([before.opcode]), given[at : at + 1])
            yield from self._looked_for(at + 1, is_loose=is_loose)
        if footer > at and given[footer : footer + 1] == bytes([Opcode.FOOTER]):
            yield footer

    def _looked_for(self, at: int, *, is_loose: bool) -> Iterator[int]:
        """Bytes from a place on where what looks like a chunk begins, or like a message of a channel that is known."""
        head = _LOOSE_HEAD if is_loose else _HEADS[Opcode.CHUNK]
        for begin in range(at, min(at + LARGEST_RECORD, len(self._given)), _PIECE):
            for match in head.finditer(self._given[begin : begin + _PIECE + _HEAD_SIZE]):
                if not is_loose or int.from_bytes(match[1], "little") in self._file.summary.channels:
                    yield begin + match.start()

    @cached_property
    def _said_chunks(self) -> set[int]:
        """Bytes where chunks begin, as their indexes in the summary say; none if that is not read to its end."""
        given, starts, opcode = self._given, set[int](), 0
        summary = int.from_bytes(given[RECORD_HEAD.size - _FOOTER_SIZE :][:8], "little")
        for opcode, _, begin, _ in records(given, summary):
            if opcode == Opcode.CHUNK_INDEX:
                starts.add(int.from_bytes(given[begin + 16 : begin + 24], "little"))
        return starts if opcode == Opcode.FOOTER else set()

    @cached_property
    def _chunks(self) -> list[int]:
        """Those of them where one does begin, in their order."""
        return sorted(start for start in self._said_chunks if self._says_twice(start, Opcode.CHUNK))

    def _sound(self, at: int) -> Place | None:
        """Record at a byte, if its length is right: by what it says itself, or else by what follows."""
        place = next(records(self._given, at), None)
        is_right = place and (
            self._given[place.end : place.end + len(MAGIC) + 1] == MAGIC
            if place.opcode == Opcode.FOOTER
            else place.end - place.begin == _DATA_END_SIZE
            if place.opcode == Opcode.DATA_END
            else self._says_twice(at, place.opcode)
            if place.opcode in _HEADS
            else _goes_on(self._given, place.end)
            or next(records(self._given, place.end), None)
            or (place.opcode in _OUTSIDE and self._given[place.end : place.end + 1] == b"\0")
        )
        return place if is_right else None

    def _says_twice(self, at: int, opcode: int) -> bool:
        """Whether a record of some kind begins at a byte, and says the same length twice."""
        found = _HEADS[Opcode(opcode)].match(self._given[at : at + _HEAD_SIZE])
        length, size = (int.from_bytes(each, "little") for each in found.groups()) if found else (0, 0)
        return found is not None and found.end(2) + size == RECORD_HEAD.size + length

    def _leave_out(self, at: int) -> None:
        """Leave out a damaged record; what the first may have declared is declared as in the summary."""
        known: Any = {Opcode.SCHEMA: self._file.summary.schemas, Opcode.CHANNEL: self._file.summary.channels}
        for place in () if self._damaged else self._places():
            if place.opcode in known and place.end - place.begin <= LARGEST_RECORD:
                with suppress(*_DAMAGE):
                    record = parsed(place.opcode, self._given[place.begin : place.end])
                    if record.id not in known[place.opcode]:
                        self._file.add(record)
        self._damaged.append(at)

    def _take(self, place: Place) -> None:
        require(place.end - place.begin <= LARGEST_RECORD, "a record is larger than what is read")
        content = self._given[place.begin : place.end]
        if place.opcode != Opcode.MESSAGE or len(self._loose) > _LOOSE_BYTES:
            self._close_loose()
        if place.opcode == Opcode.MESSAGE:
            channel, _, *times = _MESSAGE.unpack_from(content)
            self._whole += 1
            require(not self._has_chunks, "a message stands outside of the chunks")
            require(channel in self._file.summary.channels, "a message is on no channel")
            require(max(times) <= LAST_TIME, "a message is beyond all times")
            self._loose += RECORD_HEAD.pack(place.opcode, len(content)) + content
        elif place.opcode == Opcode.CHUNK:
            self._has_chunks = True
            self._take_chunk(parsed(place.opcode, content), place.start)
        elif place.opcode in _OUTSIDE:
            self._file.add(parsed(place.opcode, content))
        else:
            is_private = place.opcode >= _PRIVATE and place.start not in self._said_chunks
            is_of_no_use = place.opcode in (Opcode.HEADER, Opcode.MESSAGE_INDEX)
            require(is_of_no_use or is_private, "a record of a kind that has no place there")

    def _close_loose(self) -> None:
        """Write the messages that are in no chunk in one."""
        data, self._loose = bytes(self._loose), bytearray()
        if data:
            table = find_messages(data, NO_HINTS, len(data))
            self._file.add_chunk(compressed(table, "zstd"), table)

    def _take_chunk(self, chunk: Chunk, at: int) -> None:
        try:
            data = inflated(chunk)
        except NotOneFrameError:
            self._take_chunk(replace(chunk, compression="", data=salvaged(chunk)), at)
            self._rewritten.append(at)
            return
        table = self._whole_messages(data)
        require(len(table.data) == len(data), "a record in it is not whole")
        first_ns, last_ns = table.span_ns
        self._file.add_chunk(replace(chunk, message_start_time=first_ns, message_end_time=last_ns), table)

    def _take_part(self, begin: int) -> None:
        """Take the whole messages of an unfinished chunk, if one begins there, as far as it can be inflated."""
        if self._given[begin : begin + 1] == bytes([Opcode.CHUNK]):
            raw = self._given[begin + RECORD_HEAD.size : begin + LARGEST_RECORD]
            with suppress(*_DAMAGE):
                chunk = Chunk.read(ReadDataStream(BytesIO(raw)))  # which is not whole
                data = salvaged(chunk)
                found = find_messages(data, NO_HINTS, self._records_left)
                is_whole = _goes_on(data, len(found.data))
                table = self._whole_messages(data if is_whole else data[: found.starts[-1]])
                self._file.add_chunk(compressed(table, chunk.compression), table)

    def _whole_messages(self, data: bytes) -> MessageTable:
        """Table of the messages in the whole records at the start of some data; at least one must be a message."""
        table = find_messages(data, NO_HINTS, self._records_left)
        self._records_left -= len(table.starts) + len(table.others)
        self._whole += len(table.starts)
        require(bool(table.index), "no message is whole")
        return table


def _goes_on(data: bytes | FileBytes, end: int) -> bool:
    """Whether some data end, or another record begins, where a record ends, which then is whole.

    Where a disk lost power, zeros or other data may stand from the midst of a record on.
    """
    return end >= len(data) or 0 < data[end : end + 1][0] <= Opcode.DATA_END


def recover_folder(broken: Path, fixed: Path) -> dict[Path, Recovery | NothingWholeError]:
    """Write every whole message of the files of a bag in a folder into those of a new one, file by file.

    They are named after the new folder, as those of rosbag2 are; metadata.yaml is left to ``ros2 bag reindex``.

    Parameters
    ----------
    broken : Path
        It is only read. Where it has a metadata.yaml, that says which files are the bag's.
    fixed : Path
        Must not exist.

    Returns
    -------
    dict of Path to Recovery or NothingWholeError
        What was recovered of each file, in their order, or why nothing was, as of one that was just begun, or is gone.

    Raises
    ------
    BagError
        If the folder is none of one bag, its metadata name files outside of it, nothing is whole, or the new one cannot
        be written.
    """
    files = BagFiles(broken).files
    _make(broken, fixed)
    found, whole = dict[Path, Recovery | NothingWholeError](), 0
    try:
        for file in files:
            try:
                found[file] = recover(file, fixed / f"{real_path(fixed).name}_{whole}.mcap", overwrite=False)
                whole += 1
            except NothingWholeError as error:
                found[file] = error
        if not whole:
            raise BagError(f"{broken} holds nothing that can be recovered: 'lie-rigid-body check' says why")
    except BaseException:
        shutil.rmtree(fixed, ignore_errors=True)
        raise
    for name in left_out(broken, [file.name for file in files]):
        found[broken / name] = NothingWholeError(f"{broken / name} is none of the bag's files: recover it by itself")
    return found


def _make(broken: Path, fixed: Path) -> None:
    if fixed.suffix.lower() == ".mcap":
        raise BagError(f"{broken} is a folder, and {fixed} is to be one: give a name that does not end in .mcap")
    if real_path(broken) in real_path(fixed).parents:
        raise BagError(f"{fixed} is in the broken folder itself, which is never touched: give another place")
    try:
        fixed.mkdir()
    except FileExistsError:
        raise BagError(f"{fixed} exists and is kept: give the name of a new folder") from None
    except OSError as error:
        raise BagError(f"{fixed} cannot be created: {reason(error)}: give a place where you may write") from None
