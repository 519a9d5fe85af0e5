"""Runs of whole numbers that follow each other: those of samples that are there, doubled or missing."""

from __future__ import annotations

from itertools import islice

import numpy as np

from lie_rigid_body.arrays import Integers


class NumberRuns:
    """Whole numbers that come in any order, kept as runs: 16 bytes each, of a whole recording nearly nothing."""

    def __init__(self) -> None:
        self._runs: list[Integers] = []  # first and last of each, shape (2, N)

    def add(self, numbers: Integers) -> None:
        """Take at least one number; one that is there already counts again."""
        numbers = np.sort(numbers)
        breaks = np.flatnonzero(np.diff(numbers) != 1)
        runs = np.stack([numbers[np.append(0, breaks + 1)], numbers[np.append(breaks, len(numbers) - 1)]])
        if self._runs and runs[0, 0] == self._runs[-1][1, -1] + 1:
            self._runs[-1][1, -1] = runs[1, 0]
            runs = runs[:, 1:]
        self._runs += [runs] if runs.size else []

    def counted(self, first: int, last: int) -> tuple[Integers, Integers]:
        """Stretches of numbers between two that are there equally often.

        Parameters
        ----------
        first, last : int

        Returns
        -------
        begins : ndarray of int64, shape (M + 1,)
            The number with which each begins, and the one behind the last.
        times : ndarray of int64, shape (M,)
            How often each of its numbers is there.
        """
        begins, ends = np.concatenate([np.empty((2, 0), dtype=np.int64), *self._runs], axis=1)
        begins, behind = np.sort(begins), np.sort(ends + 1)
        edges = np.unique(np.concatenate([[first, last + 1], begins, behind]))
        edges = edges[(edges >= first) & (edges <= last + 1)]
        times = (np.searchsorted(each, edges[:-1], side="right") for each in (begins, behind))
        return edges, next(times) - next(times)


class RunList:
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

    def first(self) -> list[int]:
        """The lowest numbers, as many as runs are listed at most."""
        numbers = (number for begin, end in self.listed for number in range(begin, end + 1))
        return list(islice(numbers, self._most))
