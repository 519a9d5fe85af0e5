"""Recovering the whole messages of an MCAP file that was cut off, into a new file that is whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.bag_writer import CUT_OFF
from lie_rigid_body.recording.damaged_file import DamagedFile
from lie_rigid_body.recording.inflation import NotOneFrameError, inflated, most_records, other_format, salvaged
from lie_rigid_body.recording.mcap_file import McapFile, compressed
from lie_rigid_body.recording.records import (
    HEAD,
    LARGEST_RECORD,
    LAST_TIME,
    MAGIC,
    MESSAGE,
    NO_HINTS,
    RECORD_HEAD,
    ContradictionError,
    FileBytes,
    MessageTable,
    Place,
    find_messages,
    parsed,
    record_bytes,
    require,
)
from lie_rigid_body.recording.sound_records import DAMAGE, OUTSIDE, begins, sound
from lie_rigid_body.system.bounded_input import LONGEST_NAME
from lie_rigid_body.system.output_file import require_other, written

_LOOSE_BYTES: Final = 256 * 1024
"""Size of the chunks into which messages are put that are in none."""
_PLAIN: Final = 40
"""Bytes before the data in the record of a chunk that has no compression."""
_OF_CHUNKS: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
_ZEROS: Final = 64
"""Zeros in which no compressed data end."""


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
        self._there, self._loose = DamagedFile(given, self._declared), bytearray()
        self._damaged, self._rewritten = [0] * (given[: len(MAGIC)] != MAGIC), list[int]()
        self._knows_all = self._is_altered = False
        self._in_part: tuple[Chunk, int, int] | None = None

    def run(self) -> Recovery:
        """Recover what there is."""
        end, is_whole = self._take_whole_records()
        found = self._file.summary
        before = found.counts.total()
        if not is_whole:
            self._take_part(end, len(self._given), is_last=True)
            self._file.add(Metadata(CUT_OFF, {"broken_at": str(end)}))
        if not found.counts:
            lost = "is damaged in the definitions of its topics" if self._there.messages else "holds no whole message"
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
        for place in self._there.places():
            if self._in_part and place.opcode in _OF_CHUNKS and place.end <= self._in_part[2]:
                end = place.end  # it was in the chunk before
                continue
            self._take_in_part(place.start)
            if place.start != end:
                self._leave_out(end)
                self._take_part(end, place.start)
            data_ended = place.opcode == Opcode.DATA_END or (data_ended and place.start == end)
            if place.opcode == Opcode.DATA_END and not self._damaged:
                self._is_altered |= not self._there.agrees(place)
            if not (data_ended or self._is_taken(place)):
                self._leave_out(place.start)
                self._there.doubt(place)
            end, opcode = place.end, place.opcode
        self._take_in_part(len(self._given))
        self._close_loose()
        return end, opcode == Opcode.FOOTER

    def _leave_out(self, at: int) -> None:
        """Leave out a damaged record; what it may have declared is declared as elsewhere."""
        self._declare()
        self._damaged.append(at)

    def _declared(self) -> Mapping[int, Channel]:
        """Channels that are declared, when all are that any record declares."""
        self._declare()
        return self._file.summary.channels

    def _declare(self) -> None:
        """Declare what any record declares, as far as it is not known; once."""
        known: Any = {Opcode.SCHEMA: self._file.summary.schemas, Opcode.CHANNEL: self._file.summary.channels}
        places, self._knows_all = () if self._knows_all else self._definitions(), True
        for opcode, content in places:
            with suppress(*DAMAGE):
                record = parsed(opcode, content)
                if record.id not in known[opcode]:
                    self._file.add(record)

    def _definitions(self) -> Iterator[tuple[int, bytes]]:
        """Kinds and contents of definitions in the summary, or without one in chunks, and then in none."""
        kinds, outside, repeated = (Opcode.SCHEMA, Opcode.CHANNEL), list[Place](), self._there.repeated
        yield from ((opcode, content) for (opcode, _), content in repeated.items())
        for place in self._there.places():
            if place.end - place.begin > LARGEST_RECORD:
                continue
            if place.opcode in kinds:
                outside.append(place)
            elif place.opcode == Opcode.CHUNK and not repeated:
                try:
                    data = inflated(parsed(place.opcode, self._given[place.begin : place.end]))
                    found = find_messages(data, NO_HINTS, self._records_left).others
                    yield from ((own.opcode, data[own.begin : own.end]) for own in found if own.opcode in kinds)
                except DAMAGE:
                    self._there.doubt(place)
        yield from ((place.opcode, self._given[place.begin : place.end]) for place in outside)

    def _is_taken(self, place: Place) -> bool:
        """Take a record; whether it is not damaged. The error that tells so would keep its bytes."""
        try:
            self._take(place)
        except DAMAGE:
            return False
        return True

    def _take(self, place: Place) -> None:
        require(place.end - place.begin <= LARGEST_RECORD, "a record is larger than what is read")
        content = self._given[place.begin : place.end]
        if place.opcode != Opcode.MESSAGE or len(self._loose) > _LOOSE_BYTES:
            self._close_loose()
        if place.opcode == Opcode.MESSAGE:
            channel, _, *times = MESSAGE.unpack_from(content)
            self._there.messages += 1
            is_outside = self._there.has_chunks or self._there.is_indexed
            require(not is_outside, "a message stands outside of the chunks")
            require(place.start > len(MAGIC), "a message stands where the header was")
            is_known = channel in self._file.summary.channels or channel in self._declared()
            require(is_known, "a message is on no channel")
            require(max(times) <= LAST_TIME, "a message is beyond all times")
            self._loose += RECORD_HEAD.pack(place.opcode, len(content)) + content
        elif place.opcode == Opcode.CHUNK:
            chunk = parsed(place.opcode, content)
            del content  # it may be large
            self._take_chunk(chunk, place)
            self._there.has_chunks = True
        elif place.opcode in OUTSIDE:
            record = parsed(place.opcode, content)
            is_repeated = self._there.repeated.get((place.opcode, content[:2]), content) == content
            is_exact = isinstance(record, Schema | Channel) or len(record_bytes(record)) == place.end - place.start
            require(is_exact and is_repeated, "a record is longer than its fields, or another one in the summary")
            if isinstance(record, Attachment) and not any(content[-4:]):  # it has no checksum
                is_followed = place.end == len(self._given) or sound(self._given, place.end) is not None
                require(is_followed, "an attachment is damaged, or what follows it")
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

    def _take_chunk(self, chunk: Chunk, place: Place) -> None:
        try:
            data = inflated(chunk)
        except NotOneFrameError:
            self._take_chunk(replace(chunk, compression="", data=salvaged(chunk)), place)
            self._rewritten.append(place.start)
            return
        except ContradictionError:
            self._take_before_zeros(chunk)
            raise
        table = self._found(data)
        span_ns, told_ns = table.span_ns if table.index else (0, 0), (chunk.message_start_time, chunk.message_end_time)
        behind, adds_up = place.end, len(table.data) == len(data)
        has_won = not adds_up or self._given[behind : behind + 1] == bytes([Opcode.MESSAGE])
        is_sure = chunk.compression or chunk.uncompressed_crc or (not has_won and begins(self._given, behind))
        try:
            require(adds_up and bool(is_sure), "a record in it is not whole, or no other one begins behind it")
            self._file.add_chunk(replace(chunk, message_start_time=span_ns[0], message_end_time=span_ns[1]), table)
        except DAMAGE:
            self._there.has_chunks, begin = True, place.end - len(data)
            kept = replace(chunk, data=b"") if begin == place.begin + _PLAIN else chunk
            self._in_part = kept, begin, min(behind + (len(data) if has_won else HEAD.itemsize), begin + LARGEST_RECORD)
            raise
        self._is_altered |= bool(table.index) and span_ns != told_ns

    def _take_in_part(self, end: int) -> None:
        """Take the whole messages of a chunk that does not add up, if the last record is one; the next one is known.

        Where a plain one won bytes, others that were in it stand between the two; they are looked for as far again. One
        that adds up has none there, and a last message that may be another one.
        """
        in_part, self._in_part = self._in_part, None
        if in_part:
            chunk, begin, farthest = in_part
            with suppress(*DAMAGE):
                data = salvaged(chunk) or self._given[begin : min(end, farthest)]
                self._take_known(chunk, data, is_cut=farthest < end)

    def _take_before_zeros(self, chunk: Chunk) -> None:
        """Take the whole messages of a chunk that ends in zeros, as after a loss of power."""
        if chunk.data.endswith(bytes(_ZEROS if chunk.compression else 1)):
            data = salvaged(chunk)
            found = find_messages(data, NO_HINTS, self._records_left)
            rest = data[len(found.data) :]
            if chunk.compression or (rest and not rest.strip(b"\0")):
                self._take_known(chunk, data[: found.starts[-1]])  # the last may be of zeros in part

    def _take_part(self, begin: int, end: int, *, is_last: bool = False) -> None:
        """Take the whole messages of an unfinished chunk, if one begins there, as far as it can be inflated.

        Of one that others follow, as it lost some bytes, only without a checksum, which would be wrong.
        """
        if self._given[begin : begin + 1] == bytes([Opcode.CHUNK]):
            raw = self._given[begin + RECORD_HEAD.size : min(begin + LARGEST_RECORD, end)]
            with suppress(*DAMAGE):
                chunk = Chunk.read(ReadDataStream(BytesIO(raw)))  # which is not whole
                require(is_last or not chunk.uncompressed_crc, "a chunk with a checksum is not whole")
                self._take_known(chunk, salvaged(chunk), is_cut=is_last or bool(chunk.compression))

    def _take_known(self, chunk: Chunk, data: bytes, *, is_cut: bool = False) -> None:
        """Take those of the messages in a damaged chunk which were written there."""
        span_ns = chunk.message_start_time, chunk.message_end_time
        known = self._found(self._file.summary.known(data, span_ns, is_cut=is_cut))
        require(len(known.starts) > 0, "no message in a chunk is whole, and of a known topic")
        self._file.add_chunk(compressed(known, chunk.compression), known)
        self._there.has_chunks = True

    def _found(self, data: bytes) -> MessageTable:
        """Table of the messages in the whole records at the start of some data."""
        table = find_messages(data, NO_HINTS, self._records_left)
        self._records_left -= len(table.starts) + len(table.others)
        self._there.messages += len(table.starts)
        return table
