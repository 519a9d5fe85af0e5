"""From the body's own axes to those of a spinning frame and back."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.moser_veselov.spinning_frame import PrincipalAxes

Array = NDArray[np.float64]


class FrameChange:
    """Attitudes of the body's axes, and of a spinning frame.

    Where the frame's axes are the body's own in a cyclic order, the world's are put into the same order. Then changing
    frames is a permutation, and costs no accuracy.

    Parameters
    ----------
    principal : PrincipalAxes
    """

    __slots__ = ("_back", "_columns", "_order", "_turn")

    def __init__(self, principal: PrincipalAxes) -> None:
        order = [max(range(3), key=lambda i: abs(axis[i])) for axis in principal.axes]
        self._order = order if principal.diagonal else None
        columns = [list(row) for row in zip(*principal.axes, strict=True)]
        self._turn = _rotation_quaternion(columns)
        self._back = quaternion.conjugate(np.array([float(c) for c in self._turn]))
        self._columns = np.array([[float(c) for c in row] for row in columns])

    def inward(self, attitude_xyzw: Sequence[float]) -> list[Decimal]:
        """The frame's attitude from the body's, of unit norm to the decimal precision in force."""
        given = [Decimal(component) for component in attitude_xyzw]
        norm = sum((c * c for c in given), Decimal(0)).sqrt()
        given = [c / norm for c in given]
        if self._order:
            return [*(given[i] for i in self._order), given[3]]
        return _quaternion_product(given, self._turn)

    def outward(self, attitude_xyzw: Array, rate: Array) -> tuple[Array, Array]:
        """The body's attitudes and rates from the frame's, shapes (N, 4) and (N, 3)."""
        if self._order:
            place = [self._order.index(i) for i in range(3)]
            return attitude_xyzw[:, [*place, 3]], rate[:, place]
        return quaternion.multiply(attitude_xyzw, self._back), apply_tensor(self._columns, rate)


def rotated(q: list[Decimal], v: list[Decimal]) -> list[Decimal]:
    """The vector q v q⁻¹."""
    x, y, z, w = q
    return _quaternion_product(_quaternion_product(q, [*v, Decimal(0)]), [-x, -y, -z, w])[:3]


def _quaternion_product(p: list[Decimal], q: list[Decimal]) -> list[Decimal]:
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return [
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    ]


def _rotation_quaternion(r: Sequence[Sequence[Decimal]]) -> list[Decimal]:
    """The unit quaternion of a rotation matrix, from the largest column of 4 qqᵀ (S. W. Shepperd, 1978)."""
    (a, b, c), (d, e, f), (g, h, i) = r
    columns = [
        [1 + a - e - i, b + d, c + g, h - f],
        [b + d, 1 - a + e - i, f + h, c - g],
        [c + g, f + h, 1 - a - e + i, d - b],
        [h - f, c - g, d - b, 1 + a + e + i],
    ]
    largest = max(range(4), key=lambda k: columns[k][k])
    norm = sum((x * x for x in columns[largest]), Decimal(0)).sqrt()
    return [x / norm for x in columns[largest]]
