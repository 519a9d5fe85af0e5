"""The moving chart: Euler's equations integrated in a chart that is re-centred on the attitude at every step.

The chart of Lucas (arXiv 1111.1275) about the present attitude A₀ is A(α) = exp(αᵃTᵃ) A₀. At the start of each
step α = 0; the step carries α by its rate dexp⁻¹ and the momentum by Euler's equations; then the end point becomes the
new centre. As α never grows beyond one step, the coordinates never become singular. With Runge–Kutta in the chart this
is the Runge–Kutta–Munthe-Kaas method (Iserles et al., Acta Numerica 9 (2000), sec. 4.2). docs/moving_chart.md derives
the steps.

Departure from the paper: the coordinates used here are β = A₀ᵀα, the same chart written in body components, since
exp(hat(A₀β)) A₀ = A₀ exp(hat(β)). The inertia is then constant, and Euler's equations read π̇ = π × M⁻¹π for the body
momentum π = Mω. It makes no difference to the result.

The discrete Moser–Veselov steps are taken in the same moving chart with Cayley's coordinates, A₀ cay(hat(β)), whose β
follows from the momenta before and after the step (`moser_veselov`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Integers, as_double
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import call_repr, shown
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moser_veselov import MAX_TURN, MoserVeselovIntegrator
from lie_rigid_body.motion.motion import Samples, require_one, states_at
from lie_rigid_body.motion.munthe_kaas import CLASSICAL, EULER, MIDPOINT, MuntheKaasIntegrator
from lie_rigid_body.motion.time_steps import require_order, steps_to


class Integrator(Protocol):
    """The motion of one body in steps. The caller keeps its state, which only the method can read."""

    @property
    def start(self) -> Any:
        """The state at time 0."""

    @property
    def fastest(self) -> float:
        """A body rate of the motion, rad/s, for methods that limit the turn of a step the largest."""

    def compile(self) -> bool:
        """Compile the steps, or load them from the cache; whether numba is there to do it."""

    def require_short_steps(self, state: Any, step: float) -> None:
        """Refuse steps, up to so many seconds, that are too long for the method and a state.

        Raises
        ------
        InputError
        """

    def advance(self, state: Any, spans: Integers, counts: Integers) -> tuple[Any, Array, Array]:
        """Move a state through N samples.

        Parameters
        ----------
        state : Any
        spans, counts : ndarray of int64, shape (N,)
            Time since the sample before, ns, and the number of steps that divide it.

        Returns
        -------
        state : Any
            At the last sample.
        attitude_xyzw : ndarray, shape (N, 4)
            NaN where the steps lead to infinity.
        body_rate : ndarray, shape (N, 3)
        """


DEFAULT_STEP: Final = 0.001
"""Largest step, s, of methods that do not limit the turn of a step, where none is asked for."""


@short_dataclass
class Method:
    """A stepper of rotations.

    Attributes
    ----------
    name : str
        Its public name.
    order : int
        Order of accuracy p: the error of one step falls with its length to the power p + 1.
    integrator : callable
        Takes a body and its start, and returns an `Integrator`.
    max_turn : float
        rad: the steps are no longer than the time of this turn, whatever the largest step.
    default_step : float
        Largest step where none is asked for, s.
    """

    name: str
    order: int
    integrator: Callable[[RigidBody, State], Integrator]
    max_turn: float = math.inf
    default_step: float = DEFAULT_STEP

    def longest_step(self, max_step: float, rate_bound: float) -> float:
        """The longest step that the method takes.

        Parameters
        ----------
        max_step : float
            Largest step that is asked for, s; 0: as long as the method allows.
        rate_bound : float
            Bound of the body rate, rad/s.

        Returns
        -------
        float
            s; infinite where the step is the interval between samples.
        """
        if not rate_bound:
            return max_step or math.inf
        return min(max_step or self.default_step, self.max_turn / rate_bound)


METHODS: Final = {
    method.name: method
    for method in (
        *(
            Method(tableau.name, tableau.order, partial(MuntheKaasIntegrator, tableau=tableau))
            for tableau in (EULER, MIDPOINT, CLASSICAL)
        ),
        *(
            Method(f"dmv{order}", order, partial(MoserVeselovIntegrator, order=order), MAX_TURN)
            for order in (2, 4, 6, 8, 10)
        ),
        Method("dmv20", 20, partial(MoserVeselovIntegrator, order=20), MAX_TURN, math.inf),
    )
}
"""The steppers by their public names."""

DEFAULT_METHOD: Final = "dmv20"
DEFAULT_MAX_STEP: Final = 0.0
"""Default of the largest step: as long as the method allows."""


class MovingChart:
    """The motion of a free body, integrated from the start.

    The ``dmv`` methods are the discrete Moser–Veselov algorithm with preprocessed inertia, which keeps the energy and
    the spatial momentum vector. ``dmv20`` is exact to round-off at every step it takes, and its state is carried in
    double-double. This was measured on the inertia 0.6, 0.8, 1 with body momentum 1.8, 0.4, −0.9 and steps of 0.01 s.
    The largest errors up to 10⁶ and 10⁸ steps are 1.0e-15 and 3.1e-15 rad of attitude, 4.4e-16 of the energy and 4e-16
    of the momentum. The last two come from rounding a state to doubles. The attitude's error grows like a random walk.

    ``rkmk1``, ``rkmk2`` and ``rkmk4`` are Runge–Kutta–Munthe-Kaas methods: their energy drifts, and the attitude with
    it.

    Where numba is installed long integrations run compiled, with the same bits.

    Parameters
    ----------
    body : RigidBody
    start : State
        State at time 0, of one instant.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2``, ``rkmk4``, ``dmv2``, ``dmv4``, ``dmv6``, ``dmv8``, ``dmv10`` or ``dmv20``
        (default). The number is the order.
    max_step : float, optional
        Largest step, s. Between two requested times the steps are equal and no longer than this. With ``dmv`` methods
        they are no longer than the time in which the body turns by ¼ rad. By default, 0, they are as long as the
        method allows: that time with ``dmv20``, 1 ms with the others, and the whole interval for a body at rest.

    Raises
    ------
    InputError
        If the body is no RigidBody, or the start no State of one instant.
    ParameterError
        If the method is unknown, or the step negative or not finite.
    """

    def __init__(
        self, body: RigidBody, start: State, *, method: str = DEFAULT_METHOD, max_step: float = DEFAULT_MAX_STEP
    ) -> None:
        require_stepper(method, max_step, METHODS)
        require_one(body, start)
        self._start = start
        self._method = METHODS[method]
        self._max_step = float(max_step)
        self._integrator = self._method.integrator(body, start)
        # replaced as a whole, never changed: a copy of the motion goes on by itself, and a signal finds both or none
        self._reached = self._integrator.start, 0

    def __repr__(self) -> str:
        shown_values = {"method": self._method.name, "max_step": self._max_step, "reached_ns": self._reached[1]}
        return call_repr(self, shown_values)

    def compile(self) -> bool:
        """Compile the steps of this method now, for what is to be timed; whether numba is there to do it."""
        return self._integrator.compile()

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times.

        Where an error is raised the body has not moved, and other times may be asked for.

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
            If a time is not an integer or lies before one already reached. It is raised as well if the steps are too
            many, too long for the body's rate, or lead to infinity.
        """
        return states_at(self._start, t_ns, self._samples)

    def _samples(self, t_ns: Integers) -> Samples:
        """Attitudes and body rates at N times, shapes (N, 4) and (N, 3); the body moves on to the last."""
        state, reached_ns = self._reached
        require_order(t_ns, reached_ns)
        longest = self._method.longest_step(self._max_step, self._integrator.fastest)
        spans, counts = steps_to(t_ns, reached_ns, longest)
        step = min(longest, 1e-9 * (spans.max(initial=0)))
        self._integrator.require_short_steps(state, step)
        state, attitude, rate = self._integrator.advance(state, spans, counts)
        if np.isnan(attitude[-1:]).any():
            raise InputError(f"a step of {step:g} s leads to infinity: lower max_step")
        self._reached = state, int(t_ns[-1]) if len(t_ns) else reached_ns
        return attitude, rate


def require_stepper(method: object, max_step: object, methods: Collection[str]) -> None:
    """Refuse a stepper that does not exist, or a step that is negative or no finite time.

    Raises
    ------
    ParameterError
        Naming ``method`` or ``max_step``.
    """
    if not isinstance(method, str) or method not in methods:
        raise ParameterError("method", f"{shown(method)} is unknown: choose one of {', '.join(methods)}")
    if not 0.0 <= as_double(max_step) < np.inf:
        raise ParameterError(
            "max_step", f"{shown(max_step)} s is negative or not finite: give for example 0.001, or 0 for the longest"
        )
