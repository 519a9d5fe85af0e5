"""The moving chart: Euler's equations integrated in a chart that is re-centred on the attitude at every step.

The chart of Lucas (arXiv 1111.1275) about the present attitude A₀ is A(α) = exp(αᵃTᵃ) A₀. At the start of each
step α = 0; the step carries α by its rate dexp⁻¹ and the momentum by Euler's equations; then the end point becomes the
new centre. As α never grows beyond one step, the coordinates never become singular. With Runge–Kutta in the chart this
is the Runge–Kutta–Munthe-Kaas method (Iserles et al., Acta Numerica 9 (2000), sec. 4.2).

Departure from the paper: the coordinates used here are β = A₀ᵀα, the same chart written in body components, since
exp(hat(A₀β)) A₀ = A₀ exp(hat(β)). The inertia is then constant, and Euler's equations read π̇ = π × M⁻¹π for the body
momentum π = Mω. It makes no difference to the result.

The Moser–Veselov steps are taken in the same moving chart with Cayley's coordinates, A₀ cay(β), whose β follows from
the momenta before and after the step (`moser_veselov`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from typing import Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moser_veselov import LARGEST_TURN, MoserVeselovIntegrator
from lie_rigid_body.motion.motion import nanoseconds, require_body_and_start
from lie_rigid_body.motion.munthe_kaas_integrator import MuntheKaasIntegrator
from lie_rigid_body.motion.tableau import CLASSICAL, EULER, MIDPOINT, Tableau

Array: TypeAlias = NDArray[np.float64]


class Integrator(Protocol):
    """A motion that has come to some time."""

    def through(self, times_ns: NDArray[np.int64]) -> tuple[Array, Array]:
        """Attitudes, shape (N, 4), and body rates, shape (N, 3), at N times that do not decrease."""
        ...


@dataclass(frozen=True)
class Method:
    """A stepper of rotations.

    Attributes
    ----------
    name : str
        Its public name.
    order : int
    begin : callable
        Takes the body, the start and the largest step, s, and returns an `Integrator`.
    largest_turn : float
        rad: it takes steps no longer than the time of this turn, whatever the largest step.
    """

    name: str
    order: int
    begin: Callable[[RigidBody, State, float], Integrator]
    largest_turn: float = math.inf


def _munthe_kaas(tableau: Tableau) -> Method:
    return Method(tableau.name, tableau.order, partial(MuntheKaasIntegrator, tableau=tableau))


def _moser_veselov(order: int) -> Method:
    return Method(f"dmv{order}", order, partial(MoserVeselovIntegrator, order=order), LARGEST_TURN)


METHODS: Final = {
    method.name: method
    for method in (
        *(_munthe_kaas(tableau) for tableau in (EULER, MIDPOINT, CLASSICAL)),
        *(_moser_veselov(order) for order in (2, 4, 6, 8, 10, 20)),
    )
}
"""The steppers by their public names."""

DEFAULT_METHOD: Final = "dmv20"
DEFAULT_MAX_STEP: Final = 0.001


class MovingChart:
    """The motion of a free body, integrated from its start.

    The ``dmv`` methods are the discrete Moser–Veselov algorithm with preprocessed inertia, which keeps the energy and
    the spatial momentum vector. ``dmv20`` is exact to round-off at every step it takes, and its state is carried in
    double-double. Measured on the inertia 0.6, 0.8, 1 with body momentum 1.8, 0.4, −0.9 and steps of 0.01 s, the
    largest errors up to 10⁶ and 10⁸ steps are 1.0e-15 and 3.4e-14 rad of attitude, 4.4e-16 of the energy and 6e-16 of
    the momentum, the last two being those of reading a state in doubles. The attitude's error grows like a random
    walk.

    ``rkmk1``, ``rkmk2`` and ``rkmk4`` are Runge–Kutta–Munthe-Kaas methods: their energy drifts, and the attitude with
    it.

    Where numba is installed long integrations run compiled, to the same bits.

    Parameters
    ----------
    body : RigidBody
    start : State
        State at time 0, of one instant.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2``, ``rkmk4``, ``dmv2``, ``dmv4``, ``dmv6``, ``dmv8``, ``dmv10`` or ``dmv20``
        (default). The number is the order.
    max_step : float, optional
        Largest step, s. Between two requested times the steps are equal and no longer than this, and with ``dmv``
        methods no longer than the time in which the body turns by ¼ rad.

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
        require_stepper(method, max_step, METHODS)
        require_body_and_start(body, start)
        self._start = start
        self._integrator = METHODS[method].begin(body, start, float(max_step))

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
        flat = np.atleast_1d(times)
        attitudes, rates = self._integrator.through(flat)
        # at the start the very numbers that were given
        attitudes[flat == 0], rates[flat == 0] = self._start.attitude_xyzw, self._start.body_rate
        states = State.trusted(attitudes, rates)
        return states if times.ndim else states[0]


def require_stepper(method: object, max_step: object, methods: Collection[str]) -> None:
    """Refuse a stepper that does not exist or a step that leads nowhere.

    Raises
    ------
    ParameterError
        Naming ``method`` or ``max_step``.
    """
    if not isinstance(method, str) or method not in methods:
        raise ParameterError("method", f"{method!r} is unknown: choose one of {', '.join(methods)}")
    number = isinstance(max_step, float | int | np.integer | np.floating) and not isinstance(max_step, bool)
    if not (number and 0.0 < max_step < math.inf):  # type: ignore[operator]
        raise ParameterError("max_step", f"{max_step!r} s is not a positive finite time: give for example 0.001")
