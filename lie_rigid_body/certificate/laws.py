"""The laws of torque-free motion, each held against the samples of one segment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Array
from lie_rigid_body.certificate.law import Law, judge
from lie_rigid_body.certificate.segments import RecordedSegment
from lie_rigid_body.certificate.tolerance import NORM_LIMIT, Tolerance
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN, flow


@dataclass(frozen=True)
class Evidence:
    """What the laws look at: the samples of a segment beside what its declaration implies.

    Parameters
    ----------
    recorded : RecordedSegment
    body : RigidBody
    start : State
    tolerance : Tolerance
    t : ndarray, shape (N,)
        Seconds since the segment's start.
    unit : State
        The recorded states with their quaternions normalised, as directions only.
    exact : State
        The states that the closed form gives from the segment's start.
    """

    recorded: RecordedSegment
    body: RigidBody
    start: State
    tolerance: Tolerance
    t: Array
    unit: State
    exact: State

    def judge(self, name: str, unit: str, residuals: Array, limits: Array | float, what: str) -> Law:
        """`law.judge` over all samples, or over all intervals, each of which belongs to its later sample."""
        later = slice(len(self.t) - len(residuals), None)
        return judge(name, unit, residuals, limits, self.recorded.samples[later], self.recorded.stamps_ns[later], what)


def unit_norm(evidence: Evidence) -> Law:
    """|q| = 1."""
    residuals = np.abs(quaternion.norm(evidence.recorded.states.attitude_xyzw) - 1.0)
    return evidence.judge(
        "unit norm",
        "1",
        residuals,
        NORM_LIMIT,
        "the norm of the quaternion is {worst} off 1 (limit {limit}) at {where}",
    )


def kinetic_energy(evidence: Evidence) -> Law:
    """½ ω·Mω stays what the start makes it."""
    energy = evidence.body.kinetic_energy(evidence.recorded.states)
    start = float(evidence.body.kinetic_energy(evidence.start))
    return evidence.judge(
        "kinetic energy",
        "rel",
        _relative(np.abs(energy - start), start),
        evidence.tolerance.energy(evidence.t),
        "kinetic energy is {worst} off its value at the start (relative, limit {limit}) at {where}",
    )


def world_momentum(evidence: Evidence) -> list[Law]:
    """Each component of A M ω stays what the start makes it."""
    momentum = evidence.body.angular_momentum(evidence.unit)
    start = evidence.body.angular_momentum(evidence.start)
    scale = float(so3.norm(start))
    limits = evidence.tolerance.world_momentum(evidence.t)
    return [
        evidence.judge(
            f"world momentum {axis}",
            "rel",
            _relative(np.abs(momentum[:, i] - start[i]), scale),
            limits,
            f"world angular momentum {axis} is {{worst}} off its start (relative to |L|, limit {{limit}}) at {{where}}",
        )
        for i, axis in enumerate("xyz")
    ]


def neighbours(evidence: Evidence) -> list[Law]:
    """Each sample follows from the one before: its attitude from the twist, its twist from Euler's equations, its sign
    from continuity. The flow between them is summed as a Taylor series.
    """
    spans = np.diff(evidence.recorded.stamps_ns) * 1e-9
    fastest = evidence.tolerance.fastest
    resolved = spans * fastest <= LONGEST_TURN
    before = State.trusted(evidence.unit.attitude_xyzw[:-1], evidence.unit.body_rate[:-1])
    after = evidence.unit[1:]
    predicted = flow(evidence.body, before, np.where(resolved, spans, 0.0), fastest)
    turned = so3.norm(
        quaternion.log(quaternion.multiply(quaternion.conjugate(predicted.attitude_xyzw), after.attitude_xyzw))
    )
    changed = _relative(so3.norm(after.body_rate - predicted.body_rate), fastest)
    return [
        evidence.judge(
            "twist is the attitude's derivative",
            "rad",
            np.where(resolved, turned, 0.0),
            evidence.tolerance.attitude_step(spans),
            "the attitude's step differs by {worst} rad (limit {limit}) from what the twist makes it, up to {where}",
        ),
        evidence.judge(
            "Euler's equations",
            "rel",
            np.where(resolved, changed, 0.0),
            evidence.tolerance.rate_step(spans),
            "the twist's step differs by {worst} (of its largest, limit {limit}) from Euler's equations, up to {where}",
        ),
        _sign_continuity(evidence, predicted.attitude_xyzw, resolved),
    ]


def _sign_continuity(evidence: Evidence, predicted: Array, resolved: NDArray[np.bool_]) -> Law:
    """Each quaternion has the sign of the path from the one before; the first, and any after a long gap, that of the
    path from the segment's start.
    """
    attitudes = evidence.unit.attitude_xyzw
    by_start = np.sum(evidence.exact.attitude_xyzw * attitudes, axis=-1)
    by_neighbour = np.sum(predicted * attitudes[1:], axis=-1)
    agreement = np.concatenate([by_start[:1], np.where(resolved, by_neighbour, by_start[1:])])
    return evidence.judge(
        "sign continuity",
        "1",
        np.where(agreement < 0.0, 2.0, 0.0),
        1.0,
        "the quaternion changes sign without turning, at {where} ({count})",
    )


def closed_form(evidence: Evidence) -> Law:
    """The attitude is that of the exact solution from the segment's start."""
    turned = quaternion.multiply(quaternion.conjugate(evidence.exact.attitude_xyzw), evidence.unit.attitude_xyzw)
    return evidence.judge(
        "closed form",
        "rad",
        so3.norm(quaternion.log(turned)),
        evidence.tolerance.attitude(evidence.t),
        "the attitude is {worst} rad off the exact solution (limit {limit}) at {where}",
    )


def _relative(residuals: Array, scale: float) -> Array:
    """Residuals over their scale; where the scale is 0 (a body at rest) any residual is infinitely large."""
    if scale > 0.0:
        return residuals / scale
    return np.where(residuals == 0.0, 0.0, np.inf)
