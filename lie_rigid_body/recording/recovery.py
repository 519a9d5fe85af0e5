"""Recovering the whole messages of an MCAP file that was cut off, into a new file that is whole."""

from __future__ import annotations

import shutil
import struct
from contextlib import suppress
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, Metadata

from lie_rigid_body.bounded_input import open_file
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording.bag_files import is_one_bag, natural_order
from lie_rigid_body.recording.bag_writer import CUT_OFF
from lie_rigid_body.recording.inflation import NotOneFrameError, inflated, most_records, salvaged
from lie_rigid_body.recording.mcap_file import McapFile, compressed, compressor
from lie_rigid_body.recording.message_table import NO_HINTS, MessageTable, find_messages
from lie_rigid_body.recording.output_file import NO_ROOM, OutputFile, reason, require_other, unwritten
from lie_rigid_body.recording.records import MAGIC, RECORD_HEAD, FileBytes, parsed, records, require
from lie_rigid_body.wording import short_repr

_LOOSE_BYTES: Final = 256 * 1024
"""Size of the chunks into which messages are put that are in none."""
_MESSAGE: Final = struct.Struct("<HIQQ")
_OUTSIDE: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT)
"""Records that stand outside of chunks and are written as they are."""
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
    """Error for a file without any whole message."""


