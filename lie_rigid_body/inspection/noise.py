"""Noise of sensors in the longest rest of a log, the bias of its gyro, and declared variances.

Rounding to a resolution r adds white noise of variance r²/12, which is taken off.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, runs_of
from lie_rigid_body.foundation.wording import numerals
from lie_rigid_body.inspection.findings import Findings, Mark
from lie_rigid_body.inspection.rule import (
    MAX_REST_COLOUR,
    MAX_REST_RATE,
    MAX_VARIANCE_RATIO,
    MIN_REST_S,
    REST_PARTS,
    REST_SIGMAS,
    REST_WINDOW_S,
)
from lie_rigid_body.inspection.stamps import Stream, resolution
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.runs import Run
from lie_rigid_body.sensors.allan import allan, density


def _at_rest(readings: Array, part: int) -> Booleans:
    """Whether each window is at rest: it scatters as white noise does, and its mean is as before, the gyro's small.

    The jerk by which a motion begins is as white as noise, but more than usual at rest.

    Parameters
    ----------
    readings : ndarray, shape (N, 6)
        Those of the gyro and of the accelerometer.
    part : int
        Number of readings in a part of a window.
    """
    size = part * REST_PARTS
    parts = readings[: len(readings) // size * size].reshape(-1, REST_PARTS, part, 6)
    means = parts.mean(axis=(1, 2))
    variances = parts.var(axis=(1, 2))
    is_white = parts.mean(axis=2).var(axis=1) * part <= MAX_REST_COLOUR * variances
    change = np.abs(np.diff(means, axis=0, prepend=means[:1]))
    is_steady = change <= REST_SIGMAS * np.sqrt(2.0 * variances / size)
    at_rest = (is_white & is_steady).all(axis=1) & (norm(means[:, :3]) <= MAX_REST_RATE)
    usual = np.median(variances[at_rest] if at_rest.any() else variances, axis=0)
    return np.asarray(at_rest & ((variances <= MAX_VARIANCE_RATIO * usual) | (usual == 0.0)).all(axis=1))


def longest_rest(gyro: Stream, accelerometer: Stream) -> Integers | None:
    """First and last stamp of the longest rest, ns; None without one of `MIN_REST_S`."""
    step_s = gyro.step_s
    part = round(REST_WINDOW_S / REST_PARTS / step_s) if step_s else 0
    size = part * REST_PARTS
    if part < 2 or not size <= len(gyro.t_ns) == len(accelerometer.t_ns):
        return None
    at_rest = _at_rest(np.hstack([gyro.readings, accelerometer.readings]), part)
    firsts, lasts = runs_of(0, at_rest)
    spans = lasts + 1 - firsts
    if spans.max(initial=0) * size * step_s < MIN_REST_S:
        return None
    longest = spans.argmax()
    return gyro.t_ns[[firsts[longest] * size, (lasts[longest] + 1) * size - 1]]


def _rounding(values: Array) -> float:
    """Variance of rounding to the resolution of values."""
    return resolution(values) ** 2 / 12.0


def _judge_variance(still: Stream, declared: Array, found: Findings) -> None:
    """Name declared variances that the scatter at rest contradicts; rounding scatters as well."""
    scatter = np.maximum(still.readings.var(axis=0), _rounding(still.readings.ravel()))
    known = (declared > 0.0) & (scatter > 0.0)
    ratios = scatter[known] / declared[known]
    if np.abs(np.log(ratios)).max(initial=0.0) <= np.log(MAX_VARIANCE_RATIO):
        return
    text = f"the {still.sensor} declares variances of ({numerals(declared)}), and scatters by ({numerals(scatter)})"
    found.name("covariance", still.sensor, f"{text} at rest", f"variances of {numerals(scatter, 3)}")


def tell_noise(streams: Mapping[str, Stream], run: Run, found: Findings) -> None:
    """Tell the noise of all sensors, and the gyro's bias, in the longest rest.

    Parameters
    ----------
    streams : mapping of str to Stream
        Repaired readings of gyro, accelerometer, and perhaps a magnetometer.
    run : Run
        Its log may declare variances of sensors, (unit of the readings)².
    found : Findings
    """
    given = run.log.sensors if run.log else {}
    declared = {name: np.median(each.variance, axis=0) for name, each in given.items() if each.variance is not None}
    rest = longest_rest(streams["gyro"], streams["accelerometer"])
    if rest is None:
        for sensor in declared:
            found.ask("covariance", f"the {sensor} declares a variance, and never rests")
        return
    found.marks.append(Mark("log", "rest", *rest.tolist()))
    for name, stream in streams.items():
        still = stream.between(*rest)
        if name in declared:
            _judge_variance(still, declared[name], found)
        step_s = still.step_s
        seconds = len(still.t_ns) * step_s
        if seconds < MIN_REST_S or not np.ptp(still.readings, axis=0).any():
            continue
        measured = allan(still.readings, step_s)
        grid = _rounding(stream.readings[:, 0]) * step_s / measured.tau_s
        if np.any(grid > measured.variance / 2.0):
            continue  # the resolution hides the noise
        told = density(measured._replace(variance=measured.variance - grid))
        unit = found.unit(name)
        found.note("noise", f"the {name} has white noise of {told.white:.3g} {unit}/√Hz at rest", told.white)
        found.estimate(f"{name}_noise_density", told.white, told.white_sigma)
        if told.walk:
            found.estimate(f"{name}_bias_random_walk", told.walk, told.walk_sigma)
        if name == "gyro":
            error = np.sqrt(told.white**2 / seconds + told.walk**2 * seconds / 3.0)
            found.estimate("gyro_bias", still.readings.mean(axis=0), np.full(3, error))
