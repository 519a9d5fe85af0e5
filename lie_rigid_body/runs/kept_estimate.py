"""The attitudes of an estimate that count for its score, as they come from a topic."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.evaluation.attitude_error import SMALLEST_NORM
from lie_rigid_body.lie import quaternion
from lie_rigid_body.parameters import NS, exact_duration
from lie_rigid_body.runs.heard_truth import MOST_WAITING, HeardTruth
from lie_rigid_body.runs.kept import Kept, Rows, joined
from lie_rigid_body.runs.recorded_estimate import LENIENCE_NS, disorder, left_ahead, passed_by


class KeptEstimate:
    """Attitudes that can be used, in order, within the duration, and not ahead of the poses that were heard.

    What is ahead waits, and is left out if later ones are not: one wrong stamp would put all that follow it out of
    order, and complete the duration.

    Parameters
    ----------
    truth : HeardTruth
    most : int
        Attitudes that are kept.
    duration_s : float or None
        Those that are stamped longer after the first are left out, whenever they come.

    Raises
    ------
    InputError
        If the duration is not a time.

    Attributes
    ----------
    kept : Kept
        Attitudes, and the covariances where there are any.
    complete : bool
        Whether one came that is stamped by the duration after the first, or later.
    unusable : int
        How many were left out because they are not finite, or zero.
    first_ns : int or None
        Stamp of the first.
    """

    def __init__(self, truth: HeardTruth, most: int, duration_s: float | None) -> None:
        self._truth, self.kept = truth, Kept(most)
        self._duration_ns = None if duration_s is None else round(exact_duration(duration_s, "duration", "60.0") * NS)
        self.complete = self._has_begun = False
        self.unusable = self._first_unusable_ns = 0
        self.first_ns: int | None = None
        self._ahead: Rows | None = None
        self._astray_s = np.empty(0)

    @property
    def last_ns(self) -> int | None:
        """Stamp of the last that can be used, ns, also of one that waits; None if there is none."""
        if self._ahead is not None:
            return int(self._ahead[0][-1])
        return self.kept.last_ns if self.kept.count else None

    @property
    def span_s(self) -> float:
        """Time from the first to the last, by their stamps, s."""
        return 0.0 if self.first_ns is None else (self.kept.last_ns - self.first_ns) / NS

    @property
    def due_ns(self) -> int | None:
        """Stamp at which the duration is over, ns; None without one, or before the first."""
        return None if self._duration_ns is None or self.first_ns is None else self.first_ns + self._duration_ns

    @property
    def left_out(self) -> int:
        """How many were left out because of their stamps."""
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
        """What is wrong about those that cannot be used, in a sentence without a full stop; empty if nothing."""
        if not self.unusable:
            return ""
        return (
            f"{self.unusable} of {self.unusable + self.kept.count} attitudes are not finite, or zero, the first "
            f"stamped {self._first_unusable_ns / NS:.13g} s: they are left out; find out why the filter gave them"
        )

    def notes(self) -> Iterator[str]:
        """What a reader of the score should know of those that were left out, one sentence each."""
        count = self.kept.count + self.left_out
        yield from left_ahead(self._astray_s, count)
        if self.kept.disordered:
            yield disorder(self.kept.disordered, count)
        if self.unusable:
            yield f"{self.fault()}."

    def _timely(self, stamps: Integers, numbers: Array) -> Rows:
        """Those that do not wait, without those that are stamped ahead of the poses, and of later ones, by mistake."""
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
        self._complete_by(stamps[waits])
        return stamps[~ahead], numbers[~ahead]

    def _complete_by(self, ahead: Integers) -> None:
        """Stamps of another clock, or of a time when the truth has ended, complete a duration too, but no leap does."""
        if self._duration_ns is None or not len(ahead):
            return
        last_ns = self.kept.last_ns if self.kept.count else int(ahead[0])
        first_ns = last_ns if self.first_ns is None else self.first_ns
        steps = np.clip(np.diff(ahead, prepend=last_ns), 0, LENIENCE_NS)
        self.complete = self.complete or last_ns + int(steps.sum()) - first_ns >= self._duration_ns

    def _take(self, stamps: Integers, numbers: Array) -> Rows | None:
        usable = _usable(numbers[:, :4])
        self._begin(stamps[usable])
        inside = self._within_duration(stamps)
        self._count_unusable(stamps[inside & ~usable])
        rows = self.kept.add(stamps[inside & usable], numbers[inside & usable])
        return rows if len(rows[0]) else None

    def _begin(self, stamps: Integers) -> None:
        """Know the first: that which is not stamped long before the truth, as soon as there is one."""
        known = stamps[stamps >= self._truth.begin_ns - LENIENCE_NS]
        if len(known) and not self._has_begun:
            self.first_ns, self._has_begun = int(known[0]), True
        elif self.first_ns is None and len(stamps):
            self.first_ns = int(stamps[0])

    def _within_duration(self, stamps: Integers) -> Booleans:
        """Which stamps are no later after the first than the duration."""
        due_ns = self.due_ns
        if due_ns is None:
            return np.ones(len(stamps), dtype=np.bool_)
        self.complete = self.complete or bool(np.any(stamps >= due_ns))
        return np.asarray(stamps <= due_ns)

    def _count_unusable(self, stamps: Integers) -> None:
        if len(stamps):
            self._first_unusable_ns = self._first_unusable_ns if self.unusable else int(stamps[0])
            self.unusable += len(stamps)


def _usable(attitude_xyzw: Array) -> Booleans:
    """Which attitudes are finite and not zero."""
    finite = np.isfinite(attitude_xyzw).all(axis=1)
    return np.asarray(finite & (quaternion.norm(np.where(finite[:, np.newaxis], attitude_xyzw, 0.0)) >= SMALLEST_NORM))
