"""Reading a bag into arrays: one of this package, or one that ``ros2 bag record`` made of the running node."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Final, TypeAlias

from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.messages.batch import FAULTS_TOPIC, POSE, TF_TOPIC, TWIST
from lie_rigid_body.messages.definitions import TF_MESSAGE, TWIST_STAMPED
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.mcap_contents import (
    McapContents,
    Progress,
    RawMessages,
    RawTopic,
    TopicKey,
    TopicNames,
    nothing,
    of_types,
    unheard,
)
from lie_rigid_body.recording.records import CUT_OFF, METADATA, REWRITTEN
from lie_rigid_body.recording.segments import UNNAMED
from lie_rigid_body.recording.topic_discovery import BODY_TOPICS, Body, bodies, texts_on, the_body
from lie_rigid_body.recording.topic_messages import (
    TRUE_TYPES,
    AttitudeTrack,
    LoggedText,
    OfSensor,
    TakeReadings,
    TopicMessages,
    attitudes_in,
    decoding,
    require_cdr,
    topic_messages,
)
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SOFTWARE, Segment

_TEXTS_AT_ONCE: Final = 1000
"""Number of messages about faults that are taken together."""
_BATCH: Final = 65_536
"""Smallest number of messages of poses, twists and sensors in a batch, but for the last one."""
_RECORDER: Final = "libmcap "
"""Beginning of the library name in a file by `ros2 bag record`."""
NO_TOPICS: Final[TopicNames] = MappingProxyType({})
"""Names for a bag whose topics have their usual ones."""


@short_dataclass(kw_only=True, frozen=False)
class BagFacts:
    """Facts of a bag beside its poses, twists and readings.

    Parameters
    ----------
    pose_topic, twist_topic : str
    stamped : bool
        Whether twists have stamps of their own.
    library : str
        The software that wrote the file.
    scenario_texts : list of (int, str)
        Log time, ns, and JSON of every scenario message, in file order.
    expected_samples : int or None
        Number of samples that the writer says it wrote, where it does.
    publish_time_mismatches : int
        Messages of the three topics whose time of publishing is not their log time.
    others : tuple of str
        What the bag holds besides, in words: topics and attachments.
    was_cut_off : bool
        Whether `recover` says that it made the bag of a file that was cut off.
    sensors : dict of str to RawTopic
        Topics of the body's sensors, with their messages counted, by their relative names.
    name : str
        Name in errors: its path, if it has one.
    """

    pose_topic: str
    twist_topic: str
    stamped: bool
    library: str
    scenario_texts: list[LoggedText]
    expected_samples: int | None = None
    publish_time_mismatches: int = 0
    others: tuple[str, ...] = ()
    was_cut_off: bool = False
    sensors: Mapping[str, RawTopic] = field(default_factory=dict)
    name: str = UNNAMED

    @property
    def lacks_end(self) -> bool:
        """Whether its last samples may be missing in part; a cut behind the count of samples was behind them all."""
        return self.was_cut_off and self.expected_samples is None

    @property
    def is_original(self) -> bool:
        """Whether it is to be whole from its run's first sample on, and logged at its stamps, as by `BagWriter`.

        It is if it says so, by its library or by the record at its end, or if its first scenario is logged at its
        start. What `ros2 bag record` made of a running node begins in the midst, and is logged when it was received;
        what `Run.to_bag` made of such a bag begins there as well.
        """
        if REWRITTEN in self.library:
            return False
        if self.library.startswith(f"{SOFTWARE} ") or self.expected_samples is not None:
            return True
        log_time, text = self.scenario_texts[0]
        return log_time == Segment.from_json(text).start_ns and not self.library.startswith(_RECORDER)


@dataclass(kw_only=True, repr=False)
class Recording(BagFacts):
    """Messages of a run that a bag holds, in memory. See `BagFacts` for the other parameters.

    Parameters
    ----------
    poses, twists : TopicMessages
    readings : dict of str to OfSensor
        Messages of the sensors, and about their faults, by their relative names.
    """

    poses: TopicMessages
    twists: TopicMessages
    readings: Mapping[str, OfSensor] = field(default_factory=dict)

    @property
    def pose_count(self) -> int:
        """Number of poses."""
        return len(self.poses)

    @property
    def twist_count(self) -> int:
        """Number of twists."""
        return len(self.twists)

    def batches(
        self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None
    ) -> Iterator[tuple[TopicMessages, TopicMessages]]:
        """All poses and twists, as `Bag.batches` reads them."""
        take({name: self.readings[name] for name in sensors})
        yield self.poses, self.twists


class Bag(BagFacts):
    """A bag that is read in batches, as often as they are wanted: its memory does not grow with its length.

    See `BagFacts` for more attributes; the name is that of one of several bodies, too.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them, of one body; `all_of` reads several. It is read once to its end, and
        what is damaged refused.
    progress : callable, optional
        Called with the number of bytes that were read since it was called last, in every pass.
    topics : mapping of str to str, optional
        Topics that are called otherwise, by their relative names. See `bodies`.
    in_memory : bool, optional
        Whether poses, twists and readings are kept when it is read first, so that no later pass reads it again.

    Attributes
    ----------
    pose_count, twist_count : int
        Messages of each.

    Raises
    ------
    BagError
        If it is no bag, cut off, damaged, or lacks one of the three topics; in one line, with the remedy.
    """

    def __init__(
        self,
        path: str | Path,
        progress: Progress = unheard,
        topics: TopicNames = NO_TOPICS,
        *,
        in_memory: bool = False,
    ) -> None:
        files = BagFiles(path, progress)
        contents = files.contents(of_types({*TRUE_TYPES, *SENSORS.topics.values()}) if in_memory else nothing)
        self._take(files, contents, the_body(files.path, contents, topics))

    @classmethod
    def all_of(
        cls, path: str | Path, progress: Progress = unheard, topics: TopicNames = NO_TOPICS
    ) -> dict[str, Bag | BagError]:
        """A bag for each body of a file or folder, which is read once to find them, by their names.

        What is wrong with one of several stands in its place.
        """
        files = BagFiles(path, progress)
        contents = files.contents(nothing)
        found = bodies(files.path, contents, topics)
        besides = _others(contents, found)
        bags: dict[str, Bag | BagError] = {}
        for body in found:
            bag = cls.__new__(cls)
            name = body.name or "/"
            try:
                bag._take(files, contents, body)
            except BagError as error:
                if len(found) == 1:
                    raise
                bags[name] = error
            else:
                bag.others = besides
                bag.name += f" {name}" * (len(found) > 1)
                bags[name] = bag
        return bags

    def _take(self, files: BagFiles, contents: McapContents, body: Body) -> None:
        if body.fault is not None:
            raise body.fault
        self._path = files.path
        self._contents = contents
        self._progress = files.progress
        for track in body.tracks.values():
            require_cdr(self._path, track)
        pose, twist, scenario = (body.tracks[name] for name in BODY_TOPICS)
        self._tracks = body.tracks
        self.pose_count = pose.count
        self.twist_count = twist.count
        samples = contents.metadata.get(METADATA, {}).get("samples", "")
        super().__init__(
            pose_topic=pose.topic,
            twist_topic=twist.topic,
            stamped=twist.message_type == TWIST_STAMPED,
            library=contents.library,
            scenario_texts=read_scenarios(self._path, contents, scenario),
            expected_samples=int(samples) if samples.isdecimal() else None,
            publish_time_mismatches=sum(track.publish_time_mismatches for track in (pose, twist, scenario)),
            others=_others(contents, [body]),
            was_cut_off=CUT_OFF in contents.metadata,
            sensors={name: track for name, track in body.tracks.items() if name not in BODY_TOPICS},
            name=str(files.path),
        )

    def batches(
        self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None
    ) -> Iterator[tuple[TopicMessages, TopicMessages]]:
        """All poses and twists in file order, some ten thousand at a time.

        Parameters
        ----------
        sensors : collection of str, optional
            Those of ``self.sensors`` that are read as well.
        take : callable, optional
            Called with the messages about faults first, and then with the messages of the others that stand among the
            poses and twists of a batch, before it comes.
        """
        told = self._faults() if FAULTS_TOPIC in sensors else iter(())
        while some := list(itertools.islice(told, _TEXTS_AT_ONCE)):
            take({FAULTS_TOPIC: some})
        for readings in self._decoded([name for name in sensors if name != FAULTS_TOPIC]):
            poses = readings.pop(POSE)
            twists = readings.pop(TWIST)
            take(readings)
            yield poses, twists

    def _decoded(self, sensors: Iterable[str]) -> Iterator[dict[str, TopicMessages]]:
        """Messages of pose, twist and sensors by their relative names, as many at a time as a batch has."""
        keys = {name: self._tracks[name].key for name in (POSE, TWIST, *sensors)}
        before = Counter[str]()
        for raw in self._batched(keys):
            counts = {name: sum(map(len, parts)) for name, parts in raw.items()}
            # popped, as large chunks would else stand in memory as bytes and as numbers
            yield {name: topic_messages(self._path, key, raw.pop(name), before[name]) for name, key in keys.items()}
            before.update(counts)

    def _batched(self, keys: Mapping[str, TopicKey]) -> Iterator[dict[str, list[RawMessages]]]:
        """Messages by their relative names, in whole parts of the files, as many at a time as a batch has at least."""
        waiting = {name: list[RawMessages]() for name in keys}
        count = 0
        parts = self._contents.read({*keys.values()}, self._progress)
        while (found := next(parts, None)) is not None:
            for name, key in keys.items():
                if key in found:
                    waiting[name].append(found[key])
                    count += len(found[key])
            del found
            if count >= _BATCH:
                yield waiting
                waiting = {name: [] for name in keys}
                count = 0
        yield waiting

    def transforms(self) -> Iterator[AttitudeTrack]:
        """The transforms on /tf, a part of the files at a time, those of each pair of frames apart."""
        for track in filter(_is_of_transforms, self._contents.tracks.values()):
            for found in self._contents.read({track.key}, self._progress):
                if track.key in found:
                    with decoding(self._path, track.topic, found[track.key]):
                        parts = attitudes_in(track.topic, TF_MESSAGE, found[track.key])
                    yield from parts.values()

    def _faults(self) -> Iterator[LoggedText]:
        """Log time, ns, and text of each message about faults, as they are read."""
        return texts_on(self._path, self._contents, self._tracks[FAULTS_TOPIC])

    def load(self) -> Recording:
        """The whole bag in memory."""
        names = [name for name in self.sensors if name != FAULTS_TOPIC]
        parts = list(self._decoded(names))
        whole = {name: TopicMessages.joined([part[name] for part in parts]) for name in (POSE, TWIST, *names)}
        poses = whole.pop(POSE)
        twists = whole.pop(TWIST)
        readings = dict[str, OfSensor](whole)
        if FAULTS_TOPIC in self.sensors:
            readings[FAULTS_TOPIC] = [*self._faults()]
        facts = {each.name: getattr(self, each.name) for each in fields(BagFacts)}
        return Recording(**facts, poses=poses, twists=twists, readings=readings)


AnyBag: TypeAlias = Bag | Recording
"""A bag that is read from its file, or a recording in memory."""


def read_bag(path: str | Path) -> Recording:
    """Read a bag into memory.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them.

    Returns
    -------
    Recording

    Raises
    ------
    BagError
        If it is no bag, cut off, damaged, or lacks one of the three topics; in one line, with the remedy.
    """
    return Bag(path, in_memory=True).load()


def read_scenarios(path: Path, contents: McapContents, track: RawTopic) -> list[LoggedText]:
    """Log time, ns, and text of each message of a scenario topic, up to the first that is no scenario.

    A topic of other texts may be without end.
    """
    kept = list[LoggedText]()
    distinct = dict[str, str]()
    for time, text in texts_on(path, contents, track):
        is_new = text not in distinct
        kept.append((time, distinct.setdefault(text, text)))
        if is_new and not _is_scenario(text):
            break
    return kept


def _is_scenario(text: str) -> bool:
    try:
        Segment.from_json(text)
    except InputError:
        return False
    return True


def _is_of_transforms(track: RawTopic) -> bool:
    return (track.topic, track.message_type) == (TF_TOPIC, TF_MESSAGE)


def _others(contents: McapContents, known: Sequence[Body]) -> tuple[str, ...]:
    """Contents of a bag besides some bodies, in words."""
    own = [track for body in known for track in body.tracks.values()]
    shared = {track.topic for track in own}
    besides = [
        track
        for track in contents.tracks.values()
        if not _is_of_transforms(track) and not any(track is each for each in own)
    ]
    topics = [
        f"topic {track.topic} ({f'as {track.message_type}, ' * (track.topic in shared)}{track.count} messages), "
        "which the scenarios of the body do not determine"
        for track in besides
    ]
    return (*topics, *([f"{contents.attachments} attachments"] if contents.attachments else []))
