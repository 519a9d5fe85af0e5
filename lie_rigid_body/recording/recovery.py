"""Recovering the whole messages of an MCAP file that was cut off, into a new file that is whole."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema

from lie_rigid_body.bounded_input import open_file
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording.bag_writer import CUT_OFF
from lie_rigid_body.recording.chunk import MAGIC, RawChunk
from lie_rigid_body.recording.inflation import LARGEST_CHUNK, NotOneFrameError, inflated, most_records
from lie_rigid_body.recording.mcap_file import McapFile, compressed, compressor
from lie_rigid_body.recording.message_table import RECORD_HEAD, MessageTable, parsed, records, require
from lie_rigid_body.recording.output_file import NO_ROOM, OutputFile, reason, require_other, unwritten
from lie_rigid_body.wording import short_repr

LOOSE_BYTES: Final = 256 * 1024
"""Size of the chunks into which messages are put that are in none."""
_MESSAGE: Final = struct.Struct("<HIQQ")
_CHUNK: Final = struct.Struct("<QQQII")
_PIECE: Final = 65_536
_PARSERS: Final[dict[int, Callable[..., Any]]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
}
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
        self._stream, self._out = stream, out
        self._size = stream.seek(0, 2)
        self._records_left = most_records(self._size)
        self._position = len(MAGIC)
        self._file: McapFile | None = None
        self._loose = bytearray()
        self._damaged: list[int] = []
        self._rewritten: list[int] = []
        self._data_ended = False

    def run(self) -> Recovery | None:
        """Recover what there is; None if that is nothing."""
        unfinished = self._take_whole_records()
        self._close_loose()
        file = self._file
        if file is None:
            return None
        before = file.message_count
        self._take_part(file, unfinished or b"")
        if file.log_times_ns is None:
            return None
        if unfinished is not None:
            file.add(Metadata(CUT_OFF, {"broken_at": str(self._position)}))
        file.finish()
        return Recovery(
            file.message_count,
            len(file.channels),
            file.log_times_ns,
            None if unfinished is None else self._position,
            file.message_count - before,
            tuple(self._damaged),
            tuple(self._rewritten),
        )

    def _take_whole_records(self) -> bytes | None:
        """Take record after record; return what there is of an unfinished chunk, or None if the file has its end."""
        while True:
            self._stream.seek(self._position)
            head = self._stream.read(RECORD_HEAD.size)
            opcode, length = RECORD_HEAD.unpack(head) if len(head) == RECORD_HEAD.size else (0, 0)
            end = self._position + RECORD_HEAD.size + length
            if opcode == 0 or end > self._size:
                return self._stream.read() if opcode == Opcode.CHUNK else b""
            content = self._stream.read(length)
            if opcode == Opcode.FOOTER:
                return None if self._stream.read() == MAGIC else b""
            try:
                self._take(opcode, content)
            except _DAMAGE:
                self._damaged.append(self._position)
            self._position = end

    def _take(self, opcode: int, content: bytes) -> None:
        if opcode == Opcode.HEADER and self._file is None:
            self._file = McapFile(self._out, parsed(Header.read, content))
        self._data_ended |= opcode == Opcode.DATA_END
        if self._file is None or self._data_ended:
            return
        if opcode == Opcode.MESSAGE:
            channel, *_ = _MESSAGE.unpack_from(content)
            require(channel in self._file.channels, "a message is on no channel")
            self._loose += RECORD_HEAD.pack(opcode, len(content)) + content
            if len(self._loose) > LOOSE_BYTES:
                self._close_loose()
            return
        self._close_loose()
        if opcode == Opcode.CHUNK:
            self._take_chunk(self._file, parsed(Chunk.read, content))
        elif opcode in _PARSERS:
            self._file.add(parsed(_PARSERS[opcode], content))

    def _close_loose(self) -> None:
        """Write the messages that are in no chunk in one."""
        data, self._loose = bytes(self._loose), bytearray()
        if self._file is not None and data:
            raw = self._whole_messages(self._file, data)
            self._file.add_chunk(compressed(raw, "zstd", compressor("zstd")), raw.indexes())

    def _take_chunk(self, file: McapFile, given: Chunk) -> None:
        _require_size(given.uncompressed_size)
        chunk = given
        try:
            data = inflated(chunk)
        except NotOneFrameError:
            unpacked = _unpacked(chunk.compression, chunk.data, chunk.uncompressed_size)
            chunk = replace(chunk, compression="", data=unpacked)
            data = inflated(chunk)
        raw = self._whole_messages(file, data)
        if len(raw.data) < len(data):
            raise ValueError("a record in it is not whole")
        first_ns, last_ns = raw.log_times_ns()
        whole = replace(chunk, message_start_time=first_ns, message_end_time=last_ns)
        file.add_chunk(whole, raw.indexes())
        if chunk is not given:
            self._rewritten.append(self._position)

    def _take_part(self, file: McapFile, content: bytes) -> None:
        """Take the whole messages of an unfinished chunk, as far as it can be unpacked."""
        try:
            *_, size, _, length = _CHUNK.unpack_from(content)
            compression, begin = content[_CHUNK.size : _CHUNK.size + length].decode(), _CHUNK.size + length + 8
            data = _unpacked(compression, content[begin:], size)
            raw = self._whole_messages(file, data)
        except _DAMAGE:
            return
        file.add_chunk(compressed(raw, compression, compressor(compression)), raw.indexes())

    def _whole_messages(self, file: McapFile, data: bytes) -> RawChunk:
        """Make a chunk of the whole records at the start of some data; at least one must be a message."""
        end, found = 0, array("q")
        for opcode, begin, stop in records(data):
            self._records_left -= 1
            require(self._records_left >= 0, "its records are more than are read")
            if opcode == 0:
                break
            if opcode == Opcode.MESSAGE:
                found.extend((begin - RECORD_HEAD.size, stop))
            elif opcode == Opcode.SCHEMA:
                schema = parsed(Schema.read, data[begin:stop])
                file.schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = parsed(Channel.read, data[begin:stop])
                file.channels[channel.id] = channel
            end = stop
        require(bool(found), "no message is whole")
        places = np.frombuffer(found, dtype=np.int64).reshape(-1, 2)
        table = MessageTable.of(data, places[:, 0], places[:, 1])
        require(table.counts.keys() <= file.channels.keys(), "a message is on no channel")
        return RawChunk([data[:end]], [*table.entries.values()])


def _require_size(size: int) -> None:
    """Refuse to inflate a chunk to more than that: a damaged one may claim any size."""
    if size > LARGEST_CHUNK:
        raise ValueError("it is too large")


def _unpacked(compression: str, data: bytes, size: int) -> bytes:
    """As much of a chunk as can be unpacked, at most its size."""
    _require_size(size)
    if compression == "zstd":
        return b"".join(_zstd_pieces(data, size))
    if compression == "lz4":
        return b"".join(_lz4_frames(data, size))
    if compression:
        raise ValueError("its compression is unknown")
    return data[:size]


def _zstd_pieces(data: bytes, size: int) -> Iterator[bytes]:
    with zstandard.ZstdDecompressor().stream_reader(BytesIO(data), read_across_frames=True) as reader:
        try:
            while size > 0 and (piece := reader.read(min(size, _PIECE))):
                size -= len(piece)
                yield piece
        except zstandard.ZstdError:
            return  # what came before is whole


def _lz4_frames(data: bytes, size: int) -> Iterator[bytes]:
    from lz4.frame import LZ4FrameDecompressor

    while data and size > 0:
        decompressor = LZ4FrameDecompressor()
        try:
            unpacked: bytes = decompressor.decompress(data, max_length=size)
        except RuntimeError:
            return  # what came before is whole
        size -= len(unpacked)
        yield unpacked
        data = decompressor.unused_data or b""
