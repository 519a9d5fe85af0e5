"""Answers of a filter: its estimate in a course whose readings are repaired, beside the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.course import Course, readings
from lie_rigid_body.diagnosis.outputs import CODED
from lie_rigid_body.diagnosis.repairs import Repairs
from lie_rigid_body.estimates.buffers import usable
from lie_rigid_body.estimates.estimators import Estimator, called
from lie_rigid_body.evaluation.attitudes import angles_between
from lie_rigid_body.evaluation.causes import IDENTITY, undone
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion

ALIKE: Final = 0.25
"""Largest ratio of the turn between two first attitudes of a filter to that between the true ones, where it does not
begin with its readings."""
STILL: Final = math.radians(0.01)
"""Largest change of the mean answer from one second at rest to the next, rad, of a filter that has settled."""
CALM: Final = 5
"""Number of such seconds after which it has settled."""


@short_dataclass(eq=False)
class Answer:
    """Estimate of a filter in a course.

    Attributes
    ----------
    track : Matched
        Repaired and normalised attitudes of the part of the course that counts, beside the truth; the identity where
        one is broken.
    broken : ndarray of int64
        Numbers of the samples whose attitudes no score can use.
    given : Estimate
        Estimate as the filter returned it, of the same part.
    settled_s : float
        Time at rest after which the answers stand still, s; infinite where that is not seen.
    restless : float
        RMS of their motion about the mean of each second then, rad.
    """

    track: Matched
    broken: Integers
    given: Estimate
    settled_s: float
    restless: float

    @property
    def t_s(self) -> Array:
        """Times since the first sample that counts, s, shape (N,)."""
        return np.asarray((self.track.stamps_ns - self.track.stamps_ns[0]) / 1e9)

    def error(self, begin: float = 1.0 / 3.0, end: float = 1.0) -> float:
        """RMS of the total error, rad, from one share of the samples to another; by default of the last two thirds."""
        return error_of([self.track.fraction(begin, end)])


@dataclass(frozen=True)
class Job:
    """One run of the filter: a course whose readings are repaired, and the estimate.

    Attributes
    ----------
    course : Course
    repairs : tuple of Repair
    is_level : bool
        Whether the error is that of the vertical alone, as of a filter without a magnetometer.
    """

    course: Course
    repairs: Repairs = ()
    is_level: bool = False

    def __call__(self, estimate: Estimator) -> Answer:
        """Run the filter, and repair its estimate.

        Raises
        ------
        FilterError
            With the line in the user's file, or with the shape; or if no attitude is of the last two thirds.
        """
        course = self.course
        given = readings(course)
        for repair in self.repairs:
            given = repair.change(given) if repair.change else given
        found = called(estimate, given.run(), course.settle_s + course.counted_s / 3.0)
        broken = ~usable(found)
        attitude = quaternion.normalize(np.where(broken[:, np.newaxis], IDENTITY, found.attitude_xyzw))
        rest = found.t_ns < 10**9 * int(course.settle_s + course.rest_s)
        counted = slice(int(np.searchsorted(found.t_ns, course.begin_ns)), None)
        track = Matched(found.t_ns[counted], attitude[counted], course, origin_ns=0, is_level=self.is_level)
        causes = [(CODED[each.code], each.constants) for each in self.repairs if each.change is None]
        return Answer(
            undone(track, causes),
            np.flatnonzero(broken[counted]),
            found[counted],
            *at_rest(found.t_ns[rest], attitude[rest]),
        )


def first_attitude(answers: Sequence[Answer]) -> Array | None:
    """The attitude with which a filter begins, if that is nearly the same where two bodies begin with others."""
    told = [answer.track.attitude_xyzw[0] for answer in answers]
    true = [answer.track.truth_xyzw[0] for answer in answers]
    return told[0] if len(told) == 2 and angles_between(*told) < ALIKE * angles_between(*true) else None


def at_rest(stamps_ns: Integers, attitude_xyzw: Array) -> tuple[float, float]:
    """Time at rest after which the answers stand still, s, and RMS of their motion in the last calm seconds, rad.

    A second is calm where the mean of its answers is within `STILL` of that of the second before. The time is infinite
    where fewer than `CALM` calm seconds are there.
    """
    second, first = np.unique(stamps_ns // 10**9, return_index=True)
    if len(second) <= CALM:
        return np.inf, 0.0
    matrices = quaternion.to_matrix(attitude_xyzw)
    counts = np.diff([*first, len(matrices)])
    mean = np.add.reduceat(matrices, first, axis=0) / counts[:, np.newaxis, np.newaxis]
    moved = _angle(np.diff(mean, axis=0))
    restless = np.flatnonzero(~(moved <= STILL))
    begin = int(restless[-1]) + 1 if restless.size else 0
    settled = float(second[begin]) if len(moved) - begin >= CALM else np.inf
    return settled, rms(_angle(matrices - np.repeat(mean, counts, axis=0))[first[-CALM] :])


def _angle(difference: Array) -> Array:
    """Angle of the small rotation between matrices, rad, from their difference, shape (N, 3, 3)."""
    return np.asarray(np.sqrt(0.5) * np.linalg.norm(difference, axis=(1, 2)))
