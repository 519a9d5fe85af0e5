"""The motion of a scenario as a truth: the attitude at any time, turned to the samples where there are some."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import SampledTruth, Truth
from lie_rigid_body.evaluation.arguments import as_stamps, read_stamps, unit
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.simulation import Segment

ROUND_OFF: Final = 1e-14
"""Largest miss of samples, rad, that is left: the last digit that is shown of an error is as small."""


class ScenarioTruth(Truth):
    """The motion of a scenario, and of those that follow at its resets, known at every instant.

    It is the exact solution. Where samples of the motion are given, they are the truth at their stamps, to round-off.
    Between them the exact solution is turned by what it misses them by, which is interpolated on geodesics, from
    nothing at the start of each segment on. That keeps to the motion of a poor stepper, which the sensors have read. In
    a segment where it misses none by more than `ROUND_OFF` it is left as it is.

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
        self.first_ns = int(first_ns)
        self.last_ns = int(last_ns)
        self._starts = np.array([segment.start_ns for segment in segments], dtype=np.int64)
        self._motions = [segment.scenario.exact_motion() for segment in segments]
        self._corrections: dict[int, _Correction] = {}
        if np.size(stamps_ns):
            stamps = read_stamps("truth", stamps_ns)
            miss = quaternion.multiply(unit("truth", attitude_xyzw), quaternion.conjugate(self._exact(stamps)[0]))
            for i, inside in self._segments_of(stamps):
                if norm(quaternion.log(miss[inside])).max() > ROUND_OFF:
                    self._corrections[i] = _Correction(int(self._starts[i]), stamps[inside], miss[inside])

    @classmethod
    def of_samples(cls, segments: Sequence[Segment], stamps_ns: Integers, attitude_xyzw: ArrayLike) -> ScenarioTruth:
        """The motion from the first sample until just before the one that would follow the last."""
        clock = segments[-1].clock()
        last_ns = int(stamps_ns[-1])
        end_ns = max(clock.stamp_ns(clock.count_until(last_ns)) - 1, last_ns)
        return cls(segments, int(stamps_ns[0]), end_ns, stamps_ns, attitude_xyzw)

    def at(self, stamps_ns: Integers) -> Array:
        """The exact solution, turned to the samples."""
        return self._corrected(as_stamps("truth", stamps_ns))[0]

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitude and the body rate of the exact solution; see `Truth`."""
        return self._corrected(np.clip(as_stamps("truth", stamps_ns), self.first_ns, self.last_ns))

    def _corrected(self, stamps: Integers) -> tuple[Array, Array]:
        attitude, rate = self._exact(stamps)
        for i, inside in self._segments_of(stamps):
            if i in self._corrections:
                miss = self._corrections[i].at(stamps[inside])
                attitude[inside] = quaternion.multiply(miss, attitude[inside])
        return attitude, rate

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Largest error of the interpolation between samples, rad."""
        stamps = as_stamps("truth", stamps_ns)
        pieces = ((i, inside) for i, inside in self._segments_of(stamps) if i in self._corrections)
        return max((self._corrections[i].uncertainty_at(stamps[inside]) for i, inside in pieces), default=0.0)

    def smooth_around(self, stamps_ns: Integers) -> tuple[Integers, Integers]:
        """First and last time of the segment of each stamp, ns."""
        which = self._segment_at(stamps_ns)
        ends = np.append(self._starts[1:] - 1, self.last_ns)
        return np.maximum(self._starts[which], self.first_ns), np.minimum(ends[which], self.last_ns)

    def _exact(self, stamps_ns: Integers) -> tuple[Array, Array]:
        attitude = np.empty((*np.shape(stamps_ns), 4))
        rate = np.empty((*np.shape(stamps_ns), 3))
        for i, inside in self._segments_of(stamps_ns):
            exact = self._motions[i].at(stamps_ns[inside] - self._starts[i])
            attitude[inside] = exact.attitude_xyzw
            rate[inside] = exact.body_rate
        return attitude, rate

    def _segments_of(self, stamps_ns: Integers) -> Iterator[tuple[int, Booleans]]:
        """The segments in force at some stamps, by their numbers, and which stamps are in each."""
        which = self._segment_at(stamps_ns)
        for i in np.unique(which):
            yield int(i), which == i

    def _segment_at(self, stamps_ns: Integers) -> Integers:
        """Number of the segment in force at each stamp."""
        return np.asarray(np.maximum(np.searchsorted(self._starts, stamps_ns, side="right") - 1, 0))


class _Correction(SampledTruth):
    """Rotation by which the exact solution misses samples of a segment: none at its start, where every stepper begins.

    It is a rotation on the world's axes: on those of the body it would turn with the body from sample to sample. Behind
    the last two samples it goes on for as long as these are apart, and stays. It grows slowly, so that two near samples
    tell nothing of a far time.
    """

    def __init__(self, start_ns: int, stamps: Integers, miss: Array) -> None:
        self._begin_ns = int(stamps[0])
        self._unsampled = float(np.linalg.norm(quaternion.log(miss[0])))
        if start_ns < stamps[0]:
            stamps = np.insert(stamps, 0, start_ns)
            miss = np.insert(miss, 0, [0.0, 0.0, 0.0, 1.0], axis=0)
        super().__init__(stamps, miss, longest_gap_ns=int(stamps[-1] - stamps[0]))
        self._bounds = stamps[0], 2 * stamps[-1] - stamps[-2:][0]

    def at(self, stamps_ns: Integers) -> Array:
        return super().at(np.clip(stamps_ns, *self._bounds))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Largest error of the correction, rad: all of it before the first sample, where its course is unknown."""
        before = self._unsampled if np.any(stamps_ns < self._begin_ns) else 0.0
        return max(before, super().uncertainty_at(stamps_ns))
