"""The motion of a symmetric top in elementary functions: two uniform rotations."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lie_rigid_body.mechanics.rigid_body import RigidBody
from lie_rigid_body.mechanics.state import State
from lie_rigid_body.mechanics.top import symmetry_axis


@dataclass(frozen=True)
class SymmetricTop:
    """Rates and cones of a free symmetric top of moments I, I and J about its axis (L. D. Landau, E. M. Lifshitz,
    Mechanics, §33).

    Attributes
    ----------
    axial_rate_rad_s : float
        ω∥, the body rate along the axis of symmetry, of either sign: constant.
    transverse_rate_rad_s : float
        ω⊥, its size across the axis: constant.
    body_precession_rate_rad_s : float
        (J − I)/I ω∥: how fast body rate and momentum circle the axis, seen from the body.
    space_precession_rate_rad_s : float
        l/I: how fast axis and body rate circle the momentum, seen from the world.
    tilt_rad : float
        Angle between the axis and the momentum, in [0, ½π]: constant, there is no nutation.
    rate_to_axis_rad, rate_to_momentum_rad : float
        Half angles of the body cone and the space cone, which roll on each other along the body rate.
    """

    axial_rate_rad_s: float
    transverse_rate_rad_s: float
    body_precession_rate_rad_s: float
    space_precession_rate_rad_s: float
    tilt_rad: float
    rate_to_axis_rad: float
    rate_to_momentum_rad: float

    @classmethod
    def of(cls, body: RigidBody, start: State) -> SymmetricTop | None:
        """The rates of a motion from this start; none for a body of another kind."""
        axis = symmetry_axis(body)
        if axis is None:
            return None
        along, across = float(body.principal_moments[axis]), float(body.principal_moments[1])
        rates = [float(rate) for rate in start.body_rate @ body.principal_axes]
        axial = rates.pop(axis)
        transverse = math.hypot(*rates)
        tilt, body_cone = math.atan2(across * transverse, abs(along * axial)), math.atan2(transverse, abs(axial))
        return cls(
            axial_rate_rad_s=axial,
            transverse_rate_rad_s=transverse,
            body_precession_rate_rad_s=(along - across) / across * axial,
            space_precession_rate_rad_s=math.hypot(along * axial / across, transverse),
            tilt_rad=tilt,
            rate_to_axis_rad=body_cone,
            rate_to_momentum_rad=abs(body_cone - tilt),
        )
