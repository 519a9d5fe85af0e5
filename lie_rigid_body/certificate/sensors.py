"""The sensors of a bag, held against the readings that its scenarios determine."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from lie_rigid_body import __version__
from lie_rigid_body.certificate.erring_clocks import FASTEST, ErringClocks, err
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.segments import Survey, segment_parts
from lie_rigid_body.certificate.sensor_topics import VALUES, TopicLaws, Work, model_of
from lie_rigid_body.certificate.stamps import StampFault, stamp_result
from lie_rigid_body.messages.batch import ATTITUDE, IMU_BIAS, IMU_DATA, MAG, SENSOR_TOPICS, SUN, sensor_topics
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.sensor_reader import SensorMessages
from lie_rigid_body.simulation import SOFTWARE, SampleClock, Segment
from lie_rigid_body.wording import short_repr

_SENSORS: Final = {
    "IMU": (IMU_DATA, IMU_BIAS),
    "magnetometer": (MAG,),
    "attitude sensor": (ATTITUDE,),
    "sun sensor": (SUN,),
}
_SOFTWARE: Final = f"{SOFTWARE} {__version__}"


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
    """

    laws: tuple[tuple[LawResult, ...], ...]
    topics: tuple[str, ...] = ()
    not_certified: tuple[str, ...] = ()
    logged_otherwise: int = 0

    __repr__ = short_repr


