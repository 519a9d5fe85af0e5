"""Reading the attitudes of one topic of a bag, of any of the message types in which filters publish them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import NOT_GIVEN, decode_places
from lie_rigid_body.messages.definitions import (
    IMU,
    ODOMETRY,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    QUATERNION_STAMPED,
    TF_MESSAGE,
)
from lie_rigid_body.messages.framed import FramedNumbers, Frames, decode_odometry, decode_transforms
from lie_rigid_body.recording.mcap_contents import McapContents, RawMessages, RawTrack
from lie_rigid_body.recording.topic_messages import decoding, require_cdr
from lie_rigid_body.wording import listed, short_repr

_NUMBERS: Final = {POSE_STAMPED: 7, POSE_WITH_COVARIANCE_STAMPED: 43, QUATERNION_STAMPED: 4, IMU: 37}
"""Number of float64 fields of each type with one frame."""
_FRAMED: Final[dict[str, Callable[[list[bytes]], dict[Frames, FramedNumbers]]]] = {
    ODOMETRY: decode_odometry,
    TF_MESSAGE: decode_transforms,
}
ATTITUDE_TYPES: Final = (*_NUMBERS, *_FRAMED)
"""Message types that hold an attitude with a stamp."""
_BEHIND_POSITION: Final = (POSE_STAMPED, POSE_WITH_COVARIANCE_STAMPED, *_FRAMED)
"""Types whose attitude stands behind three numbers of a position."""
_COVARIANCES: Final = {POSE_WITH_COVARIANCE_STAMPED: slice(7, 43), ODOMETRY: slice(7, 43), IMU: slice(4, 13)}
"""Fields of the covariance: 6 × 6 after a pose, 3 × 3 after an orientation."""
NO_ORIENTATION: Final = "has no orientation, its covariance says -1: give the output of a filter"
"""Complaint about a topic of Imu in which no message has an orientation."""


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

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, rows: slice | Integers | Booleans) -> AttitudeTrack:
        P = self.covariance
        return replace(
            self,
            stamps_ns=self.stamps_ns[rows],
            attitude_xyzw=self.attitude_xyzw[rows],
            covariance=None if P is None else P[rows],
        )

    @classmethod
    def joined(cls, parts: Iterable[AttitudeTrack]) -> AttitudeTrack:
        """Attitudes of one topic that continue each other as one; of at least one part."""
        first, *rest = parts
        covariances = [part.covariance for part in (first, *rest) if part.covariance is not None]
        return replace(
            first,
            stamps_ns=np.concatenate([first.stamps_ns, *(part.stamps_ns for part in rest)]),
            attitude_xyzw=np.concatenate([first.attitude_xyzw, *(part.attitude_xyzw for part in rest)]),
            covariance=np.concatenate(covariances) if covariances else None,
        )


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
    require_cdr(path, track)
    raw = track.take()
    with decoding(path, topic, raw):
        found = _attitudes(topic, track.message_type, raw)
    chosen = frames if frames in found else next(iter(found), None)
    if chosen is None:
        raise BagError(f"{path}: the messages on {topic} are empty: record it while an estimator runs")
    if len(found) > 1 and track.message_type not in _FRAMED:
        raise BagError(f"{path}: topic {topic} is of the frames {_names(found)}: record those of one body")
    if len(found) > 1 and chosen != frames:
        what = f"none of which is {' to '.join(frames)}" if frames else "of which none is known as the body's"
        raise BagError(
            f"{path}: topic {topic} tells of {_names(found)}, {what}: record one body, or name its frames so"
        )
    if not len(found[chosen]):
        raise BagError(f"{path}: topic {topic} {NO_ORIENTATION}")
    return found[chosen]


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
    sizes = np.array([len(payload) for payload in payloads], dtype=np.int64)
    found = _attitudes(topic, message_type, RawMessages(memoryview(b"".join(payloads)), sizes, np.zeros_like(sizes)))
    if len(found) > 1 and message_type not in _FRAMED:
        raise BagError(f"topic {topic} is of the frames {_names(found)}: let one node publish it")
    return found


def _attitudes(topic: str, message_type: str, found: RawMessages) -> dict[Frames, AttitudeTrack]:
    if message_type in _FRAMED:
        framed = _FRAMED[message_type]([payload for _, payload in found.payloads()])
        return {
            frames: _track(topic, message_type, np.array(own.stamps_ns, dtype=np.int64), np.array(own.numbers), frames)
            for frames, own in framed.items()
        }
    ends = np.cumsum(found.sizes)
    read = decode_places(found.data, ends - found.sizes, ends, _NUMBERS[message_type], stamped=True)
    assert read.stamps_ns is not None
    tracks: dict[Frames, AttitudeTrack] = {}
    for i, frame in enumerate(read.frame_ids):
        told = read.frames == i
        if message_type == IMU:
            told &= read.numbers[:, _COVARIANCES[IMU].start] != NOT_GIVEN
        tracks[frame, ""] = _track(topic, message_type, read.stamps_ns[told], read.numbers[told], (frame, ""))
    return tracks


def _track(topic: str, message_type: str, stamps_ns: Integers, numbers: Array, frames: Frames) -> AttitudeTrack:
    first, covariance = 3 if message_type in _BEHIND_POSITION else 0, None
    if message_type in _COVARIANCES:
        rows = numbers[:, _COVARIANCES[message_type]]
        size = math.isqrt(rows.shape[1])
        covariance = rows.reshape(-1, size, size)[:, -3:, -3:]
    return AttitudeTrack(topic, message_type, stamps_ns, numbers[:, first : first + 4], covariance, *frames)


def _names(found: dict[Frames, AttitudeTrack]) -> str:
    return listed([" to ".join(filter(None, frames)) for frames in found])


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
