"""The moving chart: Euler's equations integrated in a chart that is re-centred on the attitude at every step.

The chart of Lucas (arXiv 1111.1275) about the present attitude A₀ is A(α) = exp(αᵃTᵃ) A₀. At the start of each
step α = 0; the step carries α by its rate dexp⁻¹ and the momentum by Euler's equations; then the end point becomes the
new centre. As α never grows beyond one step, the coordinates never become singular. With Runge–Kutta in the chart this
is the Runge–Kutta–Munthe-Kaas method (Iserles et al., Acta Numerica 9 (2000), sec. 4.2).

Departure from the paper: the coordinates used here are β = A₀ᵀα, the same chart written in body components, since
exp(hat(A₀β)) A₀ = A₀ exp(hat(β)). The inertia is then constant, and Euler's equations read π̇ = π × M⁻¹π for the body
momentum π = Mω. It makes no difference to the result.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import scalar
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.chart_integrator import ChartIntegrator
from lie_rigid_body.motion.group_chart import LARGEST_TURN
from lie_rigid_body.motion.motion import nanoseconds, require_body_and_start
from lie_rigid_body.motion.rotation_chart import RotationChart
from lie_rigid_body.motion.stepper import RungeKuttaStepper
from lie_rigid_body.motion.tableau import CLASSICAL, EULER, MIDPOINT

METHODS: Final = {tableau.name: RungeKuttaStepper(tableau) for tableau in (EULER, MIDPOINT, CLASSICAL)}
"""The steppers by their public names."""

DEFAULT_METHOD: Final = CLASSICAL.name
DEFAULT_MAX_STEP: Final = 0.001


class MovingChart:
    """The motion of a free body, integrated from its start.

    Parameters
    ----------
    body : RigidBody
    start : State
        State at time 0, of one instant.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2`` or ``rkmk4`` (default).
    max_step : float, optional
        Largest step, s. Between two requested times the steps are equal and no longer than this.

    Raises
    ------
    InputError
        If the body is no RigidBody, or the start no State of one instant.
    ParameterError
        If the method is unknown or the step not positive and finite.
    """

    def __init__(
        self, body: RigidBody, start: State, *, method: str = DEFAULT_METHOD, max_step: float = DEFAULT_MAX_STEP
    ) -> None:
        require_stepper(method, max_step)
        require_body_and_start(body, start)
        x, y, z, w = start.attitude_xyzw.tolist()
        self._body, self._start = body, start
        self._integrator: ChartIntegrator[scalar.Quaternion] = ChartIntegrator(
            METHODS[method],
            RotationChart(body),
            (x, y, z, w),
            body.body_momentum(start).tolist(),
            max_step,
            LARGEST_TURN,
        )

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start; may not decrease, within a call or from call to call.

        Returns
        -------
        State
            Shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.

        Raises
        ------
        InputError
            If a time is not an integer or lies before one already reached, or the body turns by more than π in a step.
        """
        times = nanoseconds(t_ns)
        flat = np.atleast_1d(times).tolist()
        attitudes, momenta = np.empty((len(flat), 4)), np.empty((len(flat), 3))
        for i, (attitude, momentum) in enumerate(self._integrator.through(flat)):
            attitudes[i], momenta[i] = attitude, momentum
        states = State.trusted(attitudes, self._rates(np.array(flat), momenta))
        return states if times.ndim else states[0]

    def _rates(self, times: NDArray[np.int64], momenta: NDArray[np.float64]) -> NDArray[np.float64]:
        """ω = M⁻¹π, and at the start the very numbers that were given."""
        rates = apply_tensor(self._body.inverse_inertia, momenta)
        rates[times == 0] = self._start.body_rate
        return rates


def require_stepper(method: object, max_step: object) -> None:
    """Refuse a stepper that does not exist or a step that leads nowhere.

    Raises
    ------
    ParameterError
        Naming ``method`` or ``max_step``.
    """
    if not isinstance(method, str) or method not in METHODS:
        raise ParameterError("method", f"{method!r} is unknown: choose one of {', '.join(METHODS)}")
    number = isinstance(max_step, float | int | np.integer | np.floating) and not isinstance(max_step, bool)
    if not (number and 0.0 < max_step < math.inf):  # type: ignore[operator]
        raise ParameterError("max_step", f"{max_step!r} s is not a positive finite time: give for example 0.001")
