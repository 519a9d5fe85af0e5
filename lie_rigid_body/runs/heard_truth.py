"""The truth as it comes from topics: scenarios, poses, or both."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Final

from lie_rigid_body.messages import decode_string
from lie_rigid_body.recording.attitude_reader import AttitudeTrack, attitudes_of
from lie_rigid_body.runs.kept import Kept, Rows, joined
from lie_rigid_body.runs.recorded_estimate import TrueMotion
from lie_rigid_body.simulation import Segment

MOST_WAITING: Final = 50_000
"""Largest number of estimates that wait for a truth; of more the oldest are given up."""
RECENT: Final = 40
"""Number of the latest batches of poses by which the latest estimates are judged."""


class HeardTruth:
    """Truth as messages tell it, one after the other.

    Parameters
    ----------
    most : int
        Poses that are kept.
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
            If it is none.
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

    def of_scenarios(self) -> TrueMotion:
        """Motion by the scenarios alone."""
        return TrueMotion(tuple(sorted(self._segments.values(), key=lambda segment: segment.start_ns)), None)

    def whole(self) -> TrueMotion:
        """Motion by all poses that are kept."""
        return self._with(self._poses.rows()) if self._poses.count else self.of_scenarios()

    def recent(self, since_ns: int) -> TrueMotion:
        """Motion by the latest poses, without segments that had ended at a time: each costs as much as many samples."""
        true = self._with(joined(self._recent)) if self._recent else self.of_scenarios()
        ended = sum(segment.start_ns <= since_ns for segment in true.segments[1:])
        return replace(true, segments=true.segments[ended:])

    def _with(self, poses: Rows) -> TrueMotion:
        assert self._template is not None
        track = replace(self._template, stamps_ns=poses[0], attitude_xyzw=poses[1], covariance=None)
        return replace(self.of_scenarios(), poses=track)
