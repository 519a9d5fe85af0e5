"""The Cramér–Rao bound of a run, and what the declared errors of its sensors leave to a right filter."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import Any, Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.evaluation import Truth
from lie_rigid_body.evaluation.cramer_rao_bound import (
    AttitudeReadings,
    BiasNoise,
    CramerRaoBound,
    NoisySensors,
    VectorReadings,
    cramer_rao_bound,
    dynamic_bound,
)
from lie_rigid_body.evaluation.scoring import SensorLimits
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors.sensor import AttitudeMeasurement, SensorModel, VectorMeasurement
from lie_rigid_body.simulation import SampleClock, Segment

THINNED: Final = 5_000
"""Number of IMU readings at which the bound of a score is computed, in half a second.

Measured with MEMS sensors over an hour: within 0.8 % of the bound of all readings in RMS, 1.0 % in the median. Over ten
minutes within 0.1 %, at 3 rad/s 0.4 %.
"""
DYNAMIC: Final = 500
"""Largest number of IMU readings at which the bound of filters that know the dynamics is computed.

Measured over 60 s, ten minutes and an hour: within 0.7 % of the bound of 5 000 readings in RMS and median.
"""
MAX_BOUNDED: Final = 20_000
"""Largest number of IMU readings at which the bound of a run is computed: their covariances take 700 MB."""
MAX_DECLARED: Final = 20_000_000
"""Largest number of declared readings of a run of which a bound is computed: their stamps take half a gigabyte."""
SETTLES_S: Final = 1.0
"""Time in which a right filter corrects the error of its gyro, s."""
LEFT: Final = 1.5
"""Largest turn that sensor errors leave in a right filter, as a multiple of the expected one."""
MIN_READINGS: Final = 100
"""Smallest number of IMU readings in a segment at which the bound is computed. The segments share the other readings by
their durations."""


def cramer_rao_bound_of(segments: Sequence[Segment], last_ns: int, most: int = MAX_BOUNDED) -> CramerRaoBound | None:
    """The bound for estimators that read every sensor of a run, and know all of its errors but noise and biases.

    They do not know the dynamics; those that do have the bound in ``dynamic``, where no kicks interrupt the motion. The
    acceleration of a carried body counts as known along its own axes, so that it tells nothing of the heading. The
    bound is that of the same run without it.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts. At each the attitude is unknown, and the biases are.
    last_ns : int
        The last stamp that counts, ns.
    most : int, optional
        About how many readings of the IMU the bound is computed at: evenly, and ever denser toward both ends. Readings
        of all sensors count, at the one kept before them.

    Returns
    -------
    CramerRaoBound or None
        None without an IMU, or where a sensor that tells the attitude has no noise: then the bound is 0. It is None as
        well where the IMU tells its orientation, whose noise is not that of an independent reading.

    Raises
    ------
    InputError
        If the scenario declares more than `MAX_DECLARED` readings, or a vector or a noise is too small or too large.
    """
    if not segments or not all(_has_noise(segment.scenario) for segment in segments):
        return None
    whole = max(1, last_ns - segments[0].start_ns)
    parts = list[CramerRaoBound]()
    declared = 0.0
    for segment, later in zip_longest(segments, segments[1:]):
        end = min(last_ns, later.start_ns - 1 if later else last_ns)
        declared += sum(segment.scenario.rates[1:]) * (end - segment.start_ns) / NS
        if declared > MAX_DECLARED:
            raise InputError(
                f"the scenario declares {declared:.3g} readings, and a bound is computed of {MAX_DECLARED:g}: take a "
                "shorter run"
            )
        stamps = _stamps(segment, segment.scenario.sensors.imu.rate, end)
        if len(stamps):
            parts.append(_of_segment(segment, stamps, end, max(MIN_READINGS, most * (end - segment.start_ns) // whole)))
    return _in_turn(parts)


def _in_turn(parts: Sequence[CramerRaoBound]) -> CramerRaoBound | None:
    """Bounds of consecutive segments as one; None without a segment."""
    if not parts:
        return None
    of_stamps = ("filtered", "smoothed", "gyro_bias", "stamps_ns", "joint_ns")
    return CramerRaoBound(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in of_stamps},
        unobserved=next((part.unobserved for part in parts if part.unobserved), ""),
        calibrated=_in_turn([part.calibrated for part in parts if part.calibrated is not None]),
        dynamic=_in_turn([part.dynamic for part in parts if part.dynamic is not None]),
        joint=scipy.linalg.block_diag(*(part.joint for part in parts)),
        carried=any(part.carried for part in parts),
    )


def sensor_limits(
    segments: Sequence[Segment], truth: Truth, bounded_ns: int | None = None, gyro: Array | None = None
) -> SensorLimits:
    """Limits that the sensors of a run set to any estimate of it.

    Parameters
    ----------
    segments : sequence of Segment
        Empty where no scenario is known.
    truth : Truth
    bounded_ns : int, optional
        The last stamp of the estimate, ns, whose error is to be compared with a bound.
    gyro : ndarray, shape (N, 3), optional
        Readings of the gyro, rad/s.
    """
    bound = None if bounded_ns is None else _bound_of_score(segments, min(bounded_ns, truth.last_ns))
    share = 0.0 if gyro is None else at_limit(gyro, segments[0].scenario)
    imus = [segment.scenario.sensors.imu for segment in segments]
    thrown = any(segment.scenario.translation == "thrown" for segment in segments)
    weightless = thrown or any(imu is not None and not imu.support for imu in imus)
    return SensorLimits(bound, left_by_errors_of(segments), share, weightless)


def at_limit(gyro: Array, scenario: Scenario) -> float:
    """Share of readings, shape (N, 3), of which an axis is at the limit of the gyro's range; 0 without a range."""
    reach, step = (float(str(scenario.parameters()[f"gyro_{name}"])) for name in ("range", "resolution"))
    if not reach or not len(gyro):
        return 0.0
    return float(np.mean((np.abs(gyro) > reach - (step or 1e-9 * reach)).any(axis=1)))


