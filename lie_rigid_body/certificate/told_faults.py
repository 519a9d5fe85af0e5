"""Fault messages of a bag, compared with the sensor faults that its scenarios make.

The seed determines which faults begin, and when, to the bit. So the messages of a bag must be the first ones of the
scenarios' list, in order, up to the last time of anything else in the bag. A recorder may begin late: its messages are
a part of the list without a gap. Sizes made of normal deviates may differ in the last bits between libraries.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.readings import MIN_READING_ERROR, REPLAY_BLOCK
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.loop import FaultLog

FAULT_LAW: Final = "faults"
MOST_LOOKED_THROUGH: Final = 200_000_000
"""Largest number of readings that are searched for faults, beyond those in the bag."""
_READINGS_PER_FAULT: Final = 200
"""Cost of a fault that the bag does not report, in readings: the search takes as long for so many."""
_EPISODES_PER_SECOND: Final = 1000
"""Largest number of episodes a second of one kind of fault."""
_DRAWN: Final = ("temperature_drift", "magnetic_disturbance")
"""Kinds of faults whose sizes are made of normal deviates, which differ in last bits between libraries."""
_MOST_KEPT: Final = 10_000
"""Largest number of expected faults in memory, where late and repeated messages find them; they take 10 MB."""


class ExpectedFaults:
    """Faults that segments make, in the order in which they begin.

    Parameters
    ----------
    segments : sequence of Segment
        Segments in the order of their starts.
    most : int
        Largest number of readings that are searched for faults.

    Attributes
    ----------
    left : int
        Number of readings that may still be searched.
    is_too_far : bool
        Whether the search needs more readings than ``most``.
    """

    def __init__(self, segments: Sequence[Segment], most: int) -> None:
        self._segments, self._starts = segments, np.array([segment.start_ns for segment in segments])
        self._log, self.left, self.is_too_far = FaultLog(), most, False
        self._known_ns = segments[0].start_ns - 1
        for segment in segments:
            self._log.follow(segment)

    def until(self, time_ns: int) -> Iterator[Fault]:
        """Yield the faults that begin up to a time, ns, and were not yielded before."""
        while self._known_ns < time_ns and not self.is_too_far:
            sensors = self.segment_at(self._known_ns + 1).scenario.sensors
            later = self._starts[np.searchsorted(self._starts, self._known_ns + 1, side="right") :]
            end_ns = min(time_ns, int(later[0]) - 1 if len(later) else time_ns)
            if sensors.has_faults:
                rate = max((_EPISODES_PER_SECOND, *(sensor.rate for sensor in sensors.on.values())))
                self.is_too_far = (end_ns - self._known_ns) * rate > self.left * NS
                end_ns = min(end_ns, self._known_ns + max(1, int(REPLAY_BLOCK * NS / rate)))
                self.left -= 1 + int((end_ns - self._known_ns) * rate / NS)
            self._known_ns = end_ns
            if not self.is_too_far:
                yield from self._log.take(end_ns)

    def segment_at(self, time_ns: int) -> Segment:
        """Segment that contains a time, ns."""
        return self._segments[int(np.searchsorted(self._starts, time_ns, side="right")) - 1]


@dataclass
class _MadeFault:
    """A fault of the scenarios, its number in the list of all, and whether the bag told of it."""

    number: int
    fault: Fault
    is_told: bool = False


class FaultLaw:
    """Law of a bag's fault messages, which are checked as they come.

    Parameters
    ----------
    segments : sequence of Segment
        Segments that the bag declares, in the order of their starts.
    horizon_ns : int
        Latest time of an honest message, ns.
    is_whole : bool
        Whether the bag is to have every fault from the first one on. A recorder may have some twice, as whoever
        subscribes anew hears the last messages again.
    most : int
        Largest number of readings that are searched for faults.

    Attributes
    ----------
    expected : ExpectedFaults
        Faults that the scenarios make, as far as they are known.
    early, repeated : int
        Number of a recorder's messages about faults before the first segment, and number of repeated messages.
    logged_otherwise : int
        Number of messages whose log time is not the beginning of the fault.
    """

    def __init__(self, segments: Sequence[Segment], horizon_ns: int, *, is_whole: bool, most: int) -> None:
        self.expected = ExpectedFaults(segments, most)
        self._start_ns, self._horizon_ns, self._is_whole = segments[0].start_ns, horizon_ns, is_whole
        self._known = OrderedDict[Fault, _MadeFault]()  # by all but their sizes
        self._count = self._number = 0
        self._first, self._last = (0 if is_whole else None), -1
        self._wrong: dict[str, tuple[int, str]] = {}
        self._worst: tuple[int, int] | None = None
        self.early = self.repeated = self.logged_otherwise = 0

    def add(self, messages: Iterable[tuple[int, str]]) -> None:
        """Check the next messages of the file, each of log time, ns, and text."""
        for time_ns, text in messages:
            try:
                fault = Fault.from_json(text)
            except InputError:
                self._note("that tell of no fault", f"message {self._count}", time_ns)
            else:
                self.logged_otherwise += time_ns != fault.begin_ns
                self._take(text.rstrip(" "), fault)
            self._count += 1

    def _take(self, text: str, fault: Fault) -> None:
        if fault.begin_ns < self._start_ns and not self._is_whole:
            self.early += 1
            return
        self._expect(min(fault.begin_ns, self._horizon_ns))
        found, where = self._found(text, fault), f"message {self._count} ({_in_words(fault)})"
        if found is None:
            self._note("of which the scenario makes none", where, fault.begin_ns)
        elif found.is_told:
            self.repeated += 1
            if self._is_whole:
                self._note("twice", where, fault.begin_ns)
        else:
            found.is_told = True
            self._first = found.number if self._first is None else self._first
            if found.number < self._last:
                self._note("out of order", where, fault.begin_ns)
            self._last = max(self._last, found.number)

    def _expect(self, until_ns: int) -> None:
        """Remember the faults that begin up to a time, ns; beyond `_MOST_KEPT` judge and forget the oldest."""
        for fault in self.expected.until(until_ns):
            self._known[replace(fault, size=None)] = _MadeFault(self._number, fault)
            self._number += 1
            if len(self._known) > _MOST_KEPT:
                _, oldest = self._known.popitem(last=False)
                self._miss([oldest])
                self.expected.left -= (not oldest.is_told) * _READINGS_PER_FAULT

    def _found(self, text: str, fault: Fault) -> _MadeFault | None:
        """Expected fault that a message reports; None if the scenarios make no such fault."""
        found = self._known.get(replace(fault, size=None)) if fault.to_json() == text else None
        return found if found is not None and _are_alike(found.fault, fault) else None

    def _miss(self, some: Iterable[_MadeFault], until_ns: int = -1) -> None:
        """Note expected faults that the bag lacks; a whole bag must also have those up to ``until_ns``."""
        for expected in some:
            begin_ns, first = expected.fault.begin_ns, self._first
            is_due = until_ns < 0 or expected.number < self._last or (self._is_whole and begin_ns <= until_ns)
            if is_due and not expected.is_told and first is not None and expected.number >= first:
                seconds = (begin_ns - self.expected.segment_at(begin_ns).start_ns) / NS
                self._note("missing", f"{_in_words(expected.fault)}, {seconds:.9g} s after the start", begin_ns)

    def _note(self, what: str, where: str, begin_ns: int) -> None:
        count, first = self._wrong.get(what, (0, where))
        self._wrong[what] = count + 1, first
        self._worst = self._worst or (self._count, begin_ns)

    def result(self, topic: str, until_ns: int) -> LawResult:
        """Result of the law: wrong, repeated and missing faults, in a whole bag up to ``until_ns``."""
        if self._is_whole:
            self._expect(until_ns)
        self._miss(self._known.values(), until_ns)
        self._known.clear()
        parts = [f"{count} {what}, the first: {first}" for what, (count, first) in self._wrong.items()]
        wrong = sum(count for count, _ in self._wrong.values())
        sample, stamp = self._worst or (None, None)
        message = f"{topic:.60}: {'; '.join(parts)}" if wrong else ""
        return LawResult(FAULT_LAW, "", float(wrong), 0.0, sample, stamp, wrong, self._count, message)


def _in_words(fault: Fault) -> str:
    return f"{fault.kind} of {' '.join(filter(None, (fault.sensor, fault.axis)))}"


def _are_alike(expected: Fault, told: Fault) -> bool:
    """Whether two faults have equal sizes, within round-off if normal deviates made them."""
    if expected.kind not in _DRAWN or expected.size is None or told.size is None:
        return expected.size == told.size
    return abs(expected.size - told.size) <= MIN_READING_ERROR * abs(expected.size)
