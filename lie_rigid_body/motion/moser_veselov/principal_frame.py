"""The principal frame in which a motion is stepped, and the motion in it, in units of its own.

Axes are the principal ones, that of the intermediate moment second, in a cyclic order of the body's own. So the frame
is right-handed, and a body given by its principal moments changes frames by a permutation, which costs no accuracy. The
unit of momentum is that of the motion, and the unit of time the inverse of its largest body rate. So every number is of
order 1 whatever the body.

All arithmetic but that of `CyclicFrame.outward` is decimal, in the precision in force.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.decimals import Tensor, Vector, diagonalised, dot
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.motion import Samples

DIGITS: Final = 60
"""Decimal digits that the constants of a motion are computed with."""


@short_dataclass
class CyclicFrame:
    """The principal axes of a body, that of the intermediate moment second, in a cyclic order of the body's own.

    Where these axes are the body's own in another order, those of the world are put into the same order.

    Attributes
    ----------
    tensor : 3 rows of 3 Decimal
        The inertia in the body frame, kg m².
    moments : tuple of 3 Decimal
        kg m²
    axes : 3 vectors
        Unit vectors in the body frame, right-handed.
    order : tuple of 3 int
        Which of the body's own axes these are, if the inertia has no products.
    rotation : list of 4 Decimal, or None
        The unit quaternion, scalar last, that takes vectors of this frame to the body's, if the inertia has products.
    """

    tensor: Sequence[Sequence[Decimal]]
    moments: Vector
    axes: tuple[Vector, Vector, Vector]
    order: tuple[int, int, int]
    rotation: list[Decimal] | None

    @classmethod
    def of(cls, inertia: Tensor) -> CyclicFrame:
        """The principal frame of an inertia tensor in the body frame."""
        tensor = [[Decimal(entry) for entry in row] for row in inertia]
        moments, axes = diagonalised(inertia, DIGITS)
        j = sorted(range(3), key=moments.__getitem__)[1]
        i = (j - 1) % 3
        k = (j + 1) % 3
        has_products = any(tensor[p][q] for p, q in ((0, 1), (0, 2), (1, 2)))
        rotation = _rotation_quaternion(axes[i], axes[j], axes[k]) if has_products else None
        return cls(tensor, (moments[i], moments[j], moments[k]), (axes[i], axes[j], axes[k]), (i, j, k), rotation)

    def inward(self, attitude_xyzw: Sequence[float]) -> list[Decimal]:
        """The frame's attitude from the body's, of unit norm."""
        given = [Decimal(component) for component in attitude_xyzw]
        norm = dot(given, given).sqrt()
        given = [c / norm for c in given]
        if self.rotation is None:
            return [*(given[i] for i in self.order), given[3]]
        return list(quaternion.product(given, self.rotation))

    def outward(self, attitude_xyzw: Array, rate: Array) -> Samples:
        """The body's attitudes and rates from the frame's, shapes (N, 4) and (N, 3)."""
        if self.rotation is None:
            place = [self.order.index(i) for i in range(3)]
            return attitude_xyzw[:, [*place, 3]], rate[:, place]
        inverse, matrix = self._to_body
        return quaternion.multiply(attitude_xyzw, inverse), apply_tensor(matrix, rate)

    @cached_property
    def _to_body(self) -> tuple[Array, Array]:
        """The inverse of the rotation's quaternion, and the rotation's matrix, in doubles."""
        rows = list(zip(*self.axes, strict=True))
        return quaternion.conjugate(np.array(self.rotation, np.float64)), np.array(rows, np.float64)


@short_dataclass
class DimensionlessMotion:
    """A torque-free motion in the principal frame, in units of its own momentum and its largest body rate.

    Attributes
    ----------
    inverse_moments : tuple of 3 Decimal
        e₁, e₂, e₃: body rate per momentum along each axis.
    momentum : tuple of 3 Decimal
        n, the unit vector of the body momentum at the start.
    m1, m3 : Decimal
        n₁² and n₃² where n₂ = 0, which every motion passes, or comes arbitrarily near to.
    fastest : Decimal
        The largest body rate, rad/s: the unit of rates.
    """

    inverse_moments: Vector
    momentum: Vector
    m1: Decimal
    m3: Decimal
    fastest: Decimal

    @classmethod
    def of(cls, frame: CyclicFrame, body_rate: Sequence[float]) -> DimensionlessMotion:
        """The motion of a body whose principal frame is known, from its body rate at the start, rad/s."""
        rate = [Decimal(component) for component in body_rate]
        total = [dot(row, rate) for row in frame.tensor]
        size = dot(total, total).sqrt()
        # at rest any direction will do
        x, y, z = (dot(axis, total) / size for axis in frame.axes) if size else map(Decimal, (0, 0, 1))
        e1, e2, e3 = (1 / moment for moment in frame.moments)
        a = x * x
        b = y * y
        c = z * z
        if e1 == e3:  # a sphere: any two axes will do
            m1 = a
            m3 = b + c
        else:
            # (2H − e₃)/(e₁ − e₃) and (e₁ − 2H)/(e₁ − e₃), where nothing cancels
            m1 = a + b * (e2 - e3) / (e1 - e3)
            m3 = c + b * (e1 - e2) / (e1 - e3)
        # the square of the body rate, Σ eⱼ²nⱼ², is largest where n₂ = 0
        fastest = (e1 * e1 * m1 + e3 * e3 * m3).sqrt()
        scaled = (e1 / fastest, e2 / fastest, e3 / fastest)
        return cls(scaled, (x, y, z), m1, m3, size * fastest)


def rotated(q: list[Decimal], v: Sequence[Decimal]) -> list[Decimal]:
    """The vector q v q⁻¹, for a unit quaternion q."""
    x, y, z, w = q
    return list(quaternion.product(quaternion.product(q, (*v, Decimal(0))), (-x, -y, -z, w))[:3])


def _rotation_quaternion(first: Vector, second: Vector, third: Vector) -> list[Decimal]:
    """The unit quaternion of the matrix with these columns: the longest row of its `shepperd_matrix`."""
    rows = quaternion.shepperd_matrix(zip(first, second, third, strict=True))
    largest = max(range(4), key=lambda k: rows[k][k])
    norm = dot(rows[largest], rows[largest]).sqrt()
    return [x / norm for x in rows[largest]]
