"""The bodies of a bag: which topics are pose, twist, scenario and sensors of each.

A scenario message names the topics of its body. Where it does not, as in older bags, or where these were renamed, the
topics in its namespace are taken, or else the only ones of their types.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Final, TypeAlias

from lie_rigid_body.foundation.errors import BagError, ChoiceError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shortened, shown, suggestion
from lie_rigid_body.messages.batch import FAULTS_TOPIC, POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.messages.definitions import BARE_TWIST, POSE_STAMPED, STRING, TWIST_STAMPED
from lie_rigid_body.recording.bag_files import whole_of
from lie_rigid_body.recording.mcap_contents import McapContents, RawTopic, TopicKey, TopicNames
from lie_rigid_body.recording.topic_messages import LoggedText, texts

SCENARIO: Final = "scenario"
BODY_TOPICS: Final = (POSE, TWIST, SCENARIO)
"""Relative names of the topics that every body has."""
Tracks: TypeAlias = dict[str, RawTopic]
"""Topics of a body by their relative names."""
_Declared: TypeAlias = tuple[Tracks, TopicNames, BagError | None]
"""Topics of a body, those that its scenario names, and what is wrong."""
TOPIC_TYPES: Final[Mapping[str, tuple[str, ...]]] = {
    POSE: (POSE_STAMPED,),
    TWIST: (TWIST_STAMPED, BARE_TWIST),
    SCENARIO: (STRING,),
    **{name: (kind,) for name, kind in SENSOR_TOPICS.items()},
}
"""The topics of a body by their relative names, and the message types that each may have."""
_MAX_LIST: Final = 60
"""Characters of the topics that there are, in an error line that has to say more."""


@short_dataclass
class Body:
    """The topics of one body.

    Parameters
    ----------
    name : str
        The namespace of its pose, such as ``/a``; empty for the root namespace.
    tracks : dict of str to RawTopic
        Its topics by their relative names: pose, twist and scenario, and what its sensors read, and their faults, as
        far as it is there.
    fault : BagError, optional
        Why it cannot be read; a topic that is not in the bag is a track without a message.
    """

    name: str
    tracks: Tracks
    fault: BagError | None = None


def bodies(path: Path, contents: McapContents, topics: TopicNames) -> list[Body]:
    """The bodies of a bag: one for each scenario topic with a pose and a twist.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    contents : McapContents
    topics : mapping of str to str
        Topics that are called otherwise, by their relative names (the keys of `TOPIC_TYPES`). With one of the first
        three there is one body, that to which it belongs.

    Raises
    ------
    BagError
        If a topic of the only body is not there, has no message, or cannot be told from others; with those that are
        there.
    """
    given = {name: given_track(path, contents, name, topic) for name, topic in topics.items()}
    own = [name for name in BODY_TOPICS if name in given]
    found = [each for each in _declared(path, contents, given) if all(each[0][name] is given[name] for name in own)]
    if not found:  # the topics of the one body are not in one namespace
        near = next((given[name].topic.rpartition("/")[0] for name in given if name in (POSE, TWIST)), None)
        tracks = {name: given.get(name) or _find(path, contents, name, near) for name in BODY_TOPICS}
        found = [(tracks, told_topics(path, contents, [tracks[SCENARIO]]).get(tracks[SCENARIO].key, {}), None)]
    return [_body(path, contents, *each, given, alone=len(found) == 1) for each in found]


def the_body(path: Path, contents: McapContents, topics: TopicNames) -> Body:
    """The body of a bag that has one. See `bodies`."""
    found = bodies(path, contents, topics)
    if len(found) > 1:
        names = listed([body.name or "/" for body in found])
        first = min(found, key=lambda body: body.fault is not None)
        said = f"{path} holds {len(found)} bodies, {names}: say which, as by {{choice}}"
        raise ChoiceError(said, POSE, first.tracks[POSE].topic)
    return found[0]


def texts_on(path: Path, contents: McapContents, track: RawTopic) -> Iterator[LoggedText]:
    """Log time, ns, and text of each message of a topic of texts, as they are read from the parts that have any."""
    return texts(path, track.topic, (part[track.key] for part in contents.read([track.key]) if track.key in part))


def told_topics(path: Path, contents: McapContents, tracks: Iterable[RawTopic]) -> dict[TopicKey, TopicNames]:
    """Topics that scenarios name, by the tracks of these; of texts whose first message is none there is no entry.

    They are found in one pass: there may be ten thousands. A damaged one is a scenario, and names none.
    """
    waiting = {track.key: track for track in tracks if track.count}
    found = dict[TopicKey, TopicNames]()
    for part in contents.read(waiting.keys()) if waiting else ():  # which are fewer from part to part
        for key in part.keys() & waiting.keys():
            track = waiting.pop(key)
            try:
                for _, text in islice(texts(path, track.topic, [part[key]]), 1):
                    if '"inertia"' in text:
                        found[key] = _topics_in(text)
            except BagError:
                found[key] = {}
        if not waiting:
            break
    return found


def _topics_in(text: str) -> dict[str, str]:
    try:
        topics = json.loads(text)["topics"]
        return {str(name): str(topic) for name, topic in topics.items()}
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return {}


def _declared(path: Path, contents: McapContents, given: Tracks) -> list[_Declared]:
    """The tracks of each body, what its scenario names, and what is wrong, in the order of their namespaces.

    Where some are whole, those of which pose or twist is missing stand beside them.
    """
    whole = dict[str, _Declared]()
    lacking = dict[str, _Declared]()
    scenarios = [track for track in _of_types(contents, SCENARIO) if _last(track.topic) == SCENARIO]
    scenarios = [given[SCENARIO]] if SCENARIO in given else scenarios
    told = told_topics(path, contents, scenarios)
    # where there is a choice, texts of another node, which calls something else a scenario, come last
    for scenario in sorted(scenarios, key=lambda track: track.key not in told):
        names = told.get(scenario.key, {})
        space, own = _truth(contents, scenario, names)
        tracks = {**own, SCENARIO: scenario}
        if len(own) == 1 and scenario.key in told:
            name = TWIST if POSE in own else POSE
            tracks[name] = RawTopic(f"{space}/{name}", TOPIC_TYPES[name][0], "cdr")
            fault = f"{path} has {scenario.topic} and no topic {tracks[name].topic}: record it as well"
            lacking[space] = tracks, names, BagError(fault)
        elif len(own) == 2 and space not in whole:
            whole[space] = tracks, names, None
        elif len(own) == 2 and (scenario.key in told) == (whole[space][0][SCENARIO].key in told):
            several = [whole[space][0][SCENARIO], scenario]
            whole[space] = tracks, names, _several(path, SCENARIO, several)
    every = whole and whole | lacking
    return [every[space] for space in sorted(every)]


def _truth(contents: McapContents, scenario: RawTopic, names: TopicNames) -> tuple[str, Tracks]:
    """Namespace, pose and twist of a scenario, as far as they are there: those that it names, or the nearest above."""
    own = _tracks(contents, {name: names.get(name, "") for name in (POSE, TWIST)})
    if len(own) == 2:
        return own[POSE].topic.rpartition("/")[0], own
    space = scenario.topic
    while space:
        space = space.rpartition("/")[0]
        if own := _tracks(contents, {name: f"{space}/{name}" for name in (POSE, TWIST)}):
            return space, own
    return "", {}


def _tracks(contents: McapContents, topics: TopicNames) -> Tracks:
    """Tracks of the topics, by their relative names, that are there."""
    return {name: track for name, topic in topics.items() if (track := _track(contents, TOPIC_TYPES[name], topic))}


def _find(path: Path, contents: McapContents, name: str, near: str | None) -> RawTopic:
    """The track with the right last name, of several that in the namespace; or else the only one of its types."""
    alike = _of_types(contents, name)
    named = [track for track in alike if _last(track.topic) == name]
    inside = [track for track in named if near is not None and track.topic.startswith(f"{near}/")]
    found = inside if len(inside) == 1 else named or alike  # remapped
    if not named and len(alike) != 1:
        raise _missing(path, contents, name)
    if len(found) > 1 and name == SCENARIO:
        told = told_topics(path, contents, found)
        found = [track for track in found if track.key in told] or found
    if len(found) > 1:
        raise _several(path, name, found)
    return found[0]


def _missing(path: Path, contents: McapContents, name: str) -> BagError:
    """Error for a topic that is not there, or not of its type."""
    for track in contents.tracks.values():
        if _last(track.topic) == name:
            kind = f"of {track.message_type}" if track.message_type else "without a type"
            return BagError(f"{path}: topic {track.topic} is {kind}: record it as {' or '.join(TOPIC_TYPES[name])}")
    types = " or ".join(map(_last, TOPIC_TYPES[name]))
    told = ": body, motion, frames" if name == SCENARIO else ""
    there = shortened(listed([topic for topic, _ in contents.tracks]), _MAX_LIST) or "no topic at all"
    remedy = _remedy(path, f"record it; there {'is' if len(contents.tracks) < 2 else 'are'} {there}")
    return BagError(f"{path} has no topic .../{name} ({types}{told}): {remedy}")


def _remedy(path: Path, otherwise: str) -> str:
    """Remedy where a topic is missing: it may be in another file of a bag that was split."""
    whole = whole_of(path)
    return otherwise if whole is None else f"it is one file of a bag that was split: give the folder {whole}"


def _several(path: Path, name: str, found: list[RawTopic]) -> ChoiceError:
    topics = listed([track.topic for track in found])
    said = f"{path} has several topics .../{name}: {topics}: say which, as by {{choice}}"
    return ChoiceError(said, name, found[0].topic)


def require_topics(topics: TopicNames) -> None:
    """Refuse an argument ``topics`` of Python that gives no names of `TOPIC_TYPES` their topics.

    Raises
    ------
    InputError
    """
    if not isinstance(topics, Mapping) or not all(isinstance(text, str) for pair in topics.items() for text in pair):
        raise InputError(f'topics {shown(topics)}: not names and topics; give for example topics={{"pose": "/a/pose"}}')
    for name in topics:
        if name not in TOPIC_TYPES:
            raise InputError(f"topics: no topic {shown(name)}: {suggestion(name, TOPIC_TYPES, 'topics of a body')}")


def given_track(
    path: Path, contents: McapContents, name: str, topic: str, kinds: Sequence[str] | None = None
) -> RawTopic:
    """The track of a topic that the user named, of the types of its relative name or of others."""
    kinds = TOPIC_TYPES[name] if kinds is None else kinds
    track = _track(contents, kinds, topic)
    if track is not None and track.count:
        return track
    said = "it has no message: record it while the body is published"
    if track is None:
        types = " or ".join(map(_last, kinds))
        known = [track.topic for track in _of_types(contents, name, kinds)]
        others = [track.message_type for track in contents.tracks.values() if track.topic == topic]
        what = f"topic {topic} is of {_last(others[0])}, not {types}" if others else f"there is no topic {topic}"
        hint = suggestion(topic, known, f"topics of {types}") if known else f"no topic is of {types}"
        said = f"{what}: {hint}"
    raise ChoiceError(f"{path}: {{choice}}: {said}", name, topic)


def _track(contents: McapContents, kinds: Sequence[str], topic: str) -> RawTopic | None:
    found = [track for kind in kinds if (track := contents.tracks.get((topic, kind)))]
    return max(found, key=lambda track: track.count, default=None)


def _of_types(contents: McapContents, name: str, kinds: Sequence[str] | None = None) -> list[RawTopic]:
    alike = [track for (_, kind), track in contents.tracks.items() if kind in (kinds or TOPIC_TYPES[name])]
    return [track for track in alike if name != SCENARIO or _last(track.topic) != _last(FAULTS_TOPIC)]  # texts as well


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def _body(
    path: Path,
    contents: McapContents,
    tracks: Tracks,
    names: TopicNames,
    fault: BagError | None,
    given: Tracks,
    *,
    alone: bool,
) -> Body:
    silent = [tracks[name].topic for name in BODY_TOPICS if not tracks[name].count]
    if silent and fault is None:
        remedy = _remedy(path, "record it while the body is published")
        fault = BagError(f"{path} has no message on {silent[0]}: {remedy}")
    unknown = listed(sorted(names.keys() - TOPIC_TYPES.keys()))
    if unknown and fault is None:
        fault = BagError(f"{path}: {tracks[SCENARIO].topic} names topics that no body has, {unknown}: restore the bag")
    if fault is not None and alone:
        raise fault
    told = _tracks(contents, {name: names[name] for name in names.keys() & SENSOR_TOPICS.keys()})
    found = {name: given.get(name) or told.get(name) for name in SENSOR_TOPICS}
    sensors = {name: track or _sensor(contents, name, tracks) for name, track in found.items()}
    there = {name: track for name, track in sensors.items() if track is not None and track.count}
    return Body(tracks[POSE].topic.rpartition("/")[0], {**{name: tracks[name] for name in BODY_TOPICS}, **there}, fault)


def _sensor(contents: McapContents, name: str, tracks: Tracks) -> RawTopic | None:
    """The track of what a sensor reads in the body's namespace, or of a private topic of its node."""
    last = name.removeprefix("~/")
    beside = tracks[POSE if last == name else SCENARIO].topic.rpartition("/")[0]
    return _track(contents, TOPIC_TYPES[name], f"{beside}/{last}")
