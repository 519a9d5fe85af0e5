"""Reading an MCAP file into raw messages by topic: every record framed, every checksum compared, nothing guessed.

The `mcap` library's own reader takes the end of a file for the end of a record; a cut would go unnoticed there.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Final, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, Header, Metadata, Schema
from mcap.writer import MCAP0_MAGIC as MAGIC

from lie_rigid_body.bounded_input import open_file
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording.inflation import COMPRESSIONS, LARGEST_CHUNK, inflated
from lie_rigid_body.recording.output_file import reason, rescue
from lie_rigid_body.wording import short_repr

T = TypeVar("T")

_HEAD: Final = struct.Struct("<BQ")
_MESSAGE: Final = struct.Struct("<HIQQ")
ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of whatever zstd compressed."""
_IN_CHUNKS: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
"""The only records that a chunk may hold."""
LARGEST_RECORD: Final = LARGEST_CHUNK + 2**16
"""Largest size of a record, bytes."""
_KEPT_AT_LEAST: Final = 64 * 2**20
_KEPT_PER_BYTE: Final = 200
"""Limits of what a file's messages may take, bytes and bytes per byte of the file. What moves compresses to 1/20."""
_PER_MESSAGE: Final = 100
"""About the bytes that a message takes beside its content."""
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": "it is an SQLite bag: record with 'ros2 bag record -s mcap', or convert it",
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}


@dataclass
class RawTrack:
    """The messages of one type on one topic, undecoded, in file order.

    Attributes
    ----------
    topic, message_type, encoding : str
    log_times_ns : list of int
    payloads : list of bytes
        Empty when the type was not wanted.
    count : int
        Messages, wanted or not.
    """

    topic: str
    message_type: str
    encoding: str
    log_times_ns: list[int] = field(default_factory=list)
    payloads: list[bytes] = field(default_factory=list)
    count: int = 0

    __repr__ = short_repr


@dataclass
class McapContents:
    """The messages and metadata of a file, or of several that continue each other.

    Attributes
    ----------
    library : str
        The software that wrote the first file.
    tracks : dict of (topic, message type) to RawTrack
    metadata : dict of str to dict
        Metadata records by name.
    """

    library: str = ""
    tracks: dict[tuple[str, str], RawTrack] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)

    __repr__ = short_repr

    @property
    def message_count(self) -> int:
        """Messages on all topics."""
        return sum(track.count for track in self.tracks.values())


def read_file(path: Path, wanted: Collection[str], into: McapContents) -> None:
    """Add a file's messages to the tracks.

    Parameters
    ----------
    path : Path
    wanted : collection of str
        Message types whose payloads are kept.
    into : McapContents

    Raises
    ------
    BagError
        If the file cannot be read, is no MCAP file, is cut off or damaged.
    """
    with _opened(path) as stream:
        try:
            _FileReader(path, stream, wanted, into).read()
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: copy it to a better place") from None


def _opened(path: Path) -> BinaryIO:
    try:
        return open_file(path)
    except InputError as error:
        raise BagError(str(error)) from None
    except FileNotFoundError:
        raise BagError(f"{path} does not exist: give the path of an MCAP file") from None
    except (OSError, ValueError) as error:
        raise BagError(f"{path} cannot be read: {reason(error)}: give another file") from None


