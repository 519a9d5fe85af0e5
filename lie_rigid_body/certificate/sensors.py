"""The sensors of a bag: their readings are replayed, paired with its messages, and compared.

What makes that less simple, and where it is dealt with:

- The same stamp may be shown twice, as clocks err and resets change them: messages are paired by `SensorClocks`.
- A recorder came late, or lost readings: `Replay.piece` begins anywhere, and a gap is no reason to replay all of it.
- It may have lost the truth, but not the sensors: `Replay` has limits of the readings' own time, and `SensorLaws` holds
  segments without a sample as well.
- Converters make steps: `Expected.residuals` compares behind the converter what may differ before it.
- A reset that takes a sensor away leaves out what was under way: `SegmentSensor.last_due`.
- Forged stamps lie years ahead, and scenarios declare what nobody recorded: `SegmentSensor.lost`, `Replays.allow` and
  the horizon of `SensorLaws` bound the work, and only topics that the bag has are replayed.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping

from lie_rigid_body.certificate.law_result import LawResult, Watch
from lie_rigid_body.certificate.readings import Replays
from lie_rigid_body.certificate.sensor_topics import MOST_LOST, SegmentSensor, value_laws
from lie_rigid_body.certificate.stamps import StampFault, stamp_result
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.certificate.told_faults import FAULT_LAW, MOST_LOOKED_THROUGH, FaultLaw
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages.batch import FAULTS_TOPIC, SENSOR_TOPICS, sensor_topics
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.bag_writer import LIBRARY
from lie_rigid_body.recording.segments import PlacedMessages, SensorClocks
from lie_rigid_body.recording.topic_messages import OfSensor, TopicMessages
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import Segment


@short_dataclass(frozen=True)
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
    logged_otherwise : int
        Messages that were not logged, or not published, at their stamps.
    are_exact : bool
        Whether all readings were compared, and are equal to the replayed ones, to the bit.
    """

    laws: tuple[tuple[LawResult, ...], ...]
    notes: tuple[tuple[str, ...], ...]
    whole: tuple[LawResult, ...]
    topics: tuple[str, ...]
    not_certified: tuple[str, ...]
    logged_otherwise: int
    are_exact: bool


