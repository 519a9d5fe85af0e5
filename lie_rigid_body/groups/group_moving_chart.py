"""The moving chart on any matrix Lie group, by the same steppers that serve rotations."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.chart_integrator import ChartIntegrator
from lie_rigid_body.groups.components import require_components
from lie_rigid_body.groups.group_chart import GroupChart
from lie_rigid_body.groups.group_state import GroupState
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.stepper import RungeKuttaStepper
from lie_rigid_body.motion.motion import nanoseconds
from lie_rigid_body.motion.moving_chart import DEFAULT_MAX_STEP, require_stepper
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT

GROUP_METHODS: Final = {tableau.name: RungeKuttaStepper(tableau) for tableau in (EULER, MIDPOINT, CLASSICAL)}
"""The steppers that serve every group, by their public names."""


class GroupMovingChart:
    """The motion of a Lagrangian on a matrix Lie group, integrated from its start.

    Ȧ = A ωᵃTᵃ, Mᵃᵇω̇ᵇ = fᵃᵈᶜMᵈᵇωᵇωᶜ (A. Lucas, arXiv 1111.1275); on SO(n) the free rigid body. Near the centre of each
    chart A = A₀ exp(βᵃTᵃ).

    The Moser–Veselov steps of `MovingChart` are not offered here. Their explicit momentum step is an addition theorem
    of elliptic functions, and their inertia can be preprocessed because two invariants fix the orbit: both are
    particular to three dimensions. On SO(n) the algorithm asks for a Riccati equation at each step and is of order 2.

    Parameters
    ----------
    lagrangian : Lagrangian
        The group and its metric M.
    start : GroupState
        Of one instant, shapes (n, n) and (d,). On a group from generators the element may be any matrix that nothing
        rules out; see `MatrixLieGroup.from_generators`.
    method : str, optional
        Stepper: ``rkmk1``, ``rkmk2`` or ``rkmk4`` (default).
    max_step : float, optional
        Largest step, s.

    Raises
    ------
    InputError
        If the start is not on the group, or of other shapes.
    ParameterError
        If the method is unknown or the step not positive and finite.
    """

    def __init__(
        self,
        lagrangian: Lagrangian,
        start: GroupState,
        *,
        method: str = CLASSICAL.name,
        max_step: float = DEFAULT_MAX_STEP,
    ) -> None:
        require_stepper(method, max_step, GROUP_METHODS)
        element, rate = _require_start(lagrangian.group, start)
        self._lagrangian = lagrangian
        self._integrator: ChartIntegrator[NDArray[Any]] = ChartIntegrator(
            GROUP_METHODS[method], GroupChart(lagrangian), element, lagrangian.momenta(rate).tolist(), max_step
        )

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
            If a time is not an integer or lies before one already reached, or the body turns by more than π in a step.
        """
        times = nanoseconds(t_ns)
        flat = np.atleast_1d(times).tolist()
        group = self._lagrangian.group
        n, d = group.size, group.dimension
        elements, momenta = np.empty((len(flat), n, n), group.generators.dtype), np.empty((len(flat), d))
        for i, (element, momentum) in enumerate(self._integrator.through(flat)):
            elements[i], momenta[i] = element, momentum
        rates = self._lagrangian.rates(momenta)
        return GroupState(elements, rates) if times.ndim else GroupState(elements[0], rates[0])


def _require_start(group: MatrixLieGroup, start: GroupState) -> tuple[NDArray[Any], NDArray[np.float64]]:
    rate = require_components(group, start.rate, "rates")
    element = np.asarray(start.element)
    if element.shape != (group.size, group.size) or rate.shape != (group.dimension,):
        raise InputError(
            f"start has shapes {element.shape} and {rate.shape}: give ({group.size}, {group.size}) and "
            f"({group.dimension},) for {group.name}"
        )
    try:
        element = group.as_elements(element)
    except InputError as error:
        raise InputError(f"the start is not an element of {group.name}: {error}") from None
    if not np.isfinite(rate).all():
        raise InputError(f"rate {rate.tolist()} is not finite: give finite numbers in 1/s")
    return element, rate
