"""The law of the stamps: every topic has every sample once, in order, stamped on the nanosecond."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.certificate.law_result import SHOWN, LawResult
from lie_rigid_body.foundation.arrays import Booleans, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.segments import grid, number_samples
from lie_rigid_body.simulation import SampleClock, Segment

OFF_GRID: Final = "ns"
GAP: Final = "gap"
DUPLICATE: Final = "dup"
DISORDER: Final = "ord"

MAX_MISSING: Final = 50_000_000
"""Largest number of missing samples of a topic that are computed, those of 14 h at 1 kHz: more are gaps, whatever is
lost."""
_PAGE: Final = 2**18
"""Number of missing samples looked up together."""

Lost: TypeAlias = Callable[[Integers], Booleans]
"""A function that tells which samples, by their numbers, never arrive."""


class NumberRuns:
    """Whole numbers that come in any order, kept as runs: 16 bytes each, of a whole recording nearly nothing."""

    def __init__(self) -> None:
        self._runs: list[Integers] = []  # first and last of each, shape (2, N)

    def add(self, numbers: Integers) -> None:
        """Take at least one number; one that is there already counts again."""
        runs = _runs_among(np.sort(numbers))
        if self._runs and runs[0, 0] == self._runs[-1][1, -1] + 1:
            self._runs[-1][1, -1] = runs[1, 0]
            runs = runs[:, 1:]
        self._runs += [runs] if runs.size else []

    def missing(self, first: int, last: int) -> tuple[Integers, Integers]:
        """First and last numbers of the runs between two numbers of which none is there."""
        begins, ends = self._sorted()
        begins = np.append(np.minimum(begins, last + 1), last + 1)
        reached = np.maximum.accumulate(np.append(first - 1, ends))
        gaps = begins > reached + 1
        return reached[gaps] + 1, begins[gaps] - 1

    def doubled(self) -> tuple[int, int]:
        """How often a number comes again, of all together, and the least that does."""
        begins, ends = self._sorted()
        reached = np.maximum.accumulate(ends)[:-1]
        overlaps = np.minimum(reached, ends[1:]) - begins[1:] + 1
        again = np.flatnonzero(overlaps > 0)
        return int(overlaps[again].sum()), int(begins[again[0] + 1]) if len(again) else 0

    def _sorted(self) -> Integers:
        runs = np.concatenate([np.empty((2, 0), dtype=np.int64), *self._runs], axis=1)
        return runs[:, np.argsort(runs[0], kind="stable")]


def without_lost(begins: Integers, ends: Integers, lost: Lost) -> tuple[Integers, Integers]:
    """Runs of numbers, given by their first and last ones, without the samples that were to be lost."""
    lengths = ends - begins + 1
    behind = np.cumsum(lengths)
    total = int(lengths.sum())
    if total > MAX_MISSING:
        return begins, ends
    kept = [np.empty(0, dtype=np.int64)]
    for done in range(0, total, _PAGE):
        places = np.arange(done, min(done + _PAGE, total))
        run = np.searchsorted(behind, places, side="right")
        numbers = begins[run] + places - (behind - lengths)[run]
        kept.append(numbers[~lost(numbers)])
    first, last = _runs_among(np.concatenate(kept))
    return first, last


def _runs_among(numbers: Integers) -> Integers:
    """First and last of each run of numbers that follow each other, in rising order, shape (2, N)."""
    edges = np.diff(numbers, prepend=numbers[:1] - 2, append=numbers[-1:] + 2) != 1
    return np.stack([numbers[edges[:-1]], numbers[edges[1:]]])


@short_dataclass
class StampFault:
    """Fault of the stamps of a topic: its kind, how many samples it concerns, the first one, in words."""

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
        self._clock = clock
        self._noun = noun
        self._shown = shown
        self.count = self.low = self._previous = self._displaced = self._off = self._farthest = 0
        self.high = -1
        self._there = NumberRuns()
        self._earliest = int(np.iinfo(np.int64).max)
        self._pairs = list[str]()
        self._worst = (0, 0)

    def add(self, stamps_ns: Integers) -> None:
        """Take the stamps that come next in the file."""
        if not len(stamps_ns):
            return
        found = number_samples(self._clock, stamps_ns)
        if not self.count:
            self._previous = int(found[0])
            self.low = int(found[0])
            self.high = int(found[0]) - 1
        self._take_grid(found, stamps_ns)
        self._take_order(np.concatenate([[self._previous], found]))
        self._there.add(found)
        self.low = min(self.low, int(found.min()))
        self.high = max(self.high, int(found.max()))
        self._previous = int(found[-1])
        self.count += len(found)

    def _take_grid(self, found: Integers, stamps_ns: Integers) -> None:
        off = np.abs(stamps_ns - grid(self._clock, found))
        self._off += int(np.count_nonzero(off))
        i = off.argmax()
        if off[i] > self._farthest:
            self._farthest = int(off[i])
            self._worst = (int(found[i]), int(stamps_ns[i]))

    def _take_order(self, numbers: Integers) -> None:
        at = np.flatnonzero(np.diff(numbers) < 0)
        self._earliest = int(numbers[at].min(initial=self._earliest))
        self._displaced += len(at)
        self._pairs += [f"{numbers[i]} stands before {numbers[i + 1]}" for i in at[: SHOWN - len(self._pairs)]]

    def faults(self, topic: str, first: int, last: int, lost: Lost | None = None) -> Iterator[StampFault]:
        """Faults of a topic that is to have all samples from one number to another, except for lost ones.

        Parameters
        ----------
        topic : str
        first, last : int
        lost : Lost, optional
        """
        if self._displaced:
            text = f"{topic}: out of order, {self._noun} {_some(self._pairs, self._displaced)}"
            yield StampFault(DISORDER, self._displaced, self._earliest, text)
        doubled, number = self._there.doubled()
        if doubled:
            more = f" and {doubled - 1} more" if doubled > 1 else ""
            yield StampFault(DUPLICATE, doubled, number, f"{topic}: duplicate of {self._noun} {number}{more}")
        begins, ends = self.missing(first, last, lost)
        if len(begins):
            gaps = [self._gap_in_words(int(begin), int(end)) for begin, end in zip(begins[:SHOWN], ends, strict=False)]
            text = f"{topic}: gap, {_some(gaps, len(begins))}"
            yield StampFault(GAP, int((ends - begins + 1).sum()), int(begins[0]), text)
        if self._off:
            number, stamp = self._worst
            measured = self._clock.stamp_ns(number)
            right = int(self._shown(np.array([measured]))[0])
            said = f"{self._noun} {number} stamped {right + stamp - measured} ns instead of {right}"
            text = f"{topic}: {self._off} stamps off the grid, {said}"
            yield StampFault(OFF_GRID, self._farthest, number, text)

    def missing(self, first: int, last: int, lost: Lost | None = None) -> tuple[Integers, Integers]:
        """First and last numbers of the runs of samples between two that are missing, and were not to be lost."""
        runs = self._there.missing(first, last)
        return runs if lost is None else without_lost(*runs, lost)

    def _gap_in_words(self, begin: int, end: int) -> str:
        if begin == end:
            return f"{self._noun} {begin} is missing"
        return f"{end - begin + 1} {self._noun}s from {begin} to {end} are missing"


def _some(items: list[str], count: int) -> str:
    """Text: the first four faults, then the number of the rest."""
    more = count - SHOWN
    return ", ".join(items[:SHOWN]) + (f" and {more} more" if more > 0 else "")
