"""Reading a bag into arrays: one of this package, or one that ``ros2 bag record`` made of the running node."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from lie_rigid_body import messages
from lie_rigid_body.arrays import Booleans
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.messages.definitions import POSE_STAMPED, STRING, TWIST, TWIST_STAMPED, has_fields_of
from lie_rigid_body.recording.bag_files import BagFiles, unheard
from lie_rigid_body.recording.bag_writer import CUT_OFF, METADATA
from lie_rigid_body.recording.bodies import Body, bodies, other_bodies, tells_of_body, the_body
from lie_rigid_body.recording.mcap_contents import (
    Found,
    McapContents,
    Progress,
    RawMessages,
    RawTrack,
    TrackKey,
    nothing,
    of_types,
)
from lie_rigid_body.recording.segments import MOST_SEGMENTS
from lie_rigid_body.recording.sensor_reader import (
    FaultMessages,
    SensorMessages,
    varying_fields,
)
from lie_rigid_body.recording.track_decoding import TopicMessages, require_cdr, texts, topic_messages
from lie_rigid_body.recording.tracks import BagFacts, OfSensor, PoseTrack, Recording, TakeReadings, TwistTrack, joined
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import Segment

__all__ = ["NO_TOPICS", "Bag", "Recording", "read_bag"]

_TEXTS_AT_ONCE: Final = 1000
"""Number of messages about faults that are taken together."""
_BATCH: Final = 65_536
"""Smallest number of messages of poses, twists and sensors in a batch, but for the last one."""
NO_TOPICS: Final[Mapping[str, str]] = MappingProxyType({})
"""Names for a bag whose topics have their usual ones."""
_OF_THE_TRUTH: Final = (POSE_STAMPED, TWIST_STAMPED, TWIST)


class Bag(BagFacts):
    """A bag that is read in batches, as often as they are wanted: its memory does not grow with its length.

    See `BagFacts` for more attributes; the name is that of one of several bodies, too.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them. It is read once to its end, and what is damaged refused.
    progress : callable, optional
        Called with the number of bytes that were read since it was called last, in every pass, perhaps by another
        thread.
    topics : mapping of str to str, optional
        Topics that are called otherwise, by their relative names. See `bodies`.
    in_memory : bool, optional
        Whether poses, twists and readings are kept when it is read first, so that no later pass reads it again.

    Attributes
    ----------
    body : str
        Namespace of its body, which has to be the only one; `all_of` reads the others.
    pose_topic, twist_topic : str
    pose_count, twist_count : int
        Messages of each.
    stamped : bool
        Whether twists have stamps of their own.

    Raises
    ------
    BagError
        If it is no bag, cut off, damaged, or lacks one of the three topics; in one line, with the remedy.
    """

    def __init__(
        self,
        path: str | Path,
        progress: Progress = unheard,
        topics: Mapping[str, str] = NO_TOPICS,
        *,
        in_memory: bool = False,
    ) -> None:
        files = BagFiles(path, progress)
        contents = files.contents(of_types({*_OF_THE_TRUTH, *SENSORS.topics.values()}) if in_memory else nothing)
        body = the_body(files.path, contents, topics, partial(_is_ours, files.path, contents))
        self._take(files, contents, body, in_memory=in_memory)

    @classmethod
    def all_of(
        cls, path: str | Path, progress: Progress = unheard, topics: Mapping[str, str] = NO_TOPICS
    ) -> dict[str, Bag | BagError]:
        """A bag for each body of a file or folder, which is read once to find them, by their names.

        What is wrong with one of several stands in its place.
        """
        files = BagFiles(path, progress)
        contents = files.contents(nothing)
        is_ours = partial(_is_ours, files.path, contents)
        found = bodies(files.path, contents, topics, is_ours)
        others = other_bodies(files.path, contents, found, is_ours) if topics else []
        known = [track for body in (*found, *others) for track in body.all_tracks]
        bags: dict[str, Bag | BagError] = {}
        for body in found:
            bag, name = cls.__new__(cls), body.name or "/"
            try:
                bag._take(files, contents, body)
            except BagError as error:
                if len(found) == 1:
                    raise
                bags[name] = error
                continue
            bag.others = (*(_not_chosen(other) for other in others), *_others(contents, known))
            bag.name += f" {name}" * (len(found) > 1)
            bags[name] = bag
        return bags

    def _take(self, files: BagFiles, contents: McapContents, body: Body, *, in_memory: bool = False) -> None:
        if body.fault:
            raise BagError(body.fault)
        self._path, self._contents, self._progress, self.body = files.path, contents, files.progress, body.name
        for track in body.all_tracks:
            require_cdr(self._path, track)
        pose, twist, scenario = body.tracks
        self._pose, self._twist = pose.key, twist.key
        self.pose_topic, self.twist_topic, self.stamped = pose.topic, twist.topic, twist.message_type == TWIST_STAMPED
        self.pose_count, self.twist_count = pose.count, twist.count
        super().__init__(
            library=contents.library,
            scenario_texts=_scenarios(self._texts(scenario.key)),
            expected_samples=_expected_samples(self._path, contents),
            published_otherwise=sum(track.published_otherwise for track in body.tracks),
            others=_others(contents, body.all_tracks),
            undefined=tuple(track.topic for track in body.all_tracks if not _is_defined(self._path, track)),
            without_checksum=contents.without_checksum,
            was_cut_off=CUT_OFF in contents.metadata,
            sensors=body.sensors,
            name=str(files.path),
        )
        self._kept: list[Found] | None = None
        if in_memory:
            self._kept = [{track.key: track.take() for track in body.all_tracks if track.message_type != STRING}]

    def batches(
        self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None
    ) -> Iterator[tuple[PoseTrack, TwistTrack]]:
        """All poses and twists in file order, some ten thousand at a time.

        Parameters
        ----------
        sensors : collection of str, optional
            Those of ``self.sensors`` that are read as well.
        take : callable, optional
            Called with the messages about faults first, and then with the messages of the others that stand among the
            poses and twists of a batch, before it comes.
        """
        for name in self._of_faults:
            for told in self._faults(name) if name in sensors else ():
                take({name: told})
        keys = {name: self.sensors[name].key for name in sensors if name not in self._of_faults}
        before = Counter[TrackKey]()
        for found in self._some([self._pose, self._twist, *keys.values()]):
            poses, twists, *readings = (
                topic_messages(self._path, key[0], found[key], *self._layout(key), before[key]) for key in found
            )
            before.update({key: len(messages) for key, messages in found.items()})
            take(dict(zip(keys, readings, strict=True)))
            yield self._pose_track(poses), self._twist_track(twists)

    def _some(self, keys: Sequence[TrackKey]) -> Iterator[Found]:
        """Messages of some tracks, as many as a batch has, in the order of the keys."""
        waiting: dict[TrackKey, list[RawMessages]] = {key: [] for key in keys}
        parts = self._contents.read(keys, self._progress) if self._kept is None else iter(self._kept)
        count, end = 0, Found()
        for found in itertools.chain(parts, [end]):
            for key in found.keys() & waiting.keys():
                waiting[key].append(found[key])
                count += len(found[key])
            if found is end or count >= _BATCH:
                yield {key: RawMessages.joined(pieces) for key, pieces in waiting.items()}
                waiting, count = {key: [] for key in keys}, 0

    @property
    def _of_faults(self) -> list[str]:
        """Relative names of the topics about faults."""
        return [name for name, topic in self.sensors.items() if topic.message_type == STRING]

    def _faults(self, name: str) -> Iterator[FaultMessages]:
        """Messages about faults, some at a time."""
        found = self._texts(self.sensors[name].key)
        while some := list(itertools.islice(found, _TEXTS_AT_ONCE)):
            yield FaultMessages.of(some)

    def _texts(self, key: TrackKey) -> Iterator[tuple[int, str]]:
        """Log time, ns, and text of each message of a topic of texts, as they are read."""
        return _texts(self._path, self._contents, key)

    def load(self) -> Recording:
        """The whole bag in memory."""
        names = [name for name in self.sensors if name not in self._of_faults]
        batches: list[Mapping[str, Any]] = []
        poses, twists = zip(*self.batches(names, batches.append), strict=True)
        readings: dict[str, OfSensor] = {
            name: SensorMessages.joined([some[name] for some in batches]) for name in names
        }
        told = {name: FaultMessages.of([*self._texts(self.sensors[name].key)]) for name in self._of_faults}
        facts: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(BagFacts)}
        return Recording(**facts, poses=joined(poses), twists=joined(twists), readings=readings | told)

    def _layout(self, key: TrackKey) -> tuple[Booleans, bool]:
        """Mask of the numbers of a topic's messages that are values, and whether the messages have stamps."""
        if key in (self._pose, self._twist):
            count = messages.POSE_NUMBERS if key == self._pose else messages.TWIST_NUMBERS
            return np.full(count, fill_value=True), key == self._pose or self.stamped
        return varying_fields(key[1]), True

    def _pose_track(self, found: TopicMessages) -> PoseTrack:
        times, numbers = (found.log_times_ns, found.stamps_ns), found.values
        return PoseTrack(self.pose_topic, *times, numbers[:, 3:7], numbers[:, :3], found.frame_ids)

    def _twist_track(self, found: TopicMessages) -> TwistTrack:
        stamps, frames = (found.stamps_ns, found.frame_ids) if self.stamped else (None, ())
        numbers = found.values
        return TwistTrack(self.twist_topic, found.log_times_ns, stamps, numbers[:, 3:6], numbers[:, :3], frames)


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