class _FileReader:
    """One file, read from its start to its end."""

    def __init__(self, path: Path, stream: BinaryIO, wanted: Collection[str], into: McapContents) -> None:
        self._path, self._stream, self._wanted, self._into = path, stream, wanted, into
        self._size = stream.seek(0, 2)
        self._types: dict[int, str] = {0: ""}
        self._channels: dict[int, RawTrack] = {}
        self._chunks = 0
        self._before = into.message_count
        self._kept = 0  # bytes, about
        self._crc = 0  # of the data section, then of the summary
        self._position = 0

    def read(self) -> None:
        self._require_magic()
        self._stream.seek(len(MAGIC))
        self._position = len(MAGIC)
        self._crc = zlib.crc32(MAGIC)
        while self._read_record() != Opcode.FOOTER:
            pass
        if self._stream.read() != MAGIC:
            raise self._cut_off()

    def _require_magic(self) -> None:
        self._stream.seek(0)
        start = self._stream.read(16)
        if not start:
            raise BagError(f"{self._path} is empty: record it again, it holds nothing to rescue")
        if not start.startswith(MAGIC):
            hint = next((text for magic, text in _OTHER_FORMATS.items() if start.startswith(magic)), "")
            raise BagError(f"{self._path} is not an MCAP file: {hint or f'it begins with {start[:8]!r}: give a bag'}")

    def _read_record(self) -> int:
        head = self._stream.read(_HEAD.size)
        if len(head) < _HEAD.size:
            raise self._cut_off()
        opcode, length = _HEAD.unpack(head)
        too_long = length > self._size - self._position - _HEAD.size
        if too_long and self._ends_well():
            raise self._damaged("a record is longer than the file")
        if too_long or opcode == 0:
            raise self._cut_off()
        if length > LARGEST_RECORD:
            raise self._too_large(f"a record of {length} bytes")
        content = self._stream.read(length)
        self._verify_section(opcode, head, content)
        try:
            self._take(opcode, content)
        except (BagError, ModuleNotFoundError):
            raise
        except Exception as error:  # the library's parsers fail in many ways on damaged bytes
            raise self._damaged(f"{type(error).__name__}: {error}" if str(error) else type(error).__name__) from None
        self._position += _HEAD.size + length
        return int(opcode)

    def _verify_section(self, opcode: int, head: bytes, content: bytes) -> None:
        if opcode == Opcode.DATA_END:
            self._compare(content, 0, "data section")
            self._crc = 0
        elif opcode == Opcode.FOOTER:
            self._crc = zlib.crc32(content[:16], zlib.crc32(head, self._crc))
            self._compare(content, 16, "summary")
        else:
            self._crc = zlib.crc32(content, zlib.crc32(head, self._crc))

    def _compare(self, content: bytes, at: int, what: str) -> None:
        declared = int.from_bytes(content[at : at + 4], "little")
        if declared not in (0, self._crc):
            raise self._damaged(f"the checksum of its {what} is {self._crc:08x}, not {declared:08x}")

    def _take(self, opcode: int, content: bytes) -> None:
        if opcode == Opcode.MESSAGE:
            self._message(content, 0, len(content))
        elif opcode == Opcode.CHUNK:
            self._chunk(_parse(Chunk.read, content))
        elif opcode == Opcode.SCHEMA:
            schema = _parse(Schema.read, content)
            self._types[schema.id] = schema.name
        elif opcode == Opcode.CHANNEL:
            self._channel(_parse(Channel.read, content))
        elif opcode == Opcode.HEADER:
            self._into.library = self._into.library or _parse(Header.read, content).library
        elif opcode == Opcode.METADATA:
            record = _parse(Metadata.read, content)
            self._into.metadata[record.name] = record.metadata
        elif opcode == Opcode.FOOTER:
            _parse(Footer.read, content)

    def _channel(self, channel: Channel) -> None:
        key = channel.topic, self._types[channel.schema_id]
        self._channels[channel.id] = self._into.tracks.setdefault(key, RawTrack(*key, channel.message_encoding))

    def _chunk(self, chunk: Chunk) -> None:
        if chunk.compression not in COMPRESSIONS:
            raise BagError(
                f"{self._path} is compressed with {chunk.compression!r}, which is unknown here: "
                "rewrite it with 'mcap compress'"
            )
        if chunk.uncompressed_size > LARGEST_CHUNK:
            raise self._too_large(f"a chunk of {chunk.uncompressed_size} bytes")
        try:
            data, position = inflated(chunk), 0
        except ValueError as error:
            raise self._damaged(str(error)) from None
        size = len(data)
        while position < size:
            opcode, length = _HEAD.unpack_from(data, position)
            position += _HEAD.size
            end = position + length
            if end > size:
                raise self._damaged("a record is longer than its chunk")
            if opcode == Opcode.MESSAGE:
                self._message(data, position, end)
            elif opcode in _IN_CHUNKS:
                self._take(opcode, data[position:end])
            else:
                raise self._damaged(f"a record of kind {opcode:#04x} in a chunk")
            position = end
        self._chunks += 1

    def _message(self, data: bytes, start: int, end: int) -> None:
        channel, _, log_time, _ = _MESSAGE.unpack_from(data, start)
        track = self._channels[channel]
        track.count += 1
        if track.message_type in self._wanted:
            track.log_times_ns.append(log_time)
            track.payloads.append(data[start + _MESSAGE.size : end])
            self._kept += end - start + _PER_MESSAGE
            if self._kept > max(_KEPT_AT_LEAST, _KEPT_PER_BYTE * self._size):
                raise self._too_large(f"messages of {self._kept} bytes in a file of {self._size}")

    def _ends_well(self) -> bool:
        self._stream.seek(-len(MAGIC), 2)
        return self._stream.read() == MAGIC

    def _cut_off(self) -> BagError:
        count = self._into.message_count - self._before
        return BagError(
            f"{self._path} was cut off, or is still being written: its {self._chunks} whole chunks hold {count} "
            f"messages; rescue them: {rescue(self._path)}"
        )

    def _too_large(self, what: str) -> BagError:
        return BagError(f"{self._path} has at byte {self._position} {what}, more than is read: record it again")

    def _damaged(self, what: str) -> BagError:
        return BagError(f"{self._path} is damaged at byte {self._position}: {what}: restore a copy, or record again")


def _parse(read: Callable[[ReadDataStream], T], content: bytes) -> T:
    return read(ReadDataStream(BytesIO(content)))
