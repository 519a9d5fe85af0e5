"""Rotations carried by Runge–Kutta–Munthe-Kaas steps."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.munthe_kaas_loop import LOOP
from lie_rigid_body.motion.starts import Starts
from lie_rigid_body.motion.tableau import Tableau

Array = NDArray[np.float64]

LARGEST_TURN: Final = math.pi
"""rad: further from its centre the chart is not one to one."""

GOOD_TURN: Final = 0.01
"""rad, of a step that errs little."""


class MuntheKaasIntegrator:
    """One motion.

    Parameters
    ----------
    inverse_inertia : ndarray, shape (3, 3)
    attitude_xyzw : ndarray, shape (4,)
        At the start.
    body_momentum : ndarray, shape (3,)
        At the start.
    max_step : float
        Largest step, s.
    stages : list of float
        See `munthe_kaas_loop`.

    Attributes
    ----------
    start : list of float
        The state at time 0: attitude and body momentum.
    constants : list of float
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

    def require_short_steps(self, state: list[float], ahead_ns: int) -> None:
        """Refuse steps at whose length the chart is not one to one, judged at the rate of a state.

        Raises
        ------
        InputError
        """
        step = min(self.largest_step, 1e-9 * ahead_ns)
        way = step * math.hypot(*apply_tensor(self._inverse, np.array(state[4:])).tolist())
        if way > LARGEST_TURN:
            raise InputError(
                f"a step of {step:g} s goes {way:.3g} rad at the rate of its start, or more (limit {LARGEST_TURN:.3g} "
                f"rad): lower max_step, to about {GOOD_TURN * step / way:.1g} s"
            )

    def advance(
        self, state: list[float], spans: NDArray[np.int64], counts: NDArray[np.int64], work: int
    ) -> tuple[Array, Array]:
        """Move a state, in place, through N samples; see `Integrator`.

        Raises
        ------
        InputError
            If the steps lead to infinity.
        """
        out = np.empty((len(spans), len(state)))
        LOOP.run(state, self.constants, spans, counts, out, work)
        if math.isnan(state[0]):
            raise InputError(f"a step of {self.largest_step:g} s leads to infinity: lower max_step")
        return out[:, :4], apply_tensor(self._inverse, out[:, 4:])


def munthe_kaas_integrators(starts: Starts, max_step: float, tableau: Tableau) -> list[MuntheKaasIntegrator]:
    """The motions of bodies from their starts, by a tableau in which each stage needs only the one before."""
    stages = _stages(tableau)
    momenta = apply_tensor(starts.inertia, starts.body_rate)
    return [
        MuntheKaasIntegrator(inverse, attitude, momentum, max_step, stages)
        for inverse, attitude, momentum in zip(starts.inverse_inertia, starts.attitude_xyzw, momenta, strict=True)
    ]


def _stages(tableau: Tableau) -> list[float]:
    """For each stage the weight of the slope before it, and its own in the sum."""
    if any(any(row[:-1]) for row in tableau.a):
        raise ValueError(f"tableau {tableau.name}: a stage needs others than the one before")
    before = [row[-1] if row else 0 for row in tableau.a]
    return [float(weight) for both in zip(before, tableau.b, strict=True) for weight in both]
