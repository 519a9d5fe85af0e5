"""The records of a chunk, inflated to the size that it declares and never beyond."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from io import BytesIO
from typing import Final

from mcap.records import Chunk

from lie_rigid_body.recording.records import ContradictionError, ExcessError, UnknownCompressionError, require
from lie_rigid_body.system.bounded_input import LARGEST_CHUNK

_MOST_RECORDS: Final = 65_536
_PIECE: Final = 64
"""Bytes that are given to a decompressor at a time where some are damaged: less than most blocks take, which are lost
with it."""
ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of a frame of zstd, and so of whatever it compressed."""
COMPRESSED_ONE_BY_ONE: Final = (
    "its messages are compressed one by one: record without '--compression-mode message', or unpack it with "
    "'ros2 bag convert'"
)
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": (
        "it is an SQLite bag: convert it with 'ros2 bag convert', or record in MCAP, the default of Jazzy"
    ),
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}
"""What files are that are no MCAP files, and what to do with them, by their first bytes."""
_LZ4_MAGIC: Final = b"\x04\x22\x4d\x18"
_RUN_OF_ONE_BYTE: Final = 1
"""Type number of a zstd block that repeats one byte, as often as its head says."""


class NotOneFrameError(ContradictionError):
    """The compressed bytes of a chunk that are more than one frame: readers differ in what they make of them."""


def other_format(data: bytes) -> str:
    """What a file of such first bytes is, and what to do with it; empty if that is not known."""
    return next((text for magic, text in _OTHER_FORMATS.items() if data.startswith(magic)), "")


def most_records(size: int) -> int:
    """The most records that the chunks of a file may hold: what differs in its time takes a byte of it, compressed.

    Parameters
    ----------
    size : int
        Of the file, bytes.
    """
    return _MOST_RECORDS + size


def inflated(chunk: Chunk) -> bytes:
    """The records of a chunk.

    Raises
    ------
    ContradictionError
        If the declared size is not what comes out, if the checksum differs, or if the chunk is too large or compressed
        in an unknown way.
    """
    size, name = chunk.uncompressed_size, chunk.compression
    data, frame = _inflate(chunk, size + 1)
    if frame < len(chunk.data):
        raise NotOneFrameError(_of_frames(name, chunk.data, frame))
    require(len(data) == size, f"a chunk does not inflate to the {size} bytes that it declares")
    require(frame == len(chunk.data), f"the {name} frame of a chunk has no end")
    crc = chunk.uncompressed_crc and zlib.crc32(data)
    require(crc == chunk.uncompressed_crc, f"the crc of a chunk is {crc:08x}, not {chunk.uncompressed_crc:08x}")
    return data


def salvaged(chunk: Chunk) -> bytes:
    """As much of the records of a chunk as can be inflated, of all of its frames."""
    return _inflate(chunk, chunk.uncompressed_size)[0]


def _inflate(chunk: Chunk, most: int) -> tuple[bytes, int]:
    """At most so many bytes of a chunk, and the size of its first compressed frame."""
    if chunk.compression not in _INFLATE:
        raise UnknownCompressionError(f"{chunk.compression!r}")
    if chunk.uncompressed_size > LARGEST_CHUNK:
        raise ExcessError(f"a chunk of {chunk.uncompressed_size} bytes")
    return _INFLATE[chunk.compression](chunk.data, most)


def _of_frames(compression: str, data: bytes, first: int) -> str:
    """Complaint about compressed bytes that go on behind their first frame."""
    if not first:
        return f"a chunk does not begin with a frame of {compression}"
    if data[first:].startswith(data[: len(ZSTD_MAGIC)]):
        return f"a chunk has several frames of {compression}, of which readers take one"
    return f"a chunk has {len(data) - first} bytes behind its frame of {compression}"


def _from_zstd(data: bytes, most: int) -> tuple[bytes, int]:
    """Inflate zstd; zstandard's own ``decompress`` would believe the size that the frame declares."""
    import zstandard  # only where it is needed: apt may have one of the two

    def read(piece: int) -> Iterator[bytes]:
        source, left = zstandard.ZstdDecompressor().stream_reader(BytesIO(data), piece, read_across_frames=True), most
        with suppress(zstandard.ZstdError):
            while left > 0 and (found := source.read1(left)):
                left -= len(found)
                yield found

    with suppress(zstandard.ZstdError):
        reader = zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True)
        return reader.read(most), _zstd_frame_size(data)
    return b"".join(read(_PIECE)), _zstd_frame_size(data)


def _zstd_frame_size(data: bytes) -> int:
    """Bytes of the frame at the beginning, by the heads of its blocks; 0 if there is none.

    The library has a function for that in C only, and its readers do not tell how far they read.
    """
    import zstandard

    if not data.startswith(ZSTD_MAGIC):
        return 0
    end, is_last = zstandard.frame_header_size(data), False
    while not is_last and end < len(data):
        head = int.from_bytes(data[end : end + 3], "little")
        is_last, kind, size = bool(head & 1), head >> 1 & 3, head >> 3
        end += 3 + (1 if kind == _RUN_OF_ONE_BYTE else size)
    has_checksum = zstandard.get_frame_parameters(data).has_checksum
    return end + (4 if has_checksum else 0) if is_last else len(data) + 1


def _from_lz4(data: bytes, most: int) -> tuple[bytes, int]:
    from lz4.frame import LZ4FrameDecompressor

    if not data.startswith(_LZ4_MAGIC):
        return b"", 0
    decompressor = LZ4FrameDecompressor()
    with suppress(RuntimeError):
        content = decompressor.decompress(data, max_length=most)
        behind = len(decompressor.unused_data or b"")
        if not behind:
            # it has not come to the end of what is too long, either
            return content, len(data) + (not decompressor.eof)
        return b"".join(_lz4_pieces(data, most)), len(data) - behind
    return b"".join(_lz4_pieces(data, most)), len(data) + 1


def _lz4_pieces(data: bytes, most: int) -> Iterator[bytes]:
    """What frames of lz4 hold, piece by piece, at most so many bytes; of a damaged one what comes before."""
    from lz4.frame import LZ4FrameDecompressor

    decompressor, at = LZ4FrameDecompressor(), 0
    with suppress(RuntimeError):
        while at < len(data) and most > 0:
            piece = data[at : at + _PIECE]
            found = decompressor.decompress(piece, max_length=most)
            at += len(piece) - len(decompressor.unused_data or b"")
            most -= len(found)
            yield found
            decompressor = LZ4FrameDecompressor() if decompressor.eof else decompressor


_INFLATE: Final[dict[str, Callable[[bytes, int], tuple[bytes, int]]]] = {
    "": lambda data, most: (data[:most], len(data)),
    "zstd": _from_zstd,
    "lz4": _from_lz4,
}
"""Functions that inflate, by the name of the compression.

Each takes compressed bytes and a largest size. It returns what they hold, of at most that size, and the number of bytes
that the first frame takes."""
