"""Sets of whole numbers most of which follow each other, in a bit or less for each."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers, runs_of

PAGE: Final = 2**15
"""Numbers that are kept together."""
_FULL: Final = b""
"""A page that has all of its numbers."""


class NumberSet:
    """A set of whole numbers; what is in order or missing in long runs takes next to nothing.

    Attributes
    ----------
    count : int
        How many there are.
    """

    def __init__(self) -> None:
        self._pages: dict[int, bytes] = {}
        self.count = 0

    def add(self, numbers: Integers) -> None:
        """Take numbers that rise."""
        for page, offsets in _by_page(numbers):
            there = self.page(page)
            self.count -= int(np.count_nonzero(there))
            there[offsets] = True
            count = int(np.count_nonzero(there))
            self.count += count
            self._pages[page] = _FULL if count == PAGE else zlib.compress(np.packbits(there).tobytes(), 1)

    def has(self, numbers: Integers) -> Booleans:
        """Which of some numbers that rise are in the set."""
        found = [self.page(page)[offsets] for page, offsets in _by_page(numbers)]
        return np.concatenate([np.empty(0, dtype=np.bool_), *found])

    def page(self, number: int) -> Booleans:
        """Which numbers of a page are in the set, from ``number * PAGE`` on, shape (PAGE,)."""
        kept = self._pages.get(number)
        if not kept:
            return np.full(PAGE, fill_value=kept == _FULL)
        return np.unpackbits(np.frombuffer(zlib.decompress(kept), dtype=np.uint8)).view(np.bool_)

    def first(self, most: int) -> list[int]:
        """The lowest numbers of the set, so many at most."""
        found: list[int] = []
        for page in sorted(self._pages):
            if len(found) >= most:
                break
            found += (page * PAGE + np.flatnonzero(self.page(page))[: most - len(found)]).tolist()
        return found

    def missing(self, first: int, last: int) -> Iterator[tuple[Integers, Integers]]:
        """First and last of each run of numbers between two that are not in the set, some runs at a time.

        A run may come in parts, one after the other.
        """
        at = first
        for page in sorted(page for page in self._pages if first // PAGE <= page <= last // PAGE):
            begin, end = max(first, page * PAGE), min(last, page * PAGE + PAGE - 1)
            if begin > at:
                yield np.array([at]), np.array([begin - 1])
            at = end + 1
            if self._pages[page] != _FULL:
                yield runs_of(begin, ~self.page(page)[begin - page * PAGE : at - page * PAGE])
        if at <= last:
            yield np.array([at]), np.array([last])


class Runs:
    """Runs of numbers as they come, rising: how many there are, of how many numbers, and which come first.

    Parameters
    ----------
    most : int
        How many are listed.

    Attributes
    ----------
    count, total : int
    listed : list of (int, int)
        First and last of each.
    """

    def __init__(self, most: int) -> None:
        self._most, self._end = most, 0
        self.count = self.total = 0
        self.listed: list[tuple[int, int]] = []

    def add(self, begins: Integers, ends: Integers) -> None:
        """Take the runs that come next, the first of which may continue the last one."""
        if not len(begins):
            return
        self.total += int((ends - begins + 1).sum())
        if self.count and begins[0] == self._end + 1:
            if self.count == len(self.listed):
                self.listed[-1] = self.listed[-1][0], int(ends[0])
            begins, ends, self._end = begins[1:], ends[1:], int(ends[0])
        if len(begins):
            self.count += len(begins)
            more = self._most - len(self.listed)
            self.listed += zip(begins[:more].tolist(), ends[:more].tolist(), strict=True)
            self._end = int(ends[-1])


def _by_page(numbers: Integers) -> Iterator[tuple[int, Integers]]:
    """The pages of numbers that rise, and which of their numbers each has."""
    pages = numbers // PAGE
    edges = [0, *(np.flatnonzero(np.diff(pages)) + 1).tolist(), len(numbers)]
    for begin, end in itertools.pairwise(edges):
        if begin < end:
            page = int(pages[begin])
            yield page, numbers[begin:end] - page * PAGE
