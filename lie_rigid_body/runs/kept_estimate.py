"""The attitudes of an estimate that count for its score, as they come from a topic."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.evaluation.attitude_error import SMALLEST_NORM
from lie_rigid_body.lie import quaternion
from lie_rigid_body.parameters import NS, exact_duration
from lie_rigid_body.runs.heard import MOST_WAITING, HeardTruth
from lie_rigid_body.runs.kept import Kept, Rows, joined
from lie_rigid_body.runs.recorded_estimate import LENIENCE_NS, disorder, left_ahead, passed_by


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
    """Attitudes that can be used, in order, within the duration, and not ahead of the poses that were heard.

    What is ahead waits, and is left out if later ones are not: one wrong stamp would put all that follow it out of
    order, and complete the duration.

    Parameters
    ----------
    truth : HeardTruth
    most : int
        Largest number of attitudes that are kept.
    duration_s : float or None
        Length of the `Duration`, s.

    Attributes
    ----------
    kept : Kept
        Attitudes, and the covariances where there are any.
    duration : Duration
    unusable : int
        Number of attitudes that were left out because they are not finite, or zero.
    """

    def __init__(self, truth: HeardTruth, most: int, duration_s: float | None) -> None:
        self._truth, self.kept, self.duration = truth, Kept(most), Duration(duration_s)
        self.unusable = self._first_unusable_ns = 0
        self._ahead: Rows | None = None
        self._astray_s = np.empty(0)

    @property
    def last_ns(self) -> int | None:
        """Stamp of the last attitude that can be used, ns, also of one that waits; None if there is none."""
        if self._ahead is not None:
            return int(self._ahead[0][-1])
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

    def add(self, rows: Rows | None) -> Rows | None:
        """Take attitudes and covariances, and return what counts of them and of those that waited, if anything does."""
        parts = [part for part in (self._ahead, rows) if part is not None]
        return self._take(*self._timely(*joined(parts))) if parts else None

    def end(self) -> None:
        """Take what waits as well: no later truth is to come."""
        if self._ahead is not None:
            self._take(*self._ahead)
            self._ahead = None

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
        yield from left_ahead(self._astray_s, count)
        if self.kept.disordered:
            yield disorder(self.kept.disordered, count)
        if self.unusable:
            yield f"{self.fault()}."

    def _timely(self, stamps: Integers, numbers: Array) -> Rows:
        """Rows that do not wait, but for those that are stamped ahead of the poses, and of later ones, by mistake."""
        last_ns = self._truth.last_pose_ns
        if last_ns is None:
            return stamps, numbers
        ahead = stamps > last_ns + LENIENCE_NS
        astray = passed_by(ahead)
        self._astray_s = np.concatenate([self._astray_s, (stamps[astray] - last_ns) / NS])
        waits = ahead & ~astray
        if np.count_nonzero(waits) > MOST_WAITING:  # that is no wrong stamp, but another clock
            ahead, waits = astray, np.zeros_like(ahead)
        self._ahead = (stamps[waits], numbers[waits]) if waits.any() else None
        if self._ahead is not None:
            self.duration.pass_by(stamps[waits], self.kept.last_ns if self.kept.count else int(stamps[waits][0]))
        return stamps[~ahead], numbers[~ahead]

    def _take(self, stamps: Integers, numbers: Array) -> Rows | None:
        usable = _usable(numbers[:, :4])
        self.duration.begin(stamps[usable], self._truth.begin_ns)
        inside = self.duration.holds(stamps)
        unusable = stamps[inside & ~usable]
        if len(unusable):
            self._first_unusable_ns = self._first_unusable_ns if self.unusable else int(unusable[0])
            self.unusable += len(unusable)
        rows = self.kept.add(stamps[inside & usable], numbers[inside & usable])
        return rows if len(rows[0]) else None


def _usable(attitude_xyzw: Array) -> Booleans:
    """Whether each attitude is finite and not zero."""
    finite = np.isfinite(attitude_xyzw).all(axis=1)
    return np.asarray(finite & (quaternion.norm(np.where(finite[:, np.newaxis], attitude_xyzw, 0.0)) >= SMALLEST_NORM))
