"""Clock and mounting of a truth, and the gyro's factor against it, as mistakes and notes."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.attitudes import angle_and_axis, places
from lie_rigid_body.evaluation.gyro import compare_with_truth
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    GYRO_HZ,
    GYRO_UNITS,
    MAX_TRUTH_MISFIT,
    MIN_DELAY_S,
    MIN_LOG_FACTOR,
    MIN_TRUTH_MOUNTING,
    SIGMAS,
    nearest_unit,
)
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm


def report_truth(found: Findings, gyro: Stream, truth: SampledTruth) -> SampledTruth | None:
    """Report the clock and the mounting of a truth, and the gyro's factor where the other sensors do not show it.

    Parameters
    ----------
    found : Findings
    gyro : Stream
        Readings whose mistakes are undone, rad/s.
    truth : SampledTruth

    Returns
    -------
    SampledTruth or None
        The truth with its mistakes undone; None where it has none, or is not that of the gyro.
    """
    begin_ns = int(gyro.t_ns[0])
    t_s, rate = gyro.averaged(GYRO_HZ, begin_ns)
    fit, errors = compare_with_truth(begin_ns + np.round(t_s * NS).astype(np.int64), rate, truth)
    if fit.misfit > MAX_TRUTH_MISFIT:
        why = f"by no clock and mounting the truth rotates as the gyro does: {fit.misfit:.0%} of its rotations remain"
        found.ask_all(why, "truth")
        return None
    _report_factor(found, fit.factor, errors[4])
    text = f"the truth is {fit.late_s * 1e3:.4g} ms late against the gyro, ± {errors[0] * 1e3:.1g} ms"
    is_late = abs(fit.late_s) > max(MIN_DELAY_S, SIGMAS * errors[0])
    if is_late:
        found.name("truth_late", "truth", text, f"{-fit.late_s:+.4f} s")
    else:
        found.note("truth_late", text, fit.late_s)
    angle = norm(quaternion.log(fit.mounting_xyzw))
    turn = angle_and_axis(fit.mounting_xyzw)
    error = norm(errors[1:4])
    text = f"the axes of the truth's body are those of the gyro rotated by {turn}, ± {np.degrees(error):.1g}°"
    is_turned = angle > max(MIN_TRUTH_MOUNTING, SIGMAS * error)
    if is_turned:
        found.name("truth_mounting", "truth", text + places(fit.mounting_xyzw), turn)
    else:
        found.note("truth_mounting", text, np.degrees(angle))
    if not is_late and not is_turned:
        return None
    attitude = quaternion.multiply(truth.at(truth.stamps_ns), fit.mounting_xyzw)
    return SampledTruth(truth.stamps_ns - round(fit.late_s * NS), attitude)


def _report_factor(found: Findings, factor: float, sigma: float) -> None:
    """Report the gyro's sign and factor, and undo them."""
    size = abs(factor)
    away, text, unit = nearest_unit(size, GYRO_UNITS)
    if factor < 0.0:
        found.name("gyro_axes", "gyro", "the gyro has the opposite sign of the truth's rotations", "-x -y -z", -1.0)
    if away > max(MIN_LOG_FACTOR, SIGMAS * sigma / size):
        found.name("time_step", "gyro", "the gyro counts by another factor than the truth", f"× {size:.4g}", size)
    elif text:
        found.name("gyro_units", "gyro", "the gyro reads degrees, by the truth", f"× {unit:.6g}", unit)
