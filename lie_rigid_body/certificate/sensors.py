"""The sensors of a bag, held against the readings that its scenarios determine."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from lie_rigid_body.arrays import Integers
from lie_rigid_body.certificate.erring_clocks import FASTEST, ErringClocks, err
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.residuals_over_time import Watch
from lie_rigid_body.certificate.sensor_topics import MOST_LOST, VALUES, TopicLaws, Work, model_of
from lie_rigid_body.certificate.stamps import StampFault, stamp_result
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.certificate.told_faults import FAULT_LAW, MOST_LOOKED_THROUGH, FaultLaw
from lie_rigid_body.messages.batch import FAULTS, SENSOR_TOPICS, sensor_topics
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.segments import declared_segments, segment_parts
from lie_rigid_body.recording.sensor_reader import SensorMessages
from lie_rigid_body.recording.tracks import OfSensor, Recording
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SampleClock, Segment
from lie_rigid_body.wording import short_repr

_COMPUTED: Final = VALUES | {FAULT_LAW}
"""The laws that depend on how this software computes noise and faults."""


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
        self._bag, self._surveyed, self._work, self._watch = bag, surveyed, Work(), watch
        self._declared = {name for segment in surveyed.declared for name in sensor_topics(segment.scenario.sensors)}
        self._held = [name for name in SENSOR_TOPICS if name in self._declared and name != FAULTS]
        self._unlawful = {name: reason for name in self._held if (reason := _why_unlawful(surveyed.declared, name))}
        self._held = [name for name in self._held if name not in self._unlawful]
        if not surveyed.as_written:
            self._held = [name for name in self._held if name in bag.sensors]
        self._faults = self._fault_law()
        self._silent: list[list[str]] = []
        places = {id(found.segment): found for found in surveyed.segments}
        self._found = [places.get(id(segment)) for segment in surveyed.declared]
        self._clocks = {name: clocks for name in self._readings if (clocks := _erring(surveyed.declared, name))}
        self._unshown: dict[str, tuple[int, int]] = {}
        self._ends: dict[str, int] = {}  # of each topic the last segment, as declared, that it has a reading in
        self._topics: dict[tuple[int, str], TopicLaws] = {}
        self._open: dict[str, TopicLaws] = {}
        self._early = self._unsampled = self._logged_otherwise = self._last_ns = 0

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
        models = {name: model for name in self._readings if (model := model_of(scenario, name))}
        longest = max((self._bag.sensors[name].count / model.rate for name, model in models.items()), default=0.0)
        return max(truth_ns, start_ns + round(MOST_LOST * longest * NS))

    def add(self, readings: Mapping[str, OfSensor]) -> None:
        """Take the messages that come next, by relative topic names."""
        for name, messages in readings.items():
            if isinstance(messages, SensorMessages):
                if len(messages):
                    self._add(name, messages)
            elif self._faults is not None:
                self._faults.add(messages)

    def _add(self, name: str, messages: SensorMessages) -> None:
        own_times = self._surveyed.as_written
        if name in self._clocks:
            messages, unknown = self._clocks[name].measured(messages, in_order=own_times)
            if len(unknown):
                count, first = self._unshown.get(name, (0, int(unknown[0])))
                self._unshown[name] = count + len(unknown), first
        sent_ns = messages.log_times_ns if own_times else messages.stamps_ns
        self._last_ns = max(self._last_ns, int(sent_ns.max(initial=0)))
        taken = 0
        for i, rows in segment_parts(self._surveyed.declared, messages.stamps_ns):
            own = messages[rows]
            taken += len(own)
            self._ends[name] = max(i, self._ends.get(name, i))
            if self._found[i] is None:
                self._unsampled += len(own)
            else:
                laws = self._laws(i, name)
                self._logged_otherwise += laws.logged_otherwise(own)
                laws.add(own)
        self._early += len(messages) - taken

    def _laws(self, i: int, name: str) -> TopicLaws:
        if (i, name) not in self._topics:
            found = self._found[i]
            assert found is not None
            if name in self._open:
                self._open[name].finish()
            self._open[name] = TopicLaws(
                found, self._successors(i), name, self._full_name(name), self._work, self._watch
            )
            self._topics[i, name] = self._open[name]
        return self._topics[i, name]

    def _successors(self, i: int) -> list[Segment]:
        """The segments that begin where one ends: several, if it was reset more than once before the next sample."""
        declared = self._surveyed.declared
        end = next((later.start_ns for later in declared[i + 1 :] if later.start_ns > declared[i].start_ns), None)
        return [segment for segment in declared[i + 1 :] if segment.start_ns == end]

    def findings(self) -> SensorFindings:
        """What was found, after all messages."""
        for still_open in self._open.values():
            still_open.finish()
        begun: set[str] = set()
        laws = [
            tuple(self._segment_laws(i, begun, is_last=found is self._surveyed.segments[-1]))
            for i, found in enumerate(self._found)
            if found is not None
        ]
        whole = self._of_faults()
        not_certified = [*self._unheld(), *self._unassigned()]
        foreign = self._foreign_software() if _broken_values([*laws, whole]) else None
        if foreign is not None:
            *laws, whole = (tuple(law for law in own if law.name not in _COMPUTED) for own in (*laws, whole))
            not_certified.append(
                f"readings of sensors: the scenario is of {foreign!r:.40}, this is {LIBRARY}, which computes others"
            )
        far = {laws_of.topic for laws_of in self._topics.values() if laws_of.is_too_far}
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
            if name in self._unlawful and sensor is not None:
                yield f"topic {sensor.topic} ({sensor.count} messages): {self._unlawful[name]}"
            elif name in self._declared and name not in self._held and sensor is None:
                yield f"{name}, which the scenario has: not in the bag"

    def _unassigned(self) -> Iterator[str]:
        if self._early and not self._surveyed.as_written:
            yield f"readings before the first scenario's start: {self._early}"
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

    def _foreign_software(self) -> str | None:
        """The first software other than this that a scenario says it is of."""
        found = (json.loads(text).get("software") for _, text in self._bag.scenario_texts)
        return next((str(software) for software in found if software != LIBRARY), None)

    def _segment_laws(self, i: int, begun: set[str], *, is_last: bool) -> Iterator[LawResult]:
        self._silent.append([])
        if self._found[i] is self._surveyed.segments[0]:
            yield from self._strays()
        for sensor in SENSORS.values():
            names = [topic.name for topic in sensor.topics]
            topics = [self._laws(i, name) for name in names if name in self._held]
            ended = {name for name in names if not self._surveyed.as_written and i >= self._ends.get(name, 0)}
            if topics:
                yield from self._sensor_laws(f"{sensor.title} stamps", topics, begun, ended, is_last=is_last)

    def _strays(self) -> Iterator[LawResult]:
        if self._early and self._surveyed.as_written:
            yield _stray("sensor stamps", self._early, "readings before the first scenario's start")
        for name, (count, first) in self._unshown.items():
            text = f"{self._full_name(name)}: readings whose stamp no clock of the scenario shows (first {first} ns)"
            yield _stray("sensor stamps", count, text)

    def _sensor_laws(
        self, name: str, topics: Sequence[TopicLaws], begun: set[str], ended: set[str], *, is_last: bool
    ) -> Iterator[LawResult]:
        clock = topics[0].clock
        if clock is None:
            begun -= {topic.name for topic in topics}
            for topic in topics:
                if topic.strays:
                    yield _stray(name, topic.strays, f"{topic.topic}: readings of a sensor that the scenario has not")
            return
        faults: list[StampFault] = []
        for topic in topics:
            whole = self._surveyed.as_written or topic.name in begun
            first = topic.first if whole or not topic.tally.count else topic.tally.low
            end = self._last(topic, clock, is_last=is_last)
            last = topic.tally.high if topic.name in ended else end
            lost = topic.lost(end)
            due = topic.tally.count or (whole and topic.name not in ended)
            wrong = topic.tally.faults(topic.topic, first, last, lost) if due else []
            faults += wrong
            if topic.tally.count:
                begun.add(topic.name)
                if end - last > lost.count(last + 1, end):
                    self._silent[-1].append(f"readings on {topic.topic} end with {last}: {self._why_silent(0)}")
            elif not wrong:
                why = self._why_silent(lost.count(topic.first, end))
                self._silent[-1].append(f"no reading on {topic.topic}: {why}")
        checked = sum(topic.tally.count for topic in topics)
        if checked or faults:
            yield stamp_result(name, clock, faults, checked)
        for topic in topics:
            if topic.tally.count:
                yield from topic.results()

    def _why_silent(self, lost: int) -> str:
        if not self._surveyed.as_written:
            return "what a recorder lacks before its first one, or after its last, is not certified"
        return f"the scenario loses all {lost} of this segment" if lost else "none arrives within this segment"

    def _last(self, topic: TopicLaws, clock: SampleClock, *, is_last: bool) -> int:
        """Number of the last reading that a topic is to have in a segment."""
        own, high = self._surveyed.as_written, topic.tally.high
        if is_last:
            end = self._end_ns if topic.end_ns is None else min(self._end_ns, topic.end_ns)
            return max(high, topic.arrived_until(end) - 1) if own else high
        assert topic.end_ns is not None
        if topic.goes_on:
            return topic.arrived_until(topic.end_ns) - 1
        # a reset that takes a sensor away leaves out what it would have read until then
        return max(high, topic.arrived_until(topic.last_sample_ns) - 1) if own else high


def _erring(segments: Sequence[Segment], name: str) -> ErringClocks | None:
    """The clocks that stamp a topic, if any errs."""
    models = [model_of(segment.scenario, name) for segment in segments]
    return ErringClocks(segments, models) if err(models) else None


def measured_ns(recording: Recording, name: str) -> Integers:
    """When the readings on a topic of a recorder's bag were measured, ns: their stamps, unless a clock errs."""
    messages = recording.readings[name]
    clocks = _erring([*declared_segments(text for _, text in recording.scenario_texts).values()], name)
    assert isinstance(messages, SensorMessages)
    if clocks is None:
        return messages.stamps_ns
    measured, unknown = clocks.measured(messages, in_order=False)
    return messages.stamps_ns if len(unknown) else measured.stamps_ns  # as good as any where no clock shows a stamp


def _why_unlawful(segments: Sequence[Segment], name: str) -> str:
    """Why no law speaks of a topic; empty if laws do."""
    models = [model_of(segment.scenario, name) for segment in segments]
    if err(models) and any(model is not None and model.rate > FASTEST for model in models):
        return f"its clock errs, and by that the times of more than {FASTEST:g} readings in a second are not told"
    return ""


def _broken_values(laws: Sequence[tuple[LawResult, ...]]) -> bool:
    return any(law.name in _COMPUTED and not law.holds for own in laws for law in own)


def _stray(name: str, count: int, what: str) -> LawResult:
    """The broken law of readings that should not be there."""
    return LawResult(name, "", float(count), 0.0, None, None, count, count, f"{what}: {count}")