def _scenarios(found: Iterable[tuple[int, str]]) -> list[tuple[int, str]]:
    """The messages of a scenario topic, up to the first that is none: a topic of other texts may be without end."""
    kept, distinct = list[tuple[int, str]](), dict[str, str]()
    for time, text in found:
        is_new = text not in distinct
        kept.append((time, distinct.setdefault(text, text)))
        if is_new and (len(distinct) > MOST_SEGMENTS or not _is_scenario(text)):
            break
    return kept


def _is_scenario(text: str) -> bool:
    try:
        Segment.from_json(text)
    except InputError:
        return False
    return True


def _texts(path: Path, contents: McapContents, key: TrackKey) -> Iterator[tuple[int, str]]:
    """Log time, ns, and text of each message of a topic of texts, as they are read from the parts that have any."""
    return texts(path, key[0], (found[key] for found in contents.read([key], unheard)))


def _is_ours(path: Path, contents: McapContents, track: RawTrack) -> bool:
    return tells_of_body(_texts(path, contents, track.key))


def _not_chosen(body: Body) -> str:
    topic = next(track.topic for track in body.tracks if track.count)
    return f"body {body.name or '/'} ({topic} and what goes with it), which was not asked for"


def _others(contents: McapContents, own: Sequence[RawTrack]) -> tuple[str, ...]:
    rest = [track for track in contents.tracks.values() if track.count and not any(track is known for known in own)]
    shared = {track.topic for track in own}
    kinds = [f"as {track.message_type}, " if track.topic in shared else "" for track in rest]
    topics = [
        f"topic {track.topic} ({kind}{track.count} messages), which no scenario determines"
        for track, kind in zip(rest, kinds, strict=True)
    ]
    return (*topics, *([f"{contents.attachments} attachments"] if contents.attachments else []))


def _is_defined(path: Path, track: RawTrack) -> bool:
    """Whether the track's schema has a text that can be compared; if so it must have the fields of the type."""
    encoding, text = track.definition
    if encoding != "ros2msg" or not text:
        return False
    if not has_fields_of(text.decode(errors="replace"), track.message_type):
        raise BagError(
            f"{path}: topic {track.topic}: the definition of {track.message_type} is not that of ROS 2, by which "
            "others read it: restore a copy, or record again"
        )
    return True


def _expected_samples(path: Path, contents: McapContents) -> int | None:
    text = contents.metadata.get(METADATA, {}).get("samples")
    if text is not None and not re.fullmatch("[0-9]{1,18}", text):
        raise BagError(f"{path} is damaged: its metadata counts {text!r} samples: record it again")
    return None if text is None else int(text)
