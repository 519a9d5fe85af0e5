"""The laws of torque-free motion, held against the samples of one segment block by block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.certificate.law_result import Judgement, LawResult
from lie_rigid_body.certificate.pairing import Block
from lie_rigid_body.certificate.residuals_over_time import Watch
from lie_rigid_body.certificate.segments import SurveyedSegment
from lie_rigid_body.certificate.tolerance import NORM_LIMIT, Tolerance, tolerance
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN, flow

_BLOCK: Final = 16_384
"""Samples that are compared at once."""


class _Residuals(NamedTuple):
    """Residuals of the last samples of a block, as many as they are, and their limits."""

    name: str
    unit: str
    values: Array
    limits: Array | float
    what: str


@dataclass(frozen=True)
class Comparison:
    """Samples beside the motion that the bag declares, which the laws compare.

    Parameters
    ----------
    body : RigidBody
    start : State
    tolerance : Tolerance
    stamps_ns : ndarray of int64, shape (N,)
    t : ndarray, shape (N,)
        Seconds since the segment's start.
    states : State
        As recorded.
    unit : State
        The same, their quaternions normalised.
    exact : State
        The states of the closed form from the segment's start.
    followed_span : float
        Longest time between neighbours over which the flow is followed, s.
    follows : bool
        Whether the first sample is the last one of the block before it, and only its interval is new.
    """

    body: RigidBody
    start: State
    tolerance: Tolerance
    stamps_ns: Integers
    t: Array
    states: State
    unit: State
    exact: State
    followed_span: float
    follows: bool


class SegmentLaws:
    """The laws of one segment, to which its samples are added in order.

    Parameters
    ----------
    found : SurveyedSegment
        Of which duration and longest spans decide on limits.
    watch : Watch, optional
        It is told of all residuals.
    """

    def __init__(self, found: SurveyedSegment, watch: Watch | None = None) -> None:
        self._found, self._watch, scenario = found, watch, found.segment.scenario
        self._body, self._start = scenario.body(), scenario.start()
        self._motion = ClosedForm(self._body, self._start)
        self.tolerance = tolerance(scenario, found.duration)
        self._judgements: dict[str, Judgement] = {}
        self._before: Block | None = None
        self.add(Block.empty())

    def add(self, block: Block) -> None:
        """Hold the laws against the samples that come next."""
        for i in range(0, max(len(block.stamps_ns), 1), _BLOCK):
            self._add(block[i : i + _BLOCK])

    def _add(self, new: Block) -> None:
        block = new if self._before is None else self._before.joined(new)
        compared = self._compared(block)
        for law in _all_laws(compared):
            judgement = self._judgements.setdefault(law.name, Judgement(law.name, law.unit, law.what))
            last = slice(len(block.stamps_ns) - len(law.values), None)
            judgement.add(law.values, law.limits, block.samples[last], block.stamps_ns[last])
            if self._watch is not None:
                self._watch(law.name, law.unit, law.values, law.limits, block.stamps_ns[last])
        if len(block.stamps_ns):
            self._before = block[-1:]

    def _compared(self, block: Block) -> Comparison:
        elapsed = block.stamps_ns - self._found.segment.start_ns
        return Comparison(
            self._body,
            self._start,
            self.tolerance,
            block.stamps_ns,
            np.asarray(elapsed * 1e-9, dtype=np.float64),
            block.states,
            _unit(block.states),
            self._motion.at(elapsed),
            self._found.followed_span,
            self._before is not None,
        )

    def results(self) -> tuple[LawResult, ...]:
        """How near each law came to its limit."""
        return tuple(judgement.result() for judgement in self._judgements.values())


def _unit(states: State) -> State:
    """The states with their quaternions normalised; one of norm 0 becomes NaN, which breaks every law it enters."""
    norms = quaternion.norm(states.attitude_xyzw)[:, np.newaxis]
    with np.errstate(divide="ignore"):
        return State.trusted(states.attitude_xyzw / norms, states.body_rate)


def _all_laws(compared: Comparison) -> Iterator[_Residuals]:
    first = 1 if compared.follows else 0
    for law in (
        _unit_norm(compared),
        _kinetic_energy(compared),
        *_world_momentum(compared),
        *_neighbours(compared),
        _closed_form(compared),
    ):
        if len(law.values) < len(compared.t) or not first:  # of intervals, or of samples that are all new
            yield law
        else:
            limits = law.limits if isinstance(law.limits, float) else law.limits[first:]
            yield law._replace(values=law.values[first:], limits=limits)


def _unit_norm(compared: Comparison) -> _Residuals:
    """The attitude is a unit quaternion, |q| = 1."""
    residuals = np.abs(quaternion.norm(compared.states.attitude_xyzw) - 1.0)
    return _Residuals(
        "unit norm",
        "1",
        residuals,
        NORM_LIMIT,
        "the norm of the quaternion is {worst} off 1 (limit {limit}) at {where}",
    )


def _kinetic_energy(compared: Comparison) -> _Residuals:
    """The kinetic energy ½ ω·Mω is that of the start."""
    energy = compared.body.kinetic_energy(compared.states)
    start = float(compared.body.kinetic_energy(compared.start))
    return _Residuals(
        "kinetic energy",
        "rel",
        _relative(np.abs(energy - start), start),
        compared.tolerance.energy(compared.t),
        "kinetic energy is {worst} off its value at the start (relative, limit {limit}) at {where}",
    )


def _world_momentum(compared: Comparison) -> list[_Residuals]:
    """Each component of the angular momentum in the world, A M ω, is that of the start."""
    momentum = compared.body.angular_momentum(compared.unit)
    start = compared.body.angular_momentum(compared.start)
    scale = float(so3.norm(start))
    limits = compared.tolerance.world_momentum(compared.t)
    return [
        _Residuals(
            f"world momentum {axis}",
            "rel",
            _relative(np.abs(momentum[:, i] - start[i]), scale),
            limits,
            f"world angular momentum {axis} is {{worst}} off its start (relative to |L|, limit {{limit}}) at {{where}}",
        )
        for i, axis in enumerate("xyz")
    ]


def _neighbours(compared: Comparison) -> list[_Residuals]:
    """Each sample follows from the one before by the Taylor flow.

    The attitude follows from the twist, the twist from Euler's equations, the sign of the quaternion from continuity.
    """
    spans = np.diff(compared.stamps_ns) * 1e-9
    fastest = compared.tolerance.fastest
    resolved = spans * fastest <= LONGEST_TURN
    before = State.trusted(compared.unit.attitude_xyzw[:-1], compared.unit.body_rate[:-1])
    after = compared.unit[1:]
    predicted = flow(compared.body, before, np.where(resolved, spans, 0.0), fastest, compared.followed_span)
    turned = so3.norm(
        quaternion.log(quaternion.multiply(quaternion.conjugate(predicted.attitude_xyzw), after.attitude_xyzw))
    )
    changed = _relative(so3.norm(after.body_rate - predicted.body_rate), fastest)
    return [
        _Residuals(
            "twist is the attitude's derivative",
            "rad",
            np.where(resolved, turned, 0.0),
            compared.tolerance.attitude_step(spans),
            "the attitude's step differs by {worst} rad (limit {limit}) from what the twist makes it, up to {where}",
        ),
        _Residuals(
            "Euler's equations",
            "rel",
            np.where(resolved, changed, 0.0),
            compared.tolerance.rate_step(spans),
            "the twist's step differs by {worst} (of its largest, limit {limit}) from Euler's equations, up to {where}",
        ),
        _sign_continuity(compared, predicted.attitude_xyzw, resolved),
    ]


def _sign_continuity(compared: Comparison, predicted: Array, resolved: Booleans) -> _Residuals:
    """Each quaternion has the sign of the continuous path from the one before.

    The first, and any after a long gap, has that of the path from the segment's start.
    """
    attitudes = compared.unit.attitude_xyzw
    by_start = np.sum(compared.exact.attitude_xyzw * attitudes, axis=-1)
    by_neighbour = np.sum(predicted * attitudes[1:], axis=-1)
    continued = np.where(resolved, by_neighbour, by_start[1:])
    agreement = continued if compared.follows else np.concatenate([by_start[:1], continued])
    return _Residuals(
        "sign continuity",
        "1",
        np.where(agreement < 0.0, 2.0, 0.0),
        1.0,
        "the quaternion changes sign without turning, at {where} ({count})",
    )


def _closed_form(compared: Comparison) -> _Residuals:
    """The attitude is that of the closed form from the segment's start."""
    turned = quaternion.multiply(quaternion.conjugate(compared.exact.attitude_xyzw), compared.unit.attitude_xyzw)
    return _Residuals(
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
