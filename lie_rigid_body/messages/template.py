"""Rows of bytes that are alike but for some words of eight bytes, such as the messages of a topic.

It imports nothing else of its room: the name of compiled code follows from every file that its own imports.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Integers
from lie_rigid_body.compilation import Work

_U: Final = tuple(np.uint64(k) for k in range(57))
"""Unsigned numbers: a compiler need not ask whether a place of that kind is negative."""
_ENOUGH: Final = 4_000_000
"""Number of rows from which on compiling pays: they take a second otherwise."""
_ENOUGH_TO_LOAD: Final = 400_000
"""The same where it is compiled already."""


def put_rows(data: Any, places: Any, template: Any, offsets: Any, words: Any) -> None:
    """Write each row at its place in the data.

    Parameters
    ----------
    data : ndarray of uint8
    places : ndarray of int64, shape (N,)
        Where in the data each row begins.
    template : ndarray of uint8
        What they have in common.
    offsets : ndarray of int64, shape (K,)
        Where in a row its words begin.
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
    """What rows of bytes have in common, and the places of the words in which they differ.

    Parameters
    ----------
    data : bytes
        A row, with any words.
    runs : sequence of (int, int)
        Where in a row words of eight bytes begin, and how many follow each other there.
    """

    def __init__(self, data: bytes, runs: Sequence[tuple[int, int]]) -> None:
        self._data = np.frombuffer(data, dtype=np.uint8)
        self._runs = list(runs)
        self._offsets = np.array([*chain(*(range(at, at + 8 * count, 8) for at, count in runs))], dtype=np.int64)

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return len(self._data)

    def rows(self, words: Integers) -> NDArray[np.uint8]:
        """The rows with some words.

        Parameters
        ----------
        words : ndarray of int64, shape (N, K)
            The bits of each word, in the order of the runs.

        Returns
        -------
        ndarray of uint8, shape (N, size)
        """
        rows, begin = np.empty((len(words), self.size), dtype=np.uint8), 0
        rows[:] = self._data
        content = words.astype("<i8", copy=False).view(np.uint8)
        for at, count in self._runs:
            end = begin + 8 * count
            rows[:, at : at + 8 * count] = content[:, begin:end]
            begin = end
        return rows

    def words(self, rows: NDArray[np.uint8]) -> Integers:
        """The words of some rows; see `rows`."""
        parts = [np.ascontiguousarray(rows[:, at : at + 8 * count]).view("<i8") for at, count in self._runs]
        return np.concatenate(parts, axis=1, dtype=np.int64)

    def put(self, data: NDArray[np.uint8], places: Integers, words: Integers) -> None:
        """Write the rows with some words into data, each where its place says; see `rows`."""
        compiled = PUT.compiled_for(len(places))
        if compiled is not None:
            compiled(data, places, self._data, self._offsets, words)
        elif len(places):
            kind = f"V{self.size}"
            # an item of that size at each byte of the data; they overlap
            items = np.ndarray(len(data) - self.size + 1, dtype=kind, buffer=data, strides=(1,))
            items[places] = self.rows(words).view(kind)[:, 0]
