"""Tops: which kind a body is, how a symmetric one moves, and which of its spins are stable.

Equation numbers are those of A. Lucas, arXiv 1111.1275.

References
----------
L. D. Landau, E. M. Lifshitz, *Mechanics*, §33 for the symmetric top, §37 for the stability of a spin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics.inertia import MOMENT_ROUND_OFF
from lie_rigid_body.mechanics.rigid_body import RigidBody
from lie_rigid_body.mechanics.state import State

KindOfTop: TypeAlias = Literal["asymmetric", "oblate", "prolate", "spherical"]
Verdict: TypeAlias = Literal["stable", "unstable", "neutral"]


def equal_moments(one: float, other: float) -> bool:
    """Whether two principal moments are equal to within the rounding of a tensor's decomposition.

    A symmetric body whose axis is tilted in its frame has no exactly equal moments once its tensor is rounded.
    """
    return abs(one - other) <= MOMENT_ROUND_OFF * max(abs(one), abs(other))


def kind_of_top(body: RigidBody) -> KindOfTop:
    """The kind of a body: asymmetric, oblate (two equal moments below the third), prolate (two above) or spherical.

    It tells for how many axes eq. (30) holds.
    """
    small, middle, large = body.principal_moments.tolist()
    if equal_moments(small, large):
        return "spherical"
    if equal_moments(small, middle):
        return "oblate"
    return "prolate" if equal_moments(middle, large) else "asymmetric"


def is_flat(body: RigidBody) -> bool:
    """Whether a body is flat: its largest moment, about the normal of its plane, is the sum of the other two.

    By eq. (28a) and its permutations that is where no mass lies off a plane.
    """
    small, middle, large = body.principal_moments.tolist()
    return equal_moments(small + middle, large)


def symmetry_axis(body: RigidBody) -> int | None:
    """The index of the axis of symmetry among the principal axes: 0 if prolate, 2 if oblate, or None; eq. (30)."""
    return {"oblate": 2, "prolate": 0}.get(kind_of_top(body))


def conserved_body_axes(body: RigidBody) -> Array:
    """Directions in the body along which the body momentum Mω is constant in every motion.

    They are the axes about which a rotation of the body leaves M unchanged (Noether's theorem); eq. (30)
    has the case of one such axis. `groups.conserved_momenta` finds them on any group.

    Parameters
    ----------
    body : RigidBody

    Returns
    -------
    ndarray, shape (k, 3)
        Orthonormal rows, body frame: none for an asymmetric top, its axis for a symmetric one, three for a sphere.
    """
    kind = kind_of_top(body)
    axis = symmetry_axis(body)
    if kind == "spherical":
        return np.eye(3)
    return np.empty((0, 3)) if axis is None else body.principal_axes[:, [axis]].T.copy()


@short_dataclass
class SymmetricTop:
    """Free motion of a symmetric top with moments I, I across its axis and J along it: two uniform rotations.

    It is the solution of eq. (29) for two equal moments.

    Attributes
    ----------
    axial_rate_rad_s : float
        ω∥, the component of the body rate along the axis, of either sign: constant.
    transverse_rate_rad_s : float
        ω⊥, the size of the body rate's part across the axis: constant.
    body_precession_rate_rad_s : float
        (J − I)/I ω∥: how fast body rate and momentum circle the axis, seen from the body.
    space_precession_rate_rad_s : float
        l/I, with l the size of the momentum: how fast axis and body rate circle the momentum, seen from the world.
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
        """The rates and angles of the motion, eq. (29), from a start, or None for a body that is no symmetric top."""
        axis = symmetry_axis(body)
        if axis is None:
            return None
        along = float(body.principal_moments[axis])
        across = float(body.principal_moments[1])
        rates = (start.body_rate @ body.principal_axes).tolist()
        axial = rates.pop(axis)
        transverse = math.hypot(*rates)
        tilt = math.atan2(across * transverse, abs(along * axial))
        body_cone = math.atan2(transverse, abs(axial))
        return cls(
            axial_rate_rad_s=axial,
            transverse_rate_rad_s=transverse,
            body_precession_rate_rad_s=(along - across) / across * axial,
            space_precession_rate_rad_s=math.hypot(along * axial / across, transverse),
            tilt_rad=tilt,
            rate_to_axis_rad=body_cone,
            rate_to_momentum_rad=abs(body_cone - tilt),
        )


@short_dataclass
class SpinStability:
    """Stability of the steady spin about one principal axis, by eq. (29), under a small disturbance.

    Attributes
    ----------
    verdict : str
        ``stable``: the disturbance circles the axis; ``unstable``: it grows exponentially; ``neutral``: neither, since
        a moment equal to that of the axis makes the neighbouring spins steady as well.
    spin_rate_rad_s : float
        Spin for which the other rates hold; they are proportional to it.
    growth_rate_1_s : float
        λ of the growth exp(λt), 0 unless unstable.
    wobble_rate_rad_s : float
        Angular frequency, in the body, at which the disturbance circles the axis; 0 unless stable.
    """

    verdict: Verdict
    spin_rate_rad_s: float
    growth_rate_1_s: float
    wobble_rate_rad_s: float

    @classmethod
    def of(cls, moments: Sequence[float], axis: int, spin_rate: float) -> SpinStability:
        """The stability by Euler's equations, eq. (29), linearised about the spin Ω: δ″ = −Ω² (I−J)(I−K)/(JK) δ.

        Parameters
        ----------
        moments : sequence of 3 float
            kg m².
        axis : int
            Index of the axis of the spin, whose moment is I.
        spin_rate : float
            Ω, rad/s, not negative.
        """
        own = moments[axis]
        other, third = (moment for i, moment in enumerate(moments) if i != axis)
        if equal_moments(own, other) or equal_moments(own, third):
            return cls("neutral", spin_rate, 0.0, 0.0)
        square = (own / other - 1.0) * (own / third - 1.0)
        rate = spin_rate * math.sqrt(abs(square))
        return cls("unstable", spin_rate, rate, 0.0) if square < 0.0 else cls("stable", spin_rate, 0.0, rate)
