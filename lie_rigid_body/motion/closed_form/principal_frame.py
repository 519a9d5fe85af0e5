"""The principal frame in which the momentum circulates about the positive third axis."""

from __future__ import annotations

from dataclasses import dataclass

from lie_rigid_body.arithmetic.decimals import Vector, dot
from lie_rigid_body.motion.closed_form.principal_axes import PrincipalAxes


@dataclass(frozen=True)
class PrincipalFrame:
    """A right-handed frame of principal axes, chosen for a motion.

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
            moments, axes = (moments[2], moments[1], moments[0]), (axes[2], axes[1], axes[0])
        first, third = _along(axes[0], body_rate), _along(axes[2], body_rate)
        axes = (first, _cross(third, first), third)
        rate = (dot(axes[0], body_rate), dot(axes[1], body_rate), dot(axes[2], body_rate))
        return cls(moments, axes, rate, 1 if about_largest else -1)


def _along(axis: Vector, direction: Vector) -> Vector:
    """The axis or its opposite, whichever makes no obtuse angle with a direction."""
    x, y, z = axis
    return (-x, -y, -z) if dot(axis, direction) < 0 else axis


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
