"""The motions of rigid bodies by discrete Moser–Veselov steps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.motion.initial_conditions import InitialConditions
from lie_rigid_body.motion.moser_veselov.layout import ATTITUDE, MOMENTUM, SPATIAL_MOMENTUM, STATE_SIZE, STEP_LENGTH
from lie_rigid_body.motion.moser_veselov.loop import LOOP, SAMPLE_SIZE
from lie_rigid_body.motion.moser_veselov.motion_constants import hi_lo, motion_constants
from lie_rigid_body.motion.moser_veselov.principal_frame import DIGITS, PrincipalFrame, ScaledMotion, rotated
from lie_rigid_body.motion.time_steps import longest_step

LARGEST_TURN: Final = 0.25
"""Largest rotation angle in a step, rad: there the series of the highest order end in round-off."""


class MoserVeselovIntegrator:
    """The motion of one body by discrete Moser–Veselov steps; an `Integrator`.

    Parameters
    ----------
    frame : PrincipalFrame
    motion : ScaledMotion
    constants : list of float
        Of the motion, without the spatial momentum; see `motion_constants`.
    attitude_xyzw : list of float
        At the start, world from body.
    max_step : float
        Largest step that is asked for, s.

    Attributes
    ----------
    start : list of float
        The state at time 0; see `layout`.
    constants : list of float
        Of the motion; see `layout`.
    largest_step : float
        s
    """

    __slots__ = ("_frame", "constants", "largest_step", "start")

    def __init__(
        self,
        frame: PrincipalFrame,
        motion: ScaledMotion,
        constants: list[float],
        attitude_xyzw: list[float],
        max_step: float,
    ) -> None:
        attitude = frame.inward(attitude_xyzw)
        self.start = [0.0] * STATE_SIZE
        _put(self.start, MOMENTUM, hi_lo(motion.momentum))
        _put(self.start, ATTITUDE, hi_lo(attitude))
        self.start[STEP_LENGTH] = -1.0  # no step yet
        self.constants = list(constants)
        _put(self.constants, SPATIAL_MOMENTUM, hi_lo(rotated(attitude, motion.momentum)))
        self.largest_step = longest_step(max_step, LARGEST_TURN, float(motion.fastest))
        self._frame = frame

    def require_short_steps(self, state: list[float], ahead_ns: int) -> None:
        """Accept every step: the largest is short enough."""

    def advance(self, state: list[float], spans: Integers, counts: Integers, work: int) -> tuple[Array, Array]:
        """Move a state, in place, through N samples; see `Integrator`."""
        out = np.empty((len(spans), SAMPLE_SIZE))
        LOOP.run(state, self.constants, spans, counts, out, work)
        return self._frame.outward(out[:, :4], out[:, 4:])


def _put(vector: list[float], place: int, numbers: list[float]) -> None:
    vector[place : place + len(numbers)] = numbers


def moser_veselov_integrators(starts: InitialConditions, max_step: float, order: int) -> list[MoserVeselovIntegrator]:
    """The motions of B bodies from their starts, by steps of an even order.

    Bodies of equal inertia share their axes, and those of equal rate as well the constants of their motion.
    """
    found: dict[int, MoserVeselovIntegrator] = {}
    with working_precision(DIGITS):
        motions = list(_motions(starts))
        constants = motion_constants([motion for _, motion, _ in motions], order)
        for (frame, motion, same), numbers in zip(motions, constants, strict=True):
            for i in same:
                attitude = starts.attitude_xyzw[i].tolist()
                found[i] = MoserVeselovIntegrator(frame, motion, numbers, attitude, max_step)
    return [found[i] for i in range(len(found))]


def _motions(starts: InitialConditions) -> Iterator[tuple[PrincipalFrame, ScaledMotion, list[int]]]:
    """Each distinct motion but for its attitude, and which of the bodies have it."""
    for body in _alike(starts.inertia, range(len(starts.inertia))):
        frame = PrincipalFrame.of(starts.inertia[body[0]].tolist())
        for same in _alike(starts.body_rate, body):
            yield frame, ScaledMotion.about(frame, starts.body_rate[same[0]].tolist()), same


def _alike(values: Array, places: Iterable[int]) -> list[list[int]]:
    """Some places along the first axis, those of the same bits together."""
    groups: dict[bytes, list[int]] = {}
    for i in places:
        groups.setdefault(values[i].tobytes(), []).append(i)
    return list(groups.values())
