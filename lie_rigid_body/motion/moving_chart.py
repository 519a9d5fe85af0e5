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
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Integers, as_double
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import call_repr, shown
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.moser_veselov import LARGEST_TURN, moser_veselov_integrators
from lie_rigid_body.motion.motion import DEFAULT_MEMORY_LIMIT, InitialConditions, WorkingMemory, states_at
from lie_rigid_body.motion.munthe_kaas import CLASSICAL, EULER, MIDPOINT, munthe_kaas_integrators
from lie_rigid_body.motion.time_steps import require_order, steps_through, steps_to


class Integrator(Protocol):
    """The motion of one body in steps. The caller keeps its state, a list of floats that only the method can read."""

    @property
    def start(self) -> list[float]:
        """The state at time 0."""

    @property
    def largest_step(self) -> float:
        """The length that no step exceeds, s."""

    def require_short_steps(self, state: list[float], span_ns: int) -> None:
        """Refuse to go from sample to sample, up to so many nanoseconds, in steps too long for the method and a state.

        Raises
        ------
        InputError
        """

    def advance(self, state: list[float], spans: Integers, counts: Integers, work: int) -> tuple[Array, Array]:
        """Move a state, in place, through N samples.

        Parameters
        ----------
        state : list of float
        spans, counts : ndarray of int64, shape (N,)
            Time since the sample before, ns, and the number of steps that divide it.
        work : int
            The steps that this call counts as when it is judged whether compiling pays; see `compilation.Loop`.

        Returns
        -------
        attitude_xyzw : ndarray, shape (N, 4)
        body_rate : ndarray, shape (N, 3)

        Raises
        ------
        InputError
            If the steps lead to infinity.
        """


@short_dataclass(frozen=True)
class Method:
    """A stepper of rotations.

    Attributes
    ----------
    name : str
        Its public name.
    order : int
        Order of accuracy p: the error of one step falls with its length to the power p + 1.
    integrators : callable
        Takes the initial conditions of B bodies and the largest step, s, and returns B integrators.
    largest_turn : float
        rad: the steps are no longer than the time of this turn, whatever the largest step.
    """

    name: str
    order: int
    integrators: Callable[[InitialConditions, float], Sequence[Integrator]]
    largest_turn: float = math.inf


METHODS: Final = {
    method.name: method
    for method in (
        *(
            Method(tableau.name, tableau.order, partial(munthe_kaas_integrators, tableau=tableau))
            for tableau in (EULER, MIDPOINT, CLASSICAL)
        ),
        *(
            Method(f"dmv{order}", order, partial(moser_veselov_integrators, order=order), LARGEST_TURN)
            for order in (2, 4, 6, 8, 10, 20)
        ),
    )
}
"""The steppers by their public names."""

DEFAULT_METHOD: Final = "dmv20"
DEFAULT_MAX_STEP: Final = 0.001
"""Default of the largest step, s."""

_NEEDS: Final = WorkingMemory(body=1536, time=8, sample=320)
"""Working memory, bytes. Measured are 1400 for each body, whose new state is kept beside the old one, and 250 for each
sample."""


