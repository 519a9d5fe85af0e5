"""The faults of sensors that a bag tells of, held against those that its scenarios make.

Which faults there are, and when, follows from the seed to the bit. So the messages of a bag must be the first ones of
the scenarios' list, in order, up to the last time of anything else in the bag; those of a recorder, which may begin
late, a part of it without a gap. A size may differ in the last bits where a library makes a normal deviate of it.
"""

from __future__ import annotations

import itertools
from collections import OrderedDict, deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.readings import BLOCK, deviate_rounding
from lie_rigid_body.errors import InputError
from lie_rigid_body.parameters import MAX_EPOCH_NS, NS
from lie_rigid_body.recording.sensor_reader import FaultMessages
from lie_rigid_body.sensors import Fault
from lie_rigid_body.simulation import Segment
from lie_rigid_body.simulation.fault_log import FaultLog

FAULT_LAW: Final = "faults"
MOST_LOOKED_THROUGH: Final = 200_000_000
"""Readings whose faults are computed, beyond those that the bag has."""
_EPISODES_PER_SECOND: Final = 1000
"""Most that one kind of fault has."""
_MOST_KEPT: Final = 100_000
"""Faults that are kept until the bag tells of them, or after it did."""


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
    is_too_far : bool
        Whether they are more.
    """

    def __init__(self, segments: Sequence[Segment], most: int) -> None:
        ends = [later.start_ns - 1 for later in segments[1:]]
        self._rest = list(zip(segments, [*ends, MAX_EPOCH_NS], strict=True))[::-1]
        self._log: FaultLog | None = None
        self._known_ns, self._left = 0, most
        self.is_too_far = False

    def until(self, time_ns: int) -> Iterator[tuple[Segment, Fault]]:
        """Those that begin up to a time, ns, and did not come yet, each with its segment."""
        while self._rest and not self.is_too_far:
            segment, end_ns = self._rest[-1]
            if self._log is None:
                self._log, self._known_ns = FaultLog(segment), segment.start_ns - 1
            yield from ((segment, fault) for fault in self._of(self._log, segment, min(time_ns, end_ns)))
            if time_ns < end_ns:
                return
            self._log = None
            self._rest.pop()

    def _of(self, log: FaultLog, segment: Segment, until_ns: int) -> Iterator[Fault]:
        sensors = segment.scenario.sensors
        if not sensors.have_faults:
            self._known_ns = until_ns
        rate = max((_EPISODES_PER_SECOND, *(sensor.rate for sensor in sensors.on.values())))
        while self._known_ns < until_ns and not self.is_too_far:
            last_ns = min(until_ns, self._known_ns + max(1, int(BLOCK * NS / rate)))
            self._left -= 1 + int((last_ns - self._known_ns) * rate / NS)
            self._known_ns, self.is_too_far = last_ns, self._left < 0
            yield from log.take(last_ns)


class _Expected(NamedTuple):
    """A fault that the bag should tell of, its number in the list of all, and the segment that makes it."""

    number: int
    fault: Fault
    segment: Segment


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
        self._awaited = OrderedDict[str, _Expected]()
        self._drifts: dict[Fault, str] = {}
        self._told, self._told_order = set[int](), deque[int]()  # hashes, as texts take four times as much
        self._count = self._known = 0
        self._first, self._last = (0 if is_whole else None), -1
        self._wrong: dict[str, tuple[int, str]] = {}
        self._worst: tuple[int, int] | None = None
        self.early = self.repeated = self.logged_otherwise = 0

    @property
    def is_too_far(self) -> bool:
        """Whether there are too many readings to look through."""
        return self._expected.is_too_far

    def add(self, messages: FaultMessages) -> None:
        """Take the messages that come next in the file."""
        for time_ns, text in zip(messages.log_times_ns.tolist(), messages.texts, strict=True):
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
        found = self._found(text, fault)
        where = f"message {self._count} ({_in_words(fault)})"
        if found is None and hash(text) in self._told:
            if self._is_whole:
                self._note("twice", where, fault.begin_ns)
            self.repeated += 1
        elif found is None:
            self._note("of which the scenario makes none", where, fault.begin_ns)
        else:
            self._match(found, where, fault.begin_ns)
            self._remember(hash(text))

    def _remember(self, told: int) -> None:
        if told not in self._told:
            self._told.add(told)
            self._told_order.append(told)
        if len(self._told) > _MOST_KEPT:
            self._told.remove(self._told_order.popleft())

    def _match(self, found: _Expected, where: str, begin_ns: int) -> None:
        if self._first is None:
            self._first = found.number
            self._awaited = OrderedDict((t, one) for t, one in self._awaited.items() if one.number > found.number)
        if found.number < self._last:
            self._note("out of order", where, begin_ns)
        self._last = max(self._last, found.number)

    def _found(self, text: str, fault: Fault) -> _Expected | None:
        """The awaited fault that a message tells of; it is awaited no longer."""
        if text not in self._awaited and fault.to_json() == text:
            alike = self._drifts.get(replace(fault, size=None), "")
            if alike in self._awaited and _is_alike(self._awaited[alike], fault):
                text = alike
        return self._awaited.pop(text, None)

    def _expect(self, until_ns: int) -> None:
        for expected in self._coming(until_ns):
            fault = expected.fault
            text = fault.to_json()
            self._awaited[text] = expected
            if fault.kind == "temperature_drift":
                self._drifts[replace(fault, size=None)] = text
            if len(self._awaited) > _MOST_KEPT:
                self._miss(self._awaited.popitem(last=False)[1])

    def _coming(self, until_ns: int) -> Iterator[_Expected]:
        for segment, fault in self._expected.until(until_ns):
            yield _Expected(self._known, fault, segment)
            self._known += 1

    def _miss(self, expected: _Expected) -> None:
        if self._first is not None and expected.number >= self._first:
            begin_ns = expected.fault.begin_ns
            seconds = (begin_ns - expected.segment.start_ns) / NS
            self._note("missing", f"{_in_words(expected.fault)}, {seconds:.9g} s after the start", begin_ns)

    def _note(self, what: str, where: str, begin_ns: int) -> None:
        count, first = self._wrong.get(what, (0, where))
        self._wrong[what] = count + 1, first
        self._worst = self._worst or (self._count, begin_ns)

    def result(self, topic: str, until_ns: int) -> LawResult:
        """Whether the bag tells of every fault, of a bag that is to be whole of every one that begins up to a time."""
        rest = self._coming(until_ns) if self._is_whole else ()
        for expected in itertools.chain(self._awaited.values(), rest):
            if expected.number < self._last or (self._is_whole and expected.fault.begin_ns <= until_ns):
                self._miss(expected)
        self._awaited.clear()
        parts = [f"{count} {what}, the first: {first}" for what, (count, first) in self._wrong.items()]
        wrong = sum(count for count, _ in self._wrong.values())
        sample, stamp = self._worst or (None, None)
        message = f"{topic:.60}: {'; '.join(parts)}" if wrong else ""
        return LawResult(FAULT_LAW, "", float(wrong), 0.0, sample, stamp, wrong, self._count, message)


def _in_words(fault: Fault) -> str:
    return f"{fault.kind} of {' '.join(filter(None, (fault.sensor, fault.axis)))}"


def _is_alike(expected: _Expected, drift: Fault) -> bool:
    """Whether the whole change of a drift is that expected, but for last bits: it is a normal deviate."""
    sigma = expected.segment.scenario.parameters()[f"{drift.sensor}_temperature_drift"]
    assert isinstance(sigma, float)
    return abs((expected.fault.size or 0.0) - (drift.size or 0.0)) <= deviate_rounding(sigma)
