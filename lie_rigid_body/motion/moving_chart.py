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
from numpy.typing import ArrayLike

from lie_rigid_body.errors import InputError, ParameterError
from lie_rigid_body.lie import scalar
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.motion import nanoseconds, require_body_and_start
from lie_rigid_body.motion.stepper import Field, Point, RungeKuttaStepper
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
        self._stepper = METHODS[method]
        self._max_step = float(max_step)
        self._field = _chart_field(body)
        self._body = body
        self._time_ns = 0
        x, y, z, w = start.attitude_xyzw.tolist()
        self._attitude: scalar.Quaternion = (x, y, z, w)
        self._momentum: Point = body.body_momentum(start).tolist()
        self._start = start

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
            If a time is not an integer or lies before one already reached.
        """
        times = nanoseconds(t_ns)
        flat = np.atleast_1d(times).tolist()
        self._require_forward(flat)
        attitudes, rates = np.empty((len(flat), 4)), np.empty((len(flat), 3))
        inverse = self._body.inverse_inertia.tolist()
        for i, t in enumerate(flat):
            self._advance_to(t)
            attitudes[i] = self._attitude
            rates[i] = _times(inverse, self._momentum) if t else self._start.body_rate
        states = State.trusted(attitudes, rates)
        return states if times.ndim else states[0]

    def _require_forward(self, times: list[int]) -> None:
        previous = self._time_ns
        for t in times:
            if t < previous:
                raise InputError(
                    f"t_ns {t} lies before {previous}, which is already reached: give times that do not decrease, "
                    "or start a new MovingChart"
                )
            previous = t

    def _advance_to(self, t_ns: int) -> None:
        span = 1e-9 * (t_ns - self._time_ns)
        steps = math.ceil(span / self._max_step - 1e-9)
        for _ in range(steps):
            self._step(span / steps)
        self._time_ns = t_ns

    def _step(self, h: float) -> None:
        end = self._stepper.step(self._field, [0.0, 0.0, 0.0, *self._momentum], h)
        x, y, z, *self._momentum = end
        # the chart moves on: its centre is the attitude just reached
        self._attitude = scalar.renormalize(scalar.multiply(self._attitude, scalar.exp((x, y, z))))


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


def _chart_field(body: RigidBody) -> Field:
    """The rate of (β, π): the chart rate dexp⁻¹ ω and Euler's equations π̇ = π × ω, with ω = M⁻¹π."""
    (a, b, c), (_, d, e), (_, _, f) = body.inverse_inertia.tolist()
    dexpinv = scalar.right_dexpinv

    def field(point: Point) -> Point:
        bx, by, bz, px, py, pz = point
        wx, wy, wz = a * px + b * py + c * pz, b * px + d * py + e * pz, c * px + e * py + f * pz
        rate = dexpinv((bx, by, bz), (wx, wy, wz))
        return [*rate, py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx]

    return field


def _times(matrix: list[list[float]], vector: Point) -> list[float]:
    x, y, z = vector
    return [row[0] * x + row[1] * y + row[2] * z for row in matrix]