class SensorLaws:
    """The laws of all sensors of a bag, to which their messages are added in file order.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
        Of the same bag.
    watch : Watch, optional
        It is told of the residuals of all readings that are compared.
    max_attitude : float, optional
        Limit of the attitude's error, rad, in place of that of the declared motion.
    """

    def __init__(
        self,
        bag: Bag | Recording,
        surveyed: Survey,
        watch: Watch | None = None,
        max_attitude: float | None = None,
    ) -> None:
        self._bag, self._surveyed, self._watch = bag, surveyed, watch
        self._replays = Replays(max_attitude)
        self._declared = {name for segment in surveyed.declared for name in sensor_topics(segment.scenario.sensors)}
        self._held = {name for name in self._declared if surveyed.as_written or name in bag.sensors}
        self._clocks = {
            topic.name: SensorClocks(surveyed.declared, name)
            for name, sensor in SENSORS.items()
            for topic in sensor.topics
            if topic.name in self._held and topic.name in bag.sensors
        }
        most, own = MOST_LOOKED_THROUGH + 2 * sum(topic.count for topic in bag.sensors.values()), surveyed.as_written
        is_due = FAULTS_TOPIC in self._held
        self._faults = FaultLaw(surveyed.declared, self._horizon_ns, is_whole=own, most=most) if is_due else None
        self._last_ns = {id(found.segment): found.last_ns for found in surveyed.segments}
        self._sensors: dict[tuple[int, str], SegmentSensor] = {}  # by the segment's place among those declared
        self._strays = Counter[tuple[int, str]]()
        self._logged_otherwise = self._last_sent_ns = 0

    def _full_name(self, name: str) -> str:
        return self._bag.sensors[name].topic if name in self._bag.sensors else name

    @property
    def wanted(self) -> list[str]:
        """The topics of the bag that are to be added, by their relative names."""
        return [*self._clocks, *({FAULTS_TOPIC} & self._held & self._bag.sensors.keys())]

    @property
    def _horizon_ns(self) -> int:
        """Latest time of an honest message, ns: 1 s and two samples after the last one of the truth.

        A recorder may have lost the truth before the sensors: then `MOST_LOST` times as long as their readings last.
        """
        last = self._surveyed.segments[-1]
        start_ns, scenario = last.segment.start_ns, last.segment.scenario
        truth_ns = (last.last_ns or start_ns) + round(2 * NS / scenario.rate) + NS
        longest = max(
            (
                self._bag.sensors[topic.name].count / model.rate
                for name, model in scenario.sensors.on.items()
                for topic in SENSORS[name].topics
                if topic.name in self._clocks
            ),
            default=0.0,
        )
        return truth_ns if self._surveyed.as_written else max(truth_ns, start_ns + round(MOST_LOST * longest * NS))

    def add(self, readings: Mapping[str, OfSensor]) -> None:
        """Check the next messages, by relative topic names."""
        own, faults = self._surveyed.as_written, readings.get(FAULTS_TOPIC)
        if isinstance(faults, list) and self._faults is not None:
            self._faults.add(faults)
        for name, sensor in SENSORS.items():
            placed: dict[int, dict[str, PlacedMessages]] = defaultdict(dict)
            for topic in sensor.topics:
                messages = readings.get(topic.name)
                if isinstance(messages, TopicMessages) and len(messages):
                    for part in self._clocks[topic.name].placed(messages, in_order=own):
                        sent_ns = part.messages.log_times_ns if own else part.times_ns
                        self._last_sent_ns = max(self._last_sent_ns, int(sent_ns.max()))
                        placed[part.place][topic.name] = part
            for place in sorted(placed):
                if name in self._surveyed.declared[place].scenario.sensors.on:
                    self._logged_otherwise += self._sensor(place, name).add(placed[place])
                else:
                    self._strays.update({(place, topic): len(part.numbers) for topic, part in placed[place].items()})

    def _sensor(self, place: int, name: str) -> SegmentSensor:
        if (place, name) not in self._sensors:
            segment = self._surveyed.declared[place]
            self._sensors[place, name] = SegmentSensor(
                segment,
                self._last_ns.get(id(segment)) or segment.start_ns,
                self._successors(place),
                name,
                {topic.name: self._full_name(topic.name) for topic in SENSORS[name].topics if topic.name in self._held},
                self._replays,
                self._watch,
            )
        return self._sensors[place, name]

    def _successors(self, i: int) -> list[Segment]:
        """The segments that begin where one ends: several, if it was reset more than once before the next sample."""
        declared = self._surveyed.declared
        end = next((later.start_ns for later in declared[i + 1 :] if later.start_ns > declared[i].start_ns), None)
        return [segment for segment in declared[i + 1 :] if segment.start_ns == end]

    def findings(self) -> SensorFindings:
        """Findings about the sensors, after all messages."""
        sampled = [place for place, segment in enumerate(self._surveyed.declared) if id(segment) in self._last_ns]
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
        far = {t.topic for sensor in self._sensors.values() if sensor.is_too_far for t in sensor.topics.values()}
        not_certified += [f"{topic}: too many readings are missing to compute the others" for topic in sorted(far)]
        certified = [self._full_name(name) for name in self._clocks if foreign is None]
        return SensorFindings(
            tuple(laws),
            tuple(tuple(notes[place]) for place in sampled),
            whole,
            tuple(topic for topic in certified if topic not in far),
            tuple(not_certified),
            self._logged_otherwise + sum(self._bag.sensors[name].published_otherwise for name in self.wanted),
            not far and all(topic.is_exact for topic in topics),
        )

    def _of_segments(self, sampled: list[int], notes: dict[int, list[str]]) -> dict[int, tuple[LawResult, ...]]:
        """The laws of each segment by its place, and notes about them; those of some places have samples."""
        begun, found = set[str](), {}
        ends = {
            relative: place
            for (place, _), sensor in sorted(self._sensors.items())
            for relative, topic in sensor.topics.items()
            if topic.tally.count
        }
        for place in sorted({*sampled, *(place for place, _ in (*self._sensors, *self._strays))}):
            laws, on = list[LawResult](), self._surveyed.declared[place].scenario.sensors.on
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
        own, faults, checked = self._surveyed.as_written, list[StampFault](), 0
        for relative, topic in sensor.topics.items():
            tally, has_ended = topic.tally, not own and place >= ends.get(relative, 0)
            whole = own or relative in begun
            end = sensor.last_due(tally.high, self._end_ns, is_last=is_last, is_whole=own)
            last, lost = tally.high if has_ended else end, sensor.lost(tally, end)
            if sensor.is_too_far:
                last = min(last, lost.end - 1)
            first = sensor.first if whole or not tally.count else tally.low
            is_due = tally.count or (whole and not has_ended)
            wrong = [*tally.faults(topic.topic, first, last, lost)] if is_due else []
            faults += wrong
            checked += tally.count
            if tally.count:
                begun.add(relative)
                if end - last > lost.count(last + 1, end):
                    notes.append(f"readings on {topic.topic} end with {last}: {self._why_silent(0)}")
                elif more := sensor.unsent(last):
                    why = f"a reset takes the sensor away, before which up to {more} more may have been sent"
                    notes.append(f"readings on {topic.topic} end with {last}: {why}")
            elif not wrong:
                notes.append(f"no reading on {topic.topic}: {self._why_silent(own and lost.count(sensor.first, end))}")
        if checked or faults:
            yield stamp_result(f"{SENSORS[name].title} stamps", sensor.clock, faults, checked)
        for topic in sensor.topics.values():
            if topic.tally.count:
                yield from sensor.results(topic)

    def _why_silent(self, lost: int) -> str:
        if not self._surveyed.as_written:
            return "what a recorder lacks before its first one, or after its last, is not certified"
        return f"the scenario loses all {lost} of this segment" if lost else "none arrives within this segment"

    @property
    def _end_ns(self) -> int:
        """Time until which a whole bag has everything, ns; one that was cut off may lack part of its last time."""
        cut_off = self._bag.was_cut_off and self._bag.expected_samples is None
        return max(self._last_sent_ns, self._surveyed.segments[-1].last_ns or 0) - cut_off

    def _of_bag(self) -> tuple[LawResult, ...]:
        """The laws of what belongs to no segment, and of the messages about faults."""
        laws, own = list[LawResult](), self._surveyed.as_written
        for name, clocks in self._clocks.items():
            unshown, first = clocks.unshown
            odd = {
                "before the first scenario's start": own * clocks.early,
                f"whose stamp no clock of the scenario shows (first {first} ns)": unshown,
            }
            laws += (
                LawResult.of_faults(
                    "sensor stamps", count, f"{self._full_name(name)}: readings {which}: {count}", count
                )
                for which, count in odd.items()
                if count
            )
        if self._faults is not None:
            law = self._faults.result(self._full_name(FAULTS_TOPIC), self._end_ns)
            self._logged_otherwise += self._faults.logged_otherwise
            laws += [] if self._faults.expected.is_too_far else [law]
        return tuple(laws)

    def _not_certified(self) -> Iterator[str]:
        """Topics that the bag or the scenarios lack, and messages that belong to no segment, in words."""
        for name in SENSOR_TOPICS:
            sensor = self._bag.sensors.get(name)
            if sensor is not None and name not in self._declared:
                yield f"topic {sensor.topic} ({sensor.count} messages), a sensor that no scenario has"
            if name in self._declared and name not in self._held and sensor is None:
                yield f"{name}, which the scenario has: not in the bag"
        early, faults = sum(clocks.early for clocks in self._clocks.values()), self._faults
        if early and not self._surveyed.as_written:
            yield f"readings before the first scenario's start: {early}"
        if faults is not None and faults.expected.is_too_far:
            yield f"{self._full_name(FAULTS_TOPIC)}: too many readings to compute the faults of all"
        elif faults is not None and not self._surveyed.as_written:
            if faults.early:
                yield f"faults before the first scenario's start: {faults.early}"
            if faults.repeated:
                yield f"messages about faults that come again: {faults.repeated}"


def other_software(bag: Bag | Recording) -> str | None:
    """First software other than this one that a scenario of a bag names."""
    found = (json.loads(text).get("software") for _, text in bag.scenario_texts)
    return next((str(software) for software in found if software != LIBRARY), None)
