"""A world that is turned about any axis: what a filter makes of references that contradict what is read.

A vector of wrong sign, read or referred to, turns the world of a filter that corrects its attitude to where the errors
of all vectors together are least; a wrong first attitude that nothing corrects turns it as well. Whatever the body
does, the turn is constant in the world, once the filter has converged: q_estimate = q_turn ⊗ q_truth.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.findings import Finding, gain
from lie_rigid_body.evaluation.search import angles_of, from_mean, mean
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.lie import quaternion

LARGEST_LEFT: Final = float(np.radians(5.0))
"""A turn that leaves a larger median, rad, in any quarter of the run but the first is not the cause."""
LARGEST_SHARE: Final = 0.25
"""Nor one that leaves more of the error there, or of what an attitude leaves that does not follow the body."""
LEAST_TILT: Final = float(np.radians(10.0))
"""Smaller ones of the vertical, rad, are errors of sensors; a turn about the vertical is a heading offset."""
FEWEST_SAMPLES: Final = 20


def world_turned(estimate_xyzw: Array, true_xyzw: Array) -> tuple[Finding, ...]:
    """That the world of an estimate is turned, if that explains nearly all; shapes (N, 4), in the order of time."""
    if len(estimate_xyzw) < FEWEST_SAMPLES:
        return ()
    turns = quaternion.multiply(estimate_xyzw, quaternion.conjugate(true_xyzw))
    quarters = np.array_split(np.arange(len(turns)), 4)[1:]  # in the first a filter may converge
    late = np.concatenate(quarters)
    turn = mean(turns[late])
    before, after = angles_of(turns), angles_of(quaternion.multiply(quaternion.conjugate(turn), turns))
    error, unlike = float(np.median(before[late])), float(np.median(from_mean(true_xyzw[late])))
    left = max(float(np.median(after[quarter])) for quarter in quarters)
    tilt = 2.0 * float(np.arctan2(np.hypot(turn[0], turn[1]), np.hypot(turn[2], turn[3])))
    if left > min(LARGEST_LEFT, LARGEST_SHARE * error, LARGEST_SHARE * unlike) or tilt < LEAST_TILT:
        return ()
    vector = quaternion.log(turn * (1.0 if turn[3] >= 0.0 else -1.0))
    angle = float(np.sqrt(vector @ vector))
    axis = ", ".join(f"{v:.3g}" for v in vector / angle + 0.0)
    message = (
        f"The world of the estimate is turned by {np.degrees(angle):.4g}° about ({axis}) of the world: see whether the "
        "accelerometer, the magnetometer or what they are held against has the wrong sign or other axes, or whether "
        f"nothing corrects a wrong first attitude ({gain(np.degrees(before), np.degrees(after))})."
    )
    return (Finding("world_turned", message, rms(np.degrees(after))),)
