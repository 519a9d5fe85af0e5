"""An estimate and its truth as they are heard, message by message: what is read of them, and kept of the truth."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.errors import InputError
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.recording.attitude_reader import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.kept import Kept, Rows, joined
from lie_rigid_body.runs.recorded_estimate import TrueMotion
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import listed

MOST_WAITING: Final = 50_000
"""Largest number of estimates that wait for a truth; of more the oldest are given up."""
RECENT: Final = 40
"""Number of batches of poses by which the latest estimates are judged."""


class HeardTruth:
    """Scenarios and poses that tell the truth, message by message.

    Parameters
    ----------
    most : int
        Largest number of poses that are kept.
    """

    def __init__(self, most: int) -> None:
        self._segments: dict[str, Segment] = {}
        self._poses = Kept(most)
        self._recent: deque[Rows] = deque(maxlen=RECENT)
        self._template: AttitudeTrack | None = None

    def hear_scenario(self, payload: bytes) -> None:
        """Take a latched scenario; a reset sends another.

        Raises
        ------
        InputError
            If the text is no scenario.
        """
        text = decode_string(payload)
        if text not in self._segments:
            self._segments[text] = Segment.from_json(text)

    def hear_poses(self, topic: str, message_type: str, payloads: list[bytes]) -> None:
        """Take messages of poses: those of the frames that the first is of.

        Raises
        ------
        BagError
            If they cannot be read.
        """
        if not payloads:
            return
        for track in attitudes_of(topic, message_type, payloads).values():
            self._template = self._template or track
            if (track.frame, track.child_frame) == (self._template.frame, self._template.child_frame):
                ordered = self._poses.add(track.stamps_ns, track.attitude_xyzw)
                self._recent += [ordered] if len(ordered[0]) else []

    @property
    def is_known(self) -> bool:
        """Whether a scenario or a pose was heard."""
        return bool(self._segments) or self._poses.count > 0

    @property
    def begin_ns(self) -> int:
        """Start of the first scenario, or without one the stamp of the first pose, ns."""
        return min((segment.start_ns for segment in self._segments.values()), default=self._poses.first_ns)

    @property
    def last_pose_ns(self) -> int | None:
        """Stamp of the last pose, ns."""
        return self._poses.last_ns if self._poses.count else None

    @property
    def frames(self) -> Frames | None:
        """Names of the world's and the body's frame, if a scenario tells them."""
        return self.of_scenarios().frames

    def of_scenarios(self) -> TrueMotion:
        """The motion that the scenarios alone tell."""
        return TrueMotion(tuple(sorted(self._segments.values(), key=lambda segment: segment.start_ns)), None)

    def whole(self) -> TrueMotion:
        """The motion that all tells that is kept."""
        return self._with(self._poses.rows()) if self._poses.count else self.of_scenarios()

    def recent(self, since_ns: int) -> TrueMotion:
        """The motion that the latest poses tell, without the segments that had ended at a time: each costs much."""
        true = self._with(joined(self._recent)) if self._recent else self.of_scenarios()
        ended = sum(segment.start_ns <= since_ns for segment in true.segments[1:])
        return replace(true, segments=true.segments[ended:])

    def _with(self, poses: Rows) -> TrueMotion:
        assert self._template is not None
        track = replace(self._template, stamps_ns=poses[0], attitude_xyzw=poses[1], covariance=None)
        return replace(self.of_scenarios(), poses=track)


class HeardEstimate:
    """Messages of an estimate, which wait to be read until the truth is known.

    Parameters
    ----------
    topic, message_type : str

    Attributes
    ----------
    messages : int
        Number of messages that came.
    given_up : int
        Number of those that were not read, as too many came before any truth.
    """

    def __init__(self, topic: str, message_type: str) -> None:
        self.topic, self._message_type = topic, message_type
        self.messages = self.given_up = 0
        self._unread: list[bytes] = []
        self._pairs: dict[Frames, None] = {}
        self._template: AttitudeTrack | None = None

    def hear(self, payloads: list[bytes], *, to_wait: bool) -> None:
        """Take messages; those that are to wait for a truth are no more than `MOST_WAITING`."""
        self.messages += len(payloads)
        self._unread += payloads
        excess = max(0, len(self._unread) - MOST_WAITING) if to_wait else 0
        self.given_up += excess
        del self._unread[:excess]

    def read(self, frames: Frames | None) -> Rows | None:
        """Read the messages that were not read yet: stamps, ns, attitudes and covariances.

        Parameters
        ----------
        frames : tuple of str or None
            Names of the world's and the body's frame, where the truth tells them.

        Raises
        ------
        InputError
            If the messages are of several frames.
        """
        if not self._unread:
            return None
        unread, self._unread = self._unread, []
        found = attitudes_of(self.topic, self._message_type, unread)
        self._pairs |= dict.fromkeys(found)
        track = found.get(self._chosen(frames))
        if track is None or not track.stamps_ns.size:
            return None
        self._template = self._template or track
        if track.covariance is None:
            return track.stamps_ns, track.attitude_xyzw
        return track.stamps_ns, np.concatenate([track.attitude_xyzw, track.covariance.reshape(-1, 9)], axis=1)

    def _chosen(self, frames: Frames | None) -> Frames:
        """Frames of the estimate: of transforms those of the truth, else those of all messages."""
        if self._message_type == TF_MESSAGE and frames is not None:
            return frames
        if len(self._pairs) > 1:
            pairs = listed([" to ".join(filter(None, pair)) for pair in self._pairs])
            raise InputError(f"topic {self.topic} is of the frames {pairs}: let one node publish one body")
        return next(iter(self._pairs), ("", ""))

    def track(self, rows: Rows) -> AttitudeTrack:
        """The track of rows that were read."""
        assert self._template is not None
        stamps, numbers = rows
        covariance = numbers[:, 4:].reshape(-1, 3, 3) if numbers.shape[1] > 4 else None
        return replace(self._template, stamps_ns=stamps, attitude_xyzw=numbers[:, :4], covariance=covariance)

    def fault(self, frames: Frames | None) -> str:
        """Reason, beginning with the topic, why no message has an attitude; empty if one has."""
        if self._template is not None:
            return ""
        if self._message_type == TF_MESSAGE and self._pairs:
            pairs = listed([f"{frame} to {child}" for frame, child in self._pairs])
            wanted = " to ".join(frames or ())
            return f"topic {self.topic} tells of {pairs}, none of which is {wanted}: name the frames so"
        return f"topic {self.topic} {NO_ORIENTATION}"
