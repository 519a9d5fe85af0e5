"""Reading the sensors of a run from a bag."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.batch import IMU_BIAS, IMU_DATA, MAG, SENSOR_TOPICS
from lie_rigid_body.messages.definitions import IMU, MAGNETIC_FIELD
from lie_rigid_body.recording.mcap_reader import McapContents, RawTrack
from lie_rigid_body.recording.track_decoding import stamped_columns
from lie_rigid_body.wording import listed, short_repr

SENSOR_TYPES: Final = (IMU, MAGNETIC_FIELD)
"""The message types of the sensors."""

_VECTORS: Final = {IMU: (37, (13, 25)), MAGNETIC_FIELD: (12, (0,))}
"""Of each type how many float64 fields it has, and where its vectors begin among them."""


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
