"""The records of a chunk, inflated to the size that it declares and never beyond."""

from __future__ import annotations

import threading
import zlib
from collections.abc import Callable
from typing import Final

from mcap.records import Chunk

LARGEST_CHUNK: Final = 256 * 1024 * 1024
"""Largest size of an inflated chunk, bytes. Recorders make chunks of some MB, or of one message that is larger."""

_MOST_RECORDS: Final = 65_536

_OF_THREAD: Final = threading.local()
"""Decompressor of zstd of each thread: to make one for each chunk takes as long as to inflate a tenth of it."""

ZSTD_MAGIC: Final = b"\x28\xb5\x2f\xfd"
"""The first bytes of a frame of zstd, and so of whatever it compressed."""
COMPRESSED_ONE_BY_ONE: Final = (
    "its messages are compressed one by one: record without '--compression-mode message', or unpack it with "
    "'ros2 bag convert'"
)
_LZ4_MAGIC: Final = b"\x04\x22\x4d\x18"
_RUN_OF_ONE_BYTE: Final = 1
"""Number of the kind of a zstd block that holds one byte, and in its head how often that comes."""


class NotOneFrameError(ValueError):
    """The compressed bytes of a chunk that are more than one frame: readers differ in what they make of them."""


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
    ValueError
        If the declared size is not what comes out, or if the checksum differs.
    """
    data = inflated_unverified(chunk)
    crc = chunk.uncompressed_crc and zlib.crc32(data)
    if crc != chunk.uncompressed_crc:
        raise ValueError(f"the crc of a chunk is {crc:08x}, not {chunk.uncompressed_crc:08x}")
    return data


def inflated_unverified(chunk: Chunk) -> bytes:
    """The records of a chunk whose checksum was compared before."""
    size = chunk.uncompressed_size
    data, frame = _INFLATE[chunk.compression](chunk.data, size)
    if frame < len(chunk.data):
        raise NotOneFrameError(_of_frames(chunk.compression, chunk.data, frame))
    if len(data) != size:
        raise ValueError(f"a chunk does not inflate to the {size} bytes that it declares")
    if frame > len(chunk.data):
        raise ValueError(f"the {chunk.compression} frame of a chunk has no end")
    return data


def _of_frames(compression: str, data: bytes, first: int) -> str:
    """Complaint about compressed bytes of which only the first so many are a frame."""
    if not first:
        return f"a chunk does not begin with a frame of {compression}"
    if data[first:].startswith(data[: len(ZSTD_MAGIC)]):
        return f"a chunk has several frames of {compression}, of which readers take one"
    return f"a chunk has {len(data) - first} bytes behind its frame of {compression}"


def _from_zstd(data: bytes, size: int) -> tuple[bytes, int]:
    """Inflate zstd; zstandard's own ``decompress`` would believe the size that the frame declares."""
    import zstandard  # only where it is needed: apt may have one of the two

    if not (frame := _zstd_frame_size(data)):
        return b"", 0
    if not hasattr(_OF_THREAD, "decompressor"):
        _OF_THREAD.decompressor = zstandard.ZstdDecompressor()
    return _OF_THREAD.decompressor.stream_reader(data).read(size + 1), frame


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


def _from_lz4(data: bytes, size: int) -> tuple[bytes, int]:
    from lz4.frame import LZ4FrameDecompressor

    if not data.startswith(_LZ4_MAGIC):
        return b"", 0
    decompressor = LZ4FrameDecompressor()
    content: bytes = decompressor.decompress(data, max_length=size + 1)
    # it has not come to the end of what is too long, either
    return content, len(data) - len(decompressor.unused_data or b"") + (not decompressor.eof)


_INFLATE: Final[dict[str, Callable[[bytes, int], tuple[bytes, int]]]] = {
    "": lambda data, size: (data, len(data)),
    "zstd": _from_zstd,
    "lz4": _from_lz4,
}
"""Functions that inflate, by the name of the compression.

Each is given bytes and a size; it returns at most one byte more than so many, and the size of the compressed frame."""
COMPRESSIONS: Final = tuple(_INFLATE)
"""Names of the compressions that are read."""