class SensorLaws:
    """The laws of all sensors of a bag, to which their messages are added in file order.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
        Of the same bag.
    """

    def __init__(self, bag: Bag | Recording, surveyed: Survey) -> None:
        self._bag, self._surveyed, self._work = bag, surveyed, Work()
        self._declared = {name for segment in surveyed.declared for name in sensor_topics(segment.scenario.sensors)}
        self._held = [name for name in SENSOR_TOPICS if name in self._declared]
        self._unlawful = {name: reason for name in self._held if (reason := _why_unlawful(surveyed.declared, name))}
        self._held = [name for name in self._held if name not in self._unlawful]
        if not surveyed.as_written:
            self._held = [name for name in self._held if name in bag.sensors]
        places = {id(found.segment): found for found in surveyed.segments}
        self._found = [places.get(id(segment)) for segment in surveyed.declared]
        self._clocks = {name: clocks for name in self.wanted if (clocks := _erring(surveyed.declared, name))}
        self._unshown: dict[str, tuple[int, int]] = {}
        self._topics: dict[tuple[int, str], TopicLaws] = {}
        self._open: dict[str, TopicLaws] = {}
        self._early = self._unsampled = self._logged_otherwise = self._last_ns = 0

    def _full_name(self, name: str) -> str:
        return self._bag.sensors[name].topic if name in self._bag.sensors else name

    @property
    def wanted(self) -> list[str]:
        """The topics of the bag that are to be added, by their relative names."""
        return [name for name in self._held if name in self._bag.sensors]

    def add(self, readings: Mapping[str, SensorMessages]) -> None:
        """Take the messages that come next, by relative topic names."""
        for name, messages in readings.items():
            if len(messages):
                self._add(name, messages)

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
            self._open[name] = TopicLaws(found, self._successors(i), name, self._full_name(name), self._work)
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
        not_certified = tuple(self._unheld())
        foreign = self._foreign_software() if _broken_values(laws) else None
        if foreign is not None:
            laws = [tuple(law for law in own if law.name not in VALUES) for own in laws]
            not_certified += (
                f"readings of sensors: the scenario is of {foreign!r:.40}, this is {_SOFTWARE}, which computes others",
            )
        far = {laws_of.topic for laws_of in self._topics.values() if laws_of.is_too_far}
        not_certified += tuple(f"{topic}: too many readings are missing to compute the others" for topic in sorted(far))
        certified = [self._full_name(name) for name in self.wanted if foreign is None]
        return SensorFindings(
            tuple(laws),
            tuple(topic for topic in certified if topic not in far),
            not_certified + tuple(self._unassigned()),
            self._logged_otherwise + sum(self._bag.sensors[name].published_otherwise for name in self.wanted),
        )

    def _unheld(self) -> Iterator[str]:
        for name in SENSOR_TOPICS:
            sensor = self._bag.sensors.get(name)
            if sensor is not None and name not in self._declared:
                yield f"topic {sensor.topic} ({sensor.count} messages), a sensor that no scenario has"
            if name in self._unlawful and sensor is not None:
                yield f"topic {sensor.topic} ({sensor.count} messages): {self._unlawful[name]}"
            elif name in self._declared and name not in self._held:
                yield f"{name}, which the scenario has: not in the bag"

    def _unassigned(self) -> Iterator[str]:
        if self._early and not self._surveyed.as_written:
            yield f"readings before the first scenario's start: {self._early}"
        if self._unsampled:
            yield f"readings under scenarios without a sample: {self._unsampled}"

    def _foreign_software(self) -> str | None:
        """The first software other than this that a scenario says it is of."""
        found = (json.loads(text).get("software") for _, text in self._bag.scenario_texts)
        return next((str(software) for software in found if software != _SOFTWARE), None)

    def _segment_laws(self, i: int, begun: set[str], *, is_last: bool) -> Iterator[LawResult]:
        if self._found[i] is self._surveyed.segments[0]:
            yield from self._strays()
        for sensor, names in _SENSORS.items():
            topics = [self._laws(i, name) for name in names if name in self._held]
            if topics:
                yield from self._sensor_laws(f"{sensor} stamps", topics, begun, is_last=is_last)

    def _strays(self) -> Iterator[LawResult]:
        if self._early and self._surveyed.as_written:
            yield _stray("sensor stamps", self._early, "readings before the first scenario's start")
        for name, (count, first) in self._unshown.items():
            text = f"{self._full_name(name)}: readings whose stamp no clock of the scenario shows (first {first} ns)"
            yield _stray("sensor stamps", count, text)

    def _sensor_laws(
        self, name: str, topics: Sequence[TopicLaws], begun: set[str], *, is_last: bool
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
            last = self._last(topic, clock, is_last=is_last)
            if whole or topic.tally.count:
                faults += topic.tally.faults(topic.topic, first, last, topic.lost(last))
            if topic.tally.count:
                begun.add(topic.name)
        checked = sum(topic.tally.count for topic in topics)
        if checked or faults:
            yield stamp_result(name, clock, faults, checked)
        for topic in topics:
            if topic.tally.count:
                yield from topic.results()

    def _last(self, topic: TopicLaws, clock: SampleClock, *, is_last: bool) -> int:
        """Number of the last reading that a topic is to have in a segment."""
        own, high = self._surveyed.as_written, topic.tally.high
        if is_last:
            end = max(self._last_ns, topic.found.last_ns or 0)
            if topic.end_ns is not None:
                end = min(end, topic.end_ns)
            cut_off = self._bag.was_cut_off and self._bag.expected_samples is None
            return max(high, topic.arrived_until(end - cut_off) - 1) if own else high
        assert topic.end_ns is not None
        if topic.goes_on:
            return topic.arrived_until(topic.end_ns) - 1
        # a reset that takes a sensor away leaves out what it would have read until then
        return max(high, topic.arrived_until(topic.last_sample_ns) - 1) if own else high


def _erring(segments: Sequence[Segment], name: str) -> ErringClocks | None:
    """The clocks that stamp a topic, if any errs."""
    models = [model_of(segment.scenario, name) for segment in segments]
    return ErringClocks(segments, models) if err(models) else None


def _why_unlawful(segments: Sequence[Segment], name: str) -> str:
    """Why no law speaks of a topic; empty if laws do."""
    if name not in itertools.chain(*_SENSORS.values()):
        return "no law reads it"
    models = [model_of(segment.scenario, name) for segment in segments]
    if err(models) and any(model is not None and model.rate > FASTEST for model in models):
        return f"its clock errs, and by that the times of more than {FASTEST:g} readings in a second are not told"
    return ""


def _broken_values(laws: Sequence[tuple[LawResult, ...]]) -> bool:
    return any(law.name in VALUES and not law.holds for own in laws for law in own)


def _stray(name: str, count: int, what: str) -> LawResult:
    """The broken law of readings that should not be there."""
    return LawResult(name, "", float(count), 0.0, None, None, count, count, f"{what}: {count}")
