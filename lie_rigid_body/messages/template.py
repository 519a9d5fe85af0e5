"""Rows of bytes that are alike but for some words of eight bytes, such as the messages of a topic.

It imports nothing else of its room: the name of compiled code follows from every file that its own imports.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.compilation import Work

_U: Final = tuple(np.uint64(k) for k in range(57))
"""Unsigned numbers from 0 on: the compiler need not test an unsigned place for being negative."""
_FEW: Final = 8
"""Largest number of rows that are made one by one, as for a live node."""
_ENOUGH: Final = 4_000_000
"""Number of rows from which compiling pays: without it they take a second."""
_ENOUGH_TO_LOAD: Final = 400_000
"""Number of rows from which loading of compiled code pays."""


def put_rows(data: Any, places: Any, template: Any, offsets: Any, words: Any) -> None:
    """Write each row at its place in the data.

    Parameters
    ----------
    data : ndarray of uint8
    places : ndarray of int64, shape (N,)
        Byte of the data at which each row begins.
    template : ndarray of uint8
        The bytes that they have in common.
    offsets : ndarray of int64, shape (K,)
        Bytes of a row at which its words begin.
    words : ndarray of int64, shape (N, K)
    """
    for i in range(len(places)):
        row = np.uint64(places[i])
        for j in range(len(template)):
            data[row + np.uint64(j)] = template[j]
        for k in range(len(offsets)):
            at, word = row + np.uint64(offsets[k]), np.uint64(words[i, k])
            # little-endian; a compiler makes one store of it
            data[at] = np.uint8(word)
            data[at + _U[1]] = np.uint8(word >> _U[8])
            data[at + _U[2]] = np.uint8(word >> _U[16])
            data[at + _U[3]] = np.uint8(word >> _U[24])
            data[at + _U[4]] = np.uint8(word >> _U[32])
            data[at + _U[5]] = np.uint8(word >> _U[40])
            data[at + _U[6]] = np.uint8(word >> _U[48])
            data[at + _U[7]] = np.uint8(word >> _U[56])


PUT: Final = Work(
    put_rows,
    "void(uint8[::1], int64[::1], Array(uint8, 1, 'C', True), int64[::1], int64[:,::1])",
    _ENOUGH,
    _ENOUGH_TO_LOAD,
)
"""`put_rows`, compiled as soon as that pays."""


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
        offsets = [range(at, at + size, 8) for at, size in self._parts]
        self._offsets = np.array([*chain(*offsets)], dtype=np.int64)

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
            return map(bytes, self._few(words))
        data, size = self._many(words).tobytes(), self.size
        return (data[i : i + size] for i in range(0, len(data), size))

    def _few(self, words: Integers) -> Iterator[bytearray]:
        """Make rows one by one: a call of NumPy costs more than a row."""
        content, begin = words.tobytes(), 0
        for _ in range(len(words)):
            row = bytearray(self._data)
            for at, size in self._parts:
                row[at : at + size] = content[begin : begin + size]
                begin += size
            yield row

    def _many(self, words: Integers) -> NDArray[np.uint8]:
        """Make rows as an array, shape (N, size)."""
        rows, begin = np.empty((len(words), self.size), dtype=np.uint8), 0
        rows[:] = np.frombuffer(self._data, dtype=np.uint8)
        content = words.view(np.uint8)
        for at, size in self._parts:
            rows[:, at : at + size] = content[:, begin : begin + size]
            begin += size
        return rows

    def words(self, rows: NDArray[np.uint8]) -> Integers:
        """Find the words of some rows, given as bytes, shape (N, size); see `rows`."""
        parts = [np.ascontiguousarray(rows[:, at : at + size]).view("<i8") for at, size in self._parts]
        return np.concatenate(parts, axis=1)

    def put(self, data: NDArray[np.uint8], places: Integers, words: Integers) -> None:
        """Write the rows with some words into data, each where its place says; see `rows`."""
        if len(words) <= _FEW:
            view = memoryview(data)
            for place, row in zip(places.tolist(), self._few(words), strict=True):
                view[place : place + self.size] = row
        elif (compiled := PUT.compiled_for(len(words))) is not None:
            alike = np.frombuffer(self._data, dtype=np.uint8)
            compiled(data, places, alike, self._offsets, words.astype(np.int64, copy=False))
        else:
            kind = f"V{self.size}"
            # an item of that size at each byte of the data; they overlap
            items = np.ndarray(len(data) - self.size + 1, dtype=kind, buffer=data, strides=(1,))
            items[places] = self._many(words).view(kind)[:, 0]