def _bound_of_score(segments: Sequence[Segment], last_ns: int) -> CramerRaoBound | None:
    """The bound for the score of an estimate, thinned; None where it is not known.

    A score does not fail for want of it, as with a noise whose square is no number.
    """
    try:
        with np.errstate(all="ignore"):
            bound = cramer_rao_bound_of(segments, last_ns, THINNED)
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
    imu = scenario.sensors.imu
    aids = [aid for _, aid in _measurement_models(scenario) if isinstance(aid, VectorMeasurement)]
    if imu is None:
        return 0.0
    references = np.array([aid.reference for aid in aids]).reshape(-1, 3)
    lengths = norm(references)
    directions = references / lengths[:, np.newaxis]
    across = np.linalg.norm(np.cross(directions[:, np.newaxis], directions), axis=-1).max(initial=0.0) or 1.0
    told = np.sqrt(2.0) * np.array([aid.turn_on_bias for aid in aids]) / lengths
    vectors = np.linalg.norm([*told, *imu.accelerometer.misalignment])
    scale = np.linalg.norm(np.subtract(imu.gyro.scale_factor, 1.0)) + np.linalg.norm(imu.gyro.misalignment)
    rates = np.linalg.norm(scenario.arc_starts().body_rate, axis=1)
    fastest = scenario.rate_bound() if scenario.path() else float(rates.max())
    rate = np.sqrt(3.0) * imu.gyro.turn_on_bias + scale * fastest
    return float(LEFT * np.hypot(vectors, SETTLES_S * rate) / across)


def bound_of_readings(
    scenario: Scenario, truth: Truth, stamps: Mapping[str, Integers], most: int = MAX_BOUNDED
) -> CramerRaoBound | None:
    """The bound for estimators of readings whose scenario declares the sensors alone, at those within the truth.

    Parameters
    ----------
    scenario : Scenario
    truth : Truth
    stamps : mapping of str to ndarray of int64
        Those of each sensor, ns, by its name.
    most : int, optional
        As of `cramer_rao_bound_of`.

    Returns
    -------
    CramerRaoBound or None
        None where a sensor is without noise.

    Raises
    ------
    InputError
        If no reading of the IMU is within the truth.
    """
    known = {name: np.unique(each[truth.covers(each)]) for name, each in stamps.items()}
    every = known["imu"]
    if not len(every):
        raise InputError("no reading of the IMU is within the truth: give a truth of the same clock")
    if not _has_noise(scenario):
        return None
    own = {id(model): known.get(name, every[:0]) for name, model in scenario.sensors.on.items()}
    aids = [*_aids(scenario, lambda model: own[id(model)])]
    indices = _kept(every, [aid.stamps_ns for aid in aids], most)
    steps = np.diff(indices, prepend=-1).astype(np.float64)
    return cramer_rao_bound(every[indices], truth.at(every[indices]), _noise(scenario, aids), steps)


