"""Rows in order of time that are kept in bounded memory."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.estimate import in_order

MOST_KEPT: Final = 100_000
"""Largest number of samples of the estimate, and of the poses, that are kept: a quarter of an hour at 100 Hz.

Of more every second is kept, then every fourth, and so on. Their score takes about 3 s; launch kills what does not end
within 10 s."""
MOST_BLOCKS: Final = 2000
"""Largest number of pieces of what is kept, before they are joined."""

Rows = tuple[Integers, Array]
"""Stamps, ns, shape (N,), and a row of numbers for each, shape (N, M)."""


class Kept:
    """Rows in order of time, of which evenly so many are kept that memory does not grow.

    Attributes
    ----------
    count, disordered : int
        Number of rows that came, and of those that were left out because they were stamped before an earlier one.
    first_ns, last_ns : int
        Stamps of the first row and of the last; 0 if there is none.
    stride : int
        One in so many is kept.
    """

    def __init__(self, most: int = MOST_KEPT) -> None:
        self.count = self.disordered = 0
        self.stride, self._most = 1, most
        self._blocks: list[Rows] = []
        self._size = 0
        self._last: Rows | None = None
        self.first_ns = self.last_ns = 0

    def add(self, stamps_ns: Integers, numbers: Array) -> Rows:
        """Take rows, and return those of them that are in order."""
        ordered = in_order(stamps_ns, self.last_ns if self.count else None)
        stamps, rows = stamps_ns[ordered], numbers[ordered]
        self.disordered += len(stamps_ns) - len(stamps)
        if len(stamps):
            self.first_ns, self.last_ns = self.first_ns if self.count else int(stamps[0]), int(stamps[-1])
            chosen = slice(-self.count % self.stride, None, self.stride)
            self._blocks.append((stamps[chosen], rows[chosen]))
            self._size += len(stamps[chosen])
            self.count += len(stamps)
            self._last = stamps[-1:], rows[-1:]
        if self._size > self._most or len(self._blocks) > MOST_BLOCKS:
            kept, values = joined(self._blocks)
            while len(kept) > self._most:
                kept, values, self.stride = kept[::2].copy(), values[::2].copy(), 2 * self.stride
            self._blocks, self._size = [(kept, values)], len(kept)
        return stamps, rows

    def rows(self) -> Rows:
        """Stamps, ns, and numbers of what is kept, and of the last row."""
        assert self._last is not None
        stamps, rows = joined(self._blocks)
        if (self.count - 1) % self.stride:
            return np.concatenate([stamps, self._last[0]]), np.concatenate([rows, self._last[1]])
        return stamps, rows


def joined(parts: Iterable[Rows]) -> Rows:
    """Rows after one another; of at least one part."""
    stamps, rows = zip(*parts, strict=True)
    return np.concatenate(stamps), np.concatenate(rows)
