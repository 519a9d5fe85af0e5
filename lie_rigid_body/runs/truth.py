"""Truth of a run, as scenarios and poses tell it: the attitude at any time, and the least error that sensors leave."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import (
    AttitudeReadings,
    BiasNoise,
    SampledTruth,
    Truth,
    UnavoidableError,
    VectorReadings,
    unavoidable_error,
)
from lie_rigid_body.evaluation.arguments import as_stamps, integer_stamps, read_stamps, unit
from lie_rigid_body.evaluation.consistency import covariance_fault, unknown_covariances
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, shown
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.messages.definitions import IMU
from lie_rigid_body.recording.topic_messages import AttitudeTrack
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Sensors
from lie_rigid_body.sensors.sensor import VectorAid
from lie_rigid_body.simulation import SampleClock, Segment

THINNED: Final = 40_000
"""Number of IMU readings at which the bound of a score is computed, in a few seconds at most.

Measured over an hour: within 1.5 % of the bound of all (rms, median, 95 % and last) up to 3 rad/s, at 20 rad/s 12 %.
"""
MOST_DECLARED: Final = 20_000_000
"""Largest number of declared readings of a run of which a bound is computed: their stamps take half a gigabyte."""
SETTLES_S: Final = 1.0
"""Time in which a right filter corrects the error of its gyro, s."""
LEFT: Final = 1.5
"""Largest turn that sensor errors leave in a right filter, as a multiple of the expected one."""
FEWEST_READINGS: Final = 100
"""Least number of IMU readings in a segment at which the bound is computed. The segments share the other readings by
their durations."""


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
        stamps = integer_stamps("truth", stamps_ns)
        attitude = self._exact(stamps)
        for i, inside in self._segments_of(stamps):
            if i in self._corrections:
                miss = self._corrections[i].at(stamps[inside])
                attitude[inside] = quaternion.multiply(miss, attitude[inside])
        return attitude

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

    def _exact(self, stamps_ns: Integers) -> Array:
        attitude = np.empty((*np.shape(stamps_ns), 4))
        for i, inside in self._segments_of(stamps_ns):
            attitude[inside] = self._motions[i].at(stamps_ns[inside] - self._starts[i]).attitude_xyzw
        return attitude

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
        self._begin_ns, self._unsampled = int(stamps[0]), float(np.linalg.norm(quaternion.log(miss[0])))
        if start_ns < stamps[0]:
            stamps, miss = np.insert(stamps, 0, start_ns), np.insert(miss, 0, [0.0, 0.0, 0.0, 1.0], axis=0)
        super().__init__(stamps, miss, longest_gap_ns=int(stamps[-1] - stamps[0]))
        self._bounds = stamps[0], 2 * stamps[-1] - stamps[-2:][0]

    def at(self, stamps_ns: Integers) -> Array:
        return super().at(np.clip(stamps_ns, *self._bounds))

    def uncertainty_at(self, stamps_ns: Integers) -> float:
        """Largest error of the correction, rad: all of it before the first sample, where its course is unknown."""
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
        scenarios = (segment.scenario for segment in self.segments)
        return next(((each.world_frame, each.body_frame) for each in scenarios), None)

    @property
    def source(self) -> str:
        """Names of the sources: poses, scenario, or both."""
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
        yield from self._events_of(track)
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
        if track.covariance is not None:
            unknown = unknown_covariances(track.covariance)
            if fault := covariance_fault(track.covariance):
                yield f"There is no NEES: {fault}."
            elif unknown.any() and not unknown.all():
                yield f"There is no NEES: {unknown.sum()} of {len(unknown)} covariances are unknown: give all or none."

    def _events_of(self, track: AttitudeTrack) -> Iterator[str]:
        """Sentences about what scenarios declare, and no filter can help: resets, lost readings, an erring clock."""
        begin, end = track.stamps_ns[[0, -1]].tolist()
        resets = [segment.start_ns for segment in self.segments[1:] if begin < segment.start_ns <= end]
        if resets:
            yield f"The motion began anew at {resets[0] / 1e9:.13g} s, {counted(len(resets), 'reset')} in all."
        of_imu = [imu.delivery for segment in self.segments if (imu := segment.scenario.sensors.imu) and imu.delivery]
        if any(delivery.dropout_probability or delivery.outage for delivery in of_imu):
            yield "The scenario declares that readings of the IMU are lost: gaps of the estimate may be theirs."
        if any(delivery.is_off for delivery in of_imu):
            yield "The scenario declares that the clock of the IMU errs: so do stamps that a filter takes from it."


def unavoidable_error_of(segments: Sequence[Segment], last_ns: int, most: int | None = None) -> UnavoidableError | None:
    """The bound for an estimator that reads every sensor of a run, and knows all of them but noise and biases.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts. At each the attitude is unknown, and the biases are.
    last_ns : int
        The last stamp that counts, ns.
    most : int, optional
        About how many readings of the IMU the bound is computed at, all of them by default. Of more they are all at
        first, while the error falls, and then ever fewer. Readings of all sensors count, at the one kept before them.

    Returns
    -------
    UnavoidableError or None
        None without an IMU, or where a sensor that tells the attitude has no noise: then the bound is 0. It is None as
        well where the IMU tells its orientation, whose noise is not that of an independent reading.

    Raises
    ------
    InputError
        If the scenario declares more than `MOST_DECLARED` readings, or a vector or a noise is too small or too large.
    """
    if not segments or not all(_has_noise(segment.scenario.sensors) for segment in segments):
        return None
    whole, parts, declared = max(1, last_ns - segments[0].start_ns), list[UnavoidableError](), 0.0
    for segment, later in zip_longest(segments, segments[1:]):
        end = min(last_ns, later.start_ns - 1 if later else last_ns)
        declared += sum(segment.scenario.rates[1:]) * (end - segment.start_ns) / NS
        if declared > MOST_DECLARED:
            raise InputError(
                f"the scenario declares {declared:.3g} readings, and the unavoidable error is computed of "
                f"{MOST_DECLARED:g}: take a shorter run"
            )
        share = None if most is None else max(FEWEST_READINGS, most * (end - segment.start_ns) // whole)
        stamps = _stamps(segment, segment.scenario.sensors.imu.rate, end)
        parts += [_of_segment(segment, stamps, end, share)] if len(stamps) else []
    return _in_turn(parts)


def _in_turn(parts: Sequence[UnavoidableError]) -> UnavoidableError | None:
    """Bounds of consecutive segments as one; None without a segment."""
    if not parts:
        return None
    return UnavoidableError(
        np.concatenate([part.filtered for part in parts]),
        np.concatenate([part.smoothed for part in parts]),
        np.concatenate([part.gyro_bias for part in parts]),
        np.concatenate([part.stamps_ns for part in parts]),
        next((part.unobserved for part in parts if part.unobserved), ""),
        _in_turn([part.calibrated for part in parts if part.calibrated is not None]),
    )


def at_limit(gyro: Array, scenario: Scenario) -> float:
    """Share of readings, shape (N, 3), of which an axis is at the limit of the gyro's range; 0 without a range."""
    reach, step = (float(str(scenario.parameters()[f"gyro_{name}"])) for name in ("range", "resolution"))
    return float(np.mean((np.abs(gyro) > reach - (step or 1e-9 * reach)).any(axis=1))) if reach and len(gyro) else 0.0


