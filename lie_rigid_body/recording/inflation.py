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
"""Its zstd decompressor: making one for each chunk takes as long as inflating a tenth of it."""


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
    data = _INFLATE[chunk.compression](chunk.data, size)
    if len(data) != size:
        raise ValueError(f"a chunk does not inflate to the {size} bytes that it declares")
    return data


def _from_zstd(data: bytes, size: int) -> bytes:
    """What zstandard's own ``decompress`` gives, which would believe the size that the frame declares."""
    import zstandard  # only where it is needed: apt may have one of the two

    if not hasattr(_OF_THREAD, "decompressor"):
        _OF_THREAD.decompressor = zstandard.ZstdDecompressor()
    content: bytes = _OF_THREAD.decompressor.stream_reader(data).read(size + 1)
    return content


def _from_lz4(data: bytes, size: int) -> bytes:
    from lz4.frame import LZ4FrameDecompressor

    content: bytes = LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    return content


_INFLATE: Final[dict[str, Callable[[bytes, int], bytes]]] = {
    "": lambda data, size: data,
    "zstd": _from_zstd,
    "lz4": _from_lz4,
}
COMPRESSIONS: Final = tuple(_INFLATE)
"""Names of the compressions that are read."""
