"""The motions of rigid bodies by Runge–Kutta–Munthe-Kaas steps, and the limit of their length."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.motion import InitialConditions
from lie_rigid_body.motion.munthe_kaas.loop import ATTITUDE, LOOP, MOMENTUM, STATE_SIZE
from lie_rigid_body.motion.munthe_kaas.tableau import Tableau

CHART_RADIUS: Final = math.pi
"""Largest rotation angle in a step, rad: farther from its centre the chart is not one to one."""

GOOD_TURN: Final = 0.01
"""Rotation angle of the step that a refusal advises, rad: short enough for a small error."""


class MuntheKaasIntegrator:
    """The motion of one body by Runge–Kutta–Munthe-Kaas steps; an `Integrator`.

    Parameters
    ----------
    inverse_inertia : ndarray, shape (3, 3)
    attitude_xyzw : ndarray, shape (4,)
        At the start.
    body_momentum : ndarray, shape (3,)
        At the start, kg m²/s.
    max_step : float
        Largest step, s.
    stages : list of float
        The weights of the Runge–Kutta method; see `loop`.

    Attributes
    ----------
    start : list of float
        The state at time 0; see `loop`.
    constants : list of float
        Constants of the body and the method; see `loop`.
    largest_step : float
        s
    """

    __slots__ = ("_inverse", "constants", "largest_step", "start")

    def __init__(
        self, inverse_inertia: Array, attitude_xyzw: Array, body_momentum: Array, max_step: float, stages: list[float]
    ) -> None:
        self._inverse = inverse_inertia
        (a, b, c), (_, d, e), (_, _, f) = inverse_inertia.tolist()
        self.constants: list[float] = [a, b, c, d, e, f, *stages]
        self.start: list[float] = [*attitude_xyzw.tolist(), *body_momentum.tolist()]
        self.largest_step = max_step

    def require_short_steps(self, state: list[float], span_ns: int) -> None:
        """Refuse steps that go farther than the chart is one to one, judged by the body rate of a state.

        Raises
        ------
        InputError
        """
        step = min(self.largest_step, 1e-9 * span_ns)
        way = step * math.hypot(*apply_tensor(self._inverse, np.array(state[MOMENTUM:])).tolist())
        if way > CHART_RADIUS:
            raise InputError(
                f"a step of {step:g} s goes {way:.3g} rad at the rate of its start, or more (limit {CHART_RADIUS:.3g} "
                f"rad): lower max_step, to about {GOOD_TURN * step / way:.1g} s"
            )

    def advance(self, state: list[float], spans: Integers, counts: Integers, work: int) -> tuple[Array, Array]:
        """Move a state, in place, through N samples; see `Integrator`.

        Raises
        ------
        InputError
            If the steps lead to infinity.
        """
        out = np.empty((len(spans), STATE_SIZE))
        LOOP.run(state, self.constants, spans, counts, out, work)
        if math.isnan(state[ATTITUDE]):
            raise InputError(f"a step of {self.largest_step:g} s leads to infinity: lower max_step")
        return out[:, :MOMENTUM], apply_tensor(self._inverse, out[:, MOMENTUM:])


def munthe_kaas_integrators(starts: InitialConditions, max_step: float, tableau: Tableau) -> list[MuntheKaasIntegrator]:
    """The motions of B bodies from their starts, by the Runge–Kutta method of a tableau."""
    stages = [float(weight) for both in zip(tableau.a, tableau.b, strict=True) for weight in both]
    bodies, states = starts.bodies, starts.states
    momenta = apply_tensor(bodies.inertia, states.body_rate)
    return [
        MuntheKaasIntegrator(inverse, attitude, momentum, max_step, stages)
        for inverse, attitude, momentum in zip(bodies.inverse_inertia, states.attitude_xyzw, momenta, strict=True)
    ]
