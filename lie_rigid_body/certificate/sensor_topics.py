"""The messages of one sensor in one segment, held against its replayed readings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.certificate.law_result import LawResult, LawTally
from lie_rigid_body.certificate.readings import Piece, Replay, WalkBudget
from lie_rigid_body.certificate.residuals_over_time import Watch
from lie_rigid_body.certificate.stamps import NONE_LOST, Lost, StampTally
from lie_rigid_body.certificate.surveyed_segment import SurveyedSegment
from lie_rigid_body.certificate.tolerance import ATTITUDE_CAP
from lie_rigid_body.messages import ReadingEncoder
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.sensor_clocks import PlacedMessages
from lie_rigid_body.recording.sensor_reader import value_columns, varying_fields
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.simulation.segment import Arrivals

MOST_LOST: Final = 100
"""Readings that a sensor may have lost for each that a recorder has, where it has no truth beside them."""


class _Told(NamedTuple):
    """What a scenario makes of the messages of a topic, but for the readings in them.

    Parameters
    ----------
    frame : str
    rest, values : ndarray
        The numbers that `SensorMessages` keeps as kinds, and those that it keeps for each message.
    fixed : ndarray of bool
        Which of the latter are the same in every message.
    readings : tuple of (str, str, str, slice or ndarray)
        Name of the law, unit, array, and which of the values are its numbers, of each field of readings.
    """

    frame: str
    rest: Array
    values: Array
    fixed: Booleans
    readings: tuple[tuple[str, str, str, slice | Integers], ...]


class TopicLaws:
    """The messages of one topic in one segment as they come.

    Parameters
    ----------
    told : _Told
        What its messages should be.
    title : str
        Name of the law of what is the same in every message.
    topic : str
        Its full name.
    tally : StampTally
    watch : Watch, optional
        It is told of the residuals of all readings that are compared.
    """

    def __init__(self, told: _Told, title: str, topic: str, tally: StampTally, watch: Watch | None) -> None:
        self.topic, self.tally, self._told = topic, tally, told
        self._alike = LawTally(title, "", "frame or covariances are not as declared, at {where}", "reading")
        what = "{law} is {{worst}}{unit} off what the scenario determines (limit {{limit}}) at {{where}}"
        self._values = [
            LawTally(law, unit, what.format(law=law, unit=f" {unit}" if unit else ""), "reading", watch)
            for law, unit, _, _ in told.readings
        ]

    def take(self, placed: PlacedMessages) -> None:
        """Count messages that come next, and judge what is the same in all."""
        messages, told = placed.messages, self._told
        own = [name == told.frame and np.array_equal(np.frombuffer(rest), told.rest) for name, rest in messages.kinds]
        alike = np.array(own, dtype=bool)[messages.kind]
        alike &= (messages.values[:, told.fixed] == told.values[told.fixed]).all(axis=1)
        self.tally.add(placed.times_ns)
        self._alike.add(np.where(alike, 0.0, 1.0), 0.0, placed.numbers, placed.times_ns)

    def compare(self, piece: Piece, placed: PlacedMessages) -> int:
        """Judge those messages whose readings are in a piece; return how many are not logged when they arrive."""
        at = placed.numbers - piece.first
        inside = np.flatnonzero((at >= 0) & (at < len(piece.times_ns)))
        if not len(inside):
            return 0
        own, rows = _as_slice(inside), _as_slice(at[inside])
        values, numbers, times_ns = placed.messages.values[own], placed.numbers[own], placed.times_ns[own]
        for law, (_, _, array, columns) in zip(self._values, self._told.readings, strict=True):
            law.add(*piece.arrays[array][rows].residuals(values[:, columns]), numbers, times_ns)
        return int(np.count_nonzero(piece.times_ns[rows] != placed.messages.log_times_ns[own]))

    def results(self, *, with_values: bool) -> Iterator[LawResult]:
        """How near the laws of the messages' content came to their limits."""
        for law in [*(self._values if with_values else []), self._alike]:
            yield law.result()


