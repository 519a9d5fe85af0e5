"""The true attitude at any time of a run, from its scenario."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import SampledTruth, Truth
from lie_rigid_body.evaluation.attitude_error import unit
from lie_rigid_body.evaluation.estimate import read_stamps
from lie_rigid_body.lie import quaternion
from lie_rigid_body.simulation import Segment


class ScenarioTruth(Truth):
    """The motion of a scenario, and of those that follow at its resets, known at every instant.

    It is the exact solution. Where samples of the motion are given, they are the truth at their stamps, to round-off;
    between them the exact solution is turned by what it misses them by, which is interpolated on geodesics. That is
    round-off for the default stepper, and keeps to the motion of a poor one, which the sensors have read.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    first_ns, last_ns : int
        The stamps between which it may be asked.
    stamps_ns : array_like of int, shape (N,), optional
        Stamps of samples, increasing.
    attitude_xyzw : array_like, shape (N, 4), optional
        Their attitudes.

    Raises
    ------
    InputError
        If it ends before it begins, or a sample is not finite or zero.
    """

    def __init__(
        self,
        segments: Sequence[Segment],
        first_ns: int,
        last_ns: int,
        stamps_ns: ArrayLike = (),
        attitude_xyzw: ArrayLike = (),
    ) -> None:
        if last_ns < first_ns:
            raise InputError(f"truth: it ends at {last_ns} ns, before its begin at {first_ns} ns")
        self.first_ns, self.last_ns = int(first_ns), int(last_ns)
        self._starts = np.array([segment.start_ns for segment in segments], dtype=np.int64)
        self._motions = [segment.scenario.exact_motion() for segment in segments]
        self._correction: SampledTruth | None = None
        if np.size(stamps_ns):
            stamps = read_stamps("truth", stamps_ns)
            miss = quaternion.multiply(quaternion.conjugate(self._exact(stamps)), unit("truth", attitude_xyzw))
            self._correction = SampledTruth(stamps, miss, longest_gap_ns=self.last_ns - self.first_ns)

    def at(self, stamps_ns: Integers) -> Array:
        """The exact solution, turned to the samples."""
        exact = self._exact(stamps_ns)
        return exact if self._correction is None else quaternion.multiply(exact, self._correction.at(stamps_ns))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """What the interpolation between samples may miss, rad."""
        return 0.0 if self._correction is None else self._correction.uncertainty_at(stamps_ns)

    def _exact(self, stamps_ns: Integers) -> Array:
        stamps = np.ravel(stamps_ns)
        which = np.maximum(np.searchsorted(self._starts, stamps, side="right") - 1, 0)
        attitude = np.empty((len(stamps), 4))
        for i in np.unique(which):
            inside = which == i
            attitude[inside] = self._motions[i].at(stamps[inside] - self._starts[i]).attitude_xyzw
        return attitude.reshape(*np.shape(stamps_ns), 4)
