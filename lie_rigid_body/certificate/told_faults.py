"""The faults of sensors that a bag tells of, held against those that its scenarios make.

Which faults there are, and when, follows from the seed to the bit. So the messages of a bag must be the first ones of
the scenarios' list, in order, up to the last time of anything else in the bag. Those of a recorder, which may begin
late, are a part of it without a gap. A size may differ in the last bits where a library makes a normal deviate of it.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.readings import BLOCK, ROUNDINGS
from lie_rigid_body.errors import InputError
from lie_rigid_body.motion.drift import U
from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.loop import FaultLog

FAULT_LAW: Final = "faults"
MOST_LOOKED_THROUGH: Final = 200_000_000
"""Readings whose faults are computed, beyond those that the bag has."""
_READINGS_PER_FAULT: Final = 200
"""Readings that are looked through in the time that a fault takes of which the bag does not tell."""
_EPISODES_PER_SECOND: Final = 1000
"""Most that one kind of fault has."""
_DRAWN: Final = ("temperature_drift", "magnetic_disturbance")
"""Kinds of faults whose sizes are made of normal deviates, which differ in last bits between libraries."""
_MOST_KEPT: Final = 10_000
"""Faults that are remembered until the bag tells of them, or to know one that it tells of twice; they take 10 MB."""


class ExpectedFaults:
    """The faults that segments make, in the order in which they begin.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    most : int
        Readings that may be looked through.

    Attributes
    ----------
    left : int
        How many of them are left.
    is_too_far : bool
        Whether they are more.
    """

    def __init__(self, segments: Sequence[Segment], most: int) -> None:
        self._segments, self._starts = segments, np.array([segment.start_ns for segment in segments])
        self._log, self.left, self.is_too_far = FaultLog(), most, False
        self._known_ns = segments[0].start_ns - 1
        for segment in segments:
            self._log.follow(segment)

    def until(self, time_ns: int) -> Iterator[Fault]:
        """Those that begin up to a time, ns, and did not come yet."""
        while self._known_ns < time_ns and not self.is_too_far:
            sensors = self.segment_at(self._known_ns + 1).scenario.sensors
            later = self._starts[np.searchsorted(self._starts, self._known_ns + 1, side="right") :]
            end_ns = min(time_ns, int(later[0]) - 1 if len(later) else MAX_EPOCH_NS)
            if sensors.have_faults:
                rate = max((_EPISODES_PER_SECOND, *(sensor.rate for sensor in sensors.on.values())))
                end_ns = min(end_ns, self._known_ns + max(1, int(BLOCK * NS / rate)))
                self.left -= 1 + int((end_ns - self._known_ns) * rate / NS)
            self._known_ns, self.is_too_far = end_ns, self.left < 0
            yield from self._log.take(end_ns)

    def segment_at(self, time_ns: int) -> Segment:
        """The segment in which a fault begins at a time, ns."""
        return self._segments[int(np.searchsorted(self._starts, time_ns, side="right")) - 1]


@dataclass
class _MadeFault:
    """A fault of the scenarios, its number in the list of all, and whether the bag told of it."""

    number: int
    fault: Fault
    is_told: bool = False


class FaultLaw:
    """The messages about faults as they come.

    Parameters
    ----------
    segments : sequence of Segment
        All that the bag declares, in the order of their starts.
    horizon_ns : int
        A time that no honest message lies behind.
    is_whole : bool
        Whether the bag is to have them from the first one on. Otherwise it may have some twice, as whoever subscribes
        anew hears the last ones again.
    most : int
        Readings that may be looked through.

    Attributes
    ----------
    early, repeated : int
        Messages of a recorder about what began before the first segment, and those that it has twice.
    logged_otherwise : int
        Messages that are not logged when the fault begins.
    """

    def __init__(self, segments: Sequence[Segment], horizon_ns: int, *, is_whole: bool, most: int) -> None:
        self._expected = ExpectedFaults(segments, most)
        self._start_ns, self._horizon_ns, self._is_whole = segments[0].start_ns, horizon_ns, is_whole
        self._known = OrderedDict[Fault, _MadeFault]()  # by all but their sizes
        self._count = self._number = 0
        self._first, self._last = (0 if is_whole else None), -1
        self._wrong: dict[str, tuple[int, str]] = {}
        self._worst: tuple[int, int] | None = None
        self.early = self.repeated = self.logged_otherwise = 0

    @property
    def is_too_far(self) -> bool:
        """Whether there are too many readings to look through."""
        return self._expected.is_too_far

    def add(self, messages: Iterable[tuple[int, str]]) -> None:
        """Take the messages that come next in the file: log time, ns, and text of each."""
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
        """Remember the faults that begin up to a time, ns, and the oldest ones no more."""
        for fault in self._expected.until(until_ns):
            self._known[replace(fault, size=None)] = _MadeFault(self._number, fault)
            self._number += 1
            if len(self._known) > _MOST_KEPT:
                _, oldest = self._known.popitem(last=False)
                self._miss([oldest])
                self._expected.left -= (not oldest.is_told) * _READINGS_PER_FAULT

    def _found(self, text: str, fault: Fault) -> _MadeFault | None:
        """The fault that a message tells of, if the scenarios make it."""
        found = self._known.get(replace(fault, size=None)) if fault.to_json() == text else None
        return found if found is not None and _are_alike(found.fault, fault) else None

    def _miss(self, some: Iterable[_MadeFault], until_ns: int = -1) -> None:
        """Note those of some faults that the bag should have told of; in a whole bag also those up to a time, ns."""
        for expected in some:
            begin_ns, first = expected.fault.begin_ns, self._first
            is_due = until_ns < 0 or expected.number < self._last or (self._is_whole and begin_ns <= until_ns)
            if is_due and not expected.is_told and first is not None and expected.number >= first:
                seconds = (begin_ns - self._expected.segment_at(begin_ns).start_ns) / NS
                self._note("missing", f"{_in_words(expected.fault)}, {seconds:.9g} s after the start", begin_ns)

    def _note(self, what: str, where: str, begin_ns: int) -> None:
        count, first = self._wrong.get(what, (0, where))
        self._wrong[what] = count + 1, first
        self._worst = self._worst or (self._count, begin_ns)

    def result(self, topic: str, until_ns: int) -> LawResult:
        """Whether the bag tells of every fault, of a bag that is to be whole of every one that begins up to a time."""
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
    """Whether two faults have one size, but for the last bits of one that is made of normal deviates."""
    if expected.kind not in _DRAWN or expected.size is None or told.size is None:
        return expected.size == told.size
    return abs(expected.size - told.size) <= ROUNDINGS * U * abs(expected.size)