class SegmentSensor:
    """One sensor in one segment: its topics, and the replay that they are held against.

    Parameters
    ----------
    found : SurveyedSegment
    successors : sequence of Segment
        Those that begin where this one ends.
    name : str
        The sensor's.
    topics : mapping of str to str
        Full names of the topics that are held against it, by relative names.
    work : WalkBudget
    watch : Watch, optional

    Attributes
    ----------
    clock : SampleClock or None
        Of the sensor; None if the scenario has no such sensor.
    first : int
        Number of the first reading of the segment.
    topics : dict of str to TopicLaws
        By relative names.
    strays : dict of str to int
        Readings on each topic of a sensor that the scenario has not.
    is_too_far : bool
        Whether some readings were not compared, as too many are missing before them.
    """

    def __init__(
        self,
        found: SurveyedSegment,
        successors: Sequence[Segment],
        name: str,
        topics: Mapping[str, str],
        work: WalkBudget,
        watch: Watch | None = None,
    ) -> None:
        self.found, self._successors, self._name, self._work = found, successors, name, work
        self.end_ns = successors[0].start_ns - 1 if successors else None
        self.is_too_far, self._motion_error = False, 0.0
        self._replay: Replay | None = None
        self.strays = dict.fromkeys(topics, 0)
        segment = found.segment
        self._model = model = segment.scenario.sensors.on.get(name)
        self.clock = None if model is None else SampleClock(segment.scenario.epoch_ns, model.rate)
        self.first = 0 if self.clock is None else self.clock.count_until(segment.start_ns - 1)
        told = _told(segment.scenario, name) if model is not None else {}
        self.topics = {
            topic.name: TopicLaws(told[topic.name], topic.title, topics[topic.name], self._tally(), watch)
            for topic in SENSORS[name].topics
            if model is not None and topic.name in topics
        }

    def _tally(self) -> StampTally:
        assert self.clock is not None
        return StampTally(self.clock, "reading", self._shown_ns)

    def _shown_ns(self, times_ns: Integers) -> Integers:
        """What the sensor's clock shows at some times, ns."""
        delivery = None if self._model is None else self._model.delivery
        epoch_ns = self.found.segment.scenario.epoch_ns
        return times_ns if delivery is None else times_ns + delivery.error_ns(times_ns, epoch_ns)

    @property
    def goes_on(self) -> bool:
        """Whether the sensor is there after the segment as well."""
        return all(self._name in later.scenario.sensors.on for later in self._successors)

    @property
    def last_sample_ns(self) -> int:
        """Stamp of the truth's last sample before the segment ends, ns."""
        assert self.end_ns is not None
        clock = self.found.segment.clock()
        return clock.stamp_ns(clock.count_until(self.end_ns) - 1)

    def arrived_until(self, time_ns: int) -> int:
        """How many readings of the clock, from number 0 on, arrive at or before a time."""
        assert self.clock is not None
        assert self._model is not None
        start_ns, delivery = self.found.segment.start_ns, self._model.delivery
        sent = self.clock if delivery is None else Arrivals(self.clock, self.first, start_ns, delivery)
        return sent.count_until(time_ns)

    def lost(self, tally: StampTally, last: int) -> Lost:
        """The readings of the segment that never arrived, up to a number; none far behind all messages of a topic."""
        segment, clock, first = self.found.segment, self.clock, self.first
        delivery = None if self._model is None else self._model.delivery
        if clock is None or delivery is None:
            return NONE_LOST
        # a forged stamp may lie years ahead
        truth_ns = (self.found.last_ns or segment.start_ns) + round(2 * NS / segment.scenario.rate) + NS
        most = max(clock.count_until(truth_ns), first + MOST_LOST * tally.count)
        return Lost(
            first,
            min(last + 1, most),
            lambda k, n: delivery.lost(k - first, clock.stamps_ns(k, n) - segment.start_ns),
        )

    def add(self, placed: Mapping[str, PlacedMessages]) -> int:
        """Take the messages that come next, by topic; return how many are not logged when their readings arrive."""
        if self.clock is None:
            for name, own in placed.items():
                self.strays[name] += len(own.numbers)
            return sum(int(np.count_nonzero(own.times_ns != own.messages.log_times_ns)) for own in placed.values())
        for name, own in placed.items():
            self.topics[name].take(own)
        numbers = np.unique(np.concatenate([own.numbers for own in placed.values()]))
        off = sum(int(np.count_nonzero(own.numbers < self.first)) for own in placed.values())
        numbers = numbers[np.searchsorted(numbers, self.first) :]
        while len(numbers) and not self.is_too_far:
            piece = self._replayed().piece(numbers)
            self.is_too_far = piece is None
            if piece is not None:
                off += sum(self.topics[name].compare(piece, own) for name, own in placed.items())
                numbers = numbers[np.searchsorted(numbers, piece.end) :]
        return off

    def _replayed(self) -> Replay:
        if self._replay is None:
            self._replay = Replay(self.found.segment, self._name, self.found.duration, self._work)
            self._motion_error = self._replay.motion_error
        return self._replay

    def close(self) -> None:
        """Forget the replay, which begins anew where another message comes."""
        self._replay = None

    def results(self, topic: TopicLaws) -> Iterator[LawResult]:
        """The laws of a topic's content; a broken one tells topic, time, and whether the stepper is to blame."""
        for law in topic.results(with_values=not self.is_too_far):
            if law.holds or law.stamp_ns is None:
                yield law
                continue
            time_s = (law.stamp_ns - self.found.segment.start_ns) / 1e9
            message = f"{topic.topic:.60}: {law.message}, {time_s:.9g} s after the start"
            if law.name in value_laws() and self._motion_error > ATTITUDE_CAP:
                message += (
                    f": between these readings the declared stepper errs by up to {self._motion_error:.2g} rad, "
                    f"a ground truth by {ATTITUDE_CAP:g} at most"
                )
            yield replace(law, message=message)


def value_laws() -> frozenset[str]:
    """The laws of readings, which depend on how this software computes noise."""
    return frozenset(field.quantity for sensor in SENSORS.values() for topic in sensor.topics for field in topic.fields)


@lru_cache(maxsize=4)
def _told(scenario: Scenario, name: str) -> dict[str, _Told]:
    """What a scenario makes of the messages of a sensor, by topic."""
    found = {}
    for topic in SENSORS[name].topics:
        encoder, varying = (
            ReadingEncoder(topic, scenario.sensors.on[name], scenario),
            varying_fields(topic.message_type),
        )
        numbers = np.array(encoder.numbers)
        fixed = np.full(np.count_nonzero(varying), fill_value=True)
        readings = []
        for field in encoder.fields:
            columns = value_columns(topic, field)
            fixed[columns] = False
            readings.append((field.quantity, field.unit, field.array, _as_slice(columns)))
        found[topic.name] = _Told(encoder.frame, numbers[~varying], numbers[varying], fixed, tuple(readings))
    return found


def _as_slice(indices: Integers) -> slice | Integers:
    """Indices as a slice where they follow each other, which copies nothing."""
    first, last = int(indices[0]), int(indices[-1])
    follow = last - first + 1 == len(indices) and (np.diff(indices) == 1).all()
    return slice(first, last + 1) if follow else indices
