"""The law of the stamps: every topic has every sample once, in order, stamped on the nanosecond."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.parameters import NS
from lie_rigid_body.simulation import SampleClock, Segment

OFF_GRID: Final = "ns"
GAP: Final = "gap"
DUPLICATE: Final = "dup"
DISORDER: Final = "ord"

_SHOWN: Final = 4
"""Number of faults of each kind listed in a message."""
_NONE: Final = np.empty(0, dtype=np.int64)
_MOST_DOUBLED: Final = 100_000
"""Number of doubled samples that are counted."""


def number_samples(clock: SampleClock, stamps_ns: Integers) -> Integers:
    """The numbers of the grid's samples nearest to the stamps.

    Parameters
    ----------
    clock : SampleClock
    stamps_ns : ndarray of int64, shape (N,)

    Returns
    -------
    ndarray of int64, shape (N,)
    """
    # in two parts, as the product of a long time and a rate exceeds 53 bits
    elapsed = stamps_ns - clock.epoch_ns
    whole = elapsed // NS  # half of the time of `divmod`
    rest = elapsed - whole * NS
    if float(clock.rate).is_integer():
        rate = int(clock.rate)
        return whole * rate + np.rint(rest * (clock.rate * 1e-9)).astype(np.int64)
    return np.rint(whole * clock.rate + rest * (clock.rate * 1e-9)).astype(np.int64)


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
        ``worst`` is how far a stamp is off the grid, ns; where all are on it, the number of samples that are missing
        (unit ``gap``), doubled (``dup``) or out of order (``ord``), and ``sample`` the first. The message names all.
    """
    clock = segment.clock()
    end = max((tally.high for tally in tallies.values() if tally.count), default=segment.first_sample)
    if following is not None:
        end = int(number_samples(clock, np.array([following]))[0]) - 1
    faults = []
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
        self._missing: list[tuple[int, int]] = []  # first and last of each run between low and high, rising
        self._doubled: set[int] = set()
        self._displaced, self._earliest, self._pairs = 0, 0, list[str]()
        self._off, self._farthest, self._worst = 0, 0, (0, 0)

    def add(self, stamps_ns: Integers) -> None:
        """Take the stamps that come next in the file."""
        if not len(stamps_ns):
            return
        found = number_samples(self._clock, stamps_ns)
        if not self.count:
            self._previous, self.low, self.high = int(found[0]), int(found[0]), int(found[0]) - 1
        self._take_grid(found, stamps_ns)
        steps = np.diff(found, prepend=self._previous)
        if not self.count:
            steps[0] = 1
        self._take_order(np.flatnonzero(steps < 0), np.concatenate([[self._previous], found]))
        edges = [0, *np.flatnonzero(steps[1:] != 1) + 1, len(found)]
        for begin, end in itertools.pairwise(edges):
            self._take_run(int(found[begin]), int(found[end - 1]))
        self._previous = int(found[-1])
        self.count += len(found)

    def _take_grid(self, found: Integers, stamps_ns: Integers) -> None:
        off = np.abs(stamps_ns - grid(self._clock, found))
        self._off += int(np.count_nonzero(off))
        i = int(off.argmax())
        if off[i] > self._farthest:
            self._farthest, self._worst = int(off[i]), (int(found[i]), int(stamps_ns[i]))

    def _take_order(self, at: Integers, numbers: Integers) -> None:
        if not len(at):
            return
        before = numbers[at]
        self._earliest = min([*([self._earliest] if self._displaced else []), int(before.min())])
        self._displaced += len(at)
        self._pairs += [f"{numbers[i]} stands before {numbers[i + 1]}" for i in at[: _SHOWN - len(self._pairs)]]

    def _take_run(self, begin: int, end: int) -> None:
        """Take samples that follow each other."""
        if begin > self.high:
            if begin > self.high + 1:
                self._missing.append((self.high + 1, begin - 1))
            self.high = end
        elif end < self.low:
            if end < self.low - 1:
                self._missing.insert(0, (end + 1, self.low - 1))
            self.low = begin
        else:
            self._fill(begin, end)

    def _fill(self, begin: int, end: int) -> None:
        """Take samples of which some may be there already: those are doubled, others fill gaps."""
        at = bisect.bisect_left(self._missing, begin, key=lambda gap: gap[1])
        number = begin
        while number <= min(end, self.high):
            gap = self._missing[at] if at < len(self._missing) else (self.high + 1, self.high + 1)
            known = min(end, self.high, gap[0] - 1)
            if number <= known and number >= self.low:
                self._doubled.update(range(number, min(known, number + _MOST_DOUBLED - len(self._doubled)) + 1))
            number = max(number, gap[0])
            if number > min(end, self.high):
                break
            last = min(end, gap[1])
            rest = [(gap[0], number - 1), (last + 1, gap[1])]
            self._missing[at : at + 1] = [(a, b) for a, b in rest if a <= b]
            at += number > gap[0]
            number = last + 1
        if begin < self.low:
            self.low = begin
        self.high = max(self.high, end)

    def faults(self, topic: str, first: int, last: int, lost: Integers = _NONE) -> list[StampFault]:
        """What is wrong, of a topic that is to have all samples from one number to another but those that are lost.

        Parameters
        ----------
        topic : str
        first, last : int
        lost : ndarray of int64, optional
            Numbers of samples that never arrived, rising.
        """
        found = []
        gaps = self._gaps(first, last)
        if len(lost):
            gaps, arrived = _but_lost(gaps, lost[(lost >= first) & (lost <= last)])
            if len(arrived):
                some = _some([str(k) for k in arrived[:_SHOWN].tolist()], len(arrived))
                text = f"{topic}: there is {self._noun} {some}, which the scenario loses"
                found.append(StampFault(DUPLICATE, len(arrived), int(arrived[0]), text))
        if self._displaced:
            text = f"{topic}: out of order, {self._noun} {_some(self._pairs, self._displaced)}"
            found.append(StampFault(DISORDER, self._displaced, self._earliest, text))
        if self._doubled:
            doubled = sorted(self._doubled)
            text = f"{topic}: duplicate of {self._noun} {_some([str(k) for k in doubled[:_SHOWN]], len(doubled))}"
            found.append(StampFault(DUPLICATE, len(doubled), doubled[0], text))
        if gaps:
            text = f"{topic}: gap, {_some([self._gap_in_words(*gap) for gap in gaps[:_SHOWN]], len(gaps))}"
            found.append(StampFault(GAP, sum(end - begin + 1 for begin, end in gaps), gaps[0][0], text))
        if self._off:
            number, stamp = self._worst
            measured = self._clock.stamp_ns(number)
            right = int(self._shown(np.array([measured]))[0])
            text = f"{topic}: {self._off} stamps off the grid, {self._noun} {number} stamped"
            text += f" {right + stamp - measured} ns instead of {right}"
            found.append(StampFault(OFF_GRID, self._farthest, number, text))
        return found

    def _gaps(self, first: int, last: int) -> list[tuple[int, int]]:
        """First and last of each run of missing numbers between two."""
        outer = [(first, self.low - 1), *self._missing, (self.high + 1, last)] if self.count else [(first, last)]
        clipped = [(max(begin, first), min(end, last)) for begin, end in outer]
        return [(begin, end) for begin, end in clipped if begin <= end]

    def _gap_in_words(self, begin: int, end: int) -> str:
        if begin == end:
            return f"{self._noun} {begin} is missing"
        return f"{end - begin + 1} {self._noun}s from {begin} to {end} are missing"


