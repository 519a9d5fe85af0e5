"""An estimate and its truth as they come from topics: scored as from a bag, in memory that does not grow for ever."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import AttitudeError, Limits, Score, Truth, attitude_error, evaluate
from lie_rigid_body.evaluation.attitude_error import SMALLEST_NORM
from lie_rigid_body.evaluation.estimate import GAP, period_ns
from lie_rigid_body.evaluation.tally import Tally
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages import decode_string
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.attitude_reader import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.kept import MOST_KEPT, Kept
from lie_rigid_body.runs.recorded_estimate import (
    LENIENCE_NS,
    RecordedEstimate,
    TrueMotion,
    disorder,
    held_against,
    left_ahead,
    passed_by,
)
from lie_rigid_body.runs.unavoidable import bound_of
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import listed

MOST_UNREAD: Final = 50_000
"""Messages that wait for a truth; the oldest are given up."""
RECENT: Final = 40
"""Batches of poses by which the latest estimates are judged."""
INTERIM: Final = 2000
"""Samples of the score on the way."""


@dataclass
class Heard:
    """A topic and the bytes of its messages that were not read yet."""

    topic: str
    message_type: str
    unread: list[bytes]

    def taken(self) -> list[bytes]:
        """The unread messages, which are then forgotten."""
        taken, self.unread = self.unread, []
        return taken


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
    complete : bool
        Whether an estimate came that is stamped by the duration after the first, or later.
    messages : int
        How many messages of the estimate came.
    unusable : int
        How many attitudes were left out because they are not finite, or zero.
    tally : Tally
        Of all estimates that were compared so far.
    first_ns, last_ns : int or None
        Stamps of the first estimate and the last.
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
        self._covariance_axes = covariance_axes
        self._heard = Heard(topic, message_type, [])
        self._limits, self.tally = limits, Tally(limits)
        self._segments: dict[str, Segment] = {}
        self._poses: Heard | None = None
        self._kept, self._kept_poses = Kept(most), Kept(most)
        self._recent: deque[tuple[Integers, Array]] = deque(maxlen=RECENT)
        self._waiting: list[tuple[Integers, Array]] = []
        self._pairs: dict[Frames, None] = {}
        self._given_up = self.messages = self.unusable = 0
        self._first_unusable_ns = 0
        self._duration_ns = None if duration_s is None else round(duration_s * NS)
        self.complete = False
        self._template: AttitudeTrack | None = None
        self._pose_template: AttitudeTrack | None = None
        self.first_ns: int | None = None
        self.last_ns: int | None = None
        self._has_begun = False
        self._ahead: tuple[Integers, Array] | None = None
        self._astray_s = np.empty(0)

    @property
    def span_s(self) -> float:
        """Time from the first estimate to the last, by their stamps, s."""
        return 0.0 if self.first_ns is None or self.last_ns is None else (self.last_ns - self.first_ns) / NS

    @property
    def has_truth(self) -> bool:
        """Whether a scenario or a pose was heard."""
        return bool(self._segments) or self._kept_poses.count > 0

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
        """Take messages of the truth."""
        if self._poses is None:
            self._poses = Heard(topic, message_type, [])
        self._poses.unread += payloads

    def hear_estimates(self, payloads: list[bytes]) -> None:
        """Take messages of the estimate."""
        self.messages += len(payloads)
        self._heard.unread += payloads
        excess = len(self._heard.unread) - MOST_UNREAD
        if excess > 0 and not self.has_truth:
            del self._heard.unread[:excess]
            self._given_up += excess

    def judge(self) -> tuple[Integers, AttitudeError] | None:
        """Compare the estimates that came before the last call, as far as their truth is known by now.

        Those that came since wait for the next call: a reset that they follow may be on its way.

        Returns
        -------
        tuple of ndarray and AttitudeError, or None
            Their stamps, ns, and errors, rad.
        """
        self._read_poses()
        if not self.has_truth:
            return None
        ready, self._waiting = self._waiting, self._read_estimates()
        if not ready:
            return None
        stamps, numbers = (np.concatenate(parts) for parts in zip(*ready, strict=True))
        truth = self._truth(self._recent_motion(int(stamps[0])), stamps)
        known = truth.covers(stamps)
        late = stamps > truth.last_ns  # whose truth may yet come
        if late.any():
            self._waiting.insert(0, (stamps[late][-MOST_UNREAD:], numbers[late][-MOST_UNREAD:]))
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
        for _ in range(2 if most is None else 0):
            self.judge()
        if most is None and self._ahead is not None:
            self._take(*self._ahead)
            self._ahead = None
        read = self._read(most)
        track, due_ns = read.track, read.truth.last_ns
        if self._duration_ns is not None and self.first_ns is not None:
            due_ns = self.first_ns + self._duration_ns
        score = evaluate(
            track.stamps_ns,
            track.attitude_xyzw,
            read.truth,
            limits=self._limits,
            covariance=read.covariance,
            covariance_axes=self._covariance_axes,
            bound=None if most else bound_of(read.segments, read.truth, track.stamps_ns),
            left_out=read.left_out,
            due_ns=due_ns,
        )
        thinned = self._kept.stride > 1 or most is not None
        if not thinned or not self.tally.count:
            return read, score
        return read, self.tally.exact(score, self._kept.count + read.left_out, due_ns)

    def _read(self, most: int | None) -> RecordedEstimate:
        if not self.has_truth:
            raise InputError(f"nothing tells the truth of {self._heard.topic}: neither a scenario nor a pose came")
        if self._template is None:
            raise InputError(f"topic {self._heard.topic} {self._why_nothing()}")
        if not self._kept.count:
            raise InputError(f"topic {self._heard.topic}: {self.fault()}")
        stamps, numbers = self._kept.rows()
        if most is not None:
            settled = np.flatnonzero(stamps >= (stamps[0] + stamps[-1]) // 2)
            chosen = settled[np.unique(np.linspace(0, len(settled) - 1, most).round().astype(np.int64))]
            stamps, numbers = stamps[chosen], numbers[chosen]
        track = _track(self._template, stamps, numbers)
        with_poses = self._kept_poses.count and not (self._segments and most is not None)
        true = self._motion(self._kept_poses.rows() if with_poses else None)
        truth = self._truth(true, stamps)
        if most is not None and truth.first_ns < stamps[0] <= truth.last_ns:
            truth.first_ns = int(stamps[0])
        read = held_against(track, true, truth)
        left_out = self._kept.disordered + len(self._astray_s)
        return replace(read, notes=(*read.notes, *self._notes()), left_out=left_out)

    def fault(self) -> str:
        """What is wrong about the attitudes that were left out, in a sentence without a full stop; empty if nothing."""
        if not self.unusable:
            return ""
        return (
            f"{self.unusable} of {self.unusable + self._kept.count} attitudes are not finite, or zero, the first "
            f"stamped {self._first_unusable_ns / NS:.13g} s: they are left out; find out why the filter gave them"
        )

    def _why_nothing(self) -> str:
        if self._heard.message_type == TF_MESSAGE and self._pairs:
            pairs = listed([f"{frame} to {child}" for frame, child in self._pairs])
            wanted = " to ".join(self._frames or ())
            return f"tells of {pairs}, none of which is {wanted}: name the frames so"
        return NO_ORIENTATION

    def _notes(self) -> Iterator[str]:
        kept = self._kept
        count = kept.count + kept.disordered + len(self._astray_s)
        yield from left_ahead(self._astray_s, count)
        if kept.disordered:
            yield disorder(kept.disordered, count)
        if self.unusable:
            yield f"{self.fault()}."
        if self._given_up:
            yield f"{self._given_up} estimates came before any truth, and are left out."
        if kept.stride > 1:
            yield (
                f"One in {kept.stride} of {kept.count} estimates was kept for the score. RMS, largest error and limits "
                f"are of all {self.tally.count} that could be compared; gaps below {2.5 * kept.stride:g} samples "
                "are not seen."
            )

    @property
    def _frames(self) -> Frames | None:
        return self._motion().frames

    def _motion(self, poses: tuple[Integers, Array] | None = None) -> TrueMotion:
        segments = tuple(sorted(self._segments.values(), key=lambda segment: segment.start_ns))
        if poses is None:
            return TrueMotion(segments, None)
        assert self._pose_template is not None
        return TrueMotion(segments, _track(self._pose_template, *poses))

    def _recent_motion(self, since_ns: int) -> TrueMotion:
        """By the latest poses, without the segments that had ended at a time: each costs as much as many samples."""
        recent = [np.concatenate(parts) for parts in zip(*self._recent, strict=True)]
        true = self._motion((recent[0], recent[1]) if recent else None)
        ended = sum(segment.start_ns <= since_ns for segment in true.segments[1:])
        return replace(true, segments=true.segments[ended:])

    def _truth(self, true: TrueMotion, stamps: Integers) -> Truth:
        """The truth from the first estimate on: of a scenario it is known, also where no pose was heard yet."""
        truth = true.until(int(stamps[-1]))
        start = int(self.first_ns if self.first_ns is not None else stamps[0])
        if true.segments:
            truth.first_ns = true.segments[0].start_ns
        if truth.first_ns < start <= truth.last_ns:
            truth.first_ns = start
        if self._duration_ns is not None:
            truth.last_ns = min(truth.last_ns, max(start + self._duration_ns, truth.first_ns))
        end = int(stamps[-1])
        if true.segments and truth.last_ns < end <= truth.last_ns + LENIENCE_NS:
            truth.last_ns = end
        elif end <= truth.last_ns <= end + LENIENCE_NS:  # what is on its way through the filter is no gap
            truth.last_ns = min(truth.last_ns, end + int(GAP * period_ns(stamps)))
        return truth

    def _read_poses(self) -> None:
        if self._poses is None or not self._poses.unread:
            return
        found = attitudes_of(self._poses.topic, self._poses.message_type, self._poses.taken())
        for track in found.values():
            self._pose_template = self._pose_template or track
            if (track.frame, track.child_frame) == (self._pose_template.frame, self._pose_template.child_frame):
                ordered = self._kept_poses.add(track.stamps_ns, track.attitude_xyzw)
                self._recent += [ordered] if len(ordered[0]) else []

    def _read_estimates(self) -> list[tuple[Integers, Array]]:
        stamps, numbers = self._timely(self._decoded())
        return self._take(stamps, numbers) if len(stamps) else []

    def _decoded(self) -> tuple[Integers, Array] | None:
        """Stamps, ns, attitudes and covariances of the messages that were not read yet."""
        if not self._heard.unread:
            return None
        found = attitudes_of(self._heard.topic, self._heard.message_type, self._heard.taken())
        track = found.get(self._chosen(found))
        if track is None or not track.stamps_ns.size:
            return None
        self._template = self._template or track
        numbers = track.attitude_xyzw
        if track.covariance is not None:
            numbers = np.concatenate([numbers, track.covariance.reshape(-1, 9)], axis=1)
        return track.stamps_ns, numbers

    def _timely(self, new: tuple[Integers, Array] | None) -> tuple[Integers, Array]:
        """What is not stamped ahead of the truth heard; that waits, and is left out if later ones are not ahead.

        One wrong stamp would put all that follow it out of order, and complete the duration.
        """
        parts = [rows for rows in (self._ahead, new) if rows is not None]
        if not parts:
            return np.empty(0, dtype=np.int64), np.empty((0, 4))
        stamps, numbers = (np.concatenate(column) for column in zip(*parts, strict=True))
        if not self._kept_poses.count:
            return stamps, numbers
        ahead = stamps > self._kept_poses.last_ns + LENIENCE_NS
        astray = passed_by(ahead)
        self._astray_s = np.concatenate([self._astray_s, (stamps[astray] - self._kept_poses.last_ns) / NS])
        waits = ahead & ~astray
        if np.count_nonzero(waits) > MOST_UNREAD:  # that is no wrong stamp, but another clock
            ahead, waits = astray, np.zeros_like(ahead)
        self._ahead = (stamps[waits], numbers[waits]) if waits.any() else None
        self._complete_by(stamps[waits])
        return stamps[~ahead], numbers[~ahead]

    def _complete_by(self, ahead: Integers) -> None:
        """Stamps of another clock, or of a time when the truth has ended, complete a duration too, but no leap does."""
        if self._duration_ns is None or not len(ahead):
            return
        before = [] if self.last_ns is None else [self.last_ns]
        steps = np.clip(np.diff(np.concatenate([np.array(before, dtype=np.int64), ahead])), 0, LENIENCE_NS)
        span_ns = 0 if self.first_ns is None or self.last_ns is None else self.last_ns - self.first_ns
        self.complete = self.complete or span_ns + int(steps.sum()) >= self._duration_ns

    def _begin(self, stamps: Integers) -> None:
        """Know the first estimate: that which is not stamped long before the truth, as soon as there is one."""
        start = min(segment.start_ns for segment in self._segments.values()) if self._segments else None
        least = (self._kept_poses.first_ns if start is None else start) - LENIENCE_NS
        known = stamps[stamps >= least]
        if len(known) and not self._has_begun:
            self.first_ns, self._has_begun = int(known[0]), True
        elif self.first_ns is None and len(stamps):
            self.first_ns = int(stamps[0])

    def _take(self, stamps: Integers, numbers: Array) -> list[tuple[Integers, Array]]:
        """Keep those that can be used, within the duration and in order, and return them."""
        usable = _usable(numbers[:, :4])
        self._begin(stamps[usable])
        inside = self._within_duration(stamps)
        self._count_unusable(stamps[inside & ~usable])
        stamps, numbers = self._kept.add(stamps[inside & usable], numbers[inside & usable])
        if not len(stamps):
            return []
        self.last_ns = int(stamps[-1])
        return [(stamps, numbers)]

    def _within_duration(self, stamps: Integers) -> Booleans:
        """Which stamps are no later after the first estimate than the duration."""
        if self._duration_ns is None or self.first_ns is None:
            return np.ones(len(stamps), dtype=np.bool_)
        since = stamps - self.first_ns
        self.complete = self.complete or bool(np.any(since >= self._duration_ns))
        return np.asarray(since <= self._duration_ns)

    def _count_unusable(self, stamps: Integers) -> None:
        if len(stamps):
            self._first_unusable_ns = self._first_unusable_ns if self.unusable else int(stamps[0])
            self.unusable += len(stamps)

    def _chosen(self, found: dict[Frames, AttitudeTrack]) -> Frames:
        """The frames of the estimate: of transforms those of the scenario, else those of all messages."""
        self._pairs |= dict.fromkeys(found)
        if self._heard.message_type == TF_MESSAGE and self._frames is not None:
            return self._frames
        if len(self._pairs) > 1:
            pairs = listed([" to ".join(filter(None, pair)) for pair in self._pairs])
            raise InputError(f"topic {self._heard.topic} is of the frames {pairs}: let one node publish one body")
        return next(iter(self._pairs), ("", ""))


def _usable(attitude_xyzw: Array) -> Booleans:
    """Which attitudes are finite and not zero."""
    finite = np.isfinite(attitude_xyzw).all(axis=1)
    return np.asarray(finite & (quaternion.norm(np.where(finite[:, np.newaxis], attitude_xyzw, 0.0)) >= SMALLEST_NORM))


def _track(template: AttitudeTrack, stamps: Integers, numbers: Array) -> AttitudeTrack:
    """Rows of attitudes, and of covariances where there are more numbers, as a track like another."""
    covariance = numbers[:, 4:].reshape(-1, 3, 3) if numbers.shape[1] > 4 else None
    return replace(template, stamps_ns=stamps, attitude_xyzw=numbers[:, :4], covariance=covariance)
