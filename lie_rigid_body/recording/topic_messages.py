"""Messages of a bag's topics as arrays, decoded in one place: float64 fields, texts, and attitudes of filters.

Poses and twists of a body and readings of sensors are `TopicMessages`. An estimated attitude comes in any of the
message types in which filters publish them, and is part of an `AttitudeTrack`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Final, TypeAlias, TypeVar

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.stamped import Stamped
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.messages import NOT_GIVEN, Decoded, decode_places, decode_string, numbers_of
from lie_rigid_body.messages.decoding import Frames, decode_framed
from lie_rigid_body.messages.definitions import (
    BARE_TWIST,
    IMU,
    ODOMETRY,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    QUATERNION_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    TWIST_STAMPED,
    places,
)
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE, ZSTD_MAGIC
from lie_rigid_body.recording.mcap_contents import McapContents, RawMessages, RawTopic, TopicKey
from lie_rigid_body.sensors import SENSORS, Field, Topic

TRUE_TYPES: Final = (POSE_STAMPED, TWIST_STAMPED, BARE_TWIST)
"""Types of the poses and twists of a body: three numbers of its translation, and then those of its rotation."""
_FRAMED: Final = (ODOMETRY, TRANSFORM_STAMPED, TF_MESSAGE)
"""Types of messages with two frames."""
_LAYOUTS: Final[dict[str, tuple[int, int, slice | None]]] = {
    POSE_STAMPED: (7, 3, None),
    POSE_WITH_COVARIANCE_STAMPED: (43, 3, slice(7, 43)),
    QUATERNION_STAMPED: (4, 0, None),
    IMU: (37, 0, slice(4, 13)),
    ODOMETRY: (85, 3, slice(7, 43)),
    TRANSFORM_STAMPED: (7, 3, None),
    TF_MESSAGE: (7, 3, None),
}
"""Number of float64 fields of a message type, where the attitude begins among them, and which are the covariance.

