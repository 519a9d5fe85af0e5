"""The laws of torque-free motion, each held against the samples of one segment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array, Booleans
from lie_rigid_body.certificate.law_result import LawResult, judge
from lie_rigid_body.certificate.segments import RecordedSegment
from lie_rigid_body.certificate.tolerance import NORM_LIMIT, Tolerance
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN, flow
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
class Comparison:
    """The samples of a segment beside the motion that the bag declares, which the laws compare.

    Parameters
    ----------
    recorded : RecordedSegment
    body : RigidBody
    start : State
    tolerance : Tolerance
    t : ndarray, shape (N,)
        Seconds since the segment's start.
    unit : State
        The recorded states, their quaternions normalised.
    exact : State
        The states of the closed form from the segment's start.
    """

    recorded: RecordedSegment
    body: RigidBody
    start: State
    tolerance: Tolerance
    t: Array
    unit: State
    exact: State

    __repr__ = short_repr

    def judge(self, name: str, unit: str, residuals: Array, limits: Array | float, what: str) -> LawResult:
        """`law_result.judge` over all samples, or over all intervals, each of which belongs to its later sample."""
        later = slice(len(self.t) - len(residuals), None)
        return judge(name, unit, residuals, limits, self.recorded.samples[later], self.recorded.stamps_ns[later], what)


def unit_norm(compared: Comparison) -> LawResult:
    """The attitude is a unit quaternion, |q| = 1."""
    residuals = np.abs(quaternion.norm(compared.recorded.states.attitude_xyzw) - 1.0)
    return compared.judge(
        "unit norm",
        "1",
        residuals,
        NORM_LIMIT,
        "the norm of the quaternion is {worst} off 1 (limit {limit}) at {where}",
    )


def kinetic_energy(compared: Comparison) -> LawResult:
    """The kinetic energy ½ ω·Mω is that of the start."""
    energy = compared.body.kinetic_energy(compared.recorded.states)
    start = float(compared.body.kinetic_energy(compared.start))
    return compared.judge(
        "kinetic energy",
        "rel",
        _relative(np.abs(energy - start), start),
        compared.tolerance.energy(compared.t),
        "kinetic energy is {worst} off its value at the start (relative, limit {limit}) at {where}",
    )


def world_momentum(compared: Comparison) -> list[LawResult]:
    """Each component of the angular momentum in the world, A M ω, is that of the start."""
    momentum = compared.body.angular_momentum(compared.unit)
    start = compared.body.angular_momentum(compared.start)
    scale = float(so3.norm(start))
    limits = compared.tolerance.world_momentum(compared.t)
    return [
        compared.judge(
            f"world momentum {axis}",
            "rel",
            _relative(np.abs(momentum[:, i] - start[i]), scale),
            limits,
            f"world angular momentum {axis} is {{worst}} off its start (relative to |L|, limit {{limit}}) at {{where}}",
        )
        for i, axis in enumerate("xyz")
    ]


def neighbours(compared: Comparison) -> list[LawResult]:
    """Each sample follows from the one before by the Taylor flow.

    The attitude follows from the twist, the twist from Euler's equations, the sign of the quaternion from continuity.
    """
    spans = np.diff(compared.recorded.stamps_ns) * 1e-9
    fastest = compared.tolerance.fastest
    resolved = spans * fastest <= LONGEST_TURN
    before = State.trusted(compared.unit.attitude_xyzw[:-1], compared.unit.body_rate[:-1])
    after = compared.unit[1:]
    predicted = flow(compared.body, before, np.where(resolved, spans, 0.0), fastest)
    turned = so3.norm(
        quaternion.log(quaternion.multiply(quaternion.conjugate(predicted.attitude_xyzw), after.attitude_xyzw))
    )
    changed = _relative(so3.norm(after.body_rate - predicted.body_rate), fastest)
    return [
        compared.judge(
            "twist is the attitude's derivative",
            "rad",
            np.where(resolved, turned, 0.0),
            compared.tolerance.attitude_step(spans),
            "the attitude's step differs by {worst} rad (limit {limit}) from what the twist makes it, up to {where}",
        ),
        compared.judge(
            "Euler's equations",
            "rel",
            np.where(resolved, changed, 0.0),
            compared.tolerance.rate_step(spans),
            "the twist's step differs by {worst} (of its largest, limit {limit}) from Euler's equations, up to {where}",
        ),
        _sign_continuity(compared, predicted.attitude_xyzw, resolved),
    ]


def _sign_continuity(compared: Comparison, predicted: Array, resolved: Booleans) -> LawResult:
    """Each quaternion has the sign of the continuous path from the one before.

    The first, and any after a long gap, has that of the path from the segment's start.
    """
    attitudes = compared.unit.attitude_xyzw
    by_start = np.sum(compared.exact.attitude_xyzw * attitudes, axis=-1)
    by_neighbour = np.sum(predicted * attitudes[1:], axis=-1)
    agreement = np.concatenate([by_start[:1], np.where(resolved, by_neighbour, by_start[1:])])
    return compared.judge(
        "sign continuity",
        "1",
        np.where(agreement < 0.0, 2.0, 0.0),
        1.0,
        "the quaternion changes sign without turning, at {where} ({count})",
    )


def closed_form(compared: Comparison) -> LawResult:
    """The attitude is that of the closed form from the segment's start."""
    turned = quaternion.multiply(quaternion.conjugate(compared.exact.attitude_xyzw), compared.unit.attitude_xyzw)
    return compared.judge(
        "closed form",
        "rad",
        so3.norm(quaternion.log(turned)),
        compared.tolerance.attitude(compared.t),
        "the attitude is {worst} rad off the exact solution (limit {limit}) at {where}",
    )


def _relative(residuals: Array, scale: float) -> Array:
    """Residuals over their scale; where the scale is 0 (a body at rest) any residual is infinitely large."""
    if scale > 0.0:
        return residuals / scale
    return np.where(residuals == 0.0, 0.0, np.inf)
