"""An estimate and its truth as they come from topics: scored as from a bag, in memory that does not grow for ever."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import AttitudeError, Limits, Score, Truth, attitude_error
from lie_rigid_body.evaluation.estimate import GAP, period_ns
from lie_rigid_body.evaluation.tally import Tally
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.attitude_reader import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.heard_truth import MOST_WAITING, HeardTruth
from lie_rigid_body.runs.kept import MOST_KEPT, Rows, joined
from lie_rigid_body.runs.kept_estimate import KeptEstimate
from lie_rigid_body.runs.recorded_estimate import LENIENCE_NS, RecordedEstimate, TrueMotion, held_against
from lie_rigid_body.wording import listed

INTERIM: Final = 2000
"""Samples of the score on the way."""


class LiveEstimate:
    """The truth and an estimate, message by message.

    Parameters
    ----------
    topic, message_type : str
        Of the estimate.
    limits : Limits
    most : int, optional
        Samples of each that are kept.
    duration_s : float, optional
        Estimates that are stamped longer after the first are left out, whenever they are read.
    covariance_axes : str, optional
        ``"world"`` or ``"body"``.

    Attributes
    ----------
    truth : HeardTruth
    estimate : KeptEstimate
        What was read of the estimate and counts.
    messages : int
        How many messages of the estimate came.
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
        self._topic, self._message_type = topic, message_type
        self._limits, self._covariance_axes = limits, covariance_axes
        self.truth, self.tally = HeardTruth(most), Tally(limits)
        self.estimate = KeptEstimate(self.truth, most, duration_s)
        self.messages = self._given_up = 0
        self._unread: list[bytes] = []
        self._waiting: list[Rows] = []
        self._pairs: dict[Frames, None] = {}
        self._template: AttitudeTrack | None = None

    def hear_estimates(self, payloads: list[bytes]) -> None:
        """Take messages of the estimate."""
        self.messages += len(payloads)
        self._unread += payloads
        excess = len(self._unread) - MOST_WAITING
        if excess > 0 and not self.truth.is_known:
            del self._unread[:excess]
            self._given_up += excess

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
        new = self.estimate.add(self._read())
        ready, self._waiting = self._waiting, [] if new is None else [new]
        if not ready:
            return None
        stamps, numbers = joined(ready)
        truth = self._truth_of(self.truth.recent(int(stamps[0])), stamps)
        known = truth.covers(stamps)
        late = stamps > truth.last_ns  # whose truth may yet come
        if late.any():
            self._waiting.insert(0, (stamps[late][-MOST_WAITING:], numbers[late][-MOST_WAITING:]))
        if not known.any():
            return None
        stamps = stamps[known]
        error = attitude_error(numbers[known, :4], truth.at(stamps))
        self.tally.add(stamps, error)
        return stamps, error

    def score(self, most: int | None = None) -> tuple[RecordedEstimate, Score]:
        """The score of all that was heard, with what it was held against.

        Parameters
        ----------
        most : int, optional
            A score on the way: of so many samples only, evenly spread over the second half of the time, as a filter
            converges at first.

        Raises
        ------
        InputError
            If there is no estimate, or no truth, or they do not go together.
        """
        if most is None:
            self.judge()
            self.judge()
            self.estimate.end()
        read = self._held_against_truth(most)
        due_ns = read.truth.last_ns if self.estimate.due_ns is None else self.estimate.due_ns
        score = read.score(self._limits, self._covariance_axes, due_ns, bounded=most is None)
        thinned = self.estimate.kept.stride > 1 or most is not None
        if not thinned or not self.tally.count:
            return read, score
        return read, self.tally.exact(score, self.estimate.kept.count + read.left_out, due_ns)

    def _held_against_truth(self, most: int | None) -> RecordedEstimate:
        track, scenarios = self._track(most), self.truth.of_scenarios()
        true = scenarios if most is not None and scenarios.segments else self.truth.whole()
        truth, first_ns = self._truth_of(true, track.stamps_ns), int(track.stamps_ns[0])
        if most is not None and truth.first_ns < first_ns <= truth.last_ns:
            truth.first_ns = first_ns
        read = held_against(track, true, truth)
        return replace(read, notes=(*read.notes, *self._notes()), left_out=self.estimate.left_out)

    def _track(self, most: int | None) -> AttitudeTrack:
        """The estimates that are kept, or so many of them."""
        if not self.truth.is_known:
            raise InputError(f"nothing tells the truth of {self._topic}: neither a scenario nor a pose came")
        if self._template is None:
            raise InputError(f"topic {self._topic} {self._why_nothing()}")
        if not self.estimate.kept.count:
            raise InputError(f"topic {self._topic}: {self.estimate.fault()}")
        stamps, numbers = self.estimate.kept.rows()
        if most is not None:
            settled = np.flatnonzero(stamps >= (stamps[0] + stamps[-1]) // 2)
            chosen = settled[np.unique(np.linspace(0, len(settled) - 1, most).round().astype(np.int64))]
            stamps, numbers = stamps[chosen], numbers[chosen]
        covariance = numbers[:, 4:].reshape(-1, 3, 3) if numbers.shape[1] > 4 else None
        return replace(self._template, stamps_ns=stamps, attitude_xyzw=numbers[:, :4], covariance=covariance)

    def why_not_compared(self) -> str:
        """Why no message of the estimate has an error, of which the truth is known."""
        if self._template is None:
            return f"topic {self._topic} {self._why_nothing()}"
        last_ns = self.estimate.last_ns
        if last_ns is None:
            return f"topic {self._topic}: {self.estimate.fault()}"
        pose_ns = self.truth.last_pose_ns
        end = "on" if pose_ns is None else f"to {pose_ns / NS:.13g} s"
        return (
            f"no attitude of {self._topic} is stamped within the truth, from {self.truth.begin_ns / NS:.13g} s {end}; "
            f"the last is at {last_ns / NS:.13g} s: is it of the same clock and run?"
        )

    def _why_nothing(self) -> str:
        if self._message_type == TF_MESSAGE and self._pairs:
            pairs = listed([f"{frame} to {child}" for frame, child in self._pairs])
            wanted = " to ".join(self.truth.of_scenarios().frames or ())
            return f"tells of {pairs}, none of which is {wanted}: name the frames so"
        return NO_ORIENTATION

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

    def _truth_of(self, true: TrueMotion, stamps: Integers) -> Truth:
        """The truth from the first estimate on: of a scenario it is known, also where no pose was heard yet."""
        truth = true.until(int(stamps[-1]))
        start, due_ns = self.estimate.first_ns, self.estimate.due_ns
        assert start is not None
        if true.segments:
            truth.first_ns = true.segments[0].start_ns
        if truth.first_ns < start <= truth.last_ns:
            truth.first_ns = start
        if due_ns is not None:
            truth.last_ns = min(truth.last_ns, max(due_ns, truth.first_ns))
        end = int(stamps[-1])
        if true.segments and truth.last_ns < end <= truth.last_ns + LENIENCE_NS:
            truth.last_ns = end
        elif end <= truth.last_ns <= end + LENIENCE_NS:  # what is on its way through the filter is no gap
            truth.last_ns = min(truth.last_ns, end + int(GAP * period_ns(stamps)))
        return truth

    def _read(self) -> Rows | None:
        """Stamps, ns, attitudes and covariances of the messages that were not read yet."""
        if not self._unread:
            return None
        unread, self._unread = self._unread, []
        found = attitudes_of(self._topic, self._message_type, unread)
        track = found.get(self._chosen(found))
        if track is None or not track.stamps_ns.size:
            return None
        self._template = self._template or track
        if track.covariance is None:
            return track.stamps_ns, track.attitude_xyzw
        return track.stamps_ns, np.concatenate([track.attitude_xyzw, track.covariance.reshape(-1, 9)], axis=1)

    def _chosen(self, found: dict[Frames, AttitudeTrack]) -> Frames:
        """The frames of the estimate: of transforms those of the scenario, else those of all messages."""
        self._pairs |= dict.fromkeys(found)
        frames = self.truth.of_scenarios().frames
        if self._message_type == TF_MESSAGE and frames is not None:
            return frames
        if len(self._pairs) > 1:
            pairs = listed([" to ".join(filter(None, pair)) for pair in self._pairs])
            raise InputError(f"topic {self._topic} is of the frames {pairs}: let one node publish one body")
        return next(iter(self._pairs), ("", ""))