class MovingChart:
    """The motion of a free body, or of an ensemble of bodies, integrated from the start.

    The ``dmv`` methods are the discrete Moser–Veselov algorithm with preprocessed inertia, which keeps the energy and
    the spatial momentum vector. ``dmv20`` is exact to round-off at every step it takes, and its state is carried in
    double-double. This was measured on the inertia 0.6, 0.8, 1 with body momentum 1.8, 0.4, −0.9 and steps of 0.01 s.
    The largest errors up to 10⁶ and 10⁸ steps are 1.0e-15 and 3.1e-15 rad of attitude, 4.4e-16 of the energy and 4e-16
    of the momentum. The last two come from rounding a state to doubles. The attitude's error grows like a random walk.

    ``rkmk1``, ``rkmk2`` and ``rkmk4`` are Runge–Kutta–Munthe-Kaas methods: their energy drifts, and the attitude with
    it.

    Where numba is installed long integrations run compiled, with the same bits. Whether one is long depends on the
    steps of all bodies together. A body has the same bits in a batch as alone.

    Parameters
    ----------
    body : RigidBody
        One, or a batch.
    start : State
        State at time 0, or one for each body. The batches broadcast; a single one goes with every other.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2``, ``rkmk4``, ``dmv2``, ``dmv4``, ``dmv6``, ``dmv8``, ``dmv10`` or ``dmv20``
        (default). The number is the order.
    max_step : float, optional
        Largest step, s. Between two requested times the steps are equal and no longer than this. With ``dmv`` methods
        they are no longer than the time in which the body turns by ¼ rad, each at its own rate.

    Raises
    ------
    InputError
        If the body is no RigidBody, the start no State, or their batches do not go together.
    ParameterError
        If the method is unknown or the step not positive and finite.
    """

    def __init__(
        self, body: RigidBody, start: State, *, method: str = DEFAULT_METHOD, max_step: float = DEFAULT_MAX_STEP
    ) -> None:
        require_stepper(method, max_step, METHODS)
        self._starts = InitialConditions.of(body, start)
        self._method, self._max_step = method, float(max_step)
        self._integrators = METHODS[method].integrators(self._starts, self._max_step)
        # replaced as a whole, never changed: a copy of the motion goes on by itself, and a signal finds both or none
        self._reached = [integrator.start for integrator in self._integrators], 0

    def __repr__(self) -> str:
        shape = {"bodies": self._starts.batch} if self._starts.batch else {}
        stepper = {"method": self._method, "max_step": self._max_step}
        return call_repr(self, {**shape, **stepper, "reached_ns": self._reached[1]})

    def at(self, t_ns: ArrayLike, *, memory_limit: int = DEFAULT_MEMORY_LIMIT) -> State:
        """The states at the given times.

        Where an error is raised no body has moved, and other times may be asked for.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start; may not decrease, within a call or from call to call.
        memory_limit : int, optional
            Bytes that the states and everything made on the way may take; 4 GiB unless given. The states take 56 of
            them for each body and time.

        Returns
        -------
        State
            Shapes (..., 4) and (..., 3) for one time, (..., N, 4) and (..., N, 3) for an array, after the axes of
            the batch.

        Raises
        ------
        InputError
            If a time is not an integer or lies before one already reached, or the states would take more memory than
            allowed. It is raised as well if the steps of a body, which is named, are too many, too long for its rate,
            or lead to infinity.
        """
        return states_at(self._starts, t_ns, memory_limit, _NEEDS, self._fill)

    def _fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        """Write the states of B bodies at N times, shapes (B, N, 4) and (B, N, 3), so many samples at once.

        Raises
        ------
        InputError
            If a time lies before one already reached, or a body cannot follow. Then no body has moved.
        """
        if len(t_ns) == 0:
            return
        states, reached_ns = self._reached
        require_order(t_ns, reached_ns)
        longest_ns = int((t_ns[1:] - t_ns[:-1]).max(initial=t_ns[0] - reached_ns))
        work = sum(self._steps_through(k, t_ns, longest_ns) for k in range(len(states)))
        moved = [list(state) for state in states]
        for k, state in enumerate(moved):
            for some, attitudes, rates in self._samples(k, state, t_ns, block, work):
                attitude_xyzw[k, some], body_rate[k, some] = attitudes, rates
                work = 0
        self._reached = moved, int(t_ns[-1])

    def _steps_through(self, k: int, t_ns: Integers, longest_ns: int) -> int:
        """The number of steps that a body has to take, approximately; refuses what it cannot follow."""
        integrator, (states, reached_ns) = self._integrators[k], self._reached
        try:
            integrator.require_short_steps(states[k], longest_ns)
            return max(steps_through(int(t_ns[-1]), reached_ns, integrator.largest_step), len(t_ns))
        except InputError as error:
            raise self._starts.named(k, error) from None

    def _samples(
        self, k: int, state: list[float], t_ns: Integers, block: int, work: int
    ) -> Iterator[tuple[slice, Array, Array]]:
        """Attitudes and rates of one body, block by block; its state moves on in place."""
        _, reached_ns = self._reached
        for begin in range(0, len(t_ns), block):
            some = slice(begin, begin + block)
            spans, counts = steps_to(t_ns[some], reached_ns, self._integrators[k].largest_step)
            try:
                attitudes, rates = self._integrators[k].advance(state, spans, counts, work)
            except InputError as error:
                raise self._starts.named(k, error) from None
            yield some, attitudes, rates
            reached_ns, work = int(t_ns[some][-1]), 0


def require_stepper(method: object, max_step: object, methods: Collection[str]) -> None:
    """Refuse a stepper that does not exist, or a step that is no positive finite time.

    Raises
    ------
    ParameterError
        Naming ``method`` or ``max_step``.
    """
    if not isinstance(method, str) or method not in methods:
        raise ParameterError("method", f"{shown(method)} is unknown: choose one of {', '.join(methods)}")
    if not 0.0 < as_double(max_step) < np.inf:
        raise ParameterError("max_step", f"{shown(max_step)} s is not a positive finite time: give for example 0.001")
