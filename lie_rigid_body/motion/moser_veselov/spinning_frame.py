"""The frame and the units in which a torque-free motion is stepped.

Axes are the principal ones, the one of the intermediate moment second, in a cyclic order of the body's own, so that
the frame is right-handed and a body given by its principal moments needs no arithmetic to change frames. The unit of
momentum is that of the motion and the unit of time the inverse of its largest body rate, so that every number is of
order 1 whatever the body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

from lie_rigid_body.arithmetic.decimals import Vector, dot
from lie_rigid_body.arithmetic.symmetric_eigenproblem import diagonalised
from lie_rigid_body.mechanics import RigidBody, State

DIGITS: Final = 60
"""Decimal digits carried."""


@dataclass(frozen=True)
class PrincipalAxes:
    """The principal axes of a body, that of the intermediate moment second, in a cyclic order of the body's own.

    Attributes
    ----------
    tensor : 3 rows of 3 Decimal
        The inertia in the body frame, kg m².
    moments : tuple of 3 Decimal
        kg m²
    axes : 3 vectors
        Of unit length, in the body frame, right-handed.
    diagonal : bool
        Whether the axes are the body's own.
    """

    tensor: list[Vector]
    moments: Vector
    axes: tuple[Vector, Vector, Vector]
    diagonal: bool

    @classmethod
    def of(cls, inertia: Sequence[Sequence[float]]) -> PrincipalAxes:
        """Those of an inertia tensor, in the decimal precision in force."""
        tensor = [(Decimal(x), Decimal(y), Decimal(z)) for x, y, z in inertia]
        moments, axes = diagonalised(inertia)
        middle = sorted(range(3), key=moments.__getitem__)[1]
        i, j, k = (middle - 1) % 3, middle, (middle + 1) % 3
        diagonal = all(tensor[p][q] == 0 for p, q in ((0, 1), (0, 2), (1, 2)))
        return cls(tensor, (moments[i], moments[j], moments[k]), (axes[i], axes[j], axes[k]), diagonal)


@dataclass(frozen=True)
class SpinningFrame:
    """Constants of a motion in its own frame and units.

    Attributes
    ----------
    inverse_moments : tuple of 3 Decimal
        e₁, e₂, e₃: body rates per momentum.
    momentum : tuple of 3 Decimal
        The unit vector n of the initial body momentum, in this frame.
    twice_energy : Decimal
        2H = Σ eⱼnⱼ².
    m1, m3 : Decimal
        Squares of n₁ and n₃ where n₂ = 0, which every motion passes, or comes arbitrarily near to.
    fastest : Decimal
        The largest body rate, rad/s: the unit of rates.
    """

    inverse_moments: Vector
    momentum: Vector
    twice_energy: Decimal
    m1: Decimal
    m3: Decimal
    fastest: Decimal

    @classmethod
    def of(cls, body: RigidBody, start: State) -> SpinningFrame:
        """The frame of a motion, in the decimal precision in force."""
        return cls.about(PrincipalAxes.of(body.inertia.tolist()), start.body_rate.tolist())

    @classmethod
    def about(cls, principal: PrincipalAxes, body_rate: Sequence[float]) -> SpinningFrame:
        """The frame of a motion of a body whose axes are known."""
        rate = [Decimal(component) for component in body_rate]
        total = [dot(row, rate) for row in principal.tensor]
        size = dot(total, total).sqrt()
        if size == 0:
            return cls._scaled(principal, (Decimal(0), Decimal(0), Decimal(1)), size)
        a, b, c = (dot(axis, total) / size for axis in principal.axes)
        return cls._scaled(principal, (a, b, c), size)

    @classmethod
    def _scaled(cls, principal: PrincipalAxes, momentum: Vector, size: Decimal) -> SpinningFrame:
        e1, e2, e3 = (1 / moment for moment in principal.moments)
        a, b, c = (component * component for component in momentum)
        if e1 == e3:  # a sphere: every direction will do
            m1, m3 = a, b + c
        else:
            # (2H − e₃)/(e₁ − e₃) and (e₁ − 2H)/(e₁ − e₃), where nothing cancels
            m1 = a + b * (e2 - e3) / (e1 - e3)
            m3 = c + b * (e1 - e2) / (e1 - e3)
        fastest = (e1 * e1 * m1 + e3 * e3 * m3).sqrt()
        scaled = (e1 / fastest, e2 / fastest, e3 / fastest)
        energy = scaled[0] * m1 + scaled[2] * m3
        return cls(scaled, momentum, energy, m1, m3, size * fastest)
