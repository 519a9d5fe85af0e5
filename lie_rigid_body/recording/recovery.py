"""Recovering the whole messages of an MCAP file that was cut off or damaged, into a new file that is whole."""

from __future__ import annotations

import zlib
from contextlib import closing, suppress
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Footer, Header, Metadata, Schema

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.inflation import decompress, decompress_partial, other_format
from lie_rigid_body.recording.mcap_writer import McapFile, compressed
from lie_rigid_body.recording.records import (
    CUT_OFF,
    MAGIC,
    MAX_RECORD_BYTES,
    RECORD_HEAD,
    UNREADABLE,
    DamageError,
    ExcessError,
    FileBytes,
    Place,
    chunk_of,
    find_messages,
    parsed,
    parts,
    record_bytes,
    records,
    require,
)
from lie_rigid_body.system.output_file import require_other, written

_FOOTER_BYTES: Final = len(record_bytes(Footer(0, 0, 0))) + len(MAGIC)
"""Bytes of the footer, and of what follows it."""


class NothingWholeError(BagError):
    """Error for a file of which nothing can be recovered."""


@short_dataclass
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
    in_summary : bool
        Whether it breaks off behind its data, so that all messages are whole.
    is_altered : bool
        Whether the checksum of its data is another one, though no record is known to be damaged.
    """

    messages: int
    topics: int
    log_times_ns: tuple[int, int]
    broken_at: int | None
    of_the_last: int
    damaged: tuple[int, ...]
    in_summary: bool = False
    is_altered: bool = False


def recover(broken: Path, fixed: Path, *, overwrite: bool) -> Recovery:
    """Write every whole message of a file into a new one, which is whole.

    Whole records are taken in order, up to the first place where none stands. A chunk that is damaged is left out. Of
    an unfinished chunk at the end it takes what can be decompressed. Definitions that are lost come from the summary.

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
        self._given = given
        if given[: len(MAGIC)] != MAGIC:
            hint = other_format(given[:16]) or "it does not begin as one: give a bag"
            raise NothingWholeError(f"{given.path} is not an MCAP file: {hint}")
        header = Header(profile="ros2", library="")
        for first in parts(given):
            if first.opcode == Opcode.HEADER:
                with suppress(DamageError):
                    header = parsed(Opcode.HEADER, given[first.begin : min(first.end, first.begin + MAX_RECORD_BYTES)])
            break
        self._file = McapFile(out, header)
        self._damaged = list[int]()
        self._unread: NothingWholeError | None = None
        self._crc = zlib.crc32(MAGIC)
        self._is_altered = False

    def run(self) -> Recovery:
        """Recover what there is."""
        summary = self._file.summary
        last = Place(0, 0, 0, len(MAGIC))
        in_summary = False
        for part in parts(self._given):
            if not in_summary:
                self._take(part)
            in_summary |= part.opcode == Opcode.DATA_END
            last = part
        is_whole = last.opcode == Opcode.FOOTER and self._given[last.end : last.end + len(MAGIC)] == MAGIC
        before = summary.counts.total()
        broken_at = last.end
        if not (is_whole or in_summary):
            rest = Place(0, last.end, last.end + RECORD_HEAD.size, len(self._given))
            if self._damaged[-1:] == [last.start] and not self._is_chunk(rest):  # zeros may stand from its midst on
                broken_at = self._damaged.pop()
                rest = last
            self._take_part(rest)
            self._file.add(Metadata(CUT_OFF, {"broken_at": str(broken_at)}))
        if not summary.counts:
            whole = "is whole, and holds no message: there is nothing to recover"
            lost = "holds no whole message: record it again"
            raise self._unread or NothingWholeError(f"{self._given.path} {whole if is_whole else lost}")
        self._file.finish()
        return Recovery(
            messages=summary.counts.total(),
            topics=len({channel.topic for channel in summary.channels.values()}),
            log_times_ns=(summary.first_ns, summary.last_ns),
            broken_at=None if is_whole else broken_at,
            of_the_last=summary.counts.total() - before,
            damaged=tuple(self._damaged),
            in_summary=in_summary and not is_whole,
            is_altered=self._is_altered and not self._damaged,
        )

    def _take(self, part: Place) -> None:
        """Take a part of the data section, or leave it out and note where."""
        try:
            if part.end - part.start > MAX_RECORD_BYTES + RECORD_HEAD.size:
                raise ExcessError(f"a record of {part.end - part.start} bytes")
            raw = self._given[part.start : part.end]
            if part.opcode == Opcode.DATA_END:
                self._is_altered = int.from_bytes(raw[9:13], "little") not in (0, self._crc)
                return
            self._crc = zlib.crc32(raw, self._crc)
            self._add(part, raw)
        except DamageError as error:
            self._declare()
            self._damaged.append(part.start)
            if type(error) is not DamageError:
                told = error.sentence.format(at=part.start, what=error)
                self._unread = self._unread or NothingWholeError(f"{self._given.path} {told}")

    def _add(self, part: Place, raw: bytes) -> None:
        if part.opcode == Opcode.CHUNK:
            chunk, hints = chunk_of(raw)
            assert chunk is not None
            data = decompress(chunk)
            table = find_messages(data, hints)
            require(len(table.data) == len(data), "a record in a chunk is not whole")
            first_ns, last_ns = table.span_ns if len(table.starts) else (0, 0)
            self._file.add_chunk(replace(chunk, message_start_time=first_ns, message_end_time=last_ns), table)
            return
        if part.opcode == Opcode.MESSAGE:
            self._file.add_messages(find_messages(raw))
            return
        record = parsed(part.opcode, raw[RECORD_HEAD.size :])
        if isinstance(record, Schema | Channel | Metadata | Attachment):
            self._file.add(record)

    def _declare(self) -> None:
        """Declare what the summary declares, as far as it is not known: a chunk may be lost that declared it."""
        footer = self._given[len(self._given) - _FOOTER_BYTES :][RECORD_HEAD.size :]
        begin = int.from_bytes(footer[:8], "little")
        known = self._file.summary
        for place in records(self._given, begin) if begin else ():
            with suppress(DamageError):
                if place.opcode not in (Opcode.SCHEMA, Opcode.CHANNEL) or place.end - place.begin > MAX_RECORD_BYTES:
                    continue
                record = parsed(place.opcode, self._given[place.begin : place.end])
                declared: dict[int, Schema] | dict[int, Channel] = known.schemas
                if isinstance(record, Channel):
                    declared = known.channels
                if record.id not in declared:
                    self._file.add(record)

    def _is_chunk(self, part: Place) -> bool:
        return self._given[part.start : part.start + 1] == bytes([Opcode.CHUNK])

    def _take_part(self, part: Place) -> None:
        """Take the whole messages of an unfinished chunk, if one begins there, as far as it can be decompressed.

        Where zeros took the place of its end, the last of them may be of zeros in part.
        """
        raw = self._given[part.begin : min(part.begin + MAX_RECORD_BYTES, part.end)]
        if not self._is_chunk(part):
            return
        with suppress(*UNREADABLE):
            chunk = Chunk.read(ReadDataStream(BytesIO(raw)))  # which is not whole
            data = decompress_partial(chunk)
            table = find_messages(data)
            rest = data[len(table.data) :]
            is_of_zeros = part.opcode == Opcode.CHUNK or (rest and not any(rest))
            if is_of_zeros and len(table.starts):
                table = find_messages(table.data[: table.starts[-1]])
            require(len(table.starts) > 0, "no message in a chunk is whole")
            self._file.add_chunk(compressed(table, chunk.compression), table)
