"""Rows of bytes that are alike but for some words of eight bytes, such as the messages of a topic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers

_FEW: Final = 8
"""Largest number of rows that are made one by one, as for a live node."""


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
        names, kinds = [f"{at}" for at, _ in self._parts], [f"V{size}" for _, size in self._parts]
        self._packed, offsets = np.dtype({"names": names, "formats": kinds}), [at for at, _ in self._parts]
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
        if len(words) <= _FEW:
            return self._few(words)
        data, size = self._many(words).tobytes(), self.size
        return (data[i : i + size] for i in range(0, len(data), size))

    def _few(self, words: Integers) -> Iterator[bytes]:
        """Make rows one by one: a call of NumPy costs more than a row."""
        content, begin = words.tobytes(), 0
        for _ in range(len(words)):
            row = bytearray(self._data)
            for at, size in self._parts:
                row[at : at + size] = content[begin : begin + size]
                begin += size
            yield bytes(row)

    def _many(self, words: Integers) -> NDArray[np.void]:
        """Make rows as items of an array, shape (N,)."""
        rows = np.full(len(words), np.void(self._data))
        placed, packed = rows.view(self._placed), np.ascontiguousarray(words).view(self._packed)[:, 0]
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
