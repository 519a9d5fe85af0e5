"""The records of a chunk, decompressed to the size that it declares and never beyond."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from contextlib import suppress
from io import BytesIO
from typing import Any, Final

from mcap.records import Chunk

from lie_rigid_body.recording.records import ExcessError, UnknownCompressionError, require
from lie_rigid_body.system.bounded_input import MAX_CHUNK_BYTES

ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of a frame of zstd, and so of whatever it compressed."""
COMPRESSED_ONE_BY_ONE: Final = (
    "its messages are compressed one by one: record without '--compression-mode message', or unpack it with "
    "'ros2 bag convert'"
)
_OTHER_FORMATS: Final = {
    b"SQLite format 3\x00": (
        "it is an SQLite bag: convert it with 'ros2 bag convert', or record in MCAP, the default from Jazzy on"
    ),
    b"#ROSBAG V2.0": "it is a ROS 1 bag: convert it with 'mcap convert'",
    ZSTD_MAGIC: "it is zstd-compressed as a whole: unpack it with 'unzstd'",
}
"""Formats of files that are no MCAP files, and the remedies, by their first bytes."""


def other_format(data: bytes) -> str:
    """Format of a file of such first bytes, and the remedy; empty if it is not known."""
    return next((text for magic, text in _OTHER_FORMATS.items() if data.startswith(magic)), "")


def decompress(chunk: Chunk) -> bytes:
    """The records of a chunk, be it compressed in one frame or in several.

    Raises
    ------
    DamageError
        If the declared size is not what comes out, if the checksum differs, or if the chunk is too large or compressed
        in an unknown way.
    """
    data = decompress_partial(chunk, whole=True)
    size = chunk.uncompressed_size
    require(len(data) == size, f"a chunk does not inflate to the {size} bytes that it declares")
    crc = chunk.uncompressed_crc and zlib.crc32(data)
    require(crc == chunk.uncompressed_crc, f"the crc of a chunk is {crc:08x}, not {chunk.uncompressed_crc:08x}")
    return data


def decompress_partial(chunk: Chunk, *, whole: bool = False) -> bytes:
    """As much of the records of a chunk as can be decompressed; where all is wanted at once."""
    if not chunk.compression:
        return chunk.data
    if chunk.compression not in _READERS:
        raise UnknownCompressionError(f"{chunk.compression!r:.40}")
    if chunk.uncompressed_size > MAX_CHUNK_BYTES:
        raise ExcessError(f"a chunk of {chunk.uncompressed_size} bytes")
    source = _READERS[chunk.compression](chunk.data)
    read = source.read if whole else source.read1  # which loses nothing before what is damaged
    rest = chunk.uncompressed_size
    pieces = list[bytes]()
    with suppress(Exception):  # each library has errors of its own for damaged bytes
        while rest and (piece := read(rest)):
            rest -= len(piece)
            pieces.append(piece)
    return b"".join(pieces)


def _of_zstd(data: bytes) -> Any:
    """Content of frames of zstd; zstandard's own ``decompress`` would believe the size that the frame declares."""
    import zstandard  # only where it is needed: apt may have one of the two

    return zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True)


def _of_lz4(data: bytes) -> Any:
    import lz4.frame

    return lz4.frame.open(BytesIO(data))


_READERS: Final[dict[str, Callable[[bytes], Any]]] = {"zstd": _of_zstd, "lz4": _of_lz4}
"""Functions that open what is compressed for reading, by the name of the compression."""
