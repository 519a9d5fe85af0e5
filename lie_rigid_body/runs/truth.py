"""The true attitude at any time: from the scenario of a run, and as scenarios and poses of bags and topics tell it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import SampledTruth, Truth
from lie_rigid_body.evaluation.arguments import read_stamps, unit
from lie_rigid_body.evaluation.consistency import covariance_fault
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.definitions import IMU
from lie_rigid_body.recording.topic_messages import AttitudeTrack
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import shown


class ScenarioTruth(Truth):
    """The motion of a scenario, and of those that follow at its resets, known at every instant.

    It is the exact solution. Where samples of the motion are given, they are the truth at their stamps, to round-off.
    Between them the exact solution is turned by what it misses them by, which is interpolated on geodesics, from
    nothing at the start of each segment on. That is round-off for the default stepper, and keeps to the motion of a
    poor one, which the sensors have read.

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
        self._corrections: dict[int, _Correction] = {}
        if np.size(stamps_ns):
            stamps = read_stamps("truth", stamps_ns)
            miss = quaternion.multiply(unit("truth", attitude_xyzw), quaternion.conjugate(self._exact(stamps)))
            for i, inside in self._segments_of(stamps):
                self._corrections[i] = _Correction(int(self._starts[i]), stamps[inside], miss[inside])

    @classmethod
    def of_samples(cls, segments: Sequence[Segment], stamps_ns: Integers, attitude_xyzw: ArrayLike) -> ScenarioTruth:
        """The motion from the first sample until just before the one that would follow the last."""
        clock, last_ns = segments[-1].clock(), int(stamps_ns[-1])
        end_ns = max(clock.stamp_ns(clock.count_until(last_ns)) - 1, last_ns)
        return cls(segments, int(stamps_ns[0]), end_ns, stamps_ns, attitude_xyzw)

    def at(self, stamps_ns: Integers) -> Array:
        """The exact solution, turned to the samples."""
        stamps = np.asarray(stamps_ns)
        attitude = self._exact(stamps)
        for i, inside in self._segments_of(stamps):
            if i in self._corrections:
                miss = self._corrections[i].at(stamps[inside])
                attitude[inside] = quaternion.multiply(miss, attitude[inside])
        return attitude

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Largest error of the interpolation between samples, rad."""
        pieces = ((i, inside) for i, inside in self._segments_of(stamps_ns) if i in self._corrections)
        return max((self._corrections[i].uncertainty_at(stamps_ns[inside]) for i, inside in pieces), default=0.0)

    def _exact(self, stamps_ns: Integers) -> Array:
        attitude = np.empty((*np.shape(stamps_ns), 4))
        for i, inside in self._segments_of(stamps_ns):
            attitude[inside] = self._motions[i].at(stamps_ns[inside] - self._starts[i]).attitude_xyzw
        return attitude

    def _segments_of(self, stamps_ns: Integers) -> Iterator[tuple[int, Booleans]]:
        """The segments in force at some stamps, by their numbers, and which stamps are in each."""
        which = np.asarray(np.maximum(np.searchsorted(self._starts, stamps_ns, side="right") - 1, 0))
        for i in np.unique(which):
            yield int(i), which == i


class _Correction(SampledTruth):
    """Rotation by which the exact solution misses samples of a segment: none at its start, where every stepper begins.

    It is a rotation on the world's axes: on those of the body it would turn with the body from sample to sample. Behind
    the last two samples it goes on for as long as these are apart, and stays. It grows slowly, so that two near samples
    tell nothing of a far time.
    """

    def __init__(self, start_ns: int, stamps: Integers, miss: Array) -> None:
        self._begin_ns, self._unsampled = int(stamps[0]), float(np.linalg.norm(quaternion.log(miss[0])))
        if start_ns < stamps[0]:
            stamps, miss = np.insert(stamps, 0, start_ns), np.insert(miss, 0, [0.0, 0.0, 0.0, 1.0], axis=0)
        super().__init__(stamps, miss, longest_gap_ns=int(stamps[-1] - stamps[0]))
        self._bounds = stamps[0], 2 * stamps[-1] - stamps[-2:][0]

    def at(self, stamps_ns: Integers) -> Array:
        return super().at(np.clip(stamps_ns, *self._bounds))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Before the first sample all that the exact solution misses it by: how that came about is not known."""
        before = self._unsampled if np.any(stamps_ns < self._begin_ns) else 0.0
        return max(before, super().uncertainty_at(stamps_ns))


@short_dataclass(frozen=True)
class TrueMotion:
    """True motion as it is told: by scenarios, poses, or both.

    Parameters
    ----------
    segments : tuple of Segment
        In the order of their starts; empty if no scenario is known.
    poses : AttitudeTrack or None
    """

    segments: tuple[Segment, ...]
    poses: AttitudeTrack | None

    @property
    def frames(self) -> tuple[str, str] | None:
        """Names of the world's and the body's frame, if a scenario tells them."""
        scenario = self.segments[0].scenario if self.segments else None
        return None if scenario is None else (scenario.world_frame, scenario.body_frame)

    @property
    def source(self) -> str:
        """Names of what it is made of."""
        return " and ".join([*(["poses"] if self.poses is not None else []), *(["scenario"] if self.segments else [])])

    def until(self, last_ns: int) -> Truth:
        """The truth as a function of time; without poses it is asked until the given stamp at most."""
        if self.poses is None:
            start = self.segments[0].start_ns
            return ScenarioTruth(self.segments, start, max(last_ns, start))
        stamps, first = np.unique(self.poses.stamps_ns, return_index=True)
        attitude = self.poses.attitude_xyzw[first]
        if not self.segments:
            return SampledTruth(stamps, attitude)
        return ScenarioTruth.of_samples(self.segments, stamps, attitude)

    def notes_on(self, track: AttitudeTrack) -> Iterator[str]:
        """What a reader of the score of some attitudes should know, one sentence each."""
        if self.poses is None:
            start, first = self.segments[0].start_ns, int(track.stamps_ns[0])
            yield (
                f"The truth is that of the scenario alone, from {start / 1e9:.13g} s on; the estimate begins "
                f"{(first - start) / 1e9:.9g} s after that."
            )
        # an Imu is stamped with the frame of the sensor (REP-145)
        world = self.frames[0] if self.frames else self.poses.frame if self.poses is not None else ""
        ours = {world}
        if track.message_type == IMU and self.segments:
            parameters = self.segments[0].scenario.parameters()
            ours |= {self.segments[0].scenario.body_frame, str(parameters.get("imu_frame", "imu_link"))}
        if track.frame not in ours and not (track.message_type == IMU and not self.segments):
            yield (
                f"The frame of the estimate is {shown(track.frame)}, that of the truth {shown(world)}: they are taken "
                "for the same. Is it the right topic?"
            )
        if self.frames and track.child_frame and track.child_frame != self.frames[1]:
            yield (
                f"The body of the estimate is {shown(track.child_frame)}, that of the truth {shown(self.frames[1])}: "
                "they are taken for the same. Is it the right body?"
            )
        fault = "" if track.covariance is None else covariance_fault(track.covariance)
        if fault:
            yield f"There is no NEES: {fault}."
