"""The bodies of a bag: which topics are pose, twist and scenario of each, and what its sensors read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Final, TypeAlias

from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shortened, shown, suggestion
from lie_rigid_body.messages.batch import FAULTS_TOPIC, POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.messages.definitions import BARE_TWIST, POSE_STAMPED, STRING, TWIST_STAMPED
from lie_rigid_body.recording.bag_files import missing_beside, whole_of
from lie_rigid_body.recording.mcap_contents import McapContents, RawTrack, TrackKey
from lie_rigid_body.recording.topic_messages import texts

SCENARIO: Final = "scenario"
BODY_TOPICS: Final = (POSE, TWIST, SCENARIO)
"""Relative names of the topics that every body has."""
Tracks: TypeAlias = dict[str, RawTrack]
"""Topics of a body by their relative names."""
_LONGEST_LIST: Final = 60
"""Characters of the topics that there are, in an error line that has to say more."""


def topic_types() -> dict[str, tuple[str, ...]]:
    """The topics of a body by their relative names, and the message types that each may have."""
    truth = {POSE: (POSE_STAMPED,), TWIST: (TWIST_STAMPED, BARE_TWIST), SCENARIO: (STRING,)}
    return truth | {name: (kind,) for name, kind in SENSOR_TOPICS.items()}


@short_dataclass(frozen=True)
class Body:
    """The topics of one body.

    Parameters
    ----------
    name : str
        The namespace of its pose, such as ``/a``; empty for the root namespace.
    tracks : dict of str to RawTrack
        Its topics by their relative names: pose, twist and scenario, and what its sensors read, and their faults, as
        far as it is there.
    fault : str
        Why it cannot be read, in one line; a topic that is not in the bag is a track without a message.
    """

    name: str
    tracks: Tracks
    fault: str = ""


def bodies(path: Path, contents: McapContents, topics: Mapping[str, str]) -> list[Body]:
    """The bodies of a bag: one for each scenario topic with a pose and a twist in its namespace.

    Where there is none, the only topics of the right types are taken, or those with the right last name. One of several
    that cannot be read has a fault. Texts are looked at, whether they are scenarios, where two topics of them are in
    one namespace, or pose or twist is missing beside one.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    contents : McapContents
    topics : mapping of str to str
        Topics that are called otherwise, by their relative names (the keys of `topic_types`). With one of the first
        three there is one body, that to which it belongs.

    Raises
    ------
    BagError
        If a topic of the only body is not there, has no message, or cannot be told from others; with those that are
        there.
    """
    given = {name: given_track(path, contents, name, topic) for name, topic in topics.items()}
    own = [name for name in BODY_TOPICS if name in given]
    complete = _complete(path, contents, given)
    found = [body for body in complete if all(body[0][name] is given[name] for name in own)]
    if not found:  # the topics of the one body are not in one namespace
        near = next((given[name].topic.rpartition("/")[0] for name in given if name in (POSE, TWIST)), None)
        found = [({name: given.get(name) or _find(path, contents, name, near) for name in BODY_TOPICS}, "")]
    return [_body(path, contents, tracks, given, fault, alone=len(found) == 1) for tracks, fault in found]


def other_bodies(path: Path, contents: McapContents, own: Sequence[Body]) -> list[Body]:
    """The bodies of a bag besides those that a user chose."""
    try:
        found = bodies(path, contents, {})
    except BagError:  # what is beside the chosen one need not be whole
        return []
    poses = [body.tracks[POSE].topic for body in own]
    return [body for body in found if body.tracks[POSE].topic not in poses]


def the_body(path: Path, contents: McapContents, topics: Mapping[str, str]) -> Body:
    """The body of a bag that has one. See `bodies`."""
    found = bodies(path, contents, topics)
    if len(found) > 1:
        names = listed([body.name or "/" for body in found])
        first = min(found, key=lambda body: body.fault != "")
        raise BagError(f"{path} holds {len(found)} bodies, {names}: {_choice(POSE, first.tracks[POSE].topic)}")
    return found[0]


def texts_on(path: Path, contents: McapContents, track: RawTrack) -> Iterator[tuple[int, str]]:
    """Log time, ns, and text of each message of a topic of texts, as they are read from the parts that have any."""
    return texts(path, track.topic, (part[track.key] for part in contents.read([track.key]) if track.key in part))


def telling_of_bodies(path: Path, contents: McapContents, tracks: Iterable[RawTrack]) -> set[TrackKey]:
    """Topics of texts whose first message is a scenario, even a damaged one, and not that of another node.

    They are found in one pass: there may be ten thousands.
    """
    waiting, found = {track.key: track for track in tracks}, set[TrackKey]()
    for part in contents.read(waiting.keys()):  # which are fewer from part to part
        for key in part.keys() & waiting.keys():
            track = waiting.pop(key)
            try:
                tells = any('"inertia"' in text for _, text in islice(texts(path, track.topic, [part[key]]), 1))
            except BagError:
                tells = True
            found.update([key] if tells else [])
        if not waiting:
            break
    return found


def _complete(path: Path, contents: McapContents, given: Tracks) -> list[tuple[Tracks, str]]:
    """The tracks of each body that has its topics in one namespace, in the order of their names, and what is wrong.

    Beside them, those of which pose or twist is missing.
    """
    whole: dict[str, tuple[Tracks, str]] = {}
    lacking: dict[str, tuple[Tracks, str]] = {}
    scenarios = [track for track in _of_types(contents, SCENARIO) if _last(track.topic) == SCENARIO]
    for scenario in [given[SCENARIO]] if SCENARIO in given else scenarios:
        beside = ((space, _beside(contents, space)) for space in _above(scenario.topic))
        namespace, own = next((each for each in beside if each[1]), ("", {}))
        if len(own) == 1 and telling_of_bodies(path, contents, [scenario]):
            name = TWIST if POSE in own else POSE
            none = RawTrack(f"{namespace}/{name}", topic_types()[name][0], "cdr")
            fault = f"{path} has {scenario.topic} and no topic {none.topic}: record it as well"
            lacking[namespace] = {**own, name: none, SCENARIO: scenario}, fault
        elif len(own) == 2 and namespace in whole:
            tracks, _ = whole[namespace]
            try:
                tracks[SCENARIO] = _ours(path, contents, [tracks[SCENARIO], scenario])
            except BagError as error:
                whole[namespace] = tracks, str(error)
        elif len(own) == 2:
            whole[namespace] = {**own, SCENARIO: scenario}, ""
    every = whole and whole | lacking
    return [every[namespace] for namespace in sorted(every)]


def _beside(contents: McapContents, namespace: str) -> Tracks:
    """Pose and twist in a namespace, as far as they are there."""
    return {name: track for name in (POSE, TWIST) if (track := _track(contents, name, f"{namespace}/{name}"))}


def _above(topic: str) -> Iterator[str]:
    """The namespaces that a topic is in, the innermost first."""
    while topic:
        topic = topic.rpartition("/")[0]
        yield topic


def _ours(path: Path, contents: McapContents, scenarios: list[RawTrack]) -> RawTrack:
    """The topic of scenarios among several topics of texts."""
    telling = telling_of_bodies(path, contents, [track for track in scenarios if track.count])
    own = [track for track in scenarios if track.key in telling]
    if len(own) != 1:
        raise _several(path, SCENARIO, own or scenarios)
    return own[0]


def _find(path: Path, contents: McapContents, name: str, near: str | None) -> RawTrack:
    """The track with the right last name, of several that in the namespace; or else the only one of its types."""
    alike = _of_types(contents, name)
    named = [track for track in alike if _last(track.topic) == name]
    inside = [track for track in named if near is not None and track.topic.startswith(f"{near}/")]
    found = inside if len(inside) == 1 else named or alike  # remapped
    if not named and len(alike) != 1:
        told = ": body, motion, frames" if name == SCENARIO else ""
        there = shortened(listed([topic for topic, _ in contents.tracks]), _LONGEST_LIST)
        remedy = _remedy(path, f"record it; there are {there}" if there else "record it; there is no topic at all")
        raise BagError(f"{path} has no topic .../{name} ({_types(name)}{told}): {remedy}")
    if len(found) == 1:
        return found[0]
    if name == SCENARIO:
        return _ours(path, contents, found)
    raise _several(path, name, found)


def _remedy(path: Path, otherwise: str) -> str:
    """Remedy where a topic is missing: it may be in another file of a bag that was split."""
    whole, missing = whole_of(path), missing_beside(path)
    if whole is not None:
        return f"it is one file of a bag that was split: give the folder {whole}"
    if missing is not None:
        return f"restore file {missing} of a bag that was split, if it is one of that, or record it"
    return otherwise


def _several(path: Path, name: str, found: list[RawTrack]) -> BagError:
    topics = listed([track.topic for track in found])
    return BagError(f"{path} has several topics .../{name}: {topics}: {_choice(name, found[0].topic)}")


def require_topics(topics: Mapping[str, str]) -> None:
    """Refuse an argument ``topics`` of Python that gives no names of `topic_types` their topics.

    Raises
    ------
    InputError
    """
    if not isinstance(topics, Mapping) or not all(isinstance(text, str) for pair in topics.items() for text in pair):
        raise InputError(f'topics {shown(topics)}: not names and topics; give for example topics={{"pose": "/a/pose"}}')
    for name in topics:
        if name not in topic_types():
            raise InputError(f"topics: no topic {shown(name)}: {suggestion(name, topic_types(), 'topics of a body')}")


def for_python(error: BagError) -> BagError:
    """An error of `bodies`, with the argument ``topics`` in place of that of the command line."""
    return BagError(re.sub(r"--topic (\S+?):=([^\s:]+)", r'topics={"\1": "\2"}', str(error)))


def _choice(name: str, topic: str) -> str:
    return f"say which, as by --topic {name}:={topic}"


def given_track(path: Path, contents: McapContents, name: str, topic: str) -> RawTrack:
    """The track of a topic that the user named."""
    track = _track(contents, name, topic)
    if track is not None and track.count:
        return track
    if track is not None:
        raise BagError(f"{path}: --topic {name}:={topic}: it has no message: record it while the body is published")
    types, known = _types(name), [track.topic for track in _of_types(contents, name)]
    others = [track.message_type for track in contents.tracks.values() if track.topic == topic]
    what = f"topic {topic} is of {_last(others[0])}, not {types}" if others else f"there is no topic {topic}"
    hint = suggestion(topic, known, f"topics of {types}") if known else f"no topic is of {types}"
    raise BagError(f"{path}: --topic {name}:={topic}: {what}: {hint}")


def _track(contents: McapContents, name: str, topic: str) -> RawTrack | None:
    found = [track for kind in topic_types()[name] if (track := contents.tracks.get((topic, kind)))]
    return max(found, key=lambda track: track.count, default=None)


def _of_types(contents: McapContents, name: str) -> list[RawTrack]:
    alike = [track for (_, kind), track in contents.tracks.items() if kind in topic_types()[name]]
    return [track for track in alike if name != SCENARIO or _last(track.topic) != _last(FAULTS_TOPIC)]  # texts as well


def _types(name: str) -> str:
    """Words for the types that a topic may have."""
    return " or ".join(map(_last, topic_types()[name]))


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _body(path: Path, contents: McapContents, tracks: Tracks, given: Tracks, fault: str, *, alone: bool) -> Body:
    silent = [tracks[name].topic for name in BODY_TOPICS if not tracks[name].count]
    if silent and not fault:
        fault = f"{path} has no message on {silent[0]}: {_remedy(path, 'record it while the body is published')}"
    if fault and alone:
        raise BagError(fault)
    sensors = {name: given.get(name) or _sensor(contents, name, tracks, alone=alone) for name in SENSOR_TOPICS}
    there = {name: track for name, track in sensors.items() if track is not None and track.count}
    return Body(tracks[POSE].topic.rpartition("/")[0], {**{name: tracks[name] for name in BODY_TOPICS}, **there}, fault)


def _sensor(contents: McapContents, name: str, tracks: Tracks, *, alone: bool) -> RawTrack | None:
    """The track of what a sensor of the body reads; of a body that is alone in any namespace but another's."""
    last = name.removeprefix("~/")
    private = last != name  # of the node, one name below its namespace
    beside = tracks[SCENARIO if private else POSE].topic.rpartition("/")[0]
    own = _track(contents, name, f"{beside}/{last}")
    poses = {track.topic for track in _of_types(contents, POSE)} - {tracks[POSE].topic}
    alike = [track for track in _of_types(contents, name) if f"/{track.topic}".endswith(f"/{last}") and track.count]
    elsewhere = [t for t in alike if f"{_home(t.topic.removesuffix(last), private=private)}/{POSE}" not in poses]
    return own or (elsewhere[0] if alone and len(elsewhere) == 1 else None)


def _home(prefix: str, *, private: bool) -> str:
    """The namespace of the node whose topic begins so."""
    above = prefix.rstrip("/")
    return above.rpartition("/")[0] if private else above
