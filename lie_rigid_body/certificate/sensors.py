"""The sensors of a bag: their readings are replayed, paired with its messages, and compared.

Of each segment the readings are replayed from its start, once. A message belongs to the segment in which it was logged
in a bag of this package, and to that whose clock shows its stamp in a recorder's. There its number is that of the
nearest reading. What is missing, doubled or strange is found as in sets of numbers.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence

from lie_rigid_body.certificate.law_result import LawResult, Laws, Watch
from lie_rigid_body.certificate.sensor_topics import SegmentSensor, value_laws
from lie_rigid_body.certificate.stamps import StampFault, stamp_result
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.certificate.told_faults import FAULT_LAW, FaultLaw
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages.batch import FAULTS_TOPIC, SENSOR_TOPICS, sensor_topics
from lie_rigid_body.recording.bag_reader import AnyBag
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.segments import PlacedMessages, SensorClocks
from lie_rigid_body.recording.topic_messages import OfSensor, TopicMessages
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import Segment


@short_dataclass
class SensorFindings:
    """Findings about the sensors of a bag.

    Parameters
    ----------
    laws : tuple of tuple of LawResult
        For each surveyed segment.
    notes : tuple of tuple of str
        For each surveyed segment, which sensors have no reading there, or none to its end, though no law is broken.
    whole : tuple of LawResult
        Of the bag as a whole, and of segments without a sample.
    topics : tuple of str
        Full names of the topics whose readings the laws speak of.
    not_certified : tuple of str
        What else there is, or should be, in words.
    log_time_mismatches : int
        Messages that were not logged, or not published, at their stamps.
    are_exact : bool
        Whether all readings were compared, and are equal to the replayed ones, to the bit.
    """

    laws: tuple[Laws, ...]
    notes: tuple[tuple[str, ...], ...]
    whole: Laws
    topics: tuple[str, ...]
    not_certified: tuple[str, ...]
    log_time_mismatches: int
    are_exact: bool


class SensorLaws:
    """The laws of all sensors of a bag, to which their messages are added in file order.

    Parameters
    ----------
    bag : Bag or Recording
    segments : sequence of Segment
        All that the bag declares, in the order of their starts.
    watch : Watch or None
        It is told of the residuals of all readings that are compared.
    max_attitude : float or None
        Limit of the attitude's error, rad, in place of that of the declared motion.
    """

    def __init__(
        self,
        bag: AnyBag,
        segments: Sequence[Segment],
        watch: Watch | None,
        max_attitude: float | None,
    ) -> None:
        self._bag = bag
        self._segments = segments
        self._own = bag.is_original
        self._watch = watch
        self._max_attitude = max_attitude
        self._declared = {name for segment in segments for name in sensor_topics(segment.scenario.sensors)}
        clocks = {
            topic.name: SensorClocks(segments, name)
            for name, sensor in SENSORS.items()
            for topic in sensor.topics
            if topic.name in self._declared and topic.name in bag.sensors
        }
        self._unclear = {} if self._own else {name for name, own in clocks.items() if own.differ}
        self._clocks = {name: own for name, own in clocks.items() if name not in self._unclear}
        self._held = {name for name in self._declared if self._own or name in bag.sensors} - {*self._unclear}
        self._faults = FaultLaw(segments, is_whole=self._own) if FAULTS_TOPIC in self._held else None
        self._sensors: dict[tuple[int, str], SegmentSensor] = {}  # by the segment's place
        self._live = defaultdict[str, list[SegmentSensor]](list)  # the latest of each sensor, which may get more
        self._strays = Counter[tuple[int, str]]()
        self._logged_otherwise = self._last_sent_ns = 0

    def _full_name(self, name: str) -> str:
        return self._bag.sensors[name].topic if name in self._bag.sensors else name

    @property
    def wanted(self) -> list[str]:
        """The topics of the bag that are to be added, by their relative names."""
        return [*self._clocks, *({FAULTS_TOPIC} & self._held & self._bag.sensors.keys())]

    def add(self, readings: Mapping[str, OfSensor]) -> None:
        """Check the next messages, by relative topic names."""
        faults = readings.get(FAULTS_TOPIC)
        if isinstance(faults, list) and self._faults is not None:
            self._faults.add(faults)
        for name, sensor in SENSORS.items():
            placed: dict[int, dict[str, PlacedMessages]] = defaultdict(dict)
            for topic in sensor.topics:
                messages = readings.get(topic.name)
                if isinstance(messages, TopicMessages) and len(messages):
                    for part in self._clocks[topic.name].placed(messages, in_order=self._own):
                        sent_ns = part.messages.log_times_ns if self._own else part.times_ns
                        self._last_sent_ns = max(self._last_sent_ns, int(sent_ns.max()))
                        placed[part.place][topic.name] = part
            for place in sorted(placed):
                if name in self._segments[place].scenario.sensors.on:
                    self._logged_otherwise += self._sensor(place, name).add(placed[place])
                else:
                    self._strays.update({(place, topic): len(part.numbers) for topic, part in placed[place].items()})

    def _sensor(self, place: int, name: str) -> SegmentSensor:
        if (place, name) not in self._sensors:
            self._sensors[place, name] = SegmentSensor(
                self._segments[place],
                self._successors(place),
                name,
                {topic.name: self._full_name(topic.name) for topic in SENSORS[name].topics if topic.name in self._held},
                self._max_attitude,
                self._watch,
            )
            live = self._live[name]
            live.append(self._sensors[place, name])
            while len(live) > 2:
                live.pop(0).forget()
        return self._sensors[place, name]

    def _successors(self, i: int) -> list[Segment]:
        """The segments that begin where one ends: several, if it was reset more than once before the next sample."""
        declared = self._segments
        end = next((later.start_ns for later in declared[i + 1 :] if later.start_ns > declared[i].start_ns), None)
        return [segment for segment in declared[i + 1 :] if segment.start_ns == end]

    def findings(self, surveyed: Survey) -> SensorFindings:
        """Findings about the sensors, after all messages and the survey of the same bag."""
        last = surveyed.segments[-1]
        self._truth_ns = last.last_ns or last.segment.start_ns
        self._sample_ns = round(NS / last.segment.scenario.rate)
        sampled = [found.place for found in surveyed.segments]
        notes: dict[int, list[str]] = defaultdict(list)
        found = self._of_segments(sampled, notes)
        *laws, whole = *(found.pop(place) for place in sampled), self._of_bag()
        whole += tuple(law for rest in found.values() for law in rest)
        not_certified = [*self._not_certified()]
        computed = value_laws() | {FAULT_LAW}
        broken = any(law.name in computed and not law.holds for own in (*laws, whole) for law in own)
        foreign = other_software(self._bag) if broken else None
        if foreign is not None:
            *laws, whole = (tuple(law for law in own if law.name not in computed) for own in (*laws, whole))
            not_certified.append(
                f"readings of sensors: the scenario is of {foreign!r:.40}, this is {LIBRARY}, which computes others"
            )
        topics = [topic for sensor in self._sensors.values() for topic in sensor.topics.values()]
        return SensorFindings(
            tuple(laws),
            tuple(tuple(notes[place]) for place in sampled),
            whole,
            tuple(self._full_name(name) for name in self._clocks if foreign is None),
            tuple(not_certified),
            self._logged_otherwise + sum(self._bag.sensors[name].publish_time_mismatches for name in self.wanted),
            all(topic.is_exact for topic in topics),
        )

    def _of_segments(self, sampled: list[int], notes: dict[int, list[str]]) -> dict[int, Laws]:
        """The laws of each segment by its place, and notes about them; those of some places have samples."""
        begun = set[str]()
        found = {}
        ends = {
            relative: place
            for (place, _), sensor in sorted(self._sensors.items())
            for relative, topic in sensor.topics.items()
            if topic.tally.count
        }
        for place in sorted({*sampled, *(place for place, _ in (*self._sensors, *self._strays))}):
            laws = list[LawResult]()
            on = self._segments[place].scenario.sensors.on
            for name, sensor in SENSORS.items():
                if name not in on:
                    begun -= {topic.name for topic in sensor.topics}
                    laws += self._strays_of(place, name)
                else:
                    laws += self._sensor_laws(place, name, ends, begun, notes[place], is_last=place >= sampled[-1])
            found[place] = tuple(laws)
        return found

    def _strays_of(self, place: int, name: str) -> Iterator[LawResult]:
        for topic in SENSORS[name].topics:
            if count := self._strays[place, topic.name]:
                what = f"{self._full_name(topic.name)}: readings of a sensor that the scenario has not"
                yield LawResult.of_faults(f"{SENSORS[name].title} stamps", count, f"{what}: {count}", count)

    def _sensor_laws(
        self, place: int, name: str, ends: Mapping[str, int], begun: set[str], notes: list[str], *, is_last: bool
    ) -> Iterator[LawResult]:
        sensor = self._sensor(place, name)
        if not sensor.topics:
            return
        own = self._own
        faults = list[StampFault]()
        checked = 0
        for relative, topic in sensor.topics.items():
            tally = topic.tally
            has_ended = not own and place >= ends.get(relative, 0)
            whole = own or relative in begun
            end = sensor.last_due(tally.high, self._end_ns, is_last=is_last, is_whole=own)
            last = tally.high if has_ended else end
            first = sensor.first if whole or not tally.count else tally.low
            is_due = tally.count or (whole and not has_ended)
            wrong = [*topic.faults(first, last, sensor.lost)] if is_due else []
            faults += wrong
            checked += tally.count
            if tally.count:
                begun.add(relative)
                if len(tally.missing(last + 1, end, sensor.lost)[0]):
                    notes.append(f"readings on {topic.topic} end with {last}: {self._why_silent(0)}")
                elif more := sensor.unsent(last):
                    why = f"a reset takes the sensor away, before which up to {more} more may have been sent"
                    notes.append(f"readings on {topic.topic} end with {last}: {why}")
            elif not wrong:
                lost = own * max(0, end + 1 - sensor.first)
                notes.append(f"no reading on {topic.topic}: {self._why_silent(lost)}")
        if checked or faults:
            yield stamp_result(f"{SENSORS[name].title} stamps", sensor.clock, faults, checked)
        for topic in sensor.topics.values():
            if topic.tally.count:
                yield from sensor.results(topic)

    def _why_silent(self, lost: int) -> str:
        if not self._own:
            return "what a recorder lacks before its first one, or after its last, is not certified"
        return f"the scenario loses all {lost} of this segment" if lost else "none arrives within this segment"

    @property
    def _end_ns(self) -> int:
        """Time until which a whole bag has everything, ns; one that was cut off may lack part of its last time."""
        return max(self._last_sent_ns, self._truth_ns) - self._bag.lacks_end

    def _of_bag(self) -> Laws:
        """The laws of what belongs to no segment, and of the messages about faults."""
        laws = list[LawResult]()
        for name, clocks in self._clocks.items():
            if self._own and clocks.early:
                what = f"{self._full_name(name)}: readings before the first scenario's start: {clocks.early}"
                laws.append(LawResult.of_faults("sensor stamps", clocks.early, what, clocks.early))
        if self._faults is not None:
            self._logged_otherwise += self._faults.log_time_mismatches
            if not self._faults.is_too_long(self._horizon_ns):
                laws.append(self._faults.result(self._full_name(FAULTS_TOPIC), self._end_ns, self._horizon_ns))
        return tuple(laws)

    @property
    def _horizon_ns(self) -> int:
        """Latest time of an honest message about a fault, ns: two samples and 1 s after anything else."""
        return self._end_ns + 2 * self._sample_ns + NS

    def _not_certified(self) -> Iterator[str]:
        """Topics that the bag or the scenarios lack, and messages that belong to no segment, in words."""
        for name in SENSOR_TOPICS:
            sensor = self._bag.sensors.get(name)
            if sensor is not None and name not in self._declared:
                yield f"topic {sensor.topic} ({sensor.count} messages), a sensor that no scenario has"
            if name in self._declared and name not in self._held and sensor is None:
                yield f"{name}, which the scenario has: not in the bag"
            if sensor is not None and name in self._unclear:
                yield f"{sensor.topic}: a reset changes the sensor's clock, and stamps do not tell which one shows them"
        early = sum(clocks.early for clocks in self._clocks.values())
        faults = self._faults
        if early and not self._own:
            yield f"readings before the first scenario's start: {early}"
        if faults is not None and faults.is_too_long(self._horizon_ns):
            yield f"{self._full_name(FAULTS_TOPIC)}: too many readings to compute the faults of all"
        elif faults is not None and not self._own:
            if faults.early:
                yield f"faults before the first scenario's start: {faults.early}"
            if faults.repeated:
                yield f"messages about faults that come again: {faults.repeated}"


def other_software(bag: AnyBag) -> str | None:
    """First software other than this one that a scenario of a bag names."""
    found = (json.loads(text).get("software") for _, text in bag.scenario_texts)
    return next((str(software) for software in found if software != LIBRARY), None)
