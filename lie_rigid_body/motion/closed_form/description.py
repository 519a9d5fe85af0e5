"""What the mathematics says about a body and its motion, in numbers, before a single state is computed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.top import (
    Kind,
    SpinStability,
    SymmetricTop,
    conserved_body_axes,
    equal_moments,
    is_flat,
    kind_of_top,
)
from lie_rigid_body.motion.closed_form.constants import Circulation, MotionConstants, Regime

Array = NDArray[np.float64]
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class PrincipalAxis:
    """One principal axis: its moment, its direction in the body frame, and the stability of a spin about it.

    The spin is the one that the motion's momentum would give; 1 rad/s for a body at rest.
    """

    moment_kg_m2: float
    direction: Vector
    spin: SpinStability


@dataclass(frozen=True)
class SteadyRotation:
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


@dataclass(frozen=True)
class BodyMomentum:
    """A component of the body momentum Mω that stays constant, along a direction of the body frame."""

    direction: Vector
    momentum_kg_m2_s: float


@dataclass(frozen=True)
class Description:
    """Everything about a motion that needs no clock.

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
    steady : SteadyRotation or None
        In the regime ``steady`` only.
    circulation : Circulation or None
        In the last three regimes; its flips are those of an asymmetric top only.
    symmetric_top : SymmetricTop or None
        For an oblate or a prolate top.
    conserved_body_momenta : tuple of BodyMomentum
        None for an asymmetric top, one for a symmetric one, three for a sphere.
    """

    kind: Kind
    flat: bool
    axes: tuple[PrincipalAxis, PrincipalAxis, PrincipalAxis]
    kinetic_energy_j: float
    angular_momentum_kg_m2_s: float
    world_momentum_kg_m2_s: Vector
    regime: Regime
    steady: SteadyRotation | None
    circulation: Circulation | None
    symmetric_top: SymmetricTop | None
    conserved_body_momenta: tuple[BodyMomentum, ...]


def describe(body: RigidBody, start: State) -> Description:
    """The description of the motion of a body from a start of one instant: shapes (4,) and (3,)."""
    kind, constants = kind_of_top(body), MotionConstants.of(body, start)
    circulation = constants.circulation
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
        regime=constants.regime,
        steady=_steady_rotation(body, start) if constants.regime == "steady" else None,
        circulation=circulation,
        symmetric_top=SymmetricTop.of(body, start),
        conserved_body_momenta=tuple(
            BodyMomentum(_vector(axis), float(axis @ body.body_momentum(start))) for axis in conserved_body_axes(body)
        ),
    )


def _principal_axis(body: RigidBody, start: State, index: int) -> PrincipalAxis:
    moments = [float(moment) for moment in body.principal_moments]
    # l/I, also where l itself is too small for a double
    spin = math.hypot(*(body.inertia / moments[index] @ start.body_rate)) if start.body_rate.any() else 1.0
    stability = SpinStability.of(moments, index, spin)
    return PrincipalAxis(moments[index], _vector(body.principal_axes[:, index]), stability)


def _steady_rotation(body: RigidBody, start: State) -> SteadyRotation:
    speed = math.hypot(*start.body_rate)
    axis = start.body_rate / speed
    moments = body.principal_moments
    own = float(moments[np.argmin(np.abs(moments - math.hypot(*(body.inertia @ axis))))])
    principal = tuple(i for i in range(3) if equal_moments(float(moments[i]), own))
    return SteadyRotation(_vector(axis), principal, 2.0 * math.pi / speed)


def _vector(array: Array) -> Vector:
    # + 0.0 makes −0 a plain 0
    return cast(Vector, tuple(float(component) + 0.0 for component in array))
