"""Reading the sensors of a run from a bag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.messages.batch import IMU_BIAS, IMU_DATA, MAG, SENSOR_TOPICS
from lie_rigid_body.messages.definitions import IMU, MAGNETIC_FIELD, POSE_STAMPED
from lie_rigid_body.recording.mcap_reader import McapContents, RawMessages, RawTrack
from lie_rigid_body.recording.track_decoding import columns, named, stamped_columns
from lie_rigid_body.wording import listed, short_repr

SENSOR_TYPES: Final = (IMU, MAGNETIC_FIELD)
"""The message types of the sensors."""

_VECTORS: Final = {IMU: (37, (13, 25)), MAGNETIC_FIELD: (12, (0,))}
"""Of each type how many float64 fields it has, and where its vectors begin among them."""


@dataclass(frozen=True)
class SensorTopic:
    """A topic of the body's sensors in a bag.

    Attributes
    ----------
    topic, message_type : str
    count : int
        Messages.
    published_otherwise : int
        How many of them were not published at their log time.
    """

    topic: str
    message_type: str
    count: int
    published_otherwise: int

    __repr__ = short_repr


@dataclass(frozen=True)
class SensorMessages:
    """Messages of a sensor's topic, in file order, with every field.

    Attributes
    ----------
    log_times_ns, stamps_ns : ndarray of int64, shape (N,)
    vectors : ndarray, shape (N, 3 K)
        The vectors one after the other: of an IMU angular velocity, rad/s, and specific force, m/s²; of a magnetometer
        the field, T.
    kinds : tuple of (str, bytes)
        What most messages have alike, once for each kind: name of the frame, and all other float64 fields in order.
    kind : ndarray of int64, shape (N,)
        Which of them each message has.
    """

    log_times_ns: Integers
    stamps_ns: Integers
    vectors: Array
    kinds: tuple[tuple[str, bytes], ...]
    kind: Integers

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, rows: slice | Integers | Booleans) -> SensorMessages:
        return SensorMessages(
            self.log_times_ns[rows], self.stamps_ns[rows], self.vectors[rows], self.kinds, self.kind[rows]
        )

    @classmethod
    def joined(cls, parts: Sequence[SensorMessages]) -> SensorMessages:
        """Messages that continue each other as one."""
        kinds = {kind: i for i, kind in enumerate(dict.fromkeys(kind for part in parts for kind in part.kinds))}
        own = [np.array([kinds[kind] for kind in part.kinds], dtype=np.int64) for part in parts]
        return cls(
            np.concatenate([part.log_times_ns for part in parts]),
            np.concatenate([part.stamps_ns for part in parts]),
            np.concatenate([part.vectors for part in parts]),
            tuple(kinds),
            np.concatenate([numbers[part.kind] for numbers, part in zip(own, parts, strict=True)]),
        )


@dataclass(frozen=True)
class VectorTrack:
    """The messages of a sensor's topic, in file order.

    Attributes
    ----------
    topic : str
    stamps_ns : ndarray of int64, shape (N,)
    vectors : tuple of ndarray, shape (N, 3) each
        Of an IMU angular velocity, rad/s, and specific force, m/s²; of a magnetometer the field, T.
    """

    topic: str
    stamps_ns: Integers
    vectors: tuple[Array, ...]

    __repr__ = short_repr


def sensors_of(contents: McapContents, pose_topic: str) -> dict[str, RawTrack]:
    """The topics of the sensors by their relative names: beside the poses, or else the only one of that name.

    Those beside the poses of another body are left out.
    """
    beside, _, _ = pose_topic.rpartition("/")
    poses = {topic for topic, kind in contents.tracks if kind == POSE_STAMPED and topic != pose_topic}
    found = {}
    for name, kind in SENSOR_TOPICS.items():
        alike = [t for t in contents.tracks.values() if t.message_type == kind and f"/{t.topic}".endswith(f"/{name}")]
        alike = [t for t in alike if t.count and t.topic.removesuffix(name) + "pose" not in poses]
        own = [t for t in alike if t.topic == f"{beside}/{name}"] or alike
        if len(own) == 1:
            found[name] = own[0]
    return found


def sensor_messages(
    path: Path, topic: str, message_type: str, pieces: Sequence[RawMessages], first: int
) -> SensorMessages:
    """Decode messages of a sensor's topic, the first of which has a number."""
    with named(path, topic):
        log_times, decoded = columns(pieces, _VECTORS[message_type][0], stamped=True, first=first)
    assert decoded.stamps_ns is not None
    in_vectors = vector_fields(message_type)
    vectors = np.ascontiguousarray(decoded.numbers[:, in_vectors])
    return SensorMessages(
        log_times, decoded.stamps_ns, vectors, *_kinds(decoded, np.ascontiguousarray(decoded.numbers[:, ~in_vectors]))
    )


def vector_fields(message_type: str) -> Booleans:
    """Which float64 fields of a type are those of its vectors."""
    count, places = _VECTORS[message_type]
    fields = np.full(count, fill_value=False)
    for first in places:
        fields[first : first + 3] = True
    return fields


def _kinds(decoded: Decoded, rest: Array) -> tuple[tuple[tuple[str, bytes], ...], Integers]:
    """The kinds of messages, and which of them each is, by frame and the fields that are not of vectors."""
    keys = np.column_stack([decoded.frames, rest.view(np.int64)])
    if not len(keys) or (keys == keys[0]).all():
        distinct, kind = keys[:1], np.zeros(len(keys), dtype=np.int64)
    else:
        whole = np.ascontiguousarray(keys).view(f"V{keys.itemsize * keys.shape[1]}")[:, 0]
        _, first, kind = np.unique(whole, return_index=True, return_inverse=True)
        distinct = keys[first]
    return tuple((decoded.frame_ids[int(key[0])], key[1:].tobytes()) for key in distinct), kind


def imu_tracks(path: Path, contents: McapContents) -> tuple[VectorTrack | None, VectorTrack | None]:
    """The readings of the IMU and their true biases; None for a topic that is not in the bag."""
    return _track(path, contents, IMU_DATA), _track(path, contents, IMU_BIAS)


def magnetometer_track(path: Path, contents: McapContents) -> VectorTrack | None:
    """The readings of the magnetometer, or None."""
    return _track(path, contents, MAG)


def _track(path: Path, contents: McapContents, name: str) -> VectorTrack | None:
    kind = SENSOR_TOPICS[name]
    found = [t for t in contents.tracks.values() if t.message_type == kind and f"/{t.topic}".endswith(f"/{name}")]
    found = [track for track in found if track.count]
    if len(found) > 1:
        topics = listed([track.topic for track in found])
        raise BagError(f"{path} has several topics .../{name}: {topics}: record those of one body")
    return _vectors(path, found[0]) if found else None


def _vectors(path: Path, track: RawTrack) -> VectorTrack:
    count, places = _VECTORS[track.message_type]
    stamps, read = stamped_columns(path, track, count)
    return VectorTrack(track.topic, stamps, tuple(read.numbers[:, i : i + 3].copy() for i in places))
