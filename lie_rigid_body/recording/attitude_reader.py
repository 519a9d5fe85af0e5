"""Reading the attitudes of one topic of a bag, of any of the message types in which filters publish them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded, decode
from lie_rigid_body.messages.definitions import (
    IMU,
    ODOMETRY,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    QUATERNION_STAMPED,
    TF_MESSAGE,
)
from lie_rigid_body.messages.framed import FramedNumbers, Frames, decode_odometry, decode_transforms
from lie_rigid_body.recording.mcap_contents import McapContents, RawTrack
from lie_rigid_body.recording.track_decoding import columns, named, taken
from lie_rigid_body.wording import listed, short_repr

_PLACES: Final = {POSE_STAMPED: (7, 3), POSE_WITH_COVARIANCE_STAMPED: (43, 3), QUATERNION_STAMPED: (4, 0), IMU: (37, 0)}
"""Number of float64 fields of each type with one frame, and the field with which the attitude begins."""
_FRAMED: Final[dict[str, Callable[[list[bytes]], dict[Frames, FramedNumbers]]]] = {
    ODOMETRY: decode_odometry,
    TF_MESSAGE: decode_transforms,
}
ATTITUDE_TYPES: Final = (*_PLACES, *_FRAMED)
"""Message types that hold an attitude with a stamp."""
NO_ORIENTATION: Final = "has no orientation, its covariance says -1: give the output of a filter"
"""Complaint about a topic of Imu in which no message has an orientation."""
_POSE_COVARIANCE: Final = slice(7, 43)
"""Fields of the 6 × 6 covariance after a pose."""
_IMU_COVARIANCE: Final = slice(4, 13)
"""Fields of the 3 × 3 covariance after an orientation."""


@dataclass(frozen=True)
class AttitudeTrack:
    """The attitudes of one topic, in file order.

    Attributes
    ----------
    topic, message_type : str
    stamps_ns : ndarray of int64, shape (N,)
        Those of the headers.
    attitude_xyzw : ndarray, shape (N, 4)
        As recorded: not normalised, perhaps not finite.
    covariance : ndarray, shape (N, 3, 3), or None
        As recorded, of small rotations about x, y, z, rad²; None for a type that has none.
    frame, child_frame : str
        Names of the frames; the child's is empty for a type that has none.
    """

    topic: str
    message_type: str
    stamps_ns: Integers
    attitude_xyzw: Array
    covariance: Array | None
    frame: str
    child_frame: str = ""

    __repr__ = short_repr


def read_attitudes(path: Path, contents: McapContents, topic: str, frames: Frames | None = None) -> AttitudeTrack:
    """The attitudes of a topic.

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
    if track.message_type in _FRAMED:
        return _framed_track(path, track, frames)
    found = taken(path, track)
    with named(path, topic):
        read = columns(found, _PLACES[track.message_type][0], stamped=True)
    if len(read.frame_ids) > 1:
        raise BagError(f"{path}: topic {topic} is of the frames {listed(read.frame_ids)}: record those of one body")
    attitudes = _plain_track(track.topic, track.message_type, read)
    if not attitudes.stamps_ns.size:
        raise BagError(f"{path}: topic {topic} {NO_ORIENTATION}")
    return attitudes


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
        If they cannot be read, or messages that tell of one frame each differ in it.
    """
    if message_type in _FRAMED:
        found = _FRAMED[message_type](list(payloads))
        return {frames: _framed(topic, message_type, frames, numbers) for frames, numbers in found.items()}
    read = decode(payloads, _PLACES[message_type][0], stamped=True)
    if len(read.frame_ids) > 1:
        raise BagError(f"topic {topic} is of the frames {listed(read.frame_ids)}: let one node publish it")
    track = _plain_track(topic, message_type, read)
    return {(track.frame, ""): track}


def _plain_track(topic: str, message_type: str, read: Decoded) -> AttitudeTrack:
    assert read.stamps_ns is not None
    first = _PLACES[message_type][1]
    known = np.full(len(read.numbers), True)
    if message_type == IMU:
        known = read.numbers[:, _IMU_COVARIANCE.start] != -1.0
    numbers = read.numbers[known]
    covariance = _covariance(message_type, numbers)
    return AttitudeTrack(
        topic, message_type, read.stamps_ns[known], numbers[:, first : first + 4], covariance, read.frame_ids[0]
    )


def _find(path: Path, contents: McapContents, topic: str) -> RawTrack:
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


def _framed_track(path: Path, track: RawTrack, wanted: Frames | None) -> AttitudeTrack:
    raw = taken(path, track)
    with named(path, track.topic):
        found = _FRAMED[track.message_type]([payload for _, payload in raw.payloads()])
    frames = wanted if wanted in found else next(iter(found), None)
    if frames is None:
        raise BagError(f"{path}: the messages on {track.topic} are empty: record it while an estimator runs")
    if len(found) > 1 and frames != wanted:
        pairs = listed([f"{frame} to {child}" for frame, child in found])
        what = f"none of which is {' to '.join(wanted)}" if wanted else "of which none is known as the body's"
        raise BagError(f"{path}: topic {track.topic} tells of {pairs}, {what}: record one body, or name its frames so")
    return _framed(track.topic, track.message_type, frames, found[frames])


def _framed(topic: str, message_type: str, frames: Frames, found: FramedNumbers) -> AttitudeTrack:
    numbers, stamps = np.array(found.numbers), np.array(found.stamps_ns, dtype=np.int64)
    return AttitudeTrack(topic, message_type, stamps, numbers[:, 3:7], _covariance(message_type, numbers), *frames)


def _covariance(message_type: str, numbers: Array) -> Array | None:
    if message_type == IMU:
        return numbers[:, _IMU_COVARIANCE].reshape(-1, 3, 3)
    if message_type in (POSE_WITH_COVARIANCE_STAMPED, ODOMETRY):
        return numbers[:, _POSE_COVARIANCE].reshape(-1, 6, 6)[:, 3:, 3:]
    return None