@dataclass(frozen=True)
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

    __repr__ = short_repr


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
        If the file holds no whole message.
    BagError
        If it cannot be read, or the new one cannot be written.
    """
    try:
        with open_file(broken) as stream:
            _require_mcap(broken, stream)
            require_other(fixed, [broken])
            return _written(broken, stream, OutputFile(fixed, overwrite=overwrite))
    except InputError as error:
        raise BagError(str(error)) from None
    except FileNotFoundError:
        raise BagError(f"{broken} does not exist: give the path of an MCAP file") from None
    except IsADirectoryError:
        raise BagError(f"{broken} is a folder: give an MCAP file in it") from None
    except OSError as error:
        raise BagError(f"{broken} cannot be recovered: {reason(error)}: look after the disk, and try again") from None


def _require_mcap(path: Path, stream: BinaryIO) -> None:
    if stream.read(len(MAGIC)) != MAGIC:
        raise NothingWholeError(f"{path} does not begin as an MCAP file: it holds nothing that can be recovered")


def _written(broken: Path, stream: BinaryIO, out: OutputFile) -> Recovery:
    try:
        salvage = _Salvage(stream, out.stream)
        recovery = salvage.run()
        if recovery is None:
            raise NothingWholeError(f"{broken} holds no whole message: record it again")
        out.commit()
    except BaseException as error:
        out.discard()
        if isinstance(error, OSError) and error.errno in NO_ROOM:  # reading needs none
            raise unwritten(out.path, error) from None
        raise
    return recovery


class _Salvage:
    """One file, read from its start to where it breaks off, and written anew."""

    def __init__(self, stream: BinaryIO, out: BinaryIO) -> None:
        self._given, self._out = FileBytes(stream), out
        self._records_left = most_records(len(self._given))
        self._file: McapFile | None = None
        self._loose = bytearray()
        self._damaged: list[int] = []
        self._rewritten: list[int] = []

    def run(self) -> Recovery | None:
        """Recover what there is; None if that is nothing."""
        end, is_whole = self._take_whole_records()
        self._close_loose()
        file = self._file
        if file is None:
            return None
        found = file.summary
        before = found.counts.total()
        if not is_whole:
            self._take_part(file, self._given[end:])
        if not found.counts:
            return None
        if not is_whole:
            file.add(Metadata(CUT_OFF, {"broken_at": str(end)}))
        file.finish()
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
        end, data_ended = len(MAGIC), False
        for place in records(self._given, end):
            if place.opcode == Opcode.FOOTER:
                is_whole = self._given[place.end : place.end + len(MAGIC) + 1] == MAGIC
                return (place.end, True) if is_whole else (place.start, False)
            data_ended |= place.opcode == Opcode.DATA_END
            try:
                if not data_ended:
                    self._take(place.opcode, place.start, self._given[place.start : place.end])
            except _DAMAGE:
                self._damaged.append(place.start)
            end = place.end
        return end, False

    def _take(self, opcode: int, at: int, raw: bytes) -> None:
        content = raw[RECORD_HEAD.size :]
        if opcode == Opcode.HEADER and self._file is None:
            self._file = McapFile(self._out, parsed(opcode, content))
        if self._file is None:
            return
        if opcode == Opcode.MESSAGE:
            channel, *_ = _MESSAGE.unpack_from(content)
            require(channel in self._file.summary.channels, "a message is on no channel")
            self._loose += raw
        if opcode != Opcode.MESSAGE or len(self._loose) > _LOOSE_BYTES:
            self._close_loose()
        if opcode == Opcode.CHUNK:
            self._take_chunk(self._file, parsed(opcode, content), at)
        elif opcode in _OUTSIDE:
            self._file.add(parsed(opcode, content))

    def _close_loose(self) -> None:
        """Write the messages that are in no chunk in one."""
        data, self._loose = bytes(self._loose), bytearray()
        if self._file is not None and data:
            self._add(self._file, self._whole_messages(self._file, data), "zstd")

    def _add(self, file: McapFile, table: MessageTable, compression: str) -> None:
        file.add_chunk(compressed(table, compression, compressor(compression)), table)

    def _take_chunk(self, file: McapFile, given: Chunk, at: int) -> None:
        chunk = given
        try:
            data = inflated(chunk)
        except NotOneFrameError:
            chunk = replace(chunk, compression="", data=salvaged(chunk))
            data = inflated(chunk)
        table = self._whole_messages(file, data)
        require(len(table.data) == len(data), "a record in it is not whole")
        first_ns, last_ns = table.span_ns
        file.add_chunk(replace(chunk, message_start_time=first_ns, message_end_time=last_ns), table)
        if chunk is not given:
            self._rewritten.append(at)

    def _take_part(self, file: McapFile, raw: bytes) -> None:
        """Take the whole messages of an unfinished chunk, as far as it can be inflated."""
        if raw[:1] == bytes([Opcode.CHUNK]):
            with suppress(*_DAMAGE):
                chunk = Chunk.read(ReadDataStream(BytesIO(raw[RECORD_HEAD.size :])))  # which is not whole
                self._add(file, self._whole_messages(file, salvaged(chunk)), chunk.compression)

    def _whole_messages(self, file: McapFile, data: bytes) -> MessageTable:
        """Table of the messages in the whole records at the start of some data; at least one must be a message."""
        table = find_messages(data, NO_HINTS, self._records_left)
        self._records_left -= len(table.starts) + len(table.others)
        for place in table.others:
            if place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                file.summary.add(parsed(place.opcode, data[place.begin : place.end]), place.start, 0)
        require(bool(table.index), "no message is whole")
        require(table.index.keys() <= file.summary.channels.keys(), "a message is on no channel")
        return table


def recover_folder(broken: Path, fixed: Path) -> dict[Path, Recovery | NothingWholeError]:
    """Write every whole message of the MCAP files of a folder into those of a new one, file by file.

    Its files are named after the new folder, as those of rosbag2 are; metadata.yaml is left to ``ros2 bag reindex``.

    Parameters
    ----------
    broken : Path
        It is only read, and its metadata not even that.
    fixed : Path
        Must not exist.

    Returns
    -------
    dict of Path to Recovery or NothingWholeError
        What was recovered of each file, in their order, or why nothing was, as of one that was just begun.

    Raises
    ------
    BagError
        If the folder is none of one bag or has no whole message, or the new one cannot be written.
    """
    files = sorted(broken.glob("*.mcap"), key=natural_order)
    if not files:
        raise BagError(f"{broken} is a folder without MCAP files: give a bag")
    if not is_one_bag(broken):
        raise BagError(f"{broken} is not the folder of one bag: recover the MCAP files in it one by one")
    _make(broken, fixed)
    found = dict[Path, Recovery | NothingWholeError]()
    try:
        whole = 0
        for file in files:
            found[file] = _recovered(file, fixed / f"{fixed.resolve().name}_{whole}.mcap")
            whole += isinstance(found[file], Recovery)
        if not whole:
            raise BagError(f"{broken} holds no whole message: record it again")
    except BaseException:
        shutil.rmtree(fixed, ignore_errors=True)
        raise
    return found


def _make(broken: Path, fixed: Path) -> None:
    if fixed.suffix.lower() == ".mcap":
        raise BagError(f"{broken} is a folder, and {fixed} is to be one: give a name that does not end in .mcap")
    if broken.resolve() in fixed.resolve().parents:
        raise BagError(f"{fixed} is in the broken folder itself, which is never touched: give another place")
    try:
        fixed.mkdir()
    except FileExistsError:
        raise BagError(f"{fixed} exists and is kept: give the name of a new folder") from None
    except OSError as error:
        raise BagError(f"{fixed} cannot be created: {reason(error)}: give a place where you may write") from None


def _recovered(file: Path, into: Path) -> Recovery | NothingWholeError:
    try:
        return recover(file, into, overwrite=False)
    except NothingWholeError as error:
        return error
