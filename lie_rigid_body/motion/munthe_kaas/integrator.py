"""The motion of a rigid body by Runge–Kutta–Munthe-Kaas steps, and the limit of their length."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.compilation import StepLoop
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.munthe_kaas.loop import ChartConstants, ChartState, advance
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT, ChainTableau

CHART_RADIUS: Final = math.pi
"""Largest rotation angle in a step, rad: farther from its centre the chart is not one to one."""

GOOD_TURN: Final = 0.01
"""Rotation angle of the step that a refusal advises, rad: short enough for a small error."""

LOOPS: Final = {tableau.name: StepLoop(advance, ChartState._make) for tableau in (EULER, MIDPOINT, CLASSICAL)}
"""The loop of each method, whose compiled form depends on the number of its stages."""


class MuntheKaasIntegrator:
    """The motion of one body by Runge–Kutta–Munthe-Kaas steps; an `Integrator`.

    Attributes
    ----------
    start : ChartState
        The state at time 0.
    constants : ChartConstants
        Constants of the body and the method.
    fastest : float
        The body rate at the start, rad/s.
    """

    __slots__ = ("_body", "_name", "constants", "fastest", "start")

    def __init__(self, body: RigidBody, start: State, tableau: ChainTableau) -> None:
        self._body = body
        self._name = tableau.name
        (a, b, c), (_, d, e), (_, _, f) = body.inverse_inertia.tolist()
        stages = tuple((float(before), float(own)) for before, own in zip(tableau.a, tableau.b, strict=True))
        x, y, z, w = start.attitude_xyzw.tolist()
        px, py, pz = body.body_momentum(start).tolist()
        self.constants = ChartConstants((a, b, c, d, e, f), stages)
        self.start = ChartState((x, y, z, w), (px, py, pz))
        self.fastest = math.hypot(*start.body_rate.tolist())

    def compile(self) -> bool:
        """Compile the steps; see `Integrator`."""
        return LOOPS[self._name].compile(self.start, self.constants)

    def require_short_steps(self, state: ChartState, step: float) -> None:
        """Refuse steps that go farther than the chart is one to one, judged by the body rate of a state.

        Raises
        ------
        InputError
        """
        way = step * math.hypot(*self._rate(np.array(state.momentum)).tolist())
        if way > CHART_RADIUS:
            raise InputError(
                f"a step of {step:g} s goes {way:.3g} rad at the rate of its start, or more (limit {CHART_RADIUS:.3g} "
                f"rad): lower max_step, to about {GOOD_TURN * step / way:.1g} s"
            )

    def advance(self, state: ChartState, spans: Integers, counts: Integers) -> tuple[ChartState, Array, Array]:
        """Move a state through N samples; see `Integrator`."""
        out = np.empty((len(spans), 7))
        state = LOOPS[self._name].run(state, self.constants, spans, counts, out)
        return state, out[:, :4], self._rate(out[:, 4:])

    def _rate(self, momentum: Array) -> Array:
        return apply_tensor(self._body.inverse_inertia, momentum)