def _but_lost(gaps: Sequence[tuple[int, int]], lost: Integers) -> tuple[list[tuple[int, int]], Integers]:
    """The runs of missing numbers without those that are lost, and the lost ones that are in no run."""
    if not gaps:
        return [], lost
    begins, ends = np.array(gaps, dtype=np.int64).T
    before, until = np.searchsorted(lost, begins), np.searchsorted(lost, ends, side="right")
    rest: list[tuple[int, int]] = []
    for i in np.flatnonzero(until - before <= ends - begins):
        edges = [int(begins[i]) - 1, *lost[before[i] : until[i]].tolist(), int(ends[i]) + 1]
        rest += [(a + 1, b - 1) for a, b in itertools.pairwise(edges) if a + 1 < b]
    at = np.searchsorted(begins, lost, side="right") - 1
    return rest, lost[(at < 0) | (lost > ends[at])]


def grid(clock: SampleClock, numbers: Integers) -> Integers:
    """The exact stamps of samples by their numbers, ns."""
    low, high = int(numbers.min()), int(numbers.max())
    if high - low > 4 * numbers.size + 1000:  # far-off stamps: no table of all between
        return np.array([clock.stamp_ns(int(k)) for k in numbers], dtype=np.int64)
    return clock.stamps_ns(low, high - low + 1)[numbers - low]


def _some(items: list[str], count: int) -> str:
    """Text: the first four faults, then the number of the rest."""
    more = count - _SHOWN
    return ", ".join(items[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
