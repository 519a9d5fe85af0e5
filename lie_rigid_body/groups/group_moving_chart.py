"""Runge–Kutta–Munthe-Kaas integration of free motion on a matrix Lie group (the moving chart).

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array, require_finite, shaped
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import call_repr, shown
from lie_rigid_body.groups.arguments import of_kind
from lie_rigid_body.groups.exponential import Matrix, phi_inverse
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.motion.motion import nanoseconds
from lie_rigid_body.motion.moving_chart import DEFAULT_STEP, require_stepper
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT, ChainTableau
from lie_rigid_body.motion.time_steps import require_order, steps_through

GROUP_METHODS: Final = {tableau.name: tableau for tableau in (EULER, MIDPOINT, CLASSICAL)}
"""The Runge–Kutta methods of every group, by the public names of their steppers."""

STEPS_BETWEEN_PROJECTIONS: Final = 100
"""Steps between two projections onto the group; between them only round-off moves the element off it."""

MAX_CHART_ROTATION: Final = math.pi
"""Largest turn of a step, rad, as eigenvalue of ad_β: half of the turn at which dexp(β) becomes singular."""


@short_dataclass(eq=False)
class GroupState:
    """A group element and the rate in its own frame, of one instant or of many.

    Parameters
    ----------
    element : ndarray, shape (..., n, n)
        A, real or complex.
    rate : ndarray, shape (..., d)
        Coordinates ω of A⁻¹Ȧ = ωᵃTᵃ, 1/s.
    """

    element: Matrix
    rate: Array


class _Reached(NamedTuple):
    """Time, ns, and number of steps since the start, with the element and the momentum there."""

    time_ns: int
    steps: int
    element: Matrix
    momentum: Array


class GroupMovingChart:
    """The motion of a Lagrangian on a matrix Lie group, integrated from its start.

    It solves Ȧ = A ωᵃTᵃ and ṗᵃ = f[c,a,d] ωᶜ p_d with p = Mω, which for totally antisymmetric structure constants is
    Mᵃᵇω̇ᵇ = fᵃᵈᶜMᵈᵇωᵇωᶜ, eq. (21) of A. Lucas, arXiv 1111.1275; on SO(n) it is the motion of the free rigid body. Near
    the centre A₀ of each chart A = A₀ exp(βᵃTᵃ).

    The Moser–Veselov steps of `MovingChart` are not offered here. Their explicit momentum step is an addition theorem
    of elliptic functions, and their inertia can be preprocessed because two invariants fix the orbit: both are
    particular to three dimensions. On SO(n) the algorithm needs a Riccati equation at each step and is of order 2.

    Parameters
    ----------
    lagrangian : Lagrangian
        The group and its metric M.
    start : GroupState
        Of one instant, shapes (n, n) and (d,). On a group from generators the element may be any matrix that passes
        the checks listed in `MatrixLieGroup.from_generators`.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2`` or ``rkmk4`` (default).
    max_step : float, optional
        Largest step, s. Between two requested times the steps are equal and no longer than this. 0: 1 ms.

    Raises
    ------
    InputError
        If the start is not on the group, or of other shapes.
    ParameterError
        If the method is unknown, or the step negative or not finite.
    """

    def __init__(
        self,
        lagrangian: Lagrangian,
        start: GroupState,
        *,
        method: str = CLASSICAL.name,
        max_step: float = DEFAULT_STEP,
    ) -> None:
        require_stepper(method, max_step, GROUP_METHODS)
        element, rate = _require_start(of_kind(lagrangian, Lagrangian).group, start)
        self._reached = _Reached(0, 0, element, lagrangian.momenta(rate))
        self._lagrangian = lagrangian
        self._tableau = GROUP_METHODS[method]
        self._max_step = float(max_step) or DEFAULT_STEP

    def __repr__(self) -> str:
        stepper = {"method": self._tableau.name, "max_step": self._max_step}
        return call_repr(self, {"lagrangian": self._lagrangian, **stepper, "reached_ns": self._reached.time_ns})

    def at(self, t_ns: ArrayLike) -> GroupState:
        """The states at the given times.

        Parameters
        ----------
        t_ns : int or array_like of int, shape (N,)
            Nanoseconds since the start; may not decrease, within a call or from call to call.

        Returns
        -------
        GroupState
            Shapes (n, n) and (d,) for one time, (N, n, n) and (N, d) for an array.

        Raises
        ------
        InputError
            If a time is not an integer, or lies before one already reached or impossibly many steps ahead. Nothing is
            integrated then. It is raised as well if the body turns by more than π in a step.
        """
        times = nanoseconds(t_ns)
        begin = self._reached.time_ns
        require_order(np.atleast_1d(times), begin)
        steps_through(int(times.max(initial=begin)), begin, self._max_step)
        flat = np.atleast_1d(times).tolist()
        group = self._lagrangian.group
        n = group.size
        d = group.dimension
        elements = np.empty((len(flat), n, n), group.generators.dtype)
        momenta = np.empty((len(flat), d))
        for i, t in enumerate(flat):
            self._reached = reached = self._advanced(t)  # at once, as a signal may raise an exception anywhere
            elements[i], momenta[i] = reached.element, reached.momentum
        rates = self._lagrangian.rates(momenta)
        return GroupState(elements, rates) if times.ndim else GroupState(elements[0], rates[0])

    def _advanced(self, t_ns: int) -> _Reached:
        time_ns, done, element, momentum = self._reached
        span = 1e-9 * (t_ns - time_ns)
        steps = max(math.ceil(span / self._max_step - 1e-9), int(span > 0.0))
        for count in range(done + 1, done + steps + 1):
            coordinates, momentum = self._end(momentum, span / steps).reshape(2, -1)
            # the element just reached becomes the centre of the next chart
            element = recentred(self._lagrangian.group, element, coordinates)
            if count % STEPS_BETWEEN_PROJECTIONS == 0:
                element = self._lagrangian.group.restored(element)
        return _Reached(t_ns, done + steps, element, momentum)

    def _end(self, momentum: Array, h: float) -> Array:
        """Coordinates and momentum at the end of a step from coordinates 0, shape (2d,)."""
        centre = np.concatenate([np.zeros_like(momentum), momentum])
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                end = runge_kutta_step(self._tableau, partial(chart_rates, self._lagrangian), centre, h)
            require_finite("state", end)
        except (ParameterError, np.linalg.LinAlgError):
            raise InputError(f"a step of {h:g} s leads beyond double precision: lower max_step") from None
        return end


def runge_kutta_step(tableau: ChainTableau, field: Callable[[Array], Array], start: Array, h: float) -> Array:
    """The point after one explicit Runge–Kutta step along a vector field.

    Parameters
    ----------
    tableau : ChainTableau
    field : callable, (m,) ↦ (m,)
        Rate of change of a point.
    start : ndarray, shape (m,)
    h : float
        Step, s.

    Returns
    -------
    ndarray, shape (m,)
    """
    slopes = np.zeros((len(tableau.b), len(start)))
    for stage, weight in enumerate(tableau.a):
        slopes[stage] = field(start + h * (float(weight) * slopes[stage - 1]))
    return start + h * (np.array(tableau.b, dtype=np.float64) @ slopes)


def chart_rates(lagrangian: Lagrangian, point: Array) -> Array:
    """The rates of a point of the chart: β̇ = dexp⁻¹(−β) ω and ṗ = ad*_ω p (Euler–Poincaré), with ω = M⁻¹p.

    In the coordinates of the space frame the chart is exp(αᵃTᵃ) A₀ with α = Ad(A₀)β, as in eq. (11).

    Parameters
    ----------
    lagrangian : Lagrangian
        The group, of dimension d, and its metric M.
    point : ndarray, shape (2d,)
        The coordinates β, followed by the body momentum p = Mω of the motion.

    Returns
    -------
    ndarray, shape (2d,)
    """
    coordinates, momentum = point.reshape(2, -1)
    rate = lagrangian.inverse_metric @ momentum
    ad = lagrangian.group.ad(coordinates)
    _require_reach(ad)
    return np.concatenate([phi_inverse(-ad) @ rate, momentum @ lagrangian.group.ad(rate)])


def recentred(group: MatrixLieGroup, centre: Matrix, coordinates: Array) -> Matrix:
    """The element A₀ exp(βᵃTᵃ), the centre of the next chart.

    It is refused beyond the chart's end here as well, since the only stage of `rkmk1` is evaluated at β = 0.
    """
    _require_reach(group.ad(coordinates))
    return np.asarray(centre @ group.exp(coordinates))


def _require_reach(ad: Array) -> None:
    """Refuse eigenvalues of ad_β beyond `MAX_CHART_ROTATION`; translations have none but 0."""
    if (np.abs(ad).max()) * len(ad) < MAX_CHART_ROTATION:
        return  # a bound of every eigenvalue
    turn = np.abs(np.linalg.eigvals(ad)).max()
    if not turn <= MAX_CHART_ROTATION:
        raise InputError(
            f"within a step the chart turns by {turn:.3g} rad (limit {MAX_CHART_ROTATION:.3g} rad): lower max_step"
        )


def _require_start(group: MatrixLieGroup, start: GroupState) -> tuple[Matrix, Array]:
    if not isinstance(start, GroupState):
        raise InputError(f"start: {shown(start)} is no state: give GroupState(element, rate)")
    rate = real_array("rates", start.rate, (group.dimension,))
    return group.as_elements(shaped("element", start.element, (group.size,) * 2, group.generators.dtype)), rate
