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
from lie_rigid_body.evaluation.attitudes import GAP, period_ns
from lie_rigid_body.evaluation.score import Tally
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.kept_attitudes import DISORDERED, LENIENCE_NS, MOST_KEPT, OF_OTHERS, STRAY, KeptAttitudes
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate, TrueMotion, held_against
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import listed

RECENT: Final = 40
"""Number of batches of poses by which the latest estimates are judged."""
MOST_WAITING: Final = 50_000
"""Largest number of estimates that wait for a truth; of more the oldest are given up."""
OTHERS_SHARE: Final = 0.1
"""Share of estimates of other frames from which on it is not clear which body is meant."""
INTERIM: Final = 2000
"""Number of samples of the score on the way."""


class HeardTruth:
    """Scenarios and poses that tell the truth, message by message.

    Parameters
    ----------
    most : int
        Largest number of poses that are kept.

    Attributes
    ----------
    poses : KeptAttitudes
    contradictions : int
        Number of scenarios that were left out, as another one had begun at the same stamp.
    """

    def __init__(self, most: int) -> None:
        self.poses, self.contradictions = KeptAttitudes(most), 0
        self._segments: dict[int, Segment] = {}
        self._recent = deque[AttitudeTrack](maxlen=RECENT)

    def hear_scenarios(self, payloads: list[bytes]) -> None:
        """Take latched scenarios; a reset sends another.

        Raises
        ------
        InputError
            If a text is no scenario: then none is taken.
        """
        for segment in [Segment.from_json(decode_string(payload)) for payload in payloads]:
            self.contradictions += self._segments.setdefault(segment.start_ns, segment) != segment

    def hear_poses(self, topic: str, message_type: str, payloads: list[bytes]) -> None:
        """Take messages of poses.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        for track in self.poses.of_one_body(attitudes_of(topic, message_type, payloads)):
            self._recent.append(self.poses.add(track))

    @property
    def is_known(self) -> bool:
        """Whether a scenario or a pose was heard."""
        return bool(self._segments) or self.poses.count > 0

    @property
    def begin_ns(self) -> int:
        """Start of the first scenario, or without one the stamp of the first pose, ns."""
        return min(self._segments, default=self.poses.duration.first_ns or 0)

    @property
    def frames(self) -> Frames | None:
        """Names of the world's and the body's frame, if a scenario tells them."""
        return TrueMotion(tuple(self._segments.values()), None).frames

    def between(self, first_ns: int, last_ns: int, *, recent: bool = False, poses: bool = True) -> TrueMotion:
        """The motion that is told from one stamp to another, ns, by the latest poses, all that are kept, or none."""
        heard = list(self._recent) if recent else [self.poses.track()] if poses and self.poses.count else []
        known = AttitudeTrack.joined(heard) if heard else None
        if known is not None and len(known):
            first_ns, last_ns = min(first_ns, int(known.stamps_ns[0])), max(last_ns, int(known.stamps_ns[-1]))
        starts = sorted(self._segments)
        begin, end = np.searchsorted(starts, [first_ns, last_ns], side="right")
        segments = tuple(self._segments[start] for start in starts[max(begin - 1, 0) : max(end, 1)])
        return TrueMotion(segments, known if known is not None and len(known) else None)


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
        self.estimate = KeptAttitudes(most, duration_s)
        self._unread = deque[dict[Frames, AttitudeTrack]]()
        self._waiting: list[AttitudeTrack] = []

    @property
    def complete(self) -> bool:
        """Whether an estimate came that is stamped at the end of the duration, or later."""
        return self.estimate.duration.complete

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
        wanted = self.truth.frames if self._message_type == TF_MESSAGE else None
        while self._unread:
            for read in self.estimate.of_one_body(self._unread.popleft(), wanted):
                new = self.estimate.add(read, self.truth.begin_ns)
                self._waiting += [new] if len(new) else []
        if not ready:
            return None
        track = AttitudeTrack.joined(ready)
        stamps = track.stamps_ns
        true = self.truth.between(int(stamps[0]), int(stamps[-1]), recent=True)
        truth = self._truth_of(true, stamps, self.estimate.duration.first_ns)
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
            self.truth.poses.end()
        read = self._held_against_truth(most)
        due_ns = self.estimate.duration.due_ns
        due_ns = read.truth.last_ns if due_ns is None else due_ns
        score = read.score(self._limits, self._covariance_axes, due_ns, bounded=most is None)
        if self.tally.count and (self.estimate.stride > 1 or most is not None):
            score = self.tally.exact(score, self.estimate.count + read.left_out, due_ns)
        return read, score

    def _held_against_truth(self, most: int | None) -> RecordedEstimate:
        if not self.truth.is_known:
            raise InputError(f"nothing tells the truth of {self._topic}: neither a scenario nor a pose came")
        if fault := self._fault(usable=self.estimate.count > 0):
            raise InputError(fault)
        track = self.estimate.track() if most is None else self._settled(most)
        times = int(track.stamps_ns[0]), int(track.stamps_ns[-1])
        true = self.truth.between(*times, poses=most is None or self.truth.frames is None)
        start = self.estimate.duration.first_ns if most is None else times[0]
        read = held_against(track, true, self._truth_of(true, track.stamps_ns, start))
        left_out = self.estimate.number_of(STRAY, DISORDERED)
        return replace(read, notes=(*read.notes, *self._notes()), left_out=left_out)

    def _settled(self, most: int) -> AttitudeTrack:
        """Evenly spread estimates of the second half of the time, of a given number."""
        track = self.estimate.track()
        stamps = track.stamps_ns
        settled = np.flatnonzero(stamps >= (stamps[0] + stamps[-1]) // 2)
        return track[settled[np.unique(np.linspace(0, len(settled) - 1, most).round().astype(np.int64))]]

    def _fault(self, *, usable: bool) -> str:
        """Reason why an estimate, of which attitudes are usable or not, cannot be compared; empty if there is none."""
        frames, followed = self.estimate.frames, self.estimate.followed
        pairs = listed([" to ".join(filter(None, pair)) for pair in frames])
        if self._message_type == TF_MESSAGE and frames and not frames.get(followed or ("", "")):
            wanted = " to ".join(followed or ())
            return f"topic {self._topic} tells of {pairs}, none of which is {wanted}: name the frames so"
        if not any(frames.values()):
            return f"topic {self._topic} {NO_ORIENTATION}"
        if self.estimate.number_of(OF_OTHERS) > OTHERS_SHARE * self.estimate.count:
            return f"topic {self._topic} is of the frames {pairs}: let one node publish one body"
        return "" if usable else f"topic {self._topic}: {'; '.join(self.estimate.notes('estimates').values())}"

    def why_not_compared(self) -> str:
        """Reason why no message of the estimate has an error, though the truth is known."""
        last_ns, pose_ns = self.estimate.last_ns, self.truth.poses.last_ns
        end = "on" if pose_ns is None else f"to {pose_ns / NS:.13g} s"
        return self._fault(usable=self.estimate.count > 0) or (
            f"no attitude of {self._topic} is stamped within the truth, from {self.truth.begin_ns / NS:.13g} s "
            f"{end}; the last is at {(last_ns or 0) / NS:.13g} s: is it of the same clock and run?"
        )

    def left_out(self) -> dict[str, str]:
        """Sentences, without a full stop, about the messages that count for nothing, by their kinds."""
        poses = self.truth.poses.notes("poses of the truth")
        found = {**self.estimate.notes("estimates"), **{f"pose {kind}": told for kind, told in poses.items()}}
        if self.truth.contradictions:
            found["contradiction"] = (
                f"{self.truth.contradictions} scenarios begin when another one does that came before, and are left "
                "out: let one node tell the truth"
            )
        return found

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


def _size(found: dict[Frames, AttitudeTrack]) -> int:
    """Number of the attitudes of all frames."""
    return sum(map(len, found.values()))