def bound_of(segments: Sequence[Segment], truth: Truth, stamps_ns: Integers) -> UnavoidableError | None:
    """The bound for the score of an estimate at some stamps, thinned; None where it is not known.

    A score does not fail for want of it, as with a noise whose square is no number.
    """
    try:
        with np.errstate(all="ignore"):
            bound = unavoidable_error_of(segments, min(int(stamps_ns.max()), truth.last_ns), THINNED)
    except (InputError, np.linalg.LinAlgError):
        return None
    return bound if bound is not None and np.isfinite([bound.filtered, bound.smoothed]).all() else None


def left_by_errors_of(segments: Sequence[Segment]) -> float:
    """Largest constant turn, rad, that the declared errors of a run's sensors leave to a right filter; 0 if perfect.

    A vector that is read with an error e leaves e over the sine of the angle between two vectors, so hard iron turns
    the heading by e / cos dip. A gyro leaves what it errs by in `SETTLES_S`, over the same sine. They count as
    independent.
    """
    return max((_left_by_errors(segment.scenario) for segment in segments), default=0.0)


@np.errstate(over="ignore")  # a vector may be as near to 0 as numbers get, and tells nothing then
def _left_by_errors(scenario: Scenario) -> float:
    imu, sensors = scenario.sensors.imu, scenario.sensors.on.values()
    aids = [aid for model in sensors for aid in model.aids if isinstance(aid, VectorAid)]
    if imu is None:
        return 0.0
    references = np.array([aid.reference for aid in aids]).reshape(-1, 3)
    lengths = so3.norm(references)
    directions = references / lengths[:, np.newaxis]
    across = np.linalg.norm(np.cross(directions[:, np.newaxis], directions), axis=-1).max(initial=0.0) or 1.0
    told = np.sqrt(2.0) * np.array([aid.turn_on_bias for aid in aids]) / lengths
    vectors = np.linalg.norm([*told, *imu.accelerometer.misalignment])
    scale = np.linalg.norm(np.subtract(imu.gyro.scale_factor, 1.0)) + np.linalg.norm(imu.gyro.misalignment)
    rate = np.sqrt(3.0) * imu.gyro.turn_on_bias + scale * np.linalg.norm(scenario.initial_body_rate)
    return float(LEFT * np.hypot(vectors, SETTLES_S * rate) / across)


