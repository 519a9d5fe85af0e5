"""The law of the stamps: every topic has every sample once, in order, stamped on the nanosecond."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np

from lie_rigid_body.certificate.law_result import SHOWN, LawResult
from lie_rigid_body.foundation.arrays import Booleans, Integers, runs_of
from lie_rigid_body.recording.segments import grid, number_samples
from lie_rigid_body.simulation import SampleClock, Segment

OFF_GRID: Final = "ns"
GAP: Final = "gap"
DUPLICATE: Final = "dup"
DISORDER: Final = "ord"

PAGE: Final = 2**15
"""Number of samples that are looked up together, to find those that were lost."""
_MOST_DOUBLED: Final = 100_001
"""Number of doubled samples that are told."""


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
        """Stretches of numbers between two, in each of which every number is there equally often.

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
    """Rising runs of numbers, as they come: the count of runs, the count of numbers, and the first runs.

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


@dataclass(frozen=True)
class Lost:
    """Samples that never arrived.

    Parameters
    ----------
    first, end : int
        Numbers from which on, and before which, samples may be lost.
    which : callable
        Function that gives the mask of the lost samples, of a count of samples from a number on.
    """

    first: int
    end: int
    which: Callable[[int, int], Booleans]

    def of(self, first: int, count: int) -> Booleans:
        """Mask of the lost samples, of ``count`` samples from number ``first`` on."""
        lost = np.zeros(count, dtype=np.bool_)
        begin, end = max(first, self.first), min(first + count, self.end)
        if begin < end:
            lost[begin - first : end - first] = self.which(begin, end - begin)
        return lost

    def count(self, first: int, last: int) -> int:
        """Number of lost samples from number ``first`` to number ``last``."""
        begin, end = max(first, self.first), min(last + 1, self.end)
        parts = range(begin, end, PAGE)
        return sum(int(np.count_nonzero(self.of(at, min(PAGE, end - at)))) for at in parts)


NONE_LOST: Final = Lost(0, 0, lambda first, count: np.zeros(count, dtype=np.bool_))


@dataclass(frozen=True)
class StampFault:
    """What is wrong with the stamps of a topic: its kind, how many samples it concerns, the first one, in words."""

    kind: str
    count: int
    sample: int
    text: str


def stamp_law(
    segment: Segment,
    following: int | None,
    tallies: Mapping[str, StampTally],
    *,
    late_start: bool,
    open_end: bool,
    cut_off: bool,
) -> LawResult:
    """Whether every topic has every sample of the segment once, in order, stamped on the grid.

    Parameters
    ----------
    segment : Segment
    following : int or None
        Start of the next segment, ns, if there is one.
    tallies : mapping of str to StampTally
        By topic.
    late_start, open_end : bool
        Whether the recording may begin after the start, or end at a different sample on each topic (a recorder that
        subscribes to a running node does both).
    cut_off : bool
        Whether the recording may lack the twist of its last pose, which is written after it.

    Returns
    -------
    LawResult
        ``worst`` is how far a stamp is off the grid, ns. Where all are on it, it is the number of samples that are
        missing (unit ``gap``), doubled (``dup``) or out of order (``ord``), and ``sample`` the first. The message names
        all.
    """
    clock = segment.clock()
    end = max((tally.high for tally in tallies.values() if tally.count), default=segment.first_sample)
    if following is not None:
        end = int(number_samples(clock, np.array([following]))[0]) - 1
    faults = list[StampFault]()
    for topic, tally in tallies.items():
        first = tally.low if late_start and tally.count else segment.first_sample
        last = tally.high if open_end and tally.count else end - (cut_off and topic == "twist")
        faults += tally.faults(topic, first, last)
    return stamp_result("stamps", clock, faults, sum(tally.count for tally in tallies.values()))


def stamp_result(name: str, clock: SampleClock, faults: Sequence[StampFault], checked: int) -> LawResult:
    """The result of a law of stamps with these faults; see `stamp_law`.

    Parameters
    ----------
    name : str
    clock : SampleClock
    faults : sequence of StampFault
    checked : int
        How many stamps there were.
    """
    unit = next(
        (kind for kind in (OFF_GRID, GAP, DUPLICATE, DISORDER) if any(f.kind == kind for f in faults)), OFF_GRID
    )
    kindred = [fault for fault in faults if fault.kind == unit]
    if not kindred:
        return LawResult(name, OFF_GRID, 0.0, 0.0, None, None, 0, checked)
    worst = max(f.count for f in kindred) if unit == OFF_GRID else sum(f.count for f in kindred)
    at = max(kindred, key=lambda f: f.count).sample if unit == OFF_GRID else min(f.sample for f in kindred)
    text = "; ".join(fault.text for fault in faults)
    return LawResult(name, unit, float(worst), 0.0, at, clock.stamp_ns(at), len(faults), checked, text)


class StampTally:
    """The stamps of one topic in one segment as they come: which samples are there, and what is wrong with them.

    Parameters
    ----------
    clock : SampleClock
    noun : str, optional
        What its samples are called.
    shown : callable, optional
        What their headers say at given times, ns, if another clock stamps them.

    Attributes
    ----------
    count : int
    low, high : int
        The least and the largest number of a sample so far.
    """

    def __init__(
        self, clock: SampleClock, noun: str = "sample", shown: Callable[[Integers], Integers] = lambda times: times
    ) -> None:
        self._clock, self._noun, self._shown = clock, noun, shown
        self.count, self.low, self.high = 0, 0, -1
        self._previous = 0
        self._there = NumberRuns()
        self._displaced, self._earliest, self._pairs = 0, int(np.iinfo(np.int64).max), list[str]()
        self._off, self._farthest, self._worst = 0, 0, (0, 0)

    def add(self, stamps_ns: Integers) -> None:
        """Take the stamps that come next in the file."""
        if not len(stamps_ns):
            return
        found = number_samples(self._clock, stamps_ns)
        if not self.count:
            self._previous, self.low, self.high = int(found[0]), int(found[0]), int(found[0]) - 1
        self._take_grid(found, stamps_ns)
        self._take_order(np.concatenate([[self._previous], found]))
        self._there.add(found)
        self.low, self.high = min(self.low, int(found.min())), max(self.high, int(found.max()))
        self._previous = int(found[-1])
        self.count += len(found)

    def _take_grid(self, found: Integers, stamps_ns: Integers) -> None:
        off = np.abs(stamps_ns - grid(self._clock, found))
        self._off += int(np.count_nonzero(off))
        i = int(off.argmax())
        if off[i] > self._farthest:
            self._farthest, self._worst = int(off[i]), (int(found[i]), int(stamps_ns[i]))

    def _take_order(self, numbers: Integers) -> None:
        at = np.flatnonzero(np.diff(numbers) < 0)
        self._earliest = int(numbers[at].min(initial=self._earliest))
        self._displaced += len(at)
        self._pairs += [f"{numbers[i]} stands before {numbers[i + 1]}" for i in at[: SHOWN - len(self._pairs)]]

    def faults(self, topic: str, first: int, last: int, lost: Lost = NONE_LOST) -> Iterator[StampFault]:
        """Faults of a topic that is to have all samples from one number to another, except for lost ones.

        Parameters
        ----------
        topic : str
        first, last : int
        lost : Lost, optional
        """
        gaps, arrived = self._gaps(first, last, lost)
        doubled = RunList(SHOWN)
        edges, times = self._there.counted(self.low, self.high)
        doubled.add(edges[:-1][times > 1], edges[1:][times > 1] - 1)
        if arrived.count:
            some = _some([str(k) for k in arrived.first()], arrived.total)
            text = f"{topic}: there is {self._noun} {some}, which the scenario loses"
            yield StampFault(DUPLICATE, arrived.total, arrived.first()[0], text)
        if self._displaced:
            text = f"{topic}: out of order, {self._noun} {_some(self._pairs, self._displaced)}"
            yield StampFault(DISORDER, self._displaced, self._earliest, text)
        if doubled.count:
            count = min(doubled.total, _MOST_DOUBLED)
            text = f"{topic}: duplicate of {self._noun} {_some([str(k) for k in doubled.first()], count)}"
            yield StampFault(DUPLICATE, count, doubled.first()[0], text)
        if gaps.count:
            text = f"{topic}: gap, {_some([self._gap_in_words(*gap) for gap in gaps.listed], gaps.count)}"
            yield StampFault(GAP, gaps.total, gaps.listed[0][0], text)
        if self._off:
            number, stamp = self._worst
            measured = self._clock.stamp_ns(number)
            right = int(self._shown(np.array([measured]))[0])
            said = f"{self._noun} {number} stamped {right + stamp - measured} ns instead of {right}"
            text = f"{topic}: {self._off} stamps off the grid, {said}"
            yield StampFault(OFF_GRID, self._farthest, number, text)

    def _gaps(self, first: int, last: int, lost: Lost) -> tuple[RunList, RunList]:
        """Runs of missing numbers between two, except for lost ones, and runs of lost numbers that are there."""
        gaps, arrived = RunList(SHOWN), RunList(SHOWN)
        edges, times = self._there.counted(first, last)
        while first <= last and first < lost.end:
            count = min(PAGE, last + 1 - first)
            there = times[np.searchsorted(edges, np.arange(first, first + count), side="right") - 1] > 0
            away = lost.of(first, count)
            arrived.add(*runs_of(first, there & away))
            gaps.add(*runs_of(first, ~(there | away)))
            first += count
        begins, ends = np.maximum(edges[:-1], first)[times == 0], edges[1:][times == 0] - 1
        gaps.add(begins[begins <= ends], ends[begins <= ends])
        return gaps, arrived

    def _gap_in_words(self, begin: int, end: int) -> str:
        if begin == end:
            return f"{self._noun} {begin} is missing"
        return f"{end - begin + 1} {self._noun}s from {begin} to {end} are missing"


def _some(items: list[str], count: int) -> str:
    """Text: the first four faults, then the number of the rest."""
    more = count - SHOWN
    return ", ".join(items[:SHOWN]) + (f" and {more} more" if more > 0 else "")
