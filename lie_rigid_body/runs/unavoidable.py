"""The error that the declared noise of a scenario's sensors leaves to any estimator at best."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import (
    AttitudeReadings,
    BiasNoise,
    Truth,
    UnavoidableError,
    VectorReadings,
    unavoidable_error,
)
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Sensors
from lie_rigid_body.sensors.sensor import VectorAid
from lie_rigid_body.simulation import SampleClock, Segment

THINNED: Final = 40_000
"""Readings of the IMU at which the bound is computed for a score, in a few seconds at most.

Measured over an hour: within 1.5 % of the bound of all (rms, median, 95 % and last) up to 3 rad/s, at 20 rad/s 12 %.
"""
SETTLES_S: Final = 1.0
"""Time in which a right filter corrects what its gyro errs by, s."""
LEFT: Final = 1.5
"""Ratio of the largest to the expected turn that errors of the sensors leave."""
FEWEST: Final = 100
"""Least number of such readings in a segment. The segments share the other readings by their durations."""


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
    """
    if not segments or not all(_has_noise(segment.scenario.sensors) for segment in segments):
        return None
    whole, parts = max(1, last_ns - segments[0].start_ns), list[UnavoidableError]()
    for segment, later in zip_longest(segments, segments[1:]):
        end = min(last_ns, later.start_ns - 1 if later else last_ns)
        share = None if most is None else max(FEWEST, most * (end - segment.start_ns) // whole)
        stamps = _stamps(segment, segment.scenario.sensors.imu.rate, end)
        parts += [_of_segment(segment, stamps, end, share)] if len(stamps) else []
    return _in_turn(parts)


def _in_turn(parts: Sequence[UnavoidableError]) -> UnavoidableError | None:
    """The bounds of several segments as one; None of none."""
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


def _left_by_errors(scenario: Scenario) -> float:
    imu, sensors = scenario.sensors.imu, scenario.sensors.on.values()
    aids = [aid for model in sensors for aid in model.aids if isinstance(aid, VectorAid)]
    if imu is None:
        return 0.0
    references = np.array([aid.reference for aid in aids]).reshape(-1, 3)
    lengths = np.linalg.norm(references, axis=-1)
    directions = references / lengths[:, np.newaxis]
    across = np.linalg.norm(np.cross(directions[:, np.newaxis], directions), axis=-1).max(initial=0.0) or 1.0
    told = np.sqrt(2.0) * np.array([aid.turn_on_bias for aid in aids]) / lengths
    vectors = np.linalg.norm([*told, *imu.accelerometer.misalignment])
    scale = np.linalg.norm(np.subtract(imu.gyro.scale_factor, 1.0)) + np.linalg.norm(imu.gyro.misalignment)
    rate = np.sqrt(3.0) * imu.gyro.turn_on_bias + scale * np.linalg.norm(scenario.initial_body_rate)
    return float(LEFT * np.hypot(vectors, SETTLES_S * rate) / across)


def _of_segment(segment: Segment, every: Integers, last_ns: int, most: int | None) -> UnavoidableError:
    scenario, imu = segment.scenario, segment.scenario.sensors.imu
    vectors, attitudes = _aids(segment, last_ns)
    numbers = _kept(
        every,
        [np.asarray(stamps) for stamps in (*(v.stamps_ns for v in vectors), *(a.stamps_ns for a in attitudes))],
        most,
    )
    stamps = every[numbers]
    return unavoidable_error(
        stamps,
        scenario.exact_motion().at(stamps - segment.start_ns).attitude_xyzw,
        gyro_noise=imu.gyro.noise_density * np.sqrt(imu.rate),
        gyro_bias=BiasNoise(imu.gyro.turn_on_bias, float(imu.gyro.bias_random_walk / np.sqrt(imu.rate))),
        vectors=vectors,
        attitudes=attitudes,
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


def _aids(segment: Segment, last_ns: int) -> tuple[list[VectorReadings], list[AttitudeReadings]]:
    """Readings of vectors and of attitudes by which the sensors of a segment tell the attitude."""
    vectors, attitudes = [], []
    for model in segment.scenario.sensors.on.values():
        stamps = _stamps(segment, model.rate, last_ns)
        for aid in model.aids if len(stamps) else ():
            if isinstance(aid, VectorAid):
                bias = BiasNoise(aid.turn_on_bias, aid.bias_step)
                vectors.append(VectorReadings(stamps, aid.reference, aid.noise, bias, aid.linear_errors))
            else:
                across, about, axis = aid.across**2, aid.about**2, np.outer(aid.axis, aid.axis)
                attitudes.append(AttitudeReadings(stamps, across * np.eye(3) + (about - across) * axis))
    return vectors, attitudes


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