An attitude stands behind the three numbers of a position, if there is one. A covariance is 6 × 6 after a pose, 3 × 3
after an orientation.
"""
ATTITUDE_TYPES: Final = tuple(_LAYOUTS)
"""Message types that hold an attitude with a stamp."""
POSE_TYPES: Final = tuple(kind for kind, (_, first, _) in _LAYOUTS.items() if first)
"""Message types that hold a position as well."""
NO_ORIENTATION: Final = "has no orientation, its covariance says -1: give the output of a filter"
"""Complaint about a topic of Imu in which no message has an orientation."""
Kind: TypeAlias = tuple[str | None, bytes]
"""Parts that most messages of a topic share: the frame's name, None without a header, and the bits of the float64
fields that are no values."""


@short_dataclass
class TopicMessages(Stamped):
    """Messages of a topic of float64 fields, in file order, with every field.

    Attributes
    ----------
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,)
        Stamps of the headers; of messages without one the log times.
    values : ndarray, shape (N, K)
        The fields that differ from message to message, one after the other; see `varying_fields`. As recorded: perhaps
        not finite.
    kinds : tuple of Kind
        What most messages have alike, once for each kind: name of the frame, and all other float64 fields in order.
    kind : ndarray of int64, shape (N,)
        Which of them each message has.
    """

    log_times_ns: Integers
    stamps_ns: Integers
    values: Array
    kinds: tuple[Kind, ...]
    kind: Integers

    @property
    def frame_ids(self) -> set[str]:
        """Names of the frames that the messages have."""
        present = np.unique(self.kind) if len(self.kinds) > 1 else range(len(self.kinds))
        return {frame for frame, _ in (self.kinds[number] for number in present) if frame is not None}

    @classmethod
    def joined(cls, parts: Iterable[TopicMessages]) -> TopicMessages:
        """Messages that continue each other as one."""
        parts = list(parts)
        kinds = {kind: i for i, kind in enumerate(dict.fromkeys(kind for part in parts for kind in part.kinds))}
        own = [np.array([kinds[kind] for kind in part.kinds], dtype=np.int64) for part in parts]
        kind = np.concatenate([numbers[part.kind] for numbers, part in zip(own, parts, strict=True)])
        return replace(super().joined(parts), kinds=tuple(kinds), kind=kind)

    @classmethod
    def none_of(cls, message_type: str) -> TopicMessages:
        """Messages of a topic of which there is none."""
        none = np.empty(0, dtype=np.int64)
        width = np.count_nonzero(varying_fields(message_type))
        return cls(none, none, np.empty((0, width)), (), none)


LoggedText: TypeAlias = tuple[int, str]
"""Log time, ns, and text of a message."""
OfSensor: TypeAlias = TopicMessages | list[LoggedText]
"""Readings of a sensor; or log times, ns, and texts of messages about faults, in file order."""
TakeReadings: TypeAlias = Callable[[Mapping[str, OfSensor]], object]
"""Function that takes messages of sensors, and about their faults, by relative topic names."""


@contextmanager
def decoding(path: Path, topic: str, found: RawMessages) -> Iterator[None]:
    """Context in which messages are decoded, whose errors name the bag and the topic.

    Raises
    ------
    BagError
        If one cannot be decoded, or they are compressed one by one.
    """
    if bytes(found.data[: len(ZSTD_MAGIC)]) == ZSTD_MAGIC:
        raise BagError(f"{path}: {COMPRESSED_ONE_BY_ONE}")
    try:
        yield
    except BagError as error:
        raise BagError(f"{path}: topic {topic}: {error}: record the bag again") from None


def require_cdr(path: Path, track: RawTopic) -> None:
    """Refuse a topic whose messages are encoded otherwise."""
    if track.encoding != "cdr":
        raise BagError(f"{path}: topic {track.topic} is encoded as {track.encoding!r}: give one in cdr")


def texts(path: Path, topic: str, pieces: Iterable[RawMessages]) -> Iterator[LoggedText]:
    """Log time, ns, and text of each std_msgs/String of a topic, as they come."""
    numbers = count()
    for piece in pieces:
        with decoding(path, topic, piece):
            for time, payload in piece.payloads():
                yield time, decode_string(payload, next(numbers))


def topic_messages(path: Path, key: TopicKey, parts: Iterable[RawMessages], first: int = 0) -> TopicMessages:
    """Decode messages of a topic, the first of which has a number, for errors."""
    raw = RawMessages.joined(parts)
    return _decoded(path, *key, raw, first) if len(raw) else TopicMessages.none_of(key[1])


def stamped_numbers(path: Path, contents: McapContents, track: RawTopic) -> tuple[Integers, Decoded]:
    """Log times, ns, and all float64 fields of the messages with a header on a topic.

    Raises
    ------
    BagError
        If one cannot be decoded.
    """
    require_cdr(path, track)
    raw = contents.messages(track.key)
    with decoding(path, track.topic, raw):
        decoded = _columns(raw, len(places(track.message_type)[""]))
    return raw.log_times_ns, decoded


def _decoded(path: Path, topic: str, message_type: str, found: RawMessages, first: int) -> TopicMessages:
    varying = varying_fields(message_type)
    with decoding(path, topic, found):
        decoded = _columns(found, len(varying), stamped=message_type != BARE_TWIST, first=first)
    stamps = decoded.stamps_ns
    frame_ids = decoded.frame_ids or (None,)
    values = decoded.numbers if varying.all() else decoded.numbers[:, varying]
    rest = decoded.numbers[:, ~varying].view(np.int64)
    at = np.zeros(min(1, len(rest)), dtype=np.int64)
    kind = np.zeros(len(rest), dtype=np.int64)
    if decoded.frames.any() or (rest != rest[:1]).any():
        keys = np.column_stack([decoded.frames, rest])
        whole = np.ascontiguousarray(keys).view(f"V{keys.itemsize * keys.shape[1]}")[:, 0]
        _, at, kind = np.unique(whole, return_index=True, return_inverse=True)
    kinds = tuple((frame_ids[int(decoded.frames[i])], rest[i].tobytes()) for i in at)
    return TopicMessages(found.log_times_ns, found.log_times_ns if stamps is None else stamps, values, kinds, kind)


def _columns(found: RawMessages, numbers: int, *, stamped: bool = True, first: int = 0) -> Decoded:
    ends = np.cumsum(found.sizes)
    return decode_places(found.data, ends - found.sizes, ends, numbers, stamped=stamped, first=first)


def varying_fields(message_type: str) -> Booleans:
    """Mask of the float64 numbers of a type that are values of its messages, shape (K,).

    They are those that differ between messages on any topic of a sensor; of the types of the truth they are all.
    """
    numbers = np.full(len(places(message_type)[""]), message_type in TRUE_TYPES)
    for sensor in SENSORS.values():
        for topic in sensor.topics:
            for field in topic.fields if topic.message_type == message_type else ():
                numbers[list(numbers_of(topic, field))] = True
    return numbers


def value_columns(topic: Topic, field: Field) -> Integers:
    """Columns of a field among the values of the `TopicMessages` of a topic."""
    varying = np.flatnonzero(varying_fields(topic.message_type))
    return np.asarray(np.searchsorted(varying, numbers_of(topic, field)), dtype=np.int64)


Logged = TypeVar("Logged", "TopicMessages", "AttitudeTrack")


def in_log_order(messages: Logged) -> Logged:
    """Messages in the order of their log times, and of their stamps where these are equal."""
    return messages[np.lexsort((messages.stamps_ns, messages.log_times_ns))]


@short_dataclass
class AttitudeTrack(Stamped):
    """The attitudes of one topic, in file order, or in the order of their log times.

    Attributes
    ----------
    topic, message_type : str
    stamps_ns, log_times_ns : ndarray of int64, shape (N,)
        Stamps of the headers; log times, which are 0 for messages of no file.
    attitude_xyzw : ndarray, shape (N, 4)
        As recorded: not normalised, perhaps not finite.
    covariance : ndarray, shape (N, 3, 3), or None
        As recorded, of small rotations about x, y, z, rad²; None for a type that has none.
    position : ndarray, shape (N, 3), or None
        As recorded, m; None for a type that has none.
    frame, child_frame : str
        Names of the frames; the child's is empty for a type that has none.
    """

    topic: str
    message_type: str
    stamps_ns: Integers
    log_times_ns: Integers
    attitude_xyzw: Array
    covariance: Array | None
    frame: str
    child_frame: str = ""
    position: Array | None = None


def read_attitudes(path: Path, contents: McapContents, topic: str, frames: Frames | None = None) -> AttitudeTrack:
    """The attitudes of a topic in the order in which ``ros2 bag play`` sends them; see `in_log_order`.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    contents : McapContents
        With the payloads of `ATTITUDE_TYPES`.
    topic : str
    frames : tuple of str, optional
        Frame and child frame that are wanted of messages which tell of several.

    Returns
    -------
    AttitudeTrack

    Raises
    ------
    BagError
        If there is no such topic, or none of these types on it, or no message, no orientation, or several bodies.
    """
    track = _find(path, contents, topic)
    require_cdr(path, track)
    raw = contents.messages(track.key)
    with decoding(path, topic, raw):
        found = attitudes_in(topic, track.message_type, raw)
    if not found:
        raise BagError(f"{path}: the messages on {topic} are empty: record it while an estimator runs")
    told = listed([" to ".join(filter(None, each)) for each in found])
    if len(found) > 1 and track.message_type not in _FRAMED:
        raise BagError(f"{path}: topic {topic} is of the frames {told}: give one of one body, in one frame")
    if len(found) > 1 and frames not in found:
        what = f"none of which is {' to '.join(frames)}" if frames else "of which none is known as the body's"
        raise BagError(f"{path}: topic {topic} tells of {told}, {what}: record one body, or name its frames so")
    chosen = found[frames] if frames in found else next(iter(found.values()))
    if not len(chosen):
        raise BagError(f"{path}: topic {topic} {NO_ORIENTATION}")
    return in_log_order(chosen)


def attitudes_of(topic: str, message_type: str, payloads: Sequence[bytes]) -> dict[Frames, AttitudeTrack]:
    """The attitudes in messages of a topic, by frame and child frame; without those that say that they have none.

    Parameters
    ----------
    topic : str
    message_type : str
        One of `ATTITUDE_TYPES`.
    payloads : sequence of bytes

    Raises
    ------
    BagError
        If they cannot be read.
    """
    return attitudes_in(topic, message_type, RawMessages.of_payloads([(0, payload) for payload in payloads]))


def vectors_of(message_type: str, payloads: Sequence[bytes]) -> tuple[Integers, Array]:
    """Stamps, ns, shape (N,), and the vector or angular velocity in messages, shape (N, 3).

    Raises
    ------
    BagError
        If they cannot be read.
    """
    fields = places(message_type)
    read = _columns(RawMessages.of_payloads([(0, payload) for payload in payloads]), len(fields[""]))
    assert read.stamps_ns is not None
    return read.stamps_ns, read.numbers[:, fields["angular_velocity" if message_type == IMU else "vector"]]


def attitudes_in(topic: str, message_type: str, found: RawMessages) -> dict[Frames, AttitudeTrack]:
    """The attitudes in messages of a topic as they were read, by frame and child frame."""
    count, _, covariance = _LAYOUTS[message_type]
    if message_type in _FRAMED:
        payloads = (payload for _, payload in found.payloads())
        framed = decode_framed(payloads, count, counted=message_type == TF_MESSAGE)
        return {
            frames: _track(
                topic,
                message_type,
                np.array(own.stamps_ns, dtype=np.int64),
                found.log_times_ns[own.messages],
                np.array(own.numbers),
                frames,
            )
            for frames, own in framed.items()
        }
    read = _columns(found, count)
    tracks = dict[Frames, AttitudeTrack]()
    assert read.stamps_ns is not None
    gives = np.ones(len(found), dtype=np.bool_)
    if message_type == IMU and covariance:
        gives = read.numbers[:, covariance.start] != NOT_GIVEN
    for i, frame in enumerate(read.frame_ids):
        own = gives & (read.frames == i)
        tracks[frame, ""] = _track(
            topic, message_type, read.stamps_ns[own], found.log_times_ns[own], read.numbers[own], (frame, "")
        )
    return tracks


def _track(
    topic: str, message_type: str, stamps_ns: Integers, log_times_ns: Integers, numbers: Array, frames: Frames
) -> AttitudeTrack:
    _, first, fields = _LAYOUTS[message_type]
    covariance = None
    if fields:
        size = math.isqrt(fields.stop - fields.start)
        covariance = numbers[:, fields].reshape(-1, size, size)[:, -3:, -3:]
    attitude = numbers[:, first : first + 4]
    position = numbers[:, :first] if first else None
    return AttitudeTrack(topic, message_type, stamps_ns, log_times_ns, attitude, covariance, *frames, position)


def _find(path: Path, contents: McapContents, topic: str) -> RawTopic:
    found = [track for track in contents.tracks.values() if track.topic == topic]
    usable = [track for track in found if track.message_type in ATTITUDE_TYPES]
    if not found:
        topics = [track.topic for track in contents.tracks.values() if track.message_type in ATTITUDE_TYPES]
        raise BagError(f"{path} has no topic {topic}; topics of types with attitudes are {listed(topics) or 'none'}")
    if not usable:
        raise BagError(f"{path}: topic {topic} {wrong_type(found[0].message_type)}")
    if len(usable) > 1 or not usable[0].count:
        what = "messages of several types" if len(usable) > 1 else "no message"
        raise BagError(f"{path} has {what} on {topic}: record it again while one estimator runs")
    return usable[0]


def wrong_type(message_type: str) -> str:
    """Why a topic of a type holds no attitudes, for an error."""
    kind, *kinds, last = (name.rpartition("/")[2] for name in (message_type, *ATTITUDE_TYPES))
    return f"is of {kind}: give {', '.join(kinds)} or {last}"
