"""A rotation carried by Runge–Kutta–Munthe-Kaas steps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.chart_integrator import GOOD_WAY
from lie_rigid_body.motion.group_chart import LARGEST_TURN
from lie_rigid_body.motion.munthe_kaas_loop import LOOP
from lie_rigid_body.motion.tableau import Tableau
from lie_rigid_body.motion.time_steps import TimeSteps

Array = NDArray[np.float64]


class MuntheKaasIntegrator:
    """The state of a motion that has come to some time.

    Parameters
    ----------
    body : RigidBody
    start : State
    max_step : float
        Largest step, s.
    tableau : Tableau
        One in which each stage needs only the one before.
    """

    def __init__(self, body: RigidBody, start: State, max_step: float, tableau: Tableau) -> None:
        self._inverse = body.inverse_inertia
        (a, b, c), (_, d, e), (_, _, f) = self._inverse.tolist()
        self._constants = [a, b, c, d, e, f, *_stages(tableau)]
        self._state: list[float] = [*start.attitude_xyzw.tolist(), *body.body_momentum(start).tolist()]
        self._max_step = max_step
        self._time = TimeSteps(max_step)

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
            If a time lies before one already reached; nothing is integrated then. If the steps lead to infinity.
        """
        self._require_short_steps(times_ns)
        spans, counts = self._time.to(times_ns)
        out = np.empty((len(spans), len(self._state)))
        LOOP.run(self._state, self._constants, spans, counts, out)
        if math.isnan(self._state[0]):
            raise InputError(f"a step of {self._max_step:g} s leads to infinity: lower max_step")
        return out[:, :4], apply_tensor(self._inverse, out[:, 4:])

    def _require_short_steps(self, times_ns: NDArray[np.int64]) -> None:
        """Refuse steps at whose length the chart is not one to one, judged at the present rate."""
        ahead_ns = int(times_ns[-1]) - self._time.reached_ns if len(times_ns) else 0
        step = min(self._max_step, 1e-9 * ahead_ns)
        way = step * math.hypot(*apply_tensor(self._inverse, np.array(self._state[4:])).tolist())
        if way > LARGEST_TURN:
            raise InputError(
                f"a step of {step:g} s goes {way:.3g} rad at the rate of its start, or more (limit {LARGEST_TURN:.3g} "
                f"rad): lower max_step, to about {GOOD_WAY * step / way:.1g} s"
            )


def _stages(tableau: Tableau) -> list[float]:
    """For each stage the weight of the slope before it, and its own in the sum."""
    if any(any(row[:-1]) for row in tableau.a):
        raise ValueError(f"tableau {tableau.name}: a stage needs others than the one before")
    before = [row[-1] if row else 0 for row in tableau.a]
    return [float(weight) for both in zip(before, tableau.b, strict=True) for weight in both]
