"""An estimate and its truth as they come from topics: scored as from a bag, in memory that does not grow for ever."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import AttitudeError, Limits, Score, Truth, attitude_error
from lie_rigid_body.evaluation.estimate import GAP, period_ns
from lie_rigid_body.evaluation.tally import Tally
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.kept_estimate import LENIENCE_NS, MOST_KEPT, MOST_WAITING, Kept, KeptEstimate
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate, TrueMotion, held_against
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import listed

RECENT: Final = 40
"""Number of batches of poses by which the latest estimates are judged."""
INTERIM: Final = 2000
"""Number of samples of the score on the way."""


class HeardTruth:
    """Scenarios and poses that tell the truth, message by message.

    Parameters
    ----------
    most : int
        Largest number of poses that are kept.
    """

    def __init__(self, most: int) -> None:
        self._segments: dict[str, Segment] = {}
        self._poses, self._recent = Kept(most), deque[AttitudeTrack](maxlen=RECENT)
        self._frames: Frames | None = None

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
        for frames, track in attitudes_of(topic, message_type, payloads).items():
            self._frames = self._frames or frames
            if frames == self._frames:
                ordered = self._poses.add(track)
                self._recent += [ordered] if len(ordered) else []

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
        """The motion that the scenarios alone tell."""
        return TrueMotion(tuple(sorted(self._segments.values(), key=lambda segment: segment.start_ns)), None)

    def whole(self) -> TrueMotion:
        """The motion that all tells that is kept."""
        return replace(self.of_scenarios(), poses=self._poses.track() if self._poses.count else None)

    def recent(self, since_ns: int) -> TrueMotion:
        """The motion that the latest poses tell, without the segments that had ended at a time: each costs much."""
        true = self.of_scenarios()
        ended = sum(segment.start_ns <= since_ns for segment in true.segments[1:])
        return TrueMotion(true.segments[ended:], AttitudeTrack.joined(self._recent) if self._recent else None)


class LiveEstimate:
    """The truth and an estimate, message by message.

    Parameters
    ----------
    topic, message_type : str
        Of the estimate.
    limits : Limits
    most : int, optional
        Largest number of samples of each that are kept.
    duration_s : float, optional
        Time after the first estimate beyond which further ones are left out, whenever they are read, s.
    covariance_axes : str, optional
        ``"world"`` or ``"body"``.

    Attributes
    ----------
    truth : HeardTruth
    estimate : KeptEstimate
        What was read of the estimate and counts.
    messages : int
        Number of messages of the estimate that came.
    tally : Tally
        Of all estimates that were compared so far.
    """

    def __init__(
        self,
        topic: str,
        message_type: str,
        limits: Limits,
        most: int = MOST_KEPT,
        duration_s: float | None = None,
        covariance_axes: str = "world",
    ) -> None:
        self._limits, self._covariance_axes = limits, covariance_axes
        self.truth, self.tally = HeardTruth(most), Tally(limits)
        self._topic, self._message_type = topic, message_type
        self.messages = self._given_up = 0
        self._unread: list[bytes] = []
        self._pairs: dict[Frames, None] = {}
        self._has_attitudes = False
        self.estimate = KeptEstimate(most, duration_s)
        self._waiting: list[AttitudeTrack] = []

    @property
    def complete(self) -> bool:
        """Whether an estimate came that is stamped at the end of the duration, or later."""
        return self.estimate.duration.complete

    def hear_estimates(self, payloads: list[bytes]) -> None:
        """Take messages of the estimate; those that wait for a truth are no more than `MOST_WAITING`."""
        self.messages += len(payloads)
        self._unread += payloads
        excess = 0 if self.truth.is_known else max(0, len(self._unread) - MOST_WAITING)
        self._given_up += excess
        del self._unread[:excess]

    def _read(self, frames: Frames | None) -> list[AttitudeTrack]:
        """Read the messages that were not read yet, as one track if they have any attitude.

        Parameters
        ----------
        frames : tuple of str or None
            Names of the world's and the body's frame, where the truth tells them.

        Raises
        ------
        InputError
            If the messages are of several frames.
        """
        unread, self._unread = self._unread, []
        found = attitudes_of(self._topic, self._message_type, unread)
        self._pairs |= dict.fromkeys(found)
        chosen = self._chosen(frames)
        tracks = [track for pair, track in found.items() if pair == chosen and len(track)]
        self._has_attitudes |= bool(tracks)
        return tracks

    def _chosen(self, frames: Frames | None) -> Frames:
        """Frames of the estimate: of transforms those of the truth, else those of all messages."""
        if self._message_type == TF_MESSAGE and frames is not None:
            return frames
        if len(self._pairs) > 1:
            pairs = listed([" to ".join(filter(None, pair)) for pair in self._pairs])
            raise InputError(f"topic {self._topic} is of the frames {pairs}: let one node publish one body")
        return next(iter(self._pairs), ("", ""))

    def judge(self) -> tuple[Integers, AttitudeError] | None:
        """Compare the estimates that came before the last call, as far as their truth is known by now.

        Those that came since wait for the next call: a reset that they follow may be on its way.

        Returns
        -------
        tuple of ndarray and AttitudeError, or None
            Their stamps, ns, and errors, rad.
        """
        if not self.truth.is_known:
            return None
        read = self._read(self.truth.of_scenarios().frames)
        new = self.estimate.add(read, self.truth.begin_ns, self.truth.last_pose_ns)
        ready, self._waiting = self._waiting, [] if new is None else [new]
        if not ready:
            return None
        track = AttitudeTrack.joined(ready)
        stamps = track.stamps_ns
        truth = self._truth_of(self.truth.recent(int(stamps[0])), stamps, self.estimate.duration.first_ns)
        known = truth.covers(stamps)
        late = stamps > truth.last_ns  # whose truth may yet come
        if late.any():
            self._waiting.insert(0, track[late][-MOST_WAITING:])
        if not known.any():
            return None
        stamps = stamps[known]
        error = attitude_error(track.attitude_xyzw[known], truth.at(stamps))
        self.tally.add(stamps, error)
        return stamps, error

    def score(self, most: int | None = None) -> tuple[RecordedEstimate, Score]:
        """Score all that was heard.

        Parameters
        ----------
        most : int, optional
            A score on the way: of so many samples only, evenly spread over the second half of the time, as a filter
            converges at first.

        Returns
        -------
        tuple of RecordedEstimate and Score
            What was held against the truth, and its score.

        Raises
        ------
        InputError
            If there is no estimate, or no truth, or they do not go together.
        """
        if most is None:
            self.judge()
            self.judge()
            self.estimate.end(self.truth.begin_ns)
        read = self._held_against_truth(most)
        due_ns = self.estimate.duration.due_ns
        due_ns = read.truth.last_ns if due_ns is None else due_ns
        score = read.score(self._limits, self._covariance_axes, due_ns, bounded=most is None)
        if self.tally.count and (self.estimate.kept.stride > 1 or most is not None):
            score = self.tally.exact(score, self.estimate.kept.count + read.left_out, due_ns)
        return read, score

    def _held_against_truth(self, most: int | None) -> RecordedEstimate:
        if not self.truth.is_known:
            raise InputError(f"nothing tells the truth of {self._topic}: neither a scenario nor a pose came")
        if fault := self._fault(usable=self.estimate.kept.count > 0):
            raise InputError(fault)
        track = self.estimate.kept.track() if most is None else self._settled(most)
        scenarios = self.truth.of_scenarios()
        true = scenarios if most is not None and scenarios.segments else self.truth.whole()
        start = self.estimate.duration.first_ns if most is None else int(track.stamps_ns[0])
        read = held_against(track, true, self._truth_of(true, track.stamps_ns, start))
        return replace(read, notes=(*read.notes, *self._notes()), left_out=self.estimate.left_out)

    def _settled(self, most: int) -> AttitudeTrack:
        """Evenly spread estimates of the second half of the time, of a given number."""
        track = self.estimate.kept.track()
        stamps = track.stamps_ns
        settled = np.flatnonzero(stamps >= (stamps[0] + stamps[-1]) // 2)
        return track[settled[np.unique(np.linspace(0, len(settled) - 1, most).round().astype(np.int64))]]

    def _fault(self, *, usable: bool) -> str:
        """Reason why an estimate, of which attitudes are usable or not, cannot be compared; empty if there is none."""
        if self._has_attitudes:
            return "" if usable else f"topic {self._topic}: {self.estimate.fault()}"
        if self._message_type == TF_MESSAGE and self._pairs:
            pairs = listed([f"{frame} to {child}" for frame, child in self._pairs])
            wanted = " to ".join(self.truth.of_scenarios().frames or ())
            return f"topic {self._topic} tells of {pairs}, none of which is {wanted}: name the frames so"
        return f"topic {self._topic} {NO_ORIENTATION}"

    def why_not_compared(self) -> str:
        """Reason why no message of the estimate has an error, though the truth is known."""
        last_ns, pose_ns = self.estimate.last_ns, self.truth.last_pose_ns
        end = "on" if pose_ns is None else f"to {pose_ns / NS:.13g} s"
        return self._fault(usable=last_ns is not None) or (
            f"no attitude of {self._topic} is stamped within the truth, from {self.truth.begin_ns / NS:.13g} s "
            f"{end}; the last is at {(last_ns or 0) / NS:.13g} s: is it of the same clock and run?"
        )

    def _notes(self) -> Iterator[str]:
        yield from self.estimate.notes()
        if self._given_up:
            yield f"{self._given_up} estimates came before any truth, and are left out."
        kept = self.estimate.kept
        if kept.stride > 1:
            yield (
                f"One in {kept.stride} of {kept.count} estimates was kept for the score. RMS, largest error and limits "
                f"are of all {self.tally.count} that could be compared; gaps below {2.5 * kept.stride:g} samples "
                "are not seen."
            )

    def _truth_of(self, true: TrueMotion, stamps: Integers, start_ns: int | None) -> Truth:
        """The truth from a stamp on: that of a scenario is known also where no pose was heard yet."""
        end, due_ns = int(stamps[-1]), self.estimate.duration.due_ns
        truth = true.until(end)
        if true.segments:
            truth.first_ns = true.segments[0].start_ns
        if start_ns is not None and truth.first_ns < start_ns <= truth.last_ns:
            truth.first_ns = start_ns
        if due_ns is not None:
            truth.last_ns = min(truth.last_ns, max(due_ns, truth.first_ns))
        if true.segments and truth.last_ns < end <= truth.last_ns + LENIENCE_NS:
            truth.last_ns = end
        elif end <= truth.last_ns <= end + LENIENCE_NS:  # what is on its way through the filter is no gap
            truth.last_ns = min(truth.last_ns, end + int(GAP * period_ns(stamps)))
        return truth
