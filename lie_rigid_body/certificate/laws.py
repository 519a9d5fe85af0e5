"""The laws of torque-free motion, held against the samples of one segment block by block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult, LawTally, Watch
from lie_rigid_body.certificate.residuals import WORK, Residuals
from lie_rigid_body.certificate.survey import SurveyedSegment
from lie_rigid_body.certificate.tolerance import NORM_LIMIT, READING, Tolerance, tolerance
from lie_rigid_body.foundation.arrays import Array, Booleans, same_bits
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN
from lie_rigid_body.recording.samples import Block

_BLOCK: Final = 65_536
"""Largest number of samples compared at once; a batch of a bag has fewer, unless its chunks are large."""


_LAWS: Final = (
    ("unit norm", "1", "the norm of the quaternion is {worst} off 1 (limit {limit}) at {where}"),
    (
        "kinetic energy",
        "rel",
        "kinetic energy is {worst} off its value at the start (relative, limit {limit}) at {where}",
    ),
    *(
        (
            f"world momentum {axis}",
            "rel",
            f"world angular momentum {axis} is {{worst}} off its start (relative to |L|, limit {{limit}}) at {{where}}",
        )
        for axis in "xyz"
    ),
    (
        "twist is the attitude's derivative",
        "rad",
        "the attitude's step differs by {worst} rad (limit {limit}) from what the twist makes it, up to {where}",
    ),
    (
        "Euler's equations",
        "rel",
        "the twist's step differs by {worst} (of its largest, limit {limit}) from Euler's equations, up to {where}",
    ),
    ("sign continuity", "1", "the quaternion changes sign without turning, at {where} ({count})"),
    ("closed form", "rad", "the attitude is {worst} rad off the exact solution (limit {limit}) at {where}"),
    ("exact rate", "rad/s", "the body rate is {worst} rad/s off the exact solution (limit {limit}) at {where}"),
)
"""Name of each law, unit of its residuals, and the message where it is broken."""
_Residuals: TypeAlias = tuple[Array, Array | float]
"""Residuals of a law for the last samples of a block, as many as they are, and their limits."""


@dataclass(frozen=True)
class ComparedSamples:
    """Samples beside the motion that the bag declares, which the laws compare.

    Parameters
    ----------
    body : RigidBody
    start : State
    tolerance : Tolerance
    t : ndarray, shape (N,)
        Seconds since the segment's start.
    spans : ndarray, shape (N − 1,)
        Time between neighbours, s.
    resolved : ndarray of bool, shape (N − 1,)
        Whether the flow is followed over it.
    found : Residuals
    rate_error : ndarray, shape (N,)
        Distance of the body rates from those of the exact motion, rad/s.
    speed : ndarray, shape (N,)
        Size of the exact body rates, rad/s.
    follows : bool
        Whether the first sample is the last one of the block before it, and only its interval is new.
    """

    body: RigidBody
    start: State
    tolerance: Tolerance
    t: Array
    spans: Array
    resolved: Booleans
    found: Residuals
    rate_error: Array
    speed: Array
    follows: bool


@dataclass(frozen=True)
class HeldLaws:
    """The laws of a segment, after all its samples.

    Parameters
    ----------
    results : tuple of LawResult
        How near each law came to its limit.
    motion_error : float
        How far the declared motion may err until the last sample, rad, before any cap.
    is_exact : bool
        Whether all attitudes and body rates are equal to those of the closed form, to the bit.
    """

    results: tuple[LawResult, ...]
    motion_error: float
    is_exact: bool


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
        self._found, scenario = found, found.segment.scenario
        self._body, self._start = scenario.body(), scenario.start()
        self._motion = scenario.exact_motion()
        self._tolerance = tolerance(scenario, found.duration)
        WORK.compiled_for(found.count)
        self._judgements = [LawTally(*law, watch=watch) for law in _LAWS]
        self._before: Block | None = None
        self._is_exact = True

    def add(self, block: Block) -> None:
        """Hold the laws against the samples that come next."""
        for i in range(0, len(block.stamps_ns), _BLOCK):
            self._add(block[i : i + _BLOCK])

    def _add(self, new: Block) -> None:
        block = new if self._before is None else Block.joined([self._before, new])
        for judgement, (values, limits) in zip(self._judgements, _all_laws(self._compared(block)), strict=True):
            count = min(len(values), len(new.stamps_ns))  # the sample before the new ones was judged with its own
            own, last = slice(len(values) - count, None), slice(len(block.stamps_ns) - count, None)
            of_own = np.broadcast_to(limits, values.shape)[own]
            judgement.add(values[own], of_own, block.samples[last], block.stamps_ns[last])
        self._before = block[-1:]

    def _compared(self, block: Block) -> ComparedSamples:
        elapsed = block.stamps_ns - self._found.segment.start_ns
        spans = np.diff(block.stamps_ns) * 1e-9
        fastest = self._tolerance.fastest
        resolved = spans * fastest <= LONGEST_TURN
        followed = np.where(resolved, spans, 0.0)
        exact = self._motion.at(elapsed)
        self._is_exact &= same_bits(block.states.attitude_xyzw, exact.attitude_xyzw)
        self._is_exact &= same_bits(block.states.body_rate, exact.body_rate)
        return ComparedSamples(
            self._body,
            self._start,
            self._tolerance,
            np.asarray(elapsed * 1e-9, dtype=np.float64),
            spans,
            resolved,
            Residuals.of(self._body, block.states, exact, followed, fastest, self._found.followed_span),
            so3.norm(block.states.body_rate - exact.body_rate),
            so3.norm(exact.body_rate),
            self._before is not None,
        )

    def held(self) -> HeldLaws:
        """Results of the laws, after all samples of the segment."""
        t = np.array([self._found.duration] if self._found.count else [])
        expected = float(self._tolerance.attitude_uncapped(t).max(initial=0.0))
        return HeldLaws(tuple(judgement.result() for judgement in self._judgements), expected, self._is_exact)


def _all_laws(compared: ComparedSamples) -> tuple[_Residuals, ...]:
    """Residuals in the order of `_LAWS`."""
    return (
        _unit_norm(compared),
        _kinetic_energy(compared),
        *_world_momentum(compared),
        *_neighbours(compared),
        _sign_continuity(compared),
        _closed_form(compared),
        _exact_rate(compared),
    )


def _unit_norm(compared: ComparedSamples) -> _Residuals:
    """The attitude is a unit quaternion, |q| = 1."""
    return np.abs(compared.found.norm - 1.0), NORM_LIMIT


def _kinetic_energy(compared: ComparedSamples) -> _Residuals:
    """The kinetic energy ½ ω·Mω is that of the start."""
    start = float(compared.body.kinetic_energy(compared.start))
    return _relative(np.abs(compared.found.energy - start), start), compared.tolerance.energy(compared.t)


def _world_momentum(compared: ComparedSamples) -> list[_Residuals]:
    """Each component of the angular momentum in the world, A M ω, is that of the start."""
    start = compared.body.angular_momentum(compared.start)
    scale = float(so3.norm(start))
    limits = compared.tolerance.world_momentum(compared.t)
    return [
        (_relative(np.abs(component - its_start), scale), limits)
        for component, its_start in zip(compared.found.momentum, start, strict=True)
    ]


def _neighbours(compared: ComparedSamples) -> list[_Residuals]:
    """Each sample follows from the one before by the Taylor flow.

    The attitude follows from the twist, the twist from Euler's equations.
    """
    found, resolved, spans = compared.found, compared.resolved, compared.spans
    if spans.size and spans.min() == spans.max():
        spans = spans[:1]  # one limit for all
    changed = _relative(found.step_changed, compared.tolerance.fastest)
    return [
        (np.where(resolved, found.step_turned, 0.0), compared.tolerance.attitude_step(spans)),
        (np.where(resolved, changed, 0.0), compared.tolerance.rate_step(spans)),
    ]


def _sign_continuity(compared: ComparedSamples) -> _Residuals:
    """Each quaternion has the sign of the continuous path from the one before.

    The first, and any after a long gap, has that of the path from the segment's start.
    """
    by_start = compared.found.by_start
    continued = np.where(compared.resolved, compared.found.by_neighbour, by_start[1:])
    agreement = continued if compared.follows else np.concatenate([by_start[:1], continued])
    return np.where(agreement < 0.0, 2.0, 0.0), 1.0


def _closed_form(compared: ComparedSamples) -> _Residuals:
    """The attitude is that of the closed form from the segment's start, with the closed form's own error."""
    return compared.found.turned + compared.tolerance.phases(compared.t), compared.tolerance.attitude(compared.t)


def _exact_rate(compared: ComparedSamples) -> _Residuals:
    """The body rate is that of the closed form from the segment's start."""
    return compared.rate_error, READING * compared.speed + compared.tolerance.stepper_rate(compared.t)


def _relative(residuals: Array, scale: float) -> Array:
    """Residuals over their scale; where the scale is 0 (a body at rest) any residual is infinitely large."""
    if scale > 0.0:
        return residuals / scale
    return np.where(residuals == 0.0, 0.0, np.inf)
