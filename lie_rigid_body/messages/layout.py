"""The layout of messages in CDR: the fields that all share, and rows of bytes that differ in some words only."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass

ENCAPSULATION: Final = b"\x00\x01\x00\x00"
"""First bytes of a payload: plain CDR, little-endian, no options."""
FRAME_OFFSET: Final = 16
"""Byte of a payload at which the frame name of its header begins: after encapsulation, stamp and length of the name."""

POSE_NUMBERS: Final = 7
"""float64 fields of a pose: position x y z, orientation x y z w."""
TWIST_NUMBERS: Final = 6
"""float64 fields of a twist: linear x y z, angular x y z."""


def header(frame: str) -> bytes:
    """Encode the begin of a payload, with a std_msgs/Header of the stamp 0."""
    return ENCAPSULATION + bytes(8) + text(frame)


def numbers_after(end: int) -> int:
    """Byte at which float64 numbers begin in a payload whose other fields end at byte ``end``."""
    return 4 + -(-(end - 4) // 8) * 8


def text(value: str) -> bytes:
    """Encode a string: its length with the closing zero byte, and its bytes."""
    data = value.encode()
    return struct.pack("<I", len(data) + 1) + data + b"\x00"


class Template:
    """The bytes that rows have in common, and the places of the words in which they differ.

    Parameters
    ----------
    data : bytes
        A row; its words may have any value.
    runs : sequence of (int, int)
        Bytes of a row at which words of eight bytes begin, and how many words follow each other there.
    """

    def __init__(self, data: bytes, runs: Sequence[tuple[int, int]]) -> None:
        self._data = data
        self._parts = [(at, 8 * count) for at, count in runs]
        # the words of a row as they follow each other, and as they lie in it
        names = [f"{at}" for at, _ in self._parts]
        kinds = [f"V{size}" for _, size in self._parts]
        self._packed = np.dtype({"names": names, "formats": kinds})
        offsets = [at for at, _ in self._parts]
        self._placed = np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": len(data)})

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return len(self._data)

    def behind(self, head: bytes, runs: Sequence[tuple[int, int]]) -> Template:
        """Template of these rows with a head before each; the words of the head come first."""
        shifted = [(len(head) + at, size // 8) for at, size in self._parts]
        return Template(head + self._data, [*runs, *shifted])

    def rows(self, words: Integers) -> Iterator[bytes]:
        """Make the rows that have some words.

        Parameters
        ----------
        words : ndarray of little-endian int64, shape (N, K)
            The bits of each word, in the order of the runs.
        """
        data = self._many(words).tobytes()
        size = self.size
        return (data[i : i + size] for i in range(0, len(data), size))

    def _many(self, words: Integers) -> NDArray[np.void]:
        """Make rows as items of an array, shape (N,)."""
        rows = np.full(len(words), np.void(self._data))
        placed = rows.view(self._placed)
        packed = np.ascontiguousarray(words).view(self._packed)[:, 0]
        for name in self._packed.names or ():
            placed[name] = packed[name]
        return rows

    def words(self, rows: NDArray[np.uint8]) -> Integers:
        """Find the words of some rows, given as bytes, shape (N, size); see `rows`."""
        parts = [np.ascontiguousarray(rows[:, at : at + size]).view("<i8") for at, size in self._parts]
        return np.concatenate(parts, axis=1)

    def put(self, data: NDArray[np.uint8], places: Integers, words: Integers) -> None:
        """Write the rows with some words into data, each where its place says; see `rows`."""
        # an item of that size at each byte of the data; they overlap
        items = np.ndarray(max(0, len(data) - self.size + 1), f"V{self.size}", data, strides=(1,))
        items[places] = self._many(words)


@short_dataclass(eq=False)
class Payloads:
    """Messages of one size. Their bytes are laid out when they are asked for, or straight where they are wanted.

    Parameters
    ----------
    template : Template
        The bytes that they have in common.
    words : ndarray of little-endian int64, shape (N, K)
        The words in which they differ.
    """

    template: Template
    words: Integers

    def __len__(self) -> int:
        return len(self.words)

    def __getitem__(self, index: int) -> bytes:
        return next(self.template.rows(self.words[[index]]))

    def __iter__(self) -> Iterator[bytes]:
        return self.template.rows(self.words)


class Layout:
    """The bytes of a message type: a template, and the places of the fields that samples set.

    Parameters
    ----------
    head : bytes
        The bytes before its numbers, but for padding; see `header`.
    numbers : sequence of float
        Its float64 fields in order.
    places : sequence of sequence of int
        For each vector of a sample, the numbers that it is written to, rising.
    stamp : int or None, optional
        Byte at which the stamp begins, by default where a header has it; None: there is no stamp.
    """

    def __init__(
        self,
        head: bytes,
        numbers: Sequence[float],
        places: Sequence[Sequence[int]],
        stamp: int | None = len(ENCAPSULATION),
    ) -> None:
        start = numbers_after(len(head))
        template = head.ljust(start, b"\x00") + struct.pack(f"<{len(numbers)}d", *numbers)
        # the stamp's two halves, sec and nanosec, are one word
        stamps = [] if stamp is None else [(stamp, 1)]
        words = [(start + 8 * first, length) for vector in places for first, length in _runs(vector)]
        self._template = Template(template, [*stamps, *words])
        self._stamped = len(stamps)
        ends = list(accumulate(map(len, places), initial=self._stamped))
        self._columns = [slice(*bounds) for bounds in pairwise(ends)]

    def encode(self, stamps_ns: Integers, *vectors: Array) -> Payloads:
        """Encode one payload for each sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        *vectors : ndarray, shape (N, length)
            Vectors for each of the places.

        Returns
        -------
        Payloads
        """
        words = np.empty((len(stamps_ns), self._columns[-1].stop), dtype="<i8")
        if self._stamped:
            seconds, nanoseconds = np.divmod(stamps_ns, NS)
            words[:, 0] = nanoseconds << 32 | seconds & 0xFFFF_FFFF  # 32 bits each, of either sign
        numbers = words.view("<f8")
        for columns, values in zip(self._columns, vectors, strict=True):
            numbers[:, columns] = values
        return Payloads(self._template, words)


def _runs(numbers: Sequence[int]) -> Iterator[tuple[int, int]]:
    """First and length of each run of rising numbers that follow each other."""
    begins = [i for i, number in enumerate(numbers) if not i or number != numbers[i - 1] + 1]
    for begin, end in pairwise([*begins, len(numbers)]):
        yield numbers[begin], end - begin
