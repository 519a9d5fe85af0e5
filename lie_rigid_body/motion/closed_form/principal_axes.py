"""Principal moments and axes to the decimal precision in force.

A moment wrong by 1e-16 turns the body by 1e-9 rad in 1e7 s at 1 rad/s, so the double-precision decomposition will not
do for the closed form.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Final, NamedTuple

from lie_rigid_body.arithmetic.decimals import Vector
from lie_rigid_body.arithmetic.symmetric_eigenproblem import diagonalised

DIGITS: Final = 50
"""Decimal digits carried where nothing asks for more: no sum cancels, and time multiplies some rates by 1e10 rad."""

COUPLED_DIGITS: Final = 80
"""Digits carried with products of inertia, where moments may differ by round-off."""

PHASE_DIGITS: Final = 24
"""Digits of what is rounded to a double in the end, or is no rate that time multiplies."""


class PrincipalAxes(NamedTuple):
    """Moments in ascending order, kg m², and their unit axes in the body frame (of either handedness)."""

    moments: Vector
    axes: tuple[Vector, Vector, Vector]


def digits_for(entries: list[float]) -> int:
    """Digits in which the moments of a tensor with these nine entries are told apart.

    A product of inertia of relative size ε splits equal moments by as little as ε², and the splitting is wanted to
    the full precision.
    """
    sizes = [Decimal(entry).adjusted() for entry in entries if entry != 0.0]
    return (DIGITS if len(sizes) == 3 else COUPLED_DIGITS) + 2 * (max(sizes) - min(sizes))


def principal_axes(inertia: list[list[float]]) -> PrincipalAxes:
    """The principal axes of an inertia, kg m², body frame, given as 3 rows of 3."""
    moments, axes = diagonalised(inertia)
    i, j, k = sorted(range(3), key=moments.__getitem__)
    return PrincipalAxes((moments[i], moments[j], moments[k]), (axes[i], axes[j], axes[k]))