def _of_segment(segment: Segment, every: Integers, last_ns: int, most: int | None) -> UnavoidableError:
    scenario, imu = segment.scenario, segment.scenario.sensors.imu
    aids = [*_aids(segment, last_ns)]
    numbers = _kept(every, [np.asarray(aid.stamps_ns) for aid in aids], most)
    stamps = every[numbers]
    return unavoidable_error(
        stamps,
        scenario.exact_motion().at(stamps - segment.start_ns).attitude_xyzw,
        gyro_noise=imu.gyro.noise_density * np.sqrt(imu.rate),
        gyro_bias=BiasNoise(imu.gyro.turn_on_bias, float(imu.gyro.bias_random_walk / np.sqrt(imu.rate))),
        vectors=[aid for aid in aids if isinstance(aid, VectorReadings)],
        attitudes=[aid for aid in aids if isinstance(aid, AttitudeReadings)],
        gyro_readings=np.diff(numbers, prepend=-1),
        gyro_linear_errors=imu.gyro.linear_errors,
    )


def _kept(stamps: Integers, others: Sequence[Integers], most: int | None) -> Integers:
    """Numbers of the readings at which the bound is computed: all at first, then ever fewer, and the last.

    Those by which a slow sensor reads are kept, and those before them: in between the error grows, and then it falls.
    """
    if most is None or len(stamps) <= most:
        return np.arange(len(stamps))
    even = np.linspace(0.0, 1.0, most)
    kept = [np.arange(most) + np.rint((len(stamps) - most) * even**1.5).astype(np.int64)]
    for readings in others:
        if len(readings) <= most:
            at = np.searchsorted(stamps, readings, side="right") - 1
            kept += [at, at - 1]
    numbers = np.unique(np.concatenate(kept))
    return numbers[numbers >= 0]


def _aids(segment: Segment, last_ns: int) -> Iterator[VectorReadings | AttitudeReadings]:
    """Readings of vectors and of attitudes by which the sensors of a segment tell the attitude."""
    for model in segment.scenario.sensors.on.values():
        stamps = _stamps(segment, model.rate, last_ns)
        for aid in model.aids if len(stamps) else ():
            if isinstance(aid, VectorAid):
                bias = BiasNoise(aid.turn_on_bias, aid.bias_step)
                yield VectorReadings(stamps, aid.reference, aid.noise, bias, aid.linear_errors)
            else:
                across, about, axis = aid.across**2, aid.about**2, np.outer(aid.axis, aid.axis)
                yield AttitudeReadings(stamps, across * np.eye(3) + (about - across) * axis)


def _has_noise(sensors: Sensors) -> bool:
    """Whether there is an IMU, and each sensor that tells of the attitude has white noise: else no error is left."""
    imu, aids = sensors.imu, [aid for model in sensors.on.values() for aid in model.aids]
    told = imu is not None and imu.orientation is None and imu.gyro.noise_density
    return bool(told and not any(aid.is_exact for aid in aids))


def _stamps(segment: Segment, rate: float, last_ns: int) -> Integers:
    """Stamps of a sensor's readings in a segment, ns."""
    clock = SampleClock(segment.scenario.epoch_ns, rate)
    first = clock.count_until(segment.start_ns - 1)
    return clock.stamps_ns(first, max(0, clock.count_until(last_ns) - first))
