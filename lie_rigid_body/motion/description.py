"""Time-independent properties of a motion: regime, period, precession, flips, stability of spins, conserved momenta.

They are found without computing a state; ``explain`` prints them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal
from typing import Final, Literal, TypeAlias, cast

import numpy as np

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.top import (
    KindOfTop,
    SpinStability,
    SymmetricTop,
    conserved_body_axes,
    equal_moments,
    is_flat,
    kind_of_top,
)
from lie_rigid_body.motion.closed_form.constants import Periods, Polhode, frame_and_polhode, precession_rate
from lie_rigid_body.motion.closed_form.frame import PrincipalFrame, digits_for, is_steady
from lie_rigid_body.motion.motion import exact_inertia, require_one

Vector: TypeAlias = tuple[float, float, float]
Regime: TypeAlias = Literal["rest", "steady", "about_largest", "about_smallest", "separatrix"]

SUDDEN_RAD: Final = math.pi / 6.0
"""Largest angle between the momentum and the intermediate axis at which flips count as sudden, rad: nearer than this,
the body seems to spin steadily between flips."""
LINGERING: Final = 0.01
"""Largest 1 − m at which flips count as sudden. Below it, the momentum lingers near the intermediate axis for most of
the time, while that of a nearly symmetric top circles evenly."""


@short_dataclass
class Flips:
    """When the body rate along the intermediate axis changes its sign, so that this axis turns over.

    Attributes
    ----------
    interval_s : float
        Time between flips, half a period, s; infinite on the separatrix.
    first_s : float
        Time of the first flip, s; infinite if none comes.
    nearest_angle_rad : float
        Smallest angle between the momentum and the intermediate axis between flips: near 0, the body spins about it
        for a while, and turns over suddenly.
    sudden : bool
        Whether that is nearer than ``SUDDEN_RAD``, and 1 − m below ``LINGERING``: Dzhanibekov's effect.
    """

    interval_s: float
    first_s: float
    nearest_angle_rad: float
    sudden: bool


@short_dataclass
class Circulation:
    """How a motion that is not steady circulates about a principal axis.

    Attributes
    ----------
    axis : tuple of 3 float
        Unit vector in the body frame, at an acute angle with the momentum: the principal axis which the body rate
        circles. On the separatrix, where the body rate tends to the intermediate axis, that of the largest moment.
    separatrix_distance : float
        1 − m, the complementary parameter of the elliptic functions: 0 on the separatrix, 1 for a symmetric top and
        for small wobbles about the axis.
    period_s : float
        Period of the body rate, s; infinite on the separatrix.
    precession_rate_rad_s : float
        Mean rate at which the axis circles the momentum; positive.
    advance_per_period_rad : float
        The angle about the momentum by which the attitude after one period differs from that before, counted with
        the axis' whole turns; infinite on the separatrix.
    tilt_min_rad, tilt_max_rad : float
        Smallest and largest angle between the momentum and the axis.
    flips : Flips or None
        None if two moments are equal.
    """

    axis: Vector
    separatrix_distance: float
    period_s: float
    precession_rate_rad_s: float
    advance_per_period_rad: float
    tilt_min_rad: float
    tilt_max_rad: float
    flips: Flips | None


def _constants(body: RigidBody, start: State) -> tuple[Regime, Circulation | None]:
    """The regime of a motion from a start of one instant, and its circulation unless it is steady."""
    inertia = exact_inertia(body)
    rate = start.body_rate.tolist()
    with working_precision(digits_for(inertia)):
        if is_steady(inertia, rate):
            return "steady" if any(rate) else "rest", None
        frame, polhode = frame_and_polhode(inertia, rate)
        regime: Regime = "about_largest" if frame.sense > 0 else "about_smallest"
        return regime if polhode.m1 else "separatrix", _circulation(frame, polhode)


def _circulation(frame: PrincipalFrame, polhode: Polhode) -> Circulation:
    periods = Periods.of(polhode)
    period = 4 * periods.real / polhode.argument_rate
    precession = precession_rate(frame, polhode)
    n1, n2, n3 = (j * a for j, a in zip(frame.moments, polhode.amplitudes, strict=True))
    # u = 0 and u = K
    tilts = sorted((_angle(n1, n3), _angle(n2, n3 * polhode.m1.sqrt())))
    x, y, z = frame.axes[2]
    return Circulation(
        axis=(float(x), float(y), float(z)),
        separatrix_distance=float(polhode.m1),
        period_s=float(period),
        precession_rate_rad_s=float(precession),
        advance_per_period_rad=float(precession * period),
        tilt_min_rad=tilts[0],
        tilt_max_rad=tilts[1],
        flips=_flips(polhode, periods, _angle(n3 * polhode.m1.sqrt(), n2)) if polhode.m else None,
    )


def _flips(polhode: Polhode, periods: Periods, nearest_angle: float) -> Flips:
    """The zeros of sn u, at the multiples of 2K."""
    start = polhode.start
    interval = 2 * periods.real
    first = -start if start < 0 else interval - start
    return Flips(
        interval_s=float(interval / polhode.argument_rate),
        first_s=float(first / polhode.argument_rate),
        nearest_angle_rad=nearest_angle,
        sudden=nearest_angle < SUDDEN_RAD and polhode.m1 < LINGERING,
    )


def _angle(across: Decimal, along: Decimal) -> float:
    """The angle in [0, ½π] from these components, whatever their size."""
    size = max(across, along)
    return math.atan2(float(across / size), float(along / size))


@short_dataclass
class PrincipalAxis:
    """One principal axis: its moment, its direction in the body frame, and the stability of a spin about it.

    The spin is the one that the motion's momentum would give; 1 rad/s for a body at rest.
    """

    moment_kg_m2: float
    direction: Vector
    spin: SpinStability


@short_dataclass
class FixedAxisRotation:
    """A rotation about a fixed axis.

    Attributes
    ----------
    axis : tuple of 3 float
        Unit vector along the body rate, body frame.
    principal : tuple of int
        The indices of the principal axes whose moment the body has about it: more than one where moments are equal.
    turn_s : float
        The time of one turn.
    """

    axis: Vector
    principal: tuple[int, ...]
    turn_s: float


@short_dataclass
class BodyMomentum:
    """A component of the body momentum Mω that stays constant, along a direction of the body frame."""

    direction: Vector
    momentum_kg_m2_s: float


@short_dataclass
class Description:
    """Everything about a body and its motion that does not depend on time.

    Attributes
    ----------
    kind : str
        ``asymmetric``, ``oblate``, ``prolate`` or ``spherical``.
    flat : bool
        Whether all mass lies in one plane.
    axes : tuple of 3 PrincipalAxis
        In ascending order of the moments.
    kinetic_energy_j, angular_momentum_kg_m2_s : float
        H and l = |Mω|; infinite where too large for a double.
    world_momentum_kg_m2_s : tuple of 3 float
        A M ω.
    regime : str
        ``rest``, ``steady``, ``about_largest``, ``about_smallest`` (the axis that the momentum circles in the body)
        or ``separatrix`` (exactly between these two).
    steady : FixedAxisRotation or None
        In the regime ``steady`` only.
    circulation : Circulation or None
        In the last three regimes; its flips are those of an asymmetric top only.
    symmetric_top : SymmetricTop or None
        For an oblate or a prolate top.
    conserved_body_momenta : tuple of BodyMomentum
        Empty for an asymmetric top, one for a symmetric one, three for a sphere.
    """

    kind: KindOfTop
    flat: bool
    axes: tuple[PrincipalAxis, PrincipalAxis, PrincipalAxis]
    kinetic_energy_j: float
    angular_momentum_kg_m2_s: float
    world_momentum_kg_m2_s: Vector
    regime: Regime
    steady: FixedAxisRotation | None
    circulation: Circulation | None
    symmetric_top: SymmetricTop | None
    conserved_body_momenta: tuple[BodyMomentum, ...]

    @property
    def period(self) -> float | None:
        """Period of the body rate, s; infinite on the separatrix, None where the rate is constant."""
        return self.circulation.period_s if self.circulation else None

    @property
    def precession_rate(self) -> float | None:
        """Mean rate, rad/s, at which the axis that the momentum circles goes round the momentum; None without one."""
        return self.circulation.precession_rate_rad_s if self.circulation else None

    @property
    def flip_interval(self) -> float | None:
        """Time between two flips of the intermediate axis, s; infinite on the separatrix, None where it never flips."""
        flips = self.circulation and self.circulation.flips
        return flips.interval_s if flips else None


def describe(body: RigidBody, start: State) -> Description:
    """The description of the motion of a body from a start of one instant.

    Parameters
    ----------
    body : RigidBody
    start : State

    Raises
    ------
    InputError
        If one is no such, or the start of many instants.
    """
    require_one(body, start)
    kind = kind_of_top(body)
    regime, circulation = _constants(body, start)
    if circulation is not None and kind != "asymmetric":
        circulation = replace(circulation, flips=None)
    first, second, third = (_principal_axis(body, start, i) for i in range(3))
    with np.errstate(over="ignore"):
        energy = float(body.kinetic_energy(start))
    return Description(
        kind=kind,
        flat=is_flat(body),
        axes=(first, second, third),
        kinetic_energy_j=energy,
        angular_momentum_kg_m2_s=math.hypot(*body.body_momentum(start)),
        world_momentum_kg_m2_s=_vector(body.angular_momentum(start)),
        regime=regime,
        steady=_steady_rotation(body, start) if regime == "steady" else None,
        circulation=circulation,
        symmetric_top=SymmetricTop.of(body, start),
        conserved_body_momenta=tuple(
            BodyMomentum(_vector(axis), float(axis @ body.body_momentum(start))) for axis in conserved_body_axes(body)
        ),
    )


def _principal_axis(body: RigidBody, start: State, index: int) -> PrincipalAxis:
    moments = body.principal_moments.tolist()
    # l/I, also where l itself is too small for a double
    spin = math.hypot(*(body.inertia / moments[index] @ start.body_rate)) if start.body_rate.any() else 1.0
    stability = SpinStability.of(moments, index, spin)
    return PrincipalAxis(moments[index], _vector(body.principal_axes[:, index]), stability)


def _steady_rotation(body: RigidBody, start: State) -> FixedAxisRotation:
    speed = math.hypot(*start.body_rate)
    axis = start.body_rate / speed
    moments = body.principal_moments
    own = float(moments[np.argmin(np.abs(moments - math.hypot(*(body.inertia @ axis))))])
    principal = tuple(i for i in range(3) if equal_moments((moments[i]), own))
    return FixedAxisRotation(_vector(axis), principal, 2.0 * math.pi / speed)


def _vector(array: Array) -> Vector:
    # + 0.0 makes −0 a plain 0
    return cast(Vector, tuple((array + 0.0).tolist()))
