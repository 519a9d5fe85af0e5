"""An estimate and its truth as they come from topics: scored as from a bag, in memory that does not grow for ever."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

import numpy as np

from lie_rigid_body.estimates.kept import (
    DISORDERED,
    LENIENCE_NS,
    MOST_KEPT,
    OF_OTHERS,
    STRAY,
    KeptAttitudes,
    KeptBiases,
)
from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
from lie_rigid_body.evaluation import AttitudeError, Limits, Score, Truth, attitude_error
from lie_rigid_body.evaluation.attitudes import GAP_PERIODS, period_ns
from lie_rigid_body.evaluation.statistics import Tally
from lie_rigid_body.evaluation.track import spread
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.decoding import Frames
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.recording.segments import MOST_SEGMENTS
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.truth import TrueMotion
from lie_rigid_body.simulation import Segment

RECENT: Final = 40
"""Number of batches of poses by which the latest estimates are judged."""
MOST_WAITING: Final = 50_000
"""Largest number of estimates that wait for a truth; beyond it the oldest are dropped."""
OTHERS_SHARE: Final = 0.1
"""Share of estimates in other frames from which on it is not clear which body is meant."""
INTERIM: Final = 2000
"""Number of samples in a score that is computed while messages still come."""


class HeardTruth:
    """Scenarios and poses that tell the truth, message by message.

    Parameters
    ----------
    most : int
        Largest number of poses that are kept.

    Attributes
    ----------
    poses : KeptAttitudes
    recent : deque of AttitudeTrack
        The latest poses.
    segments : dict of int to Segment
        By their starts, ns.
    reached_ns : int
        The latest stamp of a pose, or of an estimate that was read, ns.
    contradictions : int
        Number of scenarios that were left out, as samples had followed another one that begins at the same stamp.
    beyond : int
        Number of scenarios that were left out, as there were `MOST_SEGMENTS` before.
    gyro_bias : KeptBiases
        Of the gyro's readings.
    """

    def __init__(self, most: int) -> None:
        self.poses, self.reached_ns, self.contradictions, self.beyond = KeptAttitudes(most), 0, 0, 0
        self.gyro_bias = KeptBiases(most)
        self.recent = deque[AttitudeTrack](maxlen=RECENT)
        self.segments: dict[int, Segment] = {}

    def hear_scenarios(self, payloads: list[bytes]) -> None:
        """Take latched scenarios; a reset sends another, which may begin at once after one without a sample.

        Raises
        ------
        InputError
            If a text is no scenario: then none is taken.
        """
        for segment in [Segment.from_json(decode_string(payload)) for payload in payloads]:
            known = self.segments.get(segment.start_ns)
            if known is None and len(self.segments) == MOST_SEGMENTS:
                self.beyond += 1
            elif known in (None, segment) or self.reached_ns < segment.start_ns + NS:
                self.segments[segment.start_ns] = segment
            else:
                self.contradictions += 1

    def hear_poses(self, topic: str, message_type: str, payloads: list[bytes]) -> None:
        """Take messages of poses.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        tracks = self.poses.of_one_body(attitudes_of(topic, message_type, payloads))
        self.recent += filter(len, map(self.poses.add, tracks))
        self.reached_ns = max(self.reached_ns, self.poses.last_ns or 0)

    @property
    def is_known(self) -> bool:
        """Whether a scenario or a pose was heard."""
        return bool(self.segments) or self.poses.count > 0

    @property
    def begin_ns(self) -> int:
        """Start of the first scenario, or without one the stamp of the first pose, ns."""
        return min(self.segments, default=self.poses.first_ns or 0)

    def between(self, first_ns: int, last_ns: int, poses: Iterable[AttitudeTrack]) -> TrueMotion:
        """Declared motion from one stamp to another, ns: the scenarios in that time, and the poses."""
        tracks = [track for track in poses if len(track)]
        known = AttitudeTrack.joined(tracks) if tracks else None
        times = [first_ns, last_ns, *([] if known is None else known.stamps_ns[[0, -1]].tolist())]
        starts = sorted(self.segments)
        begin, end = np.searchsorted(starts, [min(times), max(times)], side="right")
        return TrueMotion(tuple(self.segments[start] for start in starts[max(begin - 1, 0) : max(end, 1)]), known)


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
    estimate : KeptAttitudes
        What was read of the estimate and counts.
    messages : int
        Number of messages of the estimate that came.
    gyro_bias : KeptBiases
        Estimates of the gyro's bias.
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
        self.estimate, self.gyro_bias = KeptAttitudes(most, duration_s), KeptBiases(most)
        self._unread = deque[Mapping[Frames, AttitudeTrack]]()
        self._waiting: list[AttitudeTrack] = []

    def hear_estimates(self, payloads: list[bytes]) -> None:
        """Take messages of the estimate; those that wait for a truth are no more than `MOST_WAITING`.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        self._unread.append(attitudes_of(self._topic, self._message_type, payloads))
        self.messages += len(payloads)
        while not self.truth.is_known and sum(map(_size, self._unread)) > MOST_WAITING:
            self._given_up += _size(self._unread.popleft())

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
        ready, self._waiting = self._waiting, []
        wanted = self.truth.between(0, 0, ()).frames if self._message_type == TF_MESSAGE else None
        while self._unread:
            for read in self.estimate.of_one_body(self._unread.popleft(), wanted):
                self._waiting.append(self.estimate.add(read, self.truth.begin_ns))
        self.truth.reached_ns = max(self.truth.reached_ns, self.estimate.last_ns or 0)
        track = AttitudeTrack.joined(ready) if ready else None
        if track is None or not len(track):
            return None
        _, truth = self._true(track.stamps_ns, self.truth.recent, self.estimate.first_ns)
        late = track.stamps_ns > truth.last_ns  # whose truth may yet come
        self._waiting.insert(0, track[late][-MOST_WAITING:])
        track = track[truth.covers(track.stamps_ns)]
        if not len(track):
            return None
        error = attitude_error(track.attitude_xyzw, truth.at(track.stamps_ns))
        self.tally.add(track.stamps_ns, error)
        return track.stamps_ns, error

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
        kept, poses = self.estimate, self.truth.poses
        if most is None:
            self.judge()
            self.judge()
            poses.end()
            kept.end(self.truth.begin_ns, poses.last_ns)
        if not self.truth.is_known:
            raise InputError(f"nothing tells the truth of {self._topic}: neither a scenario nor a pose came")
        if fault := self._fault():
            raise InputError(fault)
        track, start_ns = kept.track(), kept.first_ns
        if most is not None:
            settled = np.flatnonzero(track.stamps_ns >= (track.stamps_ns[0] + track.stamps_ns[-1]) // 2)
            track = track[settled[spread(len(settled), most)]]
            start_ns = int(track.stamps_ns[0])
        by_poses = poses.count and (most is None or not self.truth.segments)
        motion, truth = self._true(track.stamps_ns, [poses.track()] if by_poses else [], start_ns)
        bias = self.gyro_bias.beside(self.truth.gyro_bias, *track.stamps_ns[[0, -1]].tolist())
        notes = (*motion.notes_on(track), *self._notes(), *self.gyro_bias.notes)
        if bias is None and self.gyro_bias.topic:
            notes = (*notes, f"The biases on {self.gyro_bias.topic} have no score: no true ones came beside them.")
        read = RecordedEstimate(track, motion, truth, notes, kept.number_of(STRAY, DISORDERED), bias)
        due_ns = truth.last_ns if kept.due_ns is None or most is not None else kept.due_ns
        score = read.score(self._limits, self._covariance_axes, due_ns, bounded=most is None)
        if self.tally.count and (kept.stride > 1 or most is not None):
            score = score.of_all(self.tally, kept.count + read.left_out, due_ns)
        return read, score

    def _fault(self) -> str:
        """Reason why the estimate cannot be compared; empty if there is none."""
        frames, followed = self.estimate.frames, self.estimate.followed
        pairs = listed([" to ".join(filter(None, pair)) for pair in frames])
        if self._message_type == TF_MESSAGE and frames and not frames.get(followed or ("", "")):
            return (
                f"topic {self._topic} tells of {pairs}, none of which is {' to '.join(followed or ())}: name the "
                "frames so"
            )
        if not any(frames.values()):
            return f"topic {self._topic} {NO_ORIENTATION}"
        if self.estimate.number_of(OF_OTHERS) > OTHERS_SHARE * self.estimate.count:
            return f"topic {self._topic} is of the frames {pairs}: let one node publish one body"
        told = "; ".join(self.estimate.notes("estimates").values())
        return "" if self.estimate.count else f"topic {self._topic}: {told}"

    def why_not_compared(self) -> str:
        """Reason why no message of the estimate has an error, though the truth is known."""
        last_ns, pose_ns = self.estimate.last_ns, self.truth.poses.last_ns
        end = "on" if pose_ns is None else f"to {pose_ns / NS:.13g} s"
        return self._fault() or (
            f"no attitude of {self._topic} is stamped within the truth, from {self.truth.begin_ns / NS:.13g} s "
            f"{end}; the last is at {(last_ns or 0) / NS:.13g} s: is it of the same clock and run?"
        )

    def left_out(self) -> dict[str, str]:
        """Sentences, without a full stop, about the messages that count for nothing, by their kinds."""
        poses = self.truth.poses.notes("poses of the truth")
        scenarios = {
            "contradiction": (self.truth.contradictions, "begin when another one does that came before"),
            "beyond": (self.truth.beyond, f"came after {MOST_SEGMENTS} others"),
        }
        return {
            **self.estimate.notes("estimates"),
            **{f"pose {kind}": told for kind, told in poses.items()},
            **{
                kind: f"{count} scenarios {what}, and are left out: let one node tell the truth"
                for kind, (count, what) in scenarios.items()
                if count
            },
        }

    def _notes(self) -> Iterator[str]:
        yield from (f"{told}." for told in self.left_out().values())
        if self._given_up:
            yield f"{self._given_up} estimates came before any truth, and are left out."
        kept = self.estimate
        if kept.stride > 1:
            yield (
                f"One in {kept.stride} of {kept.count} estimates was kept for the score. RMS, largest error and limits "
                f"are of all {self.tally.count} that could be compared; gaps below {2.5 * kept.stride:g} samples "
                "are not seen."
            )

    def _true(self, stamps: Integers, poses: Iterable[AttitudeTrack], start_ns: int | None) -> tuple[TrueMotion, Truth]:
        """Declared motion for some stamps, and the truth from a stamp on; a scenario tells it before the poses come."""
        end, due_ns = int(stamps[-1]), self.estimate.due_ns
        motion = self.truth.between(int(stamps[0]), end, poses)
        truth = motion.until(end)
        if motion.segments:
            truth.first_ns = motion.segments[0].start_ns
        if start_ns is not None and truth.first_ns < start_ns <= truth.last_ns:
            truth.first_ns = start_ns
        if due_ns is not None:
            truth.last_ns = min(truth.last_ns, max(due_ns, truth.first_ns))
        if motion.segments and truth.last_ns < end <= truth.last_ns + LENIENCE_NS:
            truth.last_ns = end
        elif end <= truth.last_ns <= end + LENIENCE_NS:  # what is on its way through the filter is no gap
            truth.last_ns = min(truth.last_ns, end + int(GAP_PERIODS * period_ns(stamps)))
        return motion, truth


def _size(found: Mapping[Frames, AttitudeTrack]) -> int:
    """Number of the attitudes of all frames."""
    return sum(map(len, found.values()))
