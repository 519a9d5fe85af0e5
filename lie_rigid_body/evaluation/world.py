"""A world that is turned about any axis: what a filter makes of references that contradict what is read.

A vector of wrong sign, read or referred to, turns the world of a filter that corrects its attitude to where the errors
of all vectors together are least; a wrong first attitude that nothing corrects turns it as well. Whatever the body
does, the turn is constant in the world, once the filter has converged: q_estimate = q_turn ⊗ q_truth.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.attitude_error import angles
from lie_rigid_body.evaluation.attitudes import angles_between, from_mean, mean
from lie_rigid_body.evaluation.findings import Finding, angle_and_axis, gain
from lie_rigid_body.evaluation.statistics import FEWEST_SAMPLES, later_quarters, rms, worst_quarter
from lie_rigid_body.lie import quaternion

LARGEST_LEFT: Final = float(np.radians(5.0))
"""A turn that leaves a larger median, rad, in any quarter of the run but the first is not the cause."""
LARGEST_SHARE: Final = 0.25
"""Nor one that leaves more of the error there, or of what an attitude leaves that does not follow the body."""
LEAST_TILT: Final = float(np.radians(10.0))
"""Smaller ones of the vertical, rad, are errors of sensors; a turn about the vertical is a heading offset."""


def world_turned(estimate_xyzw: Array, true_xyzw: Array) -> tuple[Finding, ...]:
    """That the world of an estimate is turned, if that explains nearly all; shapes (N, 4), in the order of time."""
    if len(estimate_xyzw) < FEWEST_SAMPLES:
        return ()
    errors = quaternion.multiply(estimate_xyzw, quaternion.conjugate(true_xyzw))
    late = np.concatenate(later_quarters(len(errors)))
    turn = mean(errors[late])
    before, after = angles_between(true_xyzw, estimate_xyzw), angles_between(turn, errors)
    error, left = float(np.median(before[late])), worst_quarter(after)
    most = min(LARGEST_LEFT, LARGEST_SHARE * error, LARGEST_SHARE * from_mean(true_xyzw[late]))
    if left > most or angles(turn).inclination < LEAST_TILT:
        return ()
    message = (
        f"The world of the estimate is turned by {angle_and_axis(turn)} of the world: see whether the "
        "accelerometer, the magnetometer or what they are held against has the wrong sign or other axes, or whether "
        f"nothing corrects a wrong first attitude ({gain(np.degrees(before), np.degrees(after))})."
    )
    return (Finding("world_turned", message, rms(np.degrees(after))),)
