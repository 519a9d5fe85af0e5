"""Reading the attitudes of one topic of a bag, of any of the message types in which filters publish them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages.definitions import (
    IMU,
    ODOMETRY,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    QUATERNION_STAMPED,
    TF_MESSAGE,
)
from lie_rigid_body.messages.framed import FramedNumbers, Frames, decode_odometry, decode_transforms
from lie_rigid_body.recording.mcap_reader import McapContents, RawTrack
from lie_rigid_body.recording.track_decoding import named, payloads, stamped_columns, taken
from lie_rigid_body.wording import listed, short_repr

_PLACES: Final = {POSE_STAMPED: (7, 3), POSE_WITH_COVARIANCE_STAMPED: (43, 3), QUATERNION_STAMPED: (4, 0), IMU: (37, 0)}
"""Of each type with one frame how many float64 fields it has, and where the attitude begins among them."""
_FRAMED: Final[dict[str, Callable[[list[bytes]], dict[Frames, FramedNumbers]]]] = {
    ODOMETRY: decode_odometry,
    TF_MESSAGE: decode_transforms,
}
ATTITUDE_TYPES: Final = (*_PLACES, *_FRAMED)
"""The message types that hold an attitude with a stamp."""
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
    count, first = _PLACES[track.message_type]
    _, stamps, read = stamped_columns(path, track, count)
    if len(read.frame_ids) > 1:
        raise BagError(f"{path}: topic {topic} is of the frames {listed(read.frame_ids)}: record those of one body")
    known = np.full(len(read.numbers), True)
    if track.message_type == IMU:
        known = read.numbers[:, _IMU_COVARIANCE.start] != -1.0
    if not known.any():
        raise BagError(f"{path}: topic {topic} has no orientation, its covariance says -1: give the output of a filter")
    numbers = read.numbers[known]
    attitude = numbers[:, first : first + 4]
    return AttitudeTrack(
        track.topic, track.message_type, stamps[known], attitude, _covariance(track, numbers), read.frame_ids[0]
    )


def _find(path: Path, contents: McapContents, topic: str) -> RawTrack:
    found = [track for track in contents.tracks.values() if track.topic == topic]
    usable = [track for track in found if track.message_type in ATTITUDE_TYPES]
    if not found:
        topics = [track.topic for track in contents.tracks.values() if track.message_type in ATTITUDE_TYPES]
        raise BagError(f"{path} has no topic {topic}; attitudes are on {listed(topics) or 'none of its topics'}")
    if not usable:
        kind, *kinds, last = (name.rpartition("/")[2] for name in (found[0].message_type, *ATTITUDE_TYPES))
        raise BagError(f"{path}: topic {topic} is of {kind}: give {', '.join(kinds)} or {last}")
    if len(usable) > 1 or not usable[0].count:
        what = "messages of several types" if len(usable) > 1 else "no message"
        raise BagError(f"{path} has {what} on {topic}: record it again while one estimator runs")
    return usable[0]


def _framed_track(path: Path, track: RawTrack, wanted: Frames | None) -> AttitudeTrack:
    pieces = taken(path, track)
    with named(path, track.topic):
        found = _FRAMED[track.message_type]([payload for _, payload in payloads(pieces)])
    frames = wanted if wanted in found else next(iter(found), None)
    if frames is None:
        raise BagError(f"{path}: the messages on {track.topic} are empty: record it while an estimator runs")
    if len(found) > 1 and frames != wanted:
        pairs = listed([f"{frame} to {child}" for frame, child in found])
        what = f"none of which is {' to '.join(wanted)}" if wanted else "of which none is known as the body's"
        raise BagError(f"{path}: topic {track.topic} tells of {pairs}, {what}: record one body, or name its frames so")
    numbers = np.array(found[frames].numbers)
    stamps = np.array(found[frames].stamps_ns, dtype=np.int64)
    return AttitudeTrack(track.topic, track.message_type, stamps, numbers[:, 3:7], _covariance(track, numbers), *frames)


def _covariance(track: RawTrack, numbers: Array) -> Array | None:
    if track.message_type == IMU:
        return numbers[:, _IMU_COVARIANCE].reshape(-1, 3, 3)
    if track.message_type in (POSE_WITH_COVARIANCE_STAMPED, ODOMETRY):
        return numbers[:, _POSE_COVARIANCE].reshape(-1, 6, 6)[:, 3:, 3:]
    return None
