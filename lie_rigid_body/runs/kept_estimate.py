"""The attitudes of an estimate that count for its score, as they come, in memory that does not grow for ever."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.evaluation.attitude_error import SMALLEST_NORM
from lie_rigid_body.evaluation.estimate import in_order
from lie_rigid_body.lie import quaternion
from lie_rigid_body.parameters import NS, exact_duration
from lie_rigid_body.recording.topic_messages import AttitudeTrack

MOST_KEPT: Final = 100_000
"""Largest number of samples of the estimate, and of the poses, that are kept: a quarter of an hour at 100 Hz.

Of more every second is kept, then every fourth, and so on. Their score takes about 3 s; launch kills what does not end
within 10 s."""
MOST_BLOCKS: Final = 2000
"""Largest number of pieces of what is kept, before they are joined."""
MOST_WAITING: Final = 50_000
"""Largest number of estimates that wait for a truth; of more the oldest are given up."""
LENIENCE_NS: Final = NS
"""Largest time between the last estimate and the last pose heard, ns, as each has its way. The scenario tells the truth
so far beyond the poses: stamps further on are of another clock. A filter further behind has ended."""


class Kept:
    """Attitudes in order of time, of which evenly so many are kept that memory does not grow.

    Attributes
    ----------
    count, disordered : int
        Number of attitudes that came in order, and of those that were left out because they were stamped before an
        earlier one.
    first_ns, last_ns : int
        Stamps of the first and of the last; 0 if there is none.
    stride : int
        One in so many is kept.
    """

    def __init__(self, most: int = MOST_KEPT) -> None:
        self.count = self.disordered = self.first_ns = self.last_ns = 0
        self.stride, self._most = 1, most
        self._blocks: list[AttitudeTrack] = []
        self._last: AttitudeTrack | None = None

    def add(self, track: AttitudeTrack) -> AttitudeTrack:
        """Take attitudes, and return those of them that are in order."""
        ordered = track[in_order(track.stamps_ns, self.last_ns if self.count else None)]
        self.disordered += len(track) - len(ordered)
        if len(ordered):
            stamps, self._last = ordered.stamps_ns, ordered[-1:]
            self.first_ns, self.last_ns = self.first_ns if self.count else int(stamps[0]), int(stamps[-1])
            self._blocks.append(ordered[-self.count % self.stride :: self.stride])
            self.count += len(ordered)
        if sum(map(len, self._blocks)) > self._most or len(self._blocks) > MOST_BLOCKS:
            kept = AttitudeTrack.joined(self._blocks)
            while len(kept) > self._most:
                kept, self.stride = kept[np.arange(0, len(kept), 2)], 2 * self.stride
            self._blocks = [kept]
        return ordered

    def track(self) -> AttitudeTrack:
        """The attitudes that are kept, and the last; of at least one that came."""
        last = [self._last] if self._last is not None and (self.count - 1) % self.stride else []
        return AttitudeTrack.joined([*self._blocks, *last])


class Duration:
    """Time, by stamps, in which attitudes count: from the first one on, for as long as was asked for.

    Parameters
    ----------
    length_s : float or None
        None for attitudes that count whenever they are stamped.

    Raises
    ------
    InputError
        If it is not a time.

    Attributes
    ----------
    first_ns : int or None
        Stamp of the first attitude.
    complete : bool
        Whether an attitude came that is stamped at the end, or later.
    """

    def __init__(self, length_s: float | None) -> None:
        self._length_ns = None if length_s is None else round(exact_duration(length_s, "duration", "60.0") * NS)
        self.first_ns: int | None = None
        self.complete = self._has_begun = False

    @property
    def due_ns(self) -> int | None:
        """Stamp of the end, ns; None without a length, or before the first attitude."""
        return None if self._length_ns is None or self.first_ns is None else self.first_ns + self._length_ns

    def begin(self, stamps: Integers, truth_ns: int) -> None:
        """Begin with the first stamp that is not long before the truth; until that comes, with the first of all."""
        known = stamps[stamps >= truth_ns - LENIENCE_NS]
        if len(stamps) and not self._has_begun and (len(known) or self.first_ns is None):
            self.first_ns, self._has_begun = int((known if len(known) else stamps)[0]), len(known) > 0

    def holds(self, stamps: Integers) -> Booleans:
        """Whether each stamp is not behind the end."""
        if self.due_ns is None:
            return np.ones(len(stamps), dtype=np.bool_)
        self.complete |= bool(np.any(stamps >= self.due_ns))
        return np.asarray(stamps <= self.due_ns)

    def pass_by(self, waiting: Integers, last_ns: int) -> None:
        """Let time pass by stamps ahead of the truth, as of another clock or of a truth that has ended; no leap counts.

        Parameters
        ----------
        waiting : ndarray of int64, shape (N,)
        last_ns : int
            Stamp of the last attitude that counts.
        """
        if self._length_ns is not None:
            steps = np.clip(np.diff(waiting, prepend=last_ns), 0, LENIENCE_NS)
            first_ns = last_ns if self.first_ns is None else self.first_ns
            self.complete |= last_ns + int(steps.sum()) - first_ns >= self._length_ns


class KeptEstimate:
    """Attitudes that can be used, in order, within the duration, and not ahead of the truth.

    What is ahead waits, and is left out if later ones are not: one wrong stamp would put all that follow it out of
    order, and complete the duration.

    Parameters
    ----------
    most : int
        Largest number of attitudes that are kept.
    duration_s : float or None
        Length of the `Duration`, s.

    Attributes
    ----------
    kept : Kept
    duration : Duration
    unusable : int
        Number of attitudes that were left out because they are not finite, or zero.
    """

    def __init__(self, most: int, duration_s: float | None = None) -> None:
        self.kept, self.duration = Kept(most), Duration(duration_s)
        self.unusable = self._first_unusable_ns = 0
        self._ahead: list[AttitudeTrack] = []
        self._astray_s = np.empty(0)

    @property
    def last_ns(self) -> int | None:
        """Stamp of the last attitude that can be used, ns, also of one that waits; None if there is none."""
        if self._ahead:
            return int(self._ahead[0].stamps_ns[-1])
        return self.kept.last_ns if self.kept.count else None

    @property
    def span_s(self) -> float:
        """Time from the first attitude to the last, by their stamps, s."""
        first_ns = self.duration.first_ns
        return 0.0 if first_ns is None else (self.kept.last_ns - first_ns) / NS

    @property
    def left_out(self) -> int:
        """Number of attitudes that were left out because of their stamps."""
        return self.kept.disordered + len(self._astray_s)

    def add(self, new: list[AttitudeTrack], truth_ns: int, last_pose_ns: int | None) -> AttitudeTrack | None:
        """Take attitudes, and return what counts of them and of those that waited, if anything does.

        Parameters
        ----------
        new : list of AttitudeTrack
        truth_ns : int
            Begin of the truth, ns.
        last_pose_ns : int or None
            Stamp behind which the truth is not known yet, ns; None if it has no end.
        """
        parts, self._ahead = [*self._ahead, *new], []
        if not parts:
            return None
        track = AttitudeTrack.joined(parts)
        return self._take(track if last_pose_ns is None else self._timely(track, last_pose_ns), truth_ns)

    def end(self, truth_ns: int) -> None:
        """Take what waits as well: no later truth is to come."""
        self.add([], truth_ns, None)

    def fault(self) -> str:
        """Sentence about the attitudes that cannot be used, without a full stop; empty if there are none."""
        if not self.unusable:
            return ""
        return (
            f"{self.unusable} of {self.unusable + self.kept.count} attitudes are not finite, or zero, the first "
            f"stamped {self._first_unusable_ns / NS:.13g} s: they are left out; find out why the filter gave them"
        )

    def notes(self) -> Iterator[str]:
        """Sentences for the reader of the score about the attitudes that were left out."""
        count = self.kept.count + self.left_out
        if len(self._astray_s):
            yield (
                f"Left out of {count} estimates: {len(self._astray_s)} stamped far ahead of the truth, the first by "
                f"{self._astray_s[0]:.12g} s, where later ones are not: find out what stamped them."
            )
        if self.kept.disordered:
            yield (
                f"{self.kept.disordered} of {count} estimates were stamped before one that had come, and are left "
                "out: is there one publisher, and does time never jump back?"
            )
        if self.unusable:
            yield f"{self.fault()}."

    def _timely(self, track: AttitudeTrack, last_ns: int) -> AttitudeTrack:
        """What does not wait, but for what is stamped ahead of the poses, and of later attitudes, by mistake."""
        stamps, ahead = track.stamps_ns, track.stamps_ns > last_ns + LENIENCE_NS
        astray = ahead & np.logical_or.accumulate(~ahead[::-1])[::-1]
        self._astray_s = np.concatenate([self._astray_s, (stamps[astray] - last_ns) / NS])
        waits = ahead & ~astray
        if np.count_nonzero(waits) > MOST_WAITING:  # that is no wrong stamp, but another clock
            return track[~astray]
        if waits.any():
            self._ahead = [track[waits]]
            self.duration.pass_by(stamps[waits], self.kept.last_ns if self.kept.count else int(stamps[waits][0]))
        return track[~ahead]

    def _take(self, track: AttitudeTrack, truth_ns: int) -> AttitudeTrack | None:
        usable = _usable(track)
        self.duration.begin(track.stamps_ns[usable], truth_ns)
        inside = self.duration.holds(track.stamps_ns)
        unusable = track.stamps_ns[inside & ~usable]
        if len(unusable):
            self._first_unusable_ns = self._first_unusable_ns if self.unusable else int(unusable[0])
            self.unusable += len(unusable)
        kept = self.kept.add(track[inside & usable])
        return kept if len(kept) else None


def _usable(track: AttitudeTrack) -> Booleans:
    """Whether each attitude is finite and not zero."""
    finite = np.isfinite(track.attitude_xyzw).all(axis=1)
    known = np.where(finite[:, np.newaxis], track.attitude_xyzw, 0.0)
    norms = quaternion.norm(known)
    return np.asarray(finite & (norms >= SMALLEST_NORM) & np.isfinite(norms))
