"""The sensors of a bag, held against the readings that its scenarios determine."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.readings import WalkBudget
from lie_rigid_body.certificate.residuals_over_time import Watch
from lie_rigid_body.certificate.sensor_topics import (
    MOST_LOST,
    SegmentSensor,
    TopicLaws,
    value_laws,
)
from lie_rigid_body.certificate.stamps import StampFault, stamp_result
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.certificate.told_faults import FAULT_LAW, MOST_LOOKED_THROUGH, FaultLaw
from lie_rigid_body.messages.batch import FAULTS, SENSOR_TOPICS, sensor_topics
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.segments import PlacedMessages, SensorClocks
from lie_rigid_body.recording.topic_messages import FaultMessages, OfSensor, TopicMessages
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class SensorFindings:
    """What is found of the sensors of a bag.

    Parameters
    ----------
    laws : tuple of tuple of LawResult
        For each surveyed segment.
    topics : tuple of str
        Full names of the topics whose readings the laws speak of.
    not_certified : tuple of str
        What else there is, or should be, in words.
    logged_otherwise : int
        Messages that were not logged, or not published, at their stamps.
    whole : tuple of LawResult
        Of the bag as a whole.
    notes : tuple of tuple of str
        For each surveyed segment, which sensors have no reading there, or none to its end, though no law is broken.
    """

    laws: tuple[tuple[LawResult, ...], ...]
    topics: tuple[str, ...] = ()
    not_certified: tuple[str, ...] = ()
    logged_otherwise: int = 0
    whole: tuple[LawResult, ...] = ()
    notes: tuple[tuple[str, ...], ...] = ()

    @property
    def are_exact(self) -> bool:
        """Whether no reading that was compared differs from the replayed one."""
        values = value_laws()
        return all(law.worst == 0.0 for own in self.laws for law in own if law.name in values)

    __repr__ = short_repr


class SensorLaws:
    """The laws of all sensors of a bag, to which their messages are added in file order.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
        Of the same bag.
    watch : Watch, optional
        It is told of the residuals of all readings that are compared.
    """

    def __init__(self, bag: Bag | Recording, surveyed: Survey, watch: Watch | None = None) -> None:
        self._bag, self._surveyed, self._work, self._watch = bag, surveyed, WalkBudget(), watch
        self._declared = {name for segment in surveyed.declared for name in sensor_topics(segment.scenario.sensors)}
        held = [name for name in SENSOR_TOPICS if name in self._declared and name != FAULTS]
        self._held = held if surveyed.as_written else [name for name in held if name in bag.sensors]
        self._faults = self._fault_law()
        self._silent: list[list[str]] = []
        places = {id(found.segment): found for found in surveyed.segments}
        self._found = [places.get(id(segment)) for segment in surveyed.declared]
        self._clocks = {
            topic.name: SensorClocks(surveyed.declared, name)
            for name, sensor in SENSORS.items()
            for topic in sensor.topics
            if topic.name in self._readings
        }
        self._ends: dict[str, int] = {}  # of each topic the last segment, as declared, that it has a reading in
        self._sensors: dict[tuple[int, str], SegmentSensor] = {}
        self._open: dict[str, SegmentSensor] = {}
        self._unsampled = self._logged_otherwise = self._last_ns = 0

    def _full_name(self, name: str) -> str:
        return self._bag.sensors[name].topic if name in self._bag.sensors else name

    @property
    def wanted(self) -> list[str]:
        """The topics of the bag that are to be added, by their relative names."""
        return [*self._readings, *(name for name in (FAULTS,) if self._faults and name in self._bag.sensors)]

    @property
    def _readings(self) -> list[str]:
        return [name for name in self._held if name in self._bag.sensors]

    def _fault_law(self) -> FaultLaw | None:
        bag, surveyed = self._bag, self._surveyed
        if FAULTS not in self._declared or not (surveyed.as_written or FAULTS in bag.sensors):
            return None
        most = MOST_LOOKED_THROUGH + 2 * sum(sensor.count for sensor in bag.sensors.values())
        return FaultLaw(surveyed.declared, self._horizon_ns, is_whole=surveyed.as_written, most=most)

    @property
    def _horizon_ns(self) -> int:
        """A time that no honest message lies behind, ns: a recorder may have lost the truth long before the sensors."""
        last = self._surveyed.segments[-1]
        start_ns, scenario = last.segment.start_ns, last.segment.scenario
        truth_ns = (last.last_ns or start_ns) + round(2 * NS / scenario.rate) + NS
        if self._surveyed.as_written:
            return truth_ns
        counts = {
            name: max(
                (self._bag.sensors[t.name].count for t in SENSORS[name].topics if t.name in self._readings), default=0
            )
            for name in scenario.sensors.on
        }
        longest = max((counts[name] / model.rate for name, model in scenario.sensors.on.items()), default=0.0)
        return max(truth_ns, start_ns + round(MOST_LOST * longest * NS))

    def add(self, readings: Mapping[str, OfSensor]) -> None:
        """Take the messages that come next, by relative topic names."""
        own, faults = self._surveyed.as_written, readings.get(FAULTS)
        if isinstance(faults, FaultMessages) and self._faults is not None:
            self._faults.add(faults)
        for name, sensor in SENSORS.items():
            placed: dict[int, dict[str, PlacedMessages]] = defaultdict(dict)
            for topic in sensor.topics:
                messages = readings.get(topic.name)
                if isinstance(messages, TopicMessages) and len(messages):
                    for part in self._clocks[topic.name].placed(messages, in_order=own):
                        sent_ns = part.messages.log_times_ns if own else part.times_ns
                        self._last_ns = max(self._last_ns, int(sent_ns.max()))
                        self._ends[topic.name] = max(part.place, self._ends.get(topic.name, part.place))
                        placed[part.place][topic.name] = part
            for place in sorted(placed):
                self._add(place, name, placed[place])

    def _add(self, place: int, name: str, placed: Mapping[str, PlacedMessages]) -> None:
        if self._found[place] is None:
            self._unsampled += sum(len(own.numbers) for own in placed.values())
            return
        sensor = self._sensor(place, name)
        if self._open.get(name, sensor) is not sensor:
            self._open[name].close()
        self._open[name] = sensor
        self._logged_otherwise += sensor.add(placed)

    def _sensor(self, place: int, name: str) -> SegmentSensor:
        if (place, name) not in self._sensors:
            found = self._found[place]
            assert found is not None
            topics = {
                topic.name: self._full_name(topic.name) for topic in SENSORS[name].topics if topic.name in self._held
            }
            self._sensors[place, name] = SegmentSensor(
                found, self._successors(place), name, topics, self._work, self._watch
            )
        return self._sensors[place, name]

    def _successors(self, i: int) -> list[Segment]:
        """The segments that begin where one ends: several, if it was reset more than once before the next sample."""
        declared = self._surveyed.declared
        end = next((later.start_ns for later in declared[i + 1 :] if later.start_ns > declared[i].start_ns), None)
        return [segment for segment in declared[i + 1 :] if segment.start_ns == end]

    def findings(self) -> SensorFindings:
        """What was found, after all messages."""
        begun: set[str] = set()
        laws = [
            tuple(self._segment_laws(i, begun, is_last=found is self._surveyed.segments[-1]))
            for i, found in enumerate(self._found)
            if found is not None
        ]
        whole = self._of_faults()
        not_certified = [*self._unheld(), *self._unassigned()]
        computed = value_laws() | {FAULT_LAW}
        broken = any(law.name in computed and not law.holds for own in (*laws, whole) for law in own)
        foreign = other_software(self._bag) if broken else None
        if foreign is not None:
            *laws, whole = (tuple(law for law in own if law.name not in computed) for own in (*laws, whole))
            not_certified.append(
                f"readings of sensors: the scenario is of {foreign!r:.40}, this is {LIBRARY}, which computes others"
            )
        far = {t.topic for sensor in self._sensors.values() if sensor.is_too_far for t in sensor.topics.values()}
        not_certified += [f"{topic}: too many readings are missing to compute the others" for topic in sorted(far)]
        certified = [self._full_name(name) for name in self._readings if foreign is None]
        return SensorFindings(
            tuple(laws),
            tuple(topic for topic in certified if topic not in far),
            tuple(not_certified),
            self._logged_otherwise + sum(self._bag.sensors[name].published_otherwise for name in self.wanted),
            whole,
            tuple(map(tuple, self._silent)),
        )

    def _of_faults(self) -> tuple[LawResult, ...]:
        """The law of the messages about faults, if one speaks of them."""
        if self._faults is None:
            return ()
        law = self._faults.result(self._full_name(FAULTS), self._end_ns)
        self._logged_otherwise += self._faults.logged_otherwise
        return () if self._faults.is_too_far else (law,)

    @property
    def _end_ns(self) -> int:
        """Until when a bag that is to be whole has everything, ns: one that was cut off not all of its last time."""
        cut_off = self._bag.was_cut_off and self._bag.expected_samples is None
        return max(self._last_ns, self._surveyed.segments[-1].last_ns or 0) - cut_off

    def _unheld(self) -> Iterator[str]:
        for name in SENSOR_TOPICS:
            sensor = self._bag.sensors.get(name)
            if sensor is not None and name not in self._declared:
                yield f"topic {sensor.topic} ({sensor.count} messages), a sensor that no scenario has"
            if name in self._declared and name not in self._held and sensor is None:
                yield f"{name}, which the scenario has: not in the bag"

    def _unassigned(self) -> Iterator[str]:
        early = sum(clocks.early for clocks in self._clocks.values())
        if early and not self._surveyed.as_written:
            yield f"readings before the first scenario's start: {early}"
        if self._unsampled:
            yield f"readings under scenarios without a sample: {self._unsampled}"
        faults = self._faults
        if faults is not None and faults.is_too_far:
            yield f"{self._full_name(FAULTS)}: too many readings to compute the faults of all"
        elif faults is not None and not self._surveyed.as_written:
            if faults.early:
                yield f"faults before the first scenario's start: {faults.early}"
            if faults.repeated:
                yield f"messages about faults that come again: {faults.repeated}"

    def _segment_laws(self, i: int, begun: set[str], *, is_last: bool) -> Iterator[LawResult]:
        self._silent.append([])
        if self._found[i] is self._surveyed.segments[0]:
            yield from self._strays()
        for name in SENSORS:
            sensor = self._sensor(i, name)
            if sensor.clock is None:
                begun -= set(sensor.strays)
                yield from self._strays_of(sensor, f"{SENSORS[name].title} stamps")
            elif sensor.topics:
                yield from self._sensor_laws(i, f"{SENSORS[name].title} stamps", sensor, begun, is_last=is_last)

    def _strays(self) -> Iterator[LawResult]:
        for name, clocks in self._clocks.items():
            topic, (unshown, first) = self._full_name(name), clocks.unshown
            if clocks.early and self._surveyed.as_written:
                yield _stray("sensor stamps", clocks.early, f"{topic}: readings before the first scenario's start")
            if unshown:
                text = f"{topic}: readings whose stamp no clock of the scenario shows (first {first} ns)"
                yield _stray("sensor stamps", unshown, text)

    def _strays_of(self, sensor: SegmentSensor, name: str) -> Iterator[LawResult]:
        for topic, count in sensor.strays.items():
            if count:
                text = f"{self._full_name(topic)}: readings of a sensor that the scenario has not"
                yield _stray(name, count, text)

    def _sensor_laws(
        self, i: int, name: str, sensor: SegmentSensor, begun: set[str], *, is_last: bool
    ) -> Iterator[LawResult]:
        assert sensor.clock is not None
        own, faults = self._surveyed.as_written, list[StampFault]()
        for relative, topic in sensor.topics.items():
            tally, has_ended = topic.tally, not own and i >= self._ends.get(relative, 0)
            whole = own or relative in begun
            end = self._last(sensor, topic, is_last=is_last)
            last, lost = tally.high if has_ended else end, sensor.lost(tally, end)
            due = tally.count or (whole and not has_ended)
            wrong = (
                tally.faults(topic.topic, sensor.first if whole or not tally.count else tally.low, last, lost)
                if due
                else []
            )
            faults += wrong
            if tally.count:
                begun.add(relative)
                if end - last > lost.count(last + 1, end):
                    self._silent[-1].append(f"readings on {topic.topic} end with {last}: {self._why_silent(0)}")
            elif not wrong:
                why = self._why_silent(lost.count(sensor.first, end))
                self._silent[-1].append(f"no reading on {topic.topic}: {why}")
        checked = sum(topic.tally.count for topic in sensor.topics.values())
        if checked or faults:
            yield stamp_result(name, sensor.clock, faults, checked)
        for topic in sensor.topics.values():
            if topic.tally.count:
                yield from sensor.results(topic)

    def _why_silent(self, lost: int) -> str:
        if not self._surveyed.as_written:
            return "what a recorder lacks before its first one, or after its last, is not certified"
        return f"the scenario loses all {lost} of this segment" if lost else "none arrives within this segment"

    def _last(self, sensor: SegmentSensor, topic: TopicLaws, *, is_last: bool) -> int:
        """Number of the last reading that a topic is to have in a segment."""
        own, high = self._surveyed.as_written, topic.tally.high
        if not is_last and sensor.goes_on:
            assert sensor.end_ns is not None
            return sensor.arrived_until(sensor.end_ns) - 1
        if is_last:
            end_ns = self._end_ns if sensor.end_ns is None else min(self._end_ns, sensor.end_ns)
        else:  # a reset that takes a sensor away leaves out what it would have read until then
            end_ns = sensor.last_sample_ns
        return max(high, sensor.arrived_until(end_ns) - 1) if own else high


def other_software(bag: Bag | Recording) -> str | None:
    """The first software other than this that a scenario of a bag says it is of."""
    found = (json.loads(text).get("software") for _, text in bag.scenario_texts)
    return next((str(software) for software in found if software != LIBRARY), None)


def _stray(name: str, count: int, what: str) -> LawResult:
    """The broken law of readings that should not be there."""
    return LawResult(name, "", float(count), 0.0, None, None, count, count, f"{what}: {count}")
