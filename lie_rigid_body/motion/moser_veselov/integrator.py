"""Motions carried by Moser–Veselov steps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.motion.moser_veselov.frame_change import FrameChange, rotated
from lie_rigid_body.motion.moser_veselov.loop import LENGTH, LOOP, SAMPLE_SIZE, STATE_SIZE
from lie_rigid_body.motion.moser_veselov.motion_constants import MotionConstants, motion_constants, pairs
from lie_rigid_body.motion.moser_veselov.spinning_frame import DIGITS, PrincipalAxes, SpinningFrame
from lie_rigid_body.motion.starts import Starts
from lie_rigid_body.motion.time_steps import longest_step

Array = NDArray[np.float64]

LARGEST_TURN: Final = 0.25
"""rad: steps are no longer than the time of this turn, where the series of the highest order end in round-off."""


class MoserVeselovIntegrator:
    """One motion.

    Parameters
    ----------
    change : FrameChange
    frame : SpinningFrame
    constants : MotionConstants
    attitude_xyzw : list of float
        At the start.
    max_step : float
        Largest step that is asked for, s.

    Attributes
    ----------
    start : list of float
        The state at time 0; see `loop`.
    constants : list of float
    largest_step : float
        s
    """

    __slots__ = ("_change", "constants", "largest_step", "start")

    def __init__(
        self,
        change: FrameChange,
        frame: SpinningFrame,
        constants: MotionConstants,
        attitude_xyzw: list[float],
        max_step: float,
    ) -> None:
        attitude = change.inward(attitude_xyzw)
        world = rotated(attitude, list(frame.momentum))
        self.start = [*pairs([*frame.momentum, *attitude]), *[0.0] * STATE_SIZE][:STATE_SIZE]
        self.start[LENGTH] = -1.0  # of no step yet
        self.constants = [*constants.frame, *pairs(world), *constants.rates, *constants.differences, *constants.series]
        self.largest_step = longest_step(max_step, LARGEST_TURN, float(frame.fastest))
        self._change = change

    def require_short_steps(self, state: list[float], ahead_ns: int) -> None:
        """Every step serves that is no longer than the largest."""

    def advance(
        self, state: list[float], spans: NDArray[np.int64], counts: NDArray[np.int64], work: int
    ) -> tuple[Array, Array]:
        """Move a state, in place, through N samples; see `Integrator`."""
        out = np.empty((len(spans), SAMPLE_SIZE))
        LOOP.run(state, self.constants, spans, counts, out, work)
        return self._change.outward(out[:, :4], out[:, 4:])


def moser_veselov_integrators(starts: Starts, max_step: float, order: int) -> list[MoserVeselovIntegrator]:
    """The motions of bodies from their starts, by steps of an even order.

    Bodies of equal inertia share their axes, and those of equal rate as well the constants of their motion.
    """
    found: dict[int, MoserVeselovIntegrator] = {}
    with working_precision(DIGITS):
        motions = list(_motions(starts))
        constants = motion_constants([frame for _, frame, _ in motions], order)
        for (change, frame, same), numbers in zip(motions, constants, strict=True):
            for i in same:
                attitude = starts.attitude_xyzw[i].tolist()
                found[i] = MoserVeselovIntegrator(change, frame, numbers, attitude, max_step)
    return [found[i] for i in range(len(found))]


def _motions(starts: Starts) -> Iterator[tuple[FrameChange, SpinningFrame, list[int]]]:
    """Each distinct motion, not yet placed in the world, and which of the bodies have it."""
    for body in _alike(starts.inertia, range(len(starts.inertia))):
        principal = PrincipalAxes.of(starts.inertia[body[0]].tolist())
        change = FrameChange(principal)
        for same in _alike(starts.body_rate, body):
            yield change, SpinningFrame.about(principal, starts.body_rate[same[0]].tolist()), same


def _alike(values: Array, places: Iterable[int]) -> list[list[int]]:
    """Some places along the first axis, those of the same bits together."""
    groups: dict[bytes, list[int]] = {}
    for i in places:
        groups.setdefault(values[i].tobytes(), []).append(i)
    return list(groups.values())
