"""The principal frame of a motion in decimals, and the two questions about it that only exact arithmetic answers.

Is the rotation steady, and on which side of the separatrix is it? Doubles are decimals of finitely many digits, and so
are their sums and products, which are exact where the precision has no limit.

A moment wrong by 1e-16 turns the body by 1e-9 rad in 1e7 s at 1 rad/s, so the moments are needed to more digits than
doubles have.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import MAX_PREC, Decimal
from typing import Final

from lie_rigid_body.arithmetic.decimals import PrincipalAxes, Tensor, Vector, diagonalised, dot, working_precision
from lie_rigid_body.foundation.short_dataclass import short_dataclass

DIAGONAL_DIGITS: Final = 50
"""Decimal digits where the inertia is diagonal: no sum cancels, and time multiplies some rates by 1e10 rad."""

COUPLED_DIGITS: Final = 80
"""Decimal digits with products of inertia, where moments may differ by round-off only."""

PHASE_DIGITS: Final = 24
"""Decimal digits of what is rounded to a double in the end, and is no rate that time multiplies."""


def digits_for(inertia: Tensor) -> int:
    """Decimal digits in which the moments of an inertia are told apart.

    A product of inertia of relative size ε splits equal moments by as little as ε², and the splitting is needed to the
    full precision.
    """
    sizes = [Decimal.from_float(entry).adjusted() for row in inertia for entry in row if entry != 0.0]
    return (DIAGONAL_DIGITS if len(sizes) == 3 else COUPLED_DIGITS) + 2 * (max(sizes) - min(sizes))


def is_steady(inertia: Tensor, rate: Sequence[float]) -> bool:
    """Whether ω × Mω is exactly zero, so that the body turns about a fixed axis for ever.

    Parameters
    ----------
    inertia : 3 rows of 3
        M, body frame.
    rate : 3 numbers
        ω, body frame.
    """
    with working_precision(MAX_PREC):
        omega = [Decimal(component) for component in rate]
        momentum = [dot([Decimal(entry) for entry in row], omega) for row in inertia]
        return not any(cross(omega, momentum))


def separatrix_determinant(inertia: Tensor, rate: Sequence[float]) -> Decimal:
    """The determinant det(2H·M − l²·1), with 2H = ω·Mω and l = |Mω|, rounded once.

    With principal moments I₁ ≤ I₂ ≤ I₃ it is (2H I₁ − l²)(2H I₂ − l²)(2H I₃ − l²). For a rotation that is not steady
    its first factor is negative and its last positive, so it has the sign of l² − 2H I₂. It is positive when the
    momentum circulates about axis 3, negative when about axis 1, and zero exactly on the separatrix.
    """
    with working_precision(MAX_PREC):
        omega = [Decimal(component) for component in rate]
        rows = [[Decimal(entry) for entry in row] for row in inertia]
        momentum = [dot(row, omega) for row in rows]
        energy = dot(omega, momentum)
        square = dot(momentum, momentum)
        first, *others = (
            [energy * x - (square if i == j else 0) for j, x in enumerate(row)] for i, row in enumerate(rows)
        )
        determinant = dot(first, cross(*others))
    return +determinant


def cross(a: Sequence[Decimal], b: Sequence[Decimal]) -> Vector:
    """The vector product in the precision in force."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def principal_axes(inertia: Tensor, digits: int) -> PrincipalAxes:
    """The principal axes of an inertia in ascending order of the moments, kg m², to a number of decimal digits."""
    moments, axes = diagonalised(inertia, digits)
    i, j, k = sorted(range(3), key=moments.__getitem__)
    return (moments[i], moments[j], moments[k]), (axes[i], axes[j], axes[k])


@short_dataclass
class PrincipalFrame:
    """A right-handed frame of principal axes, in which the momentum circulates about the positive third axis.

    Attributes
    ----------
    moments : tuple of 3 Decimal
        J₁, J₂, J₃, kg m²: ascending when the momentum circulates about the axis of the largest moment, descending when
        about that of the smallest.
    axes : tuple of 3 vectors
        Unit axes in the body frame.
    rate : tuple of 3 Decimal
        The initial ω in this frame, rad/s, with ω₁ ≥ 0 and ω₃ > 0.
    sense : int
        +1 when the moments ascend, −1 when they descend: the sense in which the momentum circulates.
    """

    moments: Vector
    axes: tuple[Vector, Vector, Vector]
    rate: Vector
    sense: int

    @classmethod
    def of(cls, principal: PrincipalAxes, body_rate: Vector, *, about_largest: bool) -> PrincipalFrame:
        """The frame of a motion that starts with this ω (body frame, rad/s) and is not steady."""
        moments, axes = principal
        if not about_largest:
            moments = moments[::-1]
            axes = axes[::-1]
        first = _along(axes[0], body_rate)
        third = _along(axes[2], body_rate)
        axes = (first, cross(third, first), third)
        x, y, z = (dot(axis, body_rate) for axis in axes)
        return cls(moments, axes, (x, y, z), 1 if about_largest else -1)


def _along(axis: Vector, direction: Vector) -> Vector:
    """The axis or its opposite, whichever makes no obtuse angle with a direction."""
    x, y, z = axis
    return (-x, -y, -z) if dot(axis, direction) < 0 else axis
