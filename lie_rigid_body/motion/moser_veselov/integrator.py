"""A motion carried by Moser–Veselov steps."""

from __future__ import annotations

from decimal import Decimal
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moser_veselov.frame_change import FrameChange, rotated
from lie_rigid_body.motion.moser_veselov.loop import LENGTH, LOOP, SAMPLE_SIZE, STATE_SIZE
from lie_rigid_body.motion.moser_veselov.preprocessing import preprocessed_inertia
from lie_rigid_body.motion.moser_veselov.spinning_frame import SpinningFrame, working_precision
from lie_rigid_body.motion.time_steps import TimeSteps

Array = NDArray[np.float64]

LARGEST_TURN: Final = 0.25
"""rad: steps are no longer than the time of this turn, where the series of the highest order end in round-off."""

_NANOSECOND: Final = Decimal("1e-9")
_FEWEST_TERMS: Final = 2


class MoserVeselovIntegrator:
    """The state of a motion that has come to some time.

    Parameters
    ----------
    body : RigidBody
    start : State
    max_step : float
        Largest step, s.
    order : int
        Even.
    """

    def __init__(self, body: RigidBody, start: State, max_step: float, order: int) -> None:
        with working_precision():
            frame = SpinningFrame.of(body, start)
            self._change = FrameChange(frame)
            attitude = self._change.inward(start.attitude_xyzw.tolist())
            self._constants = _pairs(_constants(frame, attitude, order // 2))
            self._state = [*_pairs([*frame.momentum, *attitude]), *[0.0] * STATE_SIZE][:STATE_SIZE]
            self._state[LENGTH] = -1.0  # of no step yet
            fastest = float(frame.fastest)
        self._time = TimeSteps(min(max_step, LARGEST_TURN / fastest) if fastest else max_step)

    def through(self, times_ns: NDArray[np.int64]) -> tuple[Array, Array]:
        """Attitudes and body rates at times that do not decrease.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)

        Returns
        -------
        attitude_xyzw : ndarray, shape (N, 4)
        body_rate : ndarray, shape (N, 3)

        Raises
        ------
        InputError
            If a time lies before one already reached; nothing is integrated then.
        """
        spans, counts = self._time.to(times_ns)
        out = np.empty((len(spans), SAMPLE_SIZE))
        LOOP.run(self._state, self._constants, spans, counts, out)
        return self._change.outward(out[:, :4], out[:, 4:])


def _constants(frame: SpinningFrame, attitude: list[Decimal], terms: int) -> list[Decimal]:
    """One nanosecond; e₁, e₂, e₃; P, Q; m₁, m₃; 2H; the spatial momentum; and, by turns, the series of α and β.

    All in the units of the frame; then also the body rates of n₁, n₂, n₃ in rad/s.
    """
    e1, e2, e3 = frame.inverse_moments
    n1, n2, n3 = (component * component for component in frame.momentum)
    p = (e2 - e3) * ((e1 - e2) * n2 + (e1 - e3) * n3)
    q = (e1 - e2) * ((e1 - e3) * n1 + (e2 - e3) * n2)
    alpha, beta = preprocessed_inertia(frame, terms)
    alpha[-1] = Decimal(0)  # of the next order
    nothing = [Decimal(0)] * (_FEWEST_TERMS - terms)
    by_turns = [c for both in zip([*alpha, *nothing], [*beta, *nothing], strict=True) for c in both]
    rates = [e * frame.fastest for e in frame.inverse_moments]
    world = rotated(attitude, list(frame.momentum))
    first = [_NANOSECOND * frame.fastest, e1, e2, e3, p, q, frame.m1, frame.m3, frame.twice_energy]
    return [*first, *world, *rates, *by_turns]


def _pairs(values: list[Decimal]) -> list[float]:
    """Each number as hi and lo."""
    pairs: list[float] = []
    for value in values:
        hi = float(value)
        pairs += [hi, float(value - Decimal(hi))]
    return pairs
