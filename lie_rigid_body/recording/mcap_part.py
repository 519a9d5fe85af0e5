"""Parts of an MCAP file that hold messages: a chunk with the indexes behind it, or messages that stand in no chunk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk

from lie_rigid_body.arrays import Integers
from lie_rigid_body.recording.inflation import COMPRESSIONS, LARGEST_CHUNK, inflated
from lie_rigid_body.recording.message_table import (
    NO_HINTS,
    ContradictionError,
    ExcessError,
    MessageTable,
    Place,
    find_messages,
    parsed,
    records,
)


class UnknownCompressionError(Exception):
    """A chunk that is compressed in a way that is not known here. The message names it."""


@dataclass(frozen=True)
class McapPart:
    """Part of a file with messages.

    Parameters
    ----------
    raw : bytes
        Its records as they stand in the file.
    chunk : Chunk or None
        Its chunk, if it is one.
    data : bytes
        Records with the messages: those of the chunk inflated, or all.
    size : int
        Bytes of the chunk's record without its head.
    indexes : tuple of Place
        Message indexes behind the chunk.
    """

    raw: bytes
    chunk: Chunk | None
    data: bytes
    size: int
    indexes: tuple[Place, ...]

    @classmethod
    def of(cls, raw: bytes, inflate: Callable[[Chunk], bytes] = inflated) -> McapPart:
        """Part that consists of some records.

        Parameters
        ----------
        raw : bytes
        inflate : callable, optional
            Gives the records of a chunk.

        Raises
        ------
        ContradictionError, ExcessError, UnknownCompressionError
            If a chunk is damaged, too large or cannot be inflated.
        """
        first, *rest = records(raw) if raw[:1] == bytes([Opcode.CHUNK]) else (None,)
        if first is None:
            return cls(raw, None, raw, 0, ())
        chunk = parsed(Chunk.read, raw[first.begin : first.end])
        if chunk.compression not in COMPRESSIONS:
            raise UnknownCompressionError(f"{chunk.compression!r}")
        if chunk.uncompressed_size > LARGEST_CHUNK:
            raise ExcessError(f"a chunk of {chunk.uncompressed_size} bytes")
        try:
            return cls(raw, chunk, inflate(chunk), first.end - first.begin, tuple(rest))
        except ValueError as error:
            raise ContradictionError(str(error)) from None

    def messages(self, most: int) -> tuple[MessageTable, list[Place]]:
        """Messages and other records of its data; see `find_messages`."""
        return find_messages(self.data, self._hints(), most)

    def _hints(self) -> Integers:
        """Bytes of the data where the indexes say that messages begin."""
        rows = (self.raw[place.begin + 6 : place.end] for place in self.indexes)
        return np.concatenate([NO_HINTS, *(np.frombuffer(row[: len(row) // 16 * 16], "<i8")[1::2] for row in rows)])