def _of_segment(segment: Segment, every: Integers, last_ns: int, most: int) -> CramerRaoBound:
    scenario = segment.scenario
    aids = [*_aids(scenario, lambda model: _stamps(segment, model.rate, last_ns))]
    sensors = _noise(scenario, aids)
    others = [aid.stamps_ns for aid in aids]
    indices, few = (_kept(every, others, count) for count in (most, min(most, DYNAMIC)))
    whole_steps, steps = (np.diff(each, prepend=-1).astype(np.float64) for each in (indices, few))
    t_ns = every - segment.start_ns
    start = scenario.start()

    def motion(attitude_xyzw: Array, body_rate: Array) -> tuple[Array, Array]:
        states = ClosedForm(scenario.body(), State(attitude_xyzw, body_rate)).at(t_ns[few])
        return states.attitude_xyzw, states.body_rate

    truth = scenario.exact_motion().at(t_ns[indices]).attitude_xyzw
    bound = cramer_rao_bound(every[indices], truth, sensors, whole_steps)
    bound = replace(bound, carried=scenario.sway() is not None or scenario.path() is not None)
    if scenario.kicks or scenario.path():  # nobody knows them, and between kicks the dynamics tell little
        return bound
    begin = (start.attitude_xyzw, start.body_rate)
    return replace(bound, dynamic=dynamic_bound(every[few], motion, begin, sensors, steps))


def _noise(scenario: Scenario, aids: Sequence[VectorReadings | AttitudeReadings]) -> NoisySensors:
    """Sensors as the bound takes them."""
    imu = scenario.sensors.imu
    return NoisySensors(
        imu.gyro.noise_density * np.sqrt(imu.rate),
        BiasNoise(imu.gyro.turn_on_bias, float(imu.gyro.bias_random_walk / np.sqrt(imu.rate))),
        [aid for aid in aids if isinstance(aid, VectorReadings)],
        [aid for aid in aids if isinstance(aid, AttitudeReadings)],
        imu.gyro.linear_errors,
    )


def _kept(stamps: Integers, others: Sequence[Integers], most: int) -> Integers:
    """Indices of the readings at which the bound is computed: evenly, and ever denser toward both ends.

    Those by which a slow sensor reads are kept, and those before them: in between the error grows, and then it falls.
    """
    if len(stamps) <= most:
        return np.arange(len(stamps))
    dense = np.geomspace(1.0, len(stamps), most // 10)
    kept: list[Any] = [np.linspace(0.0, len(stamps) - 1.0, most - 2 * len(dense)), dense - 1.0, len(stamps) - dense]
    for readings in others:
        if len(readings) <= most:
            at = np.searchsorted(stamps, readings, side="right") - 1
            kept += [at, at - 1]
    indices = np.unique(np.rint(np.concatenate(kept)).astype(np.int64))
    return indices[indices >= 0]


def _aids(
    scenario: Scenario, stamps_of: Callable[[SensorModel], Integers]
) -> Iterator[VectorReadings | AttitudeReadings]:
    """Readings of vectors and of attitudes by which the sensors of a scenario tell the attitude."""
    for model, aid in _measurement_models(scenario):
        stamps = stamps_of(model)
        if not len(stamps):
            continue
        if isinstance(aid, VectorMeasurement):
            bias = BiasNoise(aid.turn_on_bias, aid.bias_step)
            yield VectorReadings(stamps, np.array(aid.reference), aid.noise, bias, aid.linear_errors)
        else:
            across = aid.across**2
            about = aid.about**2
            axis = np.outer(aid.axis, aid.axis)
            yield AttitudeReadings(stamps, across * np.eye(3) + (about - across) * axis)


def _measurement_models(scenario: Scenario) -> Iterator[tuple[SensorModel, VectorMeasurement | AttitudeMeasurement]]:
    """Measurements of the attitude by the sensors of a scenario: the accelerometer of a thrown body has no vertical."""
    for name, model in scenario.sensors.on.items():
        if name != "imu" or scenario.translation != "thrown":
            yield from ((model, aid) for aid in model.measurement_models)


def _has_noise(scenario: Scenario) -> bool:
    """Whether there is an IMU, and each sensor that tells of the attitude has white noise: else no error is left."""
    imu = scenario.sensors.imu
    aids = [aid for _, aid in _measurement_models(scenario)]
    told = imu is not None and imu.orientation is None and imu.gyro.noise_density
    return bool(told and not any(aid.is_exact for aid in aids))


def _stamps(segment: Segment, rate: float, last_ns: int) -> Integers:
    """Stamps of a sensor's readings in a segment, ns."""
    clock = SampleClock(segment.scenario.epoch_ns, rate)
    first = clock.count_until(segment.start_ns - 1)
    return clock.stamps_ns(first, max(0, clock.count_until(last_ns) - first))
