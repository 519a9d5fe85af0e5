"""An estimate and its truth as they come from topics, kept whole and scored as from a bag."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Final

import numpy as np

from lie_rigid_body.estimates.buffers import (
    DISORDERED,
    MAX_SAMPLES,
    AttitudeBuffer,
    BiasBuffer,
    left_out_sentence,
    notes_on_left_out,
    usable,
)
from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
from lie_rigid_body.evaluation import AttitudeError, Limits, Score, Truth, attitude_error
from lie_rigid_body.evaluation.attitudes import GAP_PERIODS, period_ns
from lie_rigid_body.evaluation.matched import spread
from lie_rigid_body.evaluation.statistics import Tally
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS, exact_duration
from lie_rigid_body.foundation.wording import counted, listed
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.recording.segments import MAX_SEGMENTS
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.true_motion import TrueMotion
from lie_rigid_body.simulation import Segment

RECENT: Final = 40
"""Number of batches of poses by which the latest estimates are judged."""
MAX_WAITING: Final = 50_000
"""Largest number of estimates that wait for a later truth; beyond it the oldest have no error on the way."""
MAX_SHARE_OF_OTHERS: Final = 0.1
"""Share of estimates in other frames from which on it is not clear which body is meant."""
INTERIM: Final = 2000
"""Number of samples in a score that is computed while messages still come."""


class TruthBuffer:
    """Scenarios and poses that tell the truth, message by message.

    Attributes
    ----------
    poses : AttitudeBuffer
    recent : deque of AttitudeTrack
        The latest poses.
    segments : dict of int to Segment
        By their starts, ns.
    reached_ns : int
        The latest stamp of a pose, or of an estimate that was compared, ns.
    left_out : int
        Number of scenarios that were left out, as samples had followed another one that begins at the same stamp, or as
        there were `MAX_SEGMENTS` before.
    gyro_bias : BiasBuffer
        Of the gyro's readings.
    """

    def __init__(self) -> None:
        self.poses = AttitudeBuffer()
        self.gyro_bias = BiasBuffer()
        self.recent = deque[AttitudeTrack](maxlen=RECENT)
        self.segments: dict[int, Segment] = {}
        self.reached_ns = 0
        self.left_out = 0

    def hear_scenarios(self, payloads: list[bytes]) -> None:
        """Take latched scenarios; a reset sends another, which may begin at once after one without a sample.

        Raises
        ------
        InputError
            If a text is no scenario: then none is taken.
        """
        for segment in [Segment.from_json(decode_string(payload)) for payload in payloads]:
            known = self.segments.get(segment.start_ns)
            is_new = known is None and len(self.segments) < MAX_SEGMENTS
            if is_new or known == segment or (known and self.reached_ns < segment.start_ns + NS):
                self.segments[segment.start_ns] = segment
            else:
                self.left_out += 1

    def hear_poses(self, topic: str, message_type: str, payloads: list[bytes]) -> None:
        """Take messages of poses.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        self.poses.add(attitudes_of(topic, message_type, payloads))
        self.recent += (track[usable(track)] for track in self.poses.take())
        self.reached_ns = max(self.reached_ns, self.poses.last_ns or 0)

    @property
    def fault(self) -> str:
        """Sentence, without a full stop, about scenarios that are left out; empty where none is."""
        why = (
            f"as they contradict one that came before, or come after {MAX_SEGMENTS} others: let one node tell the truth"
        )
        return f"{counted(self.left_out, 'scenario')} left out, {why}" if self.left_out else ""

    @property
    def is_known(self) -> bool:
        """Whether a scenario or a pose was heard."""
        return bool(self.segments) or self.poses.count > 0

    @property
    def begin_ns(self) -> int:
        """Start of the first scenario, or without one the stamp of the first pose, ns."""
        return min(self.segments, default=self.poses.first_ns or 0)

    def motion(self, stamps_ns: Integers, poses: Iterable[AttitudeTrack]) -> TrueMotion:
        """Declared motion at some stamps, ns: the scenarios in that time, and poses."""
        tracks = [track for track in poses if len(track)]
        known = AttitudeTrack.joined(tracks) if tracks else None
        times = [*stamps_ns[[0, -1]].tolist(), *([] if known is None else known.stamps_ns[[0, -1]].tolist())]
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
    duration_s : float, optional
        Time after the first estimate beyond which further ones are left out, whenever they are read, s.
    covariance_axes : str, optional
        ``"world"`` or ``"body"``.

    Raises
    ------
    InputError
        If the duration is no time.

    Attributes
    ----------
    truth : TruthBuffer
    estimate : AttitudeBuffer
    messages : int
        Number of messages of the estimate that came.
    gyro_bias : BiasBuffer
        Estimates of the gyro's bias.
    tally : Tally
        Of all estimates that were compared so far.
    """

    def __init__(
        self,
        topic: str,
        message_type: str,
        limits: Limits,
        duration_s: float | None = None,
        covariance_axes: str = "world",
    ) -> None:
        self._topic = topic
        self._message_type = message_type
        self._limits = limits
        self._length_ns = None if duration_s is None else round(exact_duration(duration_s, "duration", "60.0") * NS)
        self._covariance_axes = covariance_axes
        self.truth = TruthBuffer()
        self.estimate = AttitudeBuffer()
        self.gyro_bias = BiasBuffer()
        self.tally = Tally(limits)
        self.messages = 0
        self._waiting: list[AttitudeTrack] = []

    def hear_estimates(self, payloads: list[bytes]) -> None:
        """Take messages of the estimate.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        if self._message_type == TF_MESSAGE and self.truth.segments:
            self.estimate.wanted = TrueMotion(tuple(self.truth.segments.values()), None).frames
        self.estimate.add(attitudes_of(self._topic, self._message_type, payloads))
        self.messages += len(payloads)

    @property
    def is_full(self) -> bool:
        """Whether there are as many estimates or poses as a score takes."""
        return max(self.estimate.count, self.truth.poses.count) >= MAX_SAMPLES

    @property
    def is_complete(self) -> bool:
        """Whether the score can be made: the duration is over, or `is_full`."""
        span_ns = (self.estimate.last_ns or 0) - (self.estimate.first_ns or 0)
        if self._length_ns is None or span_ns < self._length_ns:
            return self.is_full
        stamps = self.estimate.scorable()[0].stamps_ns  # without those that leap far away
        return self.is_full or bool(len(stamps) and stamps[-1] >= self._due_ns(stamps))

    def _due_ns(self, stamps_ns: Integers) -> int:
        """Stamp until which estimates are due, ns: where they have a duration, it begins with the truth."""
        begin = int(np.searchsorted(stamps_ns, self.truth.begin_ns - NS))
        first_ns = int(stamps_ns[begin if begin < len(stamps_ns) else 0])
        return 2**63 - 1 if self._length_ns is None else first_ns + self._length_ns

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
        ready = self._waiting
        self._waiting = [track[usable(track)] for track in self.estimate.take()]
        if not sum(map(len, ready)):
            return None
        track = AttitudeTrack.joined(ready)
        _, truth = self._true(track.stamps_ns, self.truth.recent)
        late = track.stamps_ns > truth.last_ns  # whose truth may yet come
        self._waiting.insert(0, track[late][-MAX_WAITING:])
        track = track[truth.covers(track.stamps_ns)]
        if not len(track):
            return None
        error = attitude_error(track.attitude_xyzw, truth.at(track.stamps_ns))
        self.tally.add(track.stamps_ns, error)
        self.truth.reached_ns = max(self.truth.reached_ns, int(track.stamps_ns[-1]))
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
        if not self.truth.is_known:
            raise InputError(f"nothing tells the truth of {self._topic}: neither a scenario nor a pose came")
        track, left_out = self._scorable()
        notes = notes_on_left_out(left_out, len(track), "estimates")
        due_ns = self._due_ns(track.stamps_ns)
        track = track[track.stamps_ns <= due_ns]
        if most is not None:
            settled = np.flatnonzero(track.stamps_ns >= (track.stamps_ns[0] + track.stamps_ns[-1]) // 2)
            track = track[settled[spread(len(settled), most)]]
        poses: list[AttitudeTrack] = []
        if self.truth.poses.count and (most is None or not self.truth.segments):
            found, lost = self.truth.poses.scorable()
            notes += notes_on_left_out(lost, len(found), "poses of the truth")
            poses.append(found)
        motion, truth = self._true(track.stamps_ns, poses)
        if motion.poses is None and not self.truth.poses.count:
            motion.require_same_clock(int(track.stamps_ns[0]))
        truth = self._asked_of(track.stamps_ns, truth, due_ns)
        bias = self.gyro_bias.beside(self.truth.gyro_bias, *track.stamps_ns[[0, -1]].tolist())
        told = [*motion.notes_on(track), *(f"{note}." for note in (*notes, self.truth.fault) if note)]
        if self.gyro_bias.topic:
            told += self.gyro_bias.notes
        if bias is None and self.gyro_bias.topic:
            told.append(f"The biases on {self.gyro_bias.topic} have no score: no true ones came beside them.")
        if self.is_full:
            told.append(f"The score ends with {MAX_SAMPLES} attitudes, as many as are kept.")
        read = RecordedEstimate(track, motion, truth, tuple(told), len(left_out[DISORDERED]), bias)
        until_ns = truth.last_ns if self._length_ns is None or most is not None else due_ns
        return read, read.score(self._limits, self._covariance_axes, until_ns, bounded=most is None)

    def _scorable(self) -> tuple[AttitudeTrack, dict[str, Integers]]:
        """Estimates that a score can use, and the stamps of the others, ns; see `AttitudeBuffer.scorable`.

        Raises
        ------
        InputError
            If there is none, or it is not clear which body they are of.
        """
        frames = self.estimate.frames
        pairs = listed([" to ".join(filter(None, pair)) for pair in frames])
        count = self.estimate.count
        if self.estimate.wanted and frames and not count:
            name = " to ".join(self.estimate.wanted)
            raise InputError(f"topic {self._topic} tells of {pairs}, none of which is {name}: name the frames so")
        if not count:
            raise InputError(f"topic {self._topic} {NO_ORIENTATION}")
        if not self.estimate.wanted and frames.total() - count > MAX_SHARE_OF_OTHERS * count:
            raise InputError(f"topic {self._topic} is of the frames {pairs}: let one node publish one body")
        track, left_out = self.estimate.scorable()
        if not len(track):
            raise InputError(f"topic {self._topic}: {'; '.join(notes_on_left_out(left_out, 0, 'estimates'))}")
        return track, left_out

    def why_not_compared(self) -> str:
        """Reason why no message of the estimate has an error, though the truth is known."""
        try:
            track, _ = self._scorable()
        except InputError as error:
            return str(error)
        last_ns = self.truth.poses.last_ns
        end = "on" if last_ns is None else f"to {last_ns / NS:.13g} s"
        return (
            f"no attitude of {self._topic} is stamped within the truth, from {self.truth.begin_ns / NS:.13g} s "
            f"{end}; the last is at {track.stamps_ns[-1] / NS:.13g} s: is it of the same clock and run?"
        )

    def left_out(self) -> dict[str, str]:
        """Sentences, without a full stop, about messages that count for nothing, by the reason."""
        return {
            **{reason: left_out_sentence(reason, "some estimates") for reason in self.estimate.faults},
            **{f"pose {r}": left_out_sentence(r, "some poses of the truth") for r in self.truth.poses.faults},
            **({"scenarios": fault} if (fault := self.truth.fault) else {}),
        }

    def _true(self, stamps_ns: Integers, poses: Iterable[AttitudeTrack]) -> tuple[TrueMotion, Truth]:
        """Declared motion and truth for some stamps; a scenario tells it for a second before the poses come."""
        motion = self.truth.motion(stamps_ns, poses)
        end_ns = int(stamps_ns[-1])
        truth = motion.until(end_ns)
        if motion.segments:
            last_ns = max(truth.last_ns, min(end_ns, truth.last_ns + NS))
            truth = truth.between(motion.segments[0].start_ns, last_ns)
        return motion, truth

    def _asked_of(self, stamps_ns: Integers, truth: Truth, due_ns: int) -> Truth:
        """Truth of the time in which estimates are due: from the first on, until the last that can have come."""
        inside = stamps_ns[(stamps_ns >= truth.first_ns) & (stamps_ns <= truth.last_ns)]
        first_ns = int(inside[0]) if len(inside) else truth.first_ns
        end_ns = int(stamps_ns[-1])
        last_ns = min(truth.last_ns, due_ns)
        if end_ns <= last_ns <= end_ns + NS:  # what is on its way through the filter is no gap
            last_ns = min(last_ns, end_ns + int(GAP_PERIODS * period_ns(stamps_ns)))
        return truth.between(first_ns, max(last_ns, first_ns))
