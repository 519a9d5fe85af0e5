"""Recovering the whole messages of an MCAP file that was cut off, into a new file that is whole."""

from __future__ import annotations

import re
import struct
import zlib
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import replace
from functools import cached_property, partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, Final

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata, Schema

from lie_rigid_body.bounded_input import LONGEST_NAME
from lie_rigid_body.errors import BagError
from lie_rigid_body.output_file import require_other, written
from lie_rigid_body.recording.bag_writer import CUT_OFF
from lie_rigid_body.recording.inflation import NotOneFrameError, inflated, most_records, other_format, salvaged
from lie_rigid_body.recording.mcap_file import McapFile, compressed
from lie_rigid_body.recording.records import (
    LARGEST_RECORD,
    LAST_TIME,
    MAGIC,
    NO_HINTS,
    RECORD_HEAD,
    ContradictionError,
    FileBytes,
    MessageTable,
    Place,
    find_messages,
    parsed,
    record_bytes,
    records,
    require,
)
from lie_rigid_body.recording.sound_records import DAMAGE, OUTSIDE, goes_on, says_twice, sound
from lie_rigid_body.short_dataclass import short_dataclass

_LOOSE_BYTES: Final = 256 * 1024
"""Size of the chunks into which messages are put that are in none."""
_MESSAGE: Final = struct.Struct("<HIQQ")
_CHUNK: Final = rb"\x06(?=(.{8}).{28}(?:\0{4}|\x03\0{3}lz4|\x04\0{3}zstd))"
_CHUNK_HEAD, _CHUNKED_HEAD, _LOOSE_HEAD = (
    re.compile(re.escape(MAGIC) + rb"\x01|" + head, re.DOTALL)
    for head in (
        _CHUNK,
        _CHUNK + rb"|[\x09\x0c](?=.{4}(\0{4}))",
        rb"[\x03\x04\x05\x09\x0c](?=.{4}\0{4}(.{2}))",
    )
)
"""Beginnings of a chunk; of that, attachments and metadata; and of what stands in no chunk, with a message's channel.

Or of another file, as of one that is attached."""
_MAGIC: Final = re.compile(rb"(\x02\x14\0{7}.{20})?" + re.escape(MAGIC), re.DOTALL)
"""Magic, behind a footer if it ends a file."""
_BEFORE: Final = Place(0, 0, 0, len(MAGIC))
"""Place of what stands before the first record."""
_OFFSETS: Final[Mapping[int, int]] = {Opcode.CHUNK_INDEX: 16, Opcode.ATTACHMENT_INDEX: 0, Opcode.METADATA_INDEX: 0}
"""Place in an index of where its record begins."""
_HEAD_SIZE: Final = 64
"""Bytes of which the longest of these takes less."""
_PIECE: Final = 2**12
"""Bytes that are looked through at a time."""
_FOOTER_SIZE: Final = RECORD_HEAD.size + 20 + len(MAGIC)
"""Bytes of the footer, and of what follows it."""


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
        Where records begin that are left out, or of which a part is, because their content is damaged.
    rewritten : tuple of int
        Where chunks begin that were more than one compressed frame; they are whole, and written without compression.
    is_altered : bool
        Whether the checksum of its data or of its summary, or the number of messages in that, is another one, though no
        record is known to be damaged.
    """

    messages: int
    topics: int
    log_times_ns: tuple[int, int]
    broken_at: int | None
    of_the_last: int
    damaged: tuple[int, ...]
    rewritten: tuple[int, ...] = ()
    is_altered: bool = False


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
        require_other(fixed, [broken])
        with written(fixed, overwrite=overwrite) as out:
            return _Salvage(file, out).run()


class _Salvage:
    """One file, read from its start to where it breaks off, and written anew."""

    def __init__(self, given: FileBytes, out: BinaryIO) -> None:
        self._given, header = given, Header(profile="ros2", library="")
        first = sound(given, len(MAGIC))
        if first and first.opcode == Opcode.HEADER:
            with suppress(*DAMAGE):
                header = parsed(Opcode.HEADER, given[first.begin : min(first.end, first.begin + 8 * LONGEST_NAME)])
        self._file, self._records_left = McapFile(out, header), most_records(len(given))
        self._loose, self._whole, self._has_chunks = bytearray(), 0, False
        self._damaged, self._rewritten = [0] * (given[: len(MAGIC)] != MAGIC), list[int]()
        self._knows_all = self._is_altered = False

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
            lost = lost if self._given[: len(MAGIC)] == MAGIC else "does not begin as an MCAP file, nor holds a message"
            hint = (other := other_format(self._given[:16])) and f"is not an MCAP file: {other}"
            raise NothingWholeError(f"{self._given.path} {hint or f'{lost}: record it again'}")
        self._file.finish()
        return Recovery(
            found.counts.total(),
            len(found.channels),
            (found.first_ns, found.last_ns),
            None if is_whole else end,
            found.counts.total() - before,
            tuple(self._damaged),
            tuple(self._rewritten),
            self._is_altered,
        )

    def _take_whole_records(self) -> tuple[int, bool]:
        """Take record after record; return where the last ends, and whether the file does."""
        end, opcode, data_ended = len(MAGIC), 0, False
        for place in self._places():
            if place.start != end:
                self._leave_out(end)
            data_ended = place.opcode == Opcode.DATA_END or (data_ended and place.start == end)
            self._is_altered |= place.opcode == Opcode.DATA_END and not self._damaged and not self._agrees(place)
            try:
                if not data_ended:
                    self._take(place)
            except DAMAGE:
                self._leave_out(place.start)
            end, opcode = place.end, place.opcode
        self._close_loose()
        return end, opcode == Opcode.FOOTER

    def _agrees(self, end: Place) -> bool:
        """Whether the checksum of the data, the summary, and the number of messages in that, are right if given."""
        has_summary = any(self._given[RECORD_HEAD.size - _FOOTER_SIZE :][:8])
        declared = int.from_bytes(self._given[end.begin : end.end], "little")
        begins = (place.begin for place in self._summary if place.opcode == Opcode.STATISTICS)
        counts = {int.from_bytes(self._given[begin : begin + 8], "little") for begin in begins}
        is_right = (not declared or declared == self._crc(0, end.start)) and has_summary == bool(self._summary)
        return is_right and counts <= {self._whole}

    def _crc(self, begin: int, end: int) -> int:
        crc = 0
        for at in range(begin, end, _LOOSE_BYTES):
            crc = zlib.crc32(self._given[at : min(at + _LOOSE_BYTES, end)], crc)
        return crc

    def _places(self) -> Iterator[Place]:
        """Records whose lengths are right, each behind the one before; what stands between them is damaged."""
        place = _BEFORE
        while found := next(filter(None, map(partial(sound, self._given), self._starts(place))), None):
            yield (place := found)

    def _starts(self, before: Place) -> Iterator[int]:
        """Byte behind a record; should no sound one begin there, where the next chunk or message may, and the footer.

        The summary tells where chunks begin. Without one, what looks like a chunk is tried; in a file without chunks
        what looks like a definition, or a message of a known channel. In an unfinished chunk stands none of these.
        What looks like an attachment or metadata is tried in either.
        """
        yield (at := before.end)
        given, footer = self._given, len(self._given) - _FOOTER_SIZE
        if self._indexed:
            yield from self._indexed[bisect_right(self._indexed, before.start) :]
        elif given[at : at + 1] == bytes([Opcode.CHUNK]) and says_twice(given, at):
            pass
        elif self._has_chunks or (self._is_chunked and not self._whole):
            yield from (begin for begin, _ in self._looked_for(_CHUNKED_HEAD, before))
        else:
            self._declare()
            known, message = self._file.summary.channels, bytes([Opcode.MESSAGE])
            found = self._looked_for(_LOOSE_HEAD, before)
            yield from (begin for begin, of in found if of in known or given[begin : begin + 1] != message)
        if footer > at and given[footer : footer + 1] == bytes([Opcode.FOOTER]):
            yield footer

    def _looked_for(self, head: re.Pattern[bytes], before: Place) -> Iterator[tuple[int, int]]:
        """Bytes behind a record where what looks like another one begins, and the first number in that.

        A record that lost some bytes, and is no message, reaches into the other.
        """
        since, least = before.end if before.opcode == Opcode.MESSAGE else before.start, before.end - _PIECE
        for begin, match in self._matches(head, since + 1, before.end + LARGEST_RECORD):
            if match.lastindex is None:
                ends = self._matches(_MAGIC, begin + match.end(), before.end + LARGEST_RECORD)
                piece, end = next(ends, (0, None))
                if end and end.lastindex and piece + end.end() < len(self._given):
                    least = max(least, piece + end.end())
            elif begin + match.start() >= least:
                yield begin + match.start(), int.from_bytes(match[match.lastindex], "little")

    def _matches(self, pattern: re.Pattern[bytes], first: int, end: int) -> Iterator[tuple[int, re.Match[bytes]]]:
        """Matches of a pattern between two bytes, each with where the piece begins that is looked through."""
        for begin in range(first, min(end, len(self._given)), _PIECE):
            piece = self._given[begin : begin + _PIECE + _HEAD_SIZE]
            for match in pattern.finditer(piece) if piece.strip(b"\0") else ():  # a file may end in very many zeros
                if match.start() < _PIECE:  # else it is found again in the next piece
                    yield begin, match

    @cached_property
    def _is_chunked(self) -> bool:
        """Whether there are chunks, by the beginning of the file."""
        return any(sound(self._given, begin) for begin, _ in self._looked_for(_CHUNK_HEAD, _BEFORE))

    @cached_property
    def _summary(self) -> list[Place]:
        """Records of the summary; none if it is not read to its end, or its checksum is another one."""
        footer = self._given[RECORD_HEAD.size - _FOOTER_SIZE :]
        begin, declared = int.from_bytes(footer[:8], "little"), int.from_bytes(footer[16:20], "little")
        found = [*records(self._given, begin)]
        is_whole = bool(found) and found[-1].opcode == Opcode.FOOTER
        is_right = is_whole and (not declared or declared == self._crc(begin, found[-1].end - 4))
        return found if is_right else []

    @cached_property
    def _repeated(self) -> dict[tuple[int, bytes], bytes]:
        """Contents of the definitions in the summary, by their kinds and numbers."""
        own = [place for place in self._summary if place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL)]
        contents = ((place.opcode, self._given[place.begin : place.end]) for place in own)
        return {(opcode, content[:2]): content for opcode, content in contents}

    @cached_property
    def _indexed(self) -> list[int]:
        """Bytes where chunks, attachments and metadata begin, by the indexes in a summary that tells of chunks."""
        indexes = [place.begin + _OFFSETS[place.opcode] for place in self._summary if place.opcode in _OFFSETS]
        starts = (int.from_bytes(self._given[begin : begin + 8], "little") for begin in indexes)
        found = [place for start in starts if (place := sound(self._given, start))]
        return sorted(place.start for place in found) if Opcode.CHUNK in {place.opcode for place in found} else []

    def _leave_out(self, at: int) -> None:
        """Leave out a damaged record; what it may have declared is declared as elsewhere."""
        self._declare()
        self._damaged.append(at)

    def _declare(self) -> None:
        """Declare what any record declares that is in no chunk, as far as it is not known; once."""
        known: Any = {Opcode.SCHEMA: self._file.summary.schemas, Opcode.CHANNEL: self._file.summary.channels}
        places, self._knows_all = () if self._knows_all else chain(self._summary, self._places()), True
        for place in places:
            if place.opcode in known and place.end - place.begin <= LARGEST_RECORD:
                with suppress(*DAMAGE):
                    record = parsed(place.opcode, self._given[place.begin : place.end])
                    if record.id not in known[place.opcode]:
                        self._file.add(record)

    def _take(self, place: Place) -> None:
        require(place.end - place.begin <= LARGEST_RECORD, "a record is larger than what is read")
        content = self._given[place.begin : place.end]
        if place.opcode != Opcode.MESSAGE or len(self._loose) > _LOOSE_BYTES:
            self._close_loose()
        if place.opcode == Opcode.MESSAGE:
            channel, _, *times = _MESSAGE.unpack_from(content)
            self._whole += 1
            require(not self._has_chunks, "a message stands outside of the chunks")
            if channel not in self._file.summary.channels:
                self._declare()
            require(channel in self._file.summary.channels, "a message is on no channel")
            require(max(times) <= LAST_TIME, "a message is beyond all times")
            self._loose += RECORD_HEAD.pack(place.opcode, len(content)) + content
        elif place.opcode == Opcode.CHUNK:
            self._take_chunk(parsed(place.opcode, content), place.start)
            self._has_chunks = True
        elif place.opcode in OUTSIDE:
            record = parsed(place.opcode, content)
            is_repeated = self._repeated.get((place.opcode, content[:2]), content) == content
            is_exact = isinstance(record, Schema | Channel) or len(record_bytes(record)) == place.end - place.start
            require(is_exact and is_repeated, "a record is longer than its fields, or another one in the summary")
            self._file.add(record)
        else:
            is_first = place.opcode == Opcode.HEADER and place.start == len(MAGIC)
            require(is_first or place.opcode == Opcode.MESSAGE_INDEX, "a record of a kind that has no place there")

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
        except ContradictionError:
            self._take_before_zeros(chunk)
            raise
        table = self._whole_messages(data)
        chunk.message_start_time, chunk.message_end_time = table.span_ns
        try:
            require(len(table.data) == len(data), "a record in it is not whole")
            self._file.add_chunk(chunk, table)
        except ContradictionError:
            self._take_known(table, chunk.compression)
            raise

    def _take_before_zeros(self, chunk: Chunk) -> None:
        """Take the whole messages of a chunk without compression that ends in zeros, as after a loss of power."""
        found = find_messages(chunk.data, NO_HINTS, self._records_left)
        if not (chunk.compression or chunk.data[len(found.data) :].strip(b"\0")) and len(found.data) < len(chunk.data):
            self._take_known(self._whole_messages(chunk.data[: found.starts[-1]]))  # the last may be of zeros in part

    def _take_part(self, begin: int) -> None:
        """Take the whole messages of an unfinished chunk, if one begins there, as far as it can be inflated."""
        if self._given[begin : begin + 1] == bytes([Opcode.CHUNK]):
            raw = self._given[begin + RECORD_HEAD.size : begin + LARGEST_RECORD]
            with suppress(*DAMAGE):
                chunk = Chunk.read(ReadDataStream(BytesIO(raw)))  # which is not whole
                data = salvaged(chunk)
                found = find_messages(data, NO_HINTS, self._records_left)
                is_whole = goes_on(data, len(found.data))
                table = self._whole_messages(data if is_whole else data[: found.starts[-1]])
                self._take_known(table, chunk.compression)

    def _take_known(self, table: MessageTable, compression: str = "") -> None:
        """Take the messages of a chunk that are of known topics."""
        self._declare()
        known = self._file.summary.known(table)
        self._file.add_chunk(compressed(known, compression), known)
        self._has_chunks = True

    def _whole_messages(self, data: bytes) -> MessageTable:
        """Table of the messages in the whole records at the start of some data; at least one must be a message."""
        table = find_messages(data, NO_HINTS, self._records_left)
        self._records_left -= len(table.starts) + len(table.others)
        self._whole += len(table.starts)
        require(len(table.starts) > 0, "no message is whole")
        return table
