"""Fault messages of a bag, compared as a set with the sensor faults that its scenarios make.

The seed determines which faults begin, and when, to the bit. A bag of this package must report all up to the last time
of anything else in it, each once. A recorder may begin late: of its messages only those between the first and the last
one cannot be missing. Sizes made of normal deviates may differ in the last bits between libraries.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.readings import MIN_READING_ERROR
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.loop import FaultLog

FAULT_LAW: Final = "faults"
MAX_SEARCHED: Final = 200_000_000
"""Largest number of readings that are searched for faults."""
_EPISODES_PER_SECOND: Final = 1000
"""Largest number of episodes a second of one kind of fault."""
_DRAWN: Final = ("temperature_drift", "magnetic_disturbance")
"""Kinds of faults whose sizes are made of normal deviates, which differ in last bits between libraries."""
_AT_ONCE: Final = 8192
"""About the largest number of faults of a kind that are made at once."""


class FaultLaw:
    """Law of a bag's fault messages.

    Parameters
    ----------
    segments : sequence of Segment
        Segments that the bag declares, in the order of their starts.
    is_whole : bool
        Whether the bag is to have every fault from the first one on, once.

    Attributes
    ----------
    early, repeated : int
        Number of a recorder's messages about faults before the first segment, and number of repeated messages: whoever
        subscribes anew hears the last ones again.
    log_time_mismatches : int
        Number of messages whose log time is not the beginning of the fault.
    """

    def __init__(self, segments: Sequence[Segment], *, is_whole: bool) -> None:
        self._segments = segments
        self._is_whole = is_whole
        # by all but their sizes, which few have: there may be a million
        self._told = dict[Fault, tuple[int, float | None]]()
        self._count = self._last_ns = 0
        self._wrong: dict[str, tuple[int, str]] = {}
        self._worst: tuple[int, int] | None = None
        self.early = self.repeated = self.log_time_mismatches = 0

    def add(self, messages: Iterable[tuple[int, str]]) -> None:
        """Take the next messages of the file, each of log time, ns, and text."""
        for time_ns, text in messages:
            self._take(time_ns, text.rstrip(" "))
            self._count += 1

    def _take(self, time_ns: int, text: str) -> None:
        try:
            fault = Fault.from_json(text)
        except InputError:
            self._note("that tell of no fault", f"message {self._count}", time_ns, self._count)
            return
        self.log_time_mismatches += time_ns != fault.begin_ns
        where = f"message {self._count} ({_in_words(fault)})"
        if fault.begin_ns < self._segments[0].start_ns and not self._is_whole:
            self.early += 1
        elif fault.to_json() != text:
            self._note("of which the scenario makes none", where, fault.begin_ns, self._count)
        elif (key := _without_size(fault)) in self._told:
            self.repeated += 1
            if self._is_whole:
                self._note("twice", where, fault.begin_ns, self._count)
        else:
            self._told[key] = self._count, fault.size
            if fault.begin_ns < self._last_ns:
                self._note("out of order", where, fault.begin_ns, self._count)
            self._last_ns = max(self._last_ns, fault.begin_ns)

    def _note(self, what: str, where: str, begin_ns: int, message: int, more: int = 1) -> None:
        count, first = self._wrong.get(what, (0, where))
        self._wrong[what] = count + more, first
        self._worst = self._worst or (message, begin_ns)

    def is_too_long(self, until_ns: int) -> bool:
        """Whether to search all readings until a time, ns, takes too long."""
        ends = [*(segment.start_ns for segment in self._segments[1:]), until_ns]
        searched = sum(
            (end - each.start_ns) * max(_EPISODES_PER_SECOND, *(one.rate for one in each.scenario.sensors.on.values()))
            for each, end in zip(self._segments, ends, strict=True)
            if each.scenario.sensors.has_faults
        )
        return searched > MAX_SEARCHED * NS

    def result(self, topic: str, until_ns: int, horizon_ns: int) -> LawResult:
        """Result of the law.

        Parameters
        ----------
        topic : str
        until_ns : int
            Time of the last other thing in the bag, ns: a whole bag must report all faults that begin up to it.
        horizon_ns : int
            Latest time of an honest message, ns.
        """
        missing = self._missing(self._expected(min(max(until_ns, self._last_ns), horizon_ns)), until_ns)
        for key, (message, _) in self._told.items():
            where = f"message {message} ({_in_words(key)})"
            self._note("of which the scenario makes none", where, key.begin_ns, message)
        if missing:
            start_ns = max(each.start_ns for each in self._segments if each.start_ns <= missing[0].begin_ns)
            where = f"{_in_words(missing[0])}, {(missing[0].begin_ns - start_ns) / NS:.9g} s after the start"
            self._note("missing", where, missing[0].begin_ns, self._count, len(missing))
        parts = [f"{count} {what}, the first: {first}" for what, (count, first) in self._wrong.items()]
        wrong = sum(count for count, _ in self._wrong.values())
        sample, stamp = self._worst or (None, None)
        said = f"{topic:.60}: {'; '.join(parts)}" if wrong else ""
        return LawResult(FAULT_LAW, "", float(wrong), 0.0, sample, stamp, wrong, self._count, said)

    def _missing(self, expected: Iterable[Fault], until_ns: int) -> list[Fault]:
        """Faults that the bag lacks; those that the scenarios make are taken out of what it told."""
        missing = list[Fault]()
        absent = list[Fault]()
        begun = self._is_whole
        for fault in expected:
            key = _without_size(fault)
            if key in self._told and _are_alike(fault, self._told[key][1]):
                del self._told[key]
                missing += absent
                begun = True
                absent = []
            elif begun and (not self._is_whole or fault.begin_ns <= until_ns):
                absent.append(fault)
        return missing + absent if self._is_whole else missing

    def _expected(self, until_ns: int) -> Iterator[Fault]:
        """Faults that the scenarios make up to a time, ns, in the order in which they begin."""
        log = FaultLog()
        for segment in self._segments:
            log.follow(segment)
        reached_ns = -1
        while reached_ns < until_ns:
            reached_ns = min(until_ns, log.end_ns(_AT_ONCE))
            yield from log.take(reached_ns)


def _without_size(fault: Fault) -> Fault:
    """All of a fault but its size; there may be a million, which share their words, and of one reading both times."""
    end_ns = fault.begin_ns if fault.end_ns == fault.begin_ns else fault.end_ns
    return Fault(sys.intern(fault.kind), sys.intern(fault.sensor), sys.intern(fault.axis), fault.begin_ns, end_ns)


def _in_words(fault: Fault) -> str:
    return f"{fault.kind} of {' '.join(filter(None, (fault.sensor, fault.axis)))}"


def _are_alike(expected: Fault, size: float | None) -> bool:
    """Whether a fault has the expected size, within round-off if normal deviates made it."""
    if expected.kind not in _DRAWN or expected.size is None or size is None:
        return expected.size == size
    return abs(expected.size - size) <= MIN_READING_ERROR * abs(expected.size)
