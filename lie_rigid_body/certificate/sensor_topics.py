"""Messages of one sensor in one segment, compared with its replayed readings."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult, LawTally, Watch
from lie_rigid_body.certificate.readings import REPLAY_BLOCK, Replay, ReplayedBlock
from lie_rigid_body.certificate.stamps import DUPLICATE, MAX_MISSING, Lost, StampFault, StampTally
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, same_bits
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.parameters import MAX_EPOCH_NS
from lie_rigid_body.messages import ReadingEncoder
from lie_rigid_body.recording.segments import PlacedMessages, grid
from lie_rigid_body.recording.topic_messages import value_columns, varying_fields
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.simulation.segment import Arrivals


class _Told(NamedTuple):
    """Content of a topic's messages that the scenario determines, except for the readings.

    Parameters
    ----------
    frame : str
    rest : bytes
        The numbers that `TopicMessages` keeps as kinds.
    values : ndarray
        The numbers that it keeps for each message.
    fixed : ndarray of bool
        Which of the latter are the same in every message.
    readings : tuple of (str, str, str, ndarray)
        Name of the law, unit, array, and which of the values are its numbers, of each field of readings.
    """

    frame: str
    rest: bytes
    values: Array
    fixed: Booleans
    readings: tuple[tuple[str, str, str, Integers], ...]


class TopicLaws:
    """The messages of one topic in one segment as they come.

    Parameters
    ----------
    told : _Told
        Expected content of the messages.
    title : str
        Name of the law for fields that are the same in every message.
    topic : str
        Full name of the topic.
    tally : StampTally
    watch : Watch, optional
        Receiver of the residuals of all readings that are compared.

    Attributes
    ----------
    is_exact : bool
        Whether all readings that were compared are equal to the replayed ones, to the bit.
    replay : Replay or None
        What its readings are compared with; None before the first.
    """

    def __init__(self, told: _Told, title: str, topic: str, tally: StampTally, watch: Watch | None) -> None:
        self.topic = topic
        self.tally = tally
        self.is_exact = True
        self.replay: Replay | None = None
        self._told = told
        self._arrived = list[int]()
        self._alike = LawTally(title, "", "frame or covariances are not as declared, at {where}", "reading")
        what = "{law} is {{worst}}{unit} off what the scenario determines (limit {{limit}}) at {{where}}"
        self._values = [
            LawTally(law, unit, what.format(law=law, unit=f" {unit}" if unit else ""), "reading", watch)
            for law, unit, _, _ in told.readings
        ]

    def take(self, placed: PlacedMessages) -> None:
        """Count the next messages, and judge the fields that are the same in all."""
        messages = placed.messages
        told = self._told
        kinds = [(frame, rest) == (told.frame, told.rest) for frame, rest in messages.kinds]
        alike = np.array(kinds, dtype=bool)[messages.kind]
        alike &= (messages.values[:, told.fixed] == told.values[told.fixed]).all(axis=1)
        self.tally.add(placed.times_ns)
        self._alike.add(np.where(alike, 0.0, 1.0), 0.0, placed.numbers, placed.times_ns)

    def compare(self, block: ReplayedBlock, placed: PlacedMessages) -> int:
        """Judge the messages whose readings are in a block; return how many were not logged at their arrival."""
        at = placed.numbers - block.first
        own = np.flatnonzero((at >= 0) & (at < len(block.times_ns)))
        if not len(own):
            return 0
        rows = at[own]
        values = placed.messages.values[own]
        numbers = placed.numbers[own]
        times_ns = placed.times_ns[own]
        for law, (_, _, array, columns) in zip(self._values, self._told.readings, strict=True):
            expected = block.arrays[array][rows]
            recorded = values[:, columns]
            law.add(*expected.residuals(recorded), numbers, times_ns)
            self.is_exact &= same_bits(recorded, expected.values)
        self._arrived.extend(numbers[block.lost[rows]].tolist())
        return int(np.count_nonzero(block.times_ns[rows] != placed.messages.log_times_ns[own]))

    def faults(self, first: int, last: int, lost: Lost | None) -> Iterator[StampFault]:
        """Faults of the stamps of a topic that is to have readings from one number to another, but for lost ones."""
        if self._arrived:
            count = len(self._arrived)
            more = f" and {count - 1} more" if count > 1 else ""
            text = f"{self.topic}: there is reading {min(self._arrived)}{more}, which the scenario loses"
            yield StampFault(DUPLICATE, count, min(self._arrived), text)
        yield from self.tally.faults(self.topic, first, last, lost)

    def results(self) -> Iterator[LawResult]:
        """Results of the laws: how near the content of the messages came to the limits."""
        for law in [*self._values, self._alike]:
            yield law.result()


class SegmentSensor:
    """One sensor in one segment: its topics, and the replay with which they are compared.

    Parameters
    ----------
    segment : Segment
        One whose scenario has the sensor.
    successors : sequence of Segment
        Segments that begin where this one ends.
    name : str
        Name of the sensor.
    topics : mapping of str to str
        Full names of the sensor's topics in the bag, by relative names.
    max_attitude : float or None
        Limit of the attitude's error, rad, in place of that of the declared motion.
    watch : Watch or None

    Attributes
    ----------
    clock : SampleClock
        Clock of the sensor.
    first : int
        Number of the first reading of the segment.
    topics : dict of str to TopicLaws
        Laws of the topics, by relative names.
    """

    def __init__(
        self,
        segment: Segment,
        successors: Sequence[Segment],
        name: str,
        topics: Mapping[str, str],
        max_attitude: float | None,
        watch: Watch | None,
    ) -> None:
        self._segment = segment
        self._begin = partial(Replay, segment, name, max_attitude)
        self._delivery = segment.scenario.sensors.on[name].delivery
        self._end_ns = successors[0].start_ns - 1 if successors else MAX_EPOCH_NS
        self._goes_on = all(name in later.scenario.sensors.on for later in successors)
        self.clock = SampleClock(segment.scenario.epoch_ns, segment.scenario.sensors.on[name].rate)
        self.first = self.clock.count_until(segment.start_ns - 1)
        told = _told(segment.scenario, name)
        self.topics = {
            topic.name: TopicLaws(
                told[topic.name],
                topic.title,
                topics[topic.name],
                StampTally(self.clock, "reading", self._shown_ns),
                watch,
            )
            for topic in SENSORS[name].topics
            if topic.name in topics
        }

    def _shown_ns(self, times_ns: Integers) -> Integers:
        """Times that the sensor's clock shows at given times, ns."""
        if self._delivery is None:
            return times_ns
        return times_ns + self._delivery.error_ns(times_ns, self._segment.scenario.epoch_ns)

    def last_due(self, high: int, end_ns: int, *, is_last: bool, is_whole: bool) -> int:
        """Number of the last reading that a topic is to have.

        Parameters
        ----------
        high : int
            Largest number of a reading in the topic.
        end_ns : int
            Time until which a whole bag has everything, ns.
        is_last : bool
            Whether no later segment has a sample.
        is_whole : bool
            Whether the bag is to have all readings; of a recorder's only those before a reset can be missing.
        """
        if self._goes_on and not is_last:
            return self._arrived_until(self._end_ns) - 1
        if not is_whole:
            return high
        if not self._goes_on:  # a reset leaves out what the sensor would have read after the last sample
            clock = self._segment.clock()
            end_ns = clock.stamp_ns(clock.count_until(self._end_ns) - 1)
        return max(high, self._arrived_until(min(end_ns, self._end_ns)) - 1)

    def unsent(self, last: int) -> int:
        """Number of readings after number ``last`` until a reset that takes the sensor away; 0 without such a reset."""
        return 0 if self._goes_on else max(0, self._arrived_until(self._end_ns) - 1 - last)

    def _arrived_until(self, time_ns: int) -> int:
        """Number of the clock's readings, from number 0 on, that arrive at or before a time, ns."""
        return Arrivals(self.clock, self.first, self._segment.start_ns, self._delivery).count_until(time_ns)

    @property
    def lost(self) -> Lost | None:
        """A function that tells which readings the scenario loses; None if it loses none."""
        delivery = self._delivery
        start_ns = self._segment.start_ns
        first = self.first
        clock = self.clock
        if delivery is None:
            return None
        return lambda numbers: (numbers >= first) & delivery.lost(numbers - first, grid(clock, numbers) - start_ns)

    def add(self, placed: Mapping[str, PlacedMessages]) -> int:
        """Check the next messages, by topic; return how many were not logged at the arrival of their readings."""
        off = 0
        groups = defaultdict[Replay, dict[str, PlacedMessages]](dict)
        for name, own in placed.items():
            topic = self.topics[name]
            groups[self._replay_of(topic, int(own.numbers.min()))][name] = own
            topic.take(own)
            off += int(np.count_nonzero(own.numbers < self.first))
        return off + sum(self._compare(replay, own) for replay, own in groups.items())

    def _replay_of(self, topic: TopicLaws, number: int) -> Replay:
        """The replay that has a topic's next readings: the sensor's own, unless the topic is far behind its others."""
        shared = next((one.replay for one in self.topics.values() if one.replay is not None), None)
        replay = topic.replay or shared or self._begin()
        if self.first <= number < replay.first and (topic.replay is None or number > topic.tally.high):
            replay = self._begin()
        topic.replay = replay
        return replay

    def _compare(self, replay: Replay, placed: Mapping[str, PlacedMessages]) -> int:
        numbers = np.unique(np.concatenate([own.numbers for own in placed.values()]))
        numbers = numbers[np.searchsorted(numbers, replay.first) :]
        off = 0
        while len(numbers):
            number = int(numbers[0])
            if number - replay.next > MAX_MISSING and replay.next > self.first:
                break  # such a gap breaks the law of the stamps
            if number - replay.next > MAX_MISSING:
                topic = next(iter(self.topics.values())).topic
                raise BagError(
                    f"{topic}: {number - replay.next} readings are missing before reading {number}, more than are "
                    "computed: record the bag again"
                )
            last = int(numbers[min(len(numbers), REPLAY_BLOCK) - 1])
            block = replay.block(number, max(number, min(last, number + REPLAY_BLOCK)))
            off += sum(self.topics[name].compare(block, own) for name, own in placed.items())
            numbers = numbers[np.searchsorted(numbers, block.end) :]
        return off

    def forget(self) -> None:
        """Give the memory of replayed readings back."""
        for topic in self.topics.values():
            topic.replay = None

    def results(self, topic: TopicLaws) -> Iterator[LawResult]:
        """The laws of a topic's content; a broken one tells topic and time."""
        for law in topic.results():
            if law.holds or law.stamp_ns is None:
                yield law
                continue
            time_s = (law.stamp_ns - self._segment.start_ns) / 1e9
            message = f"{topic.topic:.60}: {law.message}, {time_s:.9g} s after the start"
            yield replace(law, message=message)


def value_laws() -> frozenset[str]:
    """The laws of readings, which depend on how this software computes noise."""
    return frozenset(field.quantity for sensor in SENSORS.values() for topic in sensor.topics for field in topic.fields)


@lru_cache(maxsize=4)
def _told(scenario: Scenario, name: str) -> dict[str, _Told]:
    """Content of a sensor's messages that the scenario determines, by topic."""
    found = {}
    for topic in SENSORS[name].topics:
        encoder = ReadingEncoder(topic, scenario.sensors.on[name], scenario)
        numbers = np.array(encoder.numbers)
        varying = varying_fields(topic.message_type)
        columns = {field: value_columns(topic, field) for field in encoder.fields}
        fixed = ~np.isin(np.arange(np.count_nonzero(varying)), [place for own in columns.values() for place in own])
        readings = tuple((each.quantity, each.unit, each.array, own) for each, own in columns.items())
        found[topic.name] = _Told(encoder.frame, numbers[~varying].tobytes(), numbers[varying], fixed, readings)
    return found
