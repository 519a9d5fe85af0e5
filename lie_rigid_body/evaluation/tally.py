"""The errors of samples as they come: what is exact of all of them, however many, in little memory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.attitude_error import AttitudeError
from lie_rigid_body.evaluation.limits import Limits
from lie_rigid_body.evaluation.score import Score
from lie_rigid_body.evaluation.statistics import Statistics


class Tally:
    """Number, RMS and largest error of all samples so far, and what limits need to know of them.

    Parameters
    ----------
    limits : Limits

    Attributes
    ----------
    count : int
    """

    def __init__(self, limits: Limits) -> None:
        self.limits, self.count = limits, 0
        self._squares, self._largest = np.zeros(3), np.zeros(3)
        self._first_ns = self._last_ns = 0
        self._worst: list[tuple[float, float] | None] = [None for _ in limits.max_after]

    def add(self, stamps_ns: Integers, error: AttitudeError) -> None:
        """Take samples that come next: at least one, with their errors, rad."""
        angles_deg = np.degrees(np.stack(error))
        self._first_ns = int(stamps_ns[0]) if not self.count else self._first_ns
        self._last_ns = int(stamps_ns[-1])
        self.count += len(stamps_ns)
        self._squares += np.sum(angles_deg**2, axis=1)
        self._largest = np.maximum(self._largest, angles_deg.max(axis=1))
        t_s = (stamps_ns - self._first_ns) / 1e9
        for i, (start, _) in enumerate(self.limits.max_after):
            self._worst[i] = _worse(self._worst[i], t_s, np.where(t_s >= start, angles_deg[0], -1.0))

    @property
    def rms_deg(self) -> Array:
        """RMS of the total, heading and inclination error, degrees, shape (3,)."""
        return np.asarray(np.sqrt(self._squares / max(self.count, 1)))

    @property
    def largest_deg(self) -> Array:
        """Largest total, heading and inclination error, degrees, shape (3,)."""
        return self._largest

    def broken(self) -> tuple[str, ...]:
        """Sentences about the limits that the samples so far break, one for each."""
        return self.limits.broken_by(float(self.rms_deg[0]), self._worst, (self._last_ns - self._first_ns) / 1e9)

    def exact(self, score: Score, given: int, due_ns: int) -> Score:
        """Replace RMS, largest error and limits in a score of some of the samples by those of all.

        Parameters
        ----------
        score : Score
        given : int
            Estimates, of which those that were compared were added.
        due_ns : int
            The stamp until which they are due.
        """
        span_s, due_s = ((end - self._first_ns) / 1e9 for end in (self._last_ns, due_ns))
        broken = (*self.broken(), *self.limits.too_little(self.count, given, span_s, due_s))
        parts = score.total_deg, score.heading_deg, score.inclination_deg
        total, heading, inclination = map(_with, parts, self.rms_deg.tolist(), self._largest.tolist())
        return replace(score, total_deg=total, heading_deg=heading, inclination_deg=inclination, broken=broken)


def _with(statistics: Statistics, rms: float, largest: float) -> Statistics:
    return replace(statistics, rms=rms, max=largest)


def _worse(before: tuple[float, float] | None, t_s: Array, total_deg: Array) -> tuple[float, float] | None:
    """Time and size of the larger of an earlier error and the largest of some; sizes below 0 do not count."""
    k = int(np.argmax(total_deg))
    if total_deg[k] < 0.0 or (before is not None and before[1] >= total_deg[k]):
        return before
    return float(t_s[k]), float(total_deg[k])
