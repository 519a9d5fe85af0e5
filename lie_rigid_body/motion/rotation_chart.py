"""The chart of SO(3) in plain floats: the generic chart written out, for speed."""

from __future__ import annotations

from typing import Final

from lie_rigid_body.lie import scalar
from lie_rigid_body.mechanics import RigidBody
from lie_rigid_body.motion.stepper import Point


class RotationChart:
    """A₀ exp(hat(β)) with the momentum of a rigid body. A centre is a unit quaternion.

    Parameters
    ----------
    body : RigidBody
    """

    dimension: Final = 3

    def __init__(self, body: RigidBody) -> None:
        (a, b, c), (_, d, e), (_, _, f) = body.inverse_inertia.tolist()
        self._inverse = a, b, c, d, e, f

    def field(self, point: Point) -> Point:
        """The chart rate J_r(β)⁻¹ω and Euler's equations π̇ = π × ω, with ω = M⁻¹π."""
        bx, by, bz, px, py, pz = point
        a, b, c, d, e, f = self._inverse
        wx, wy, wz = a * px + b * py + c * pz, b * px + d * py + e * pz, c * px + e * py + f * pz
        rate = scalar.right_dexpinv((bx, by, bz), (wx, wy, wz))
        return [*rate, py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx]

    def recentred(self, centre: scalar.Quaternion, coordinates: Point) -> scalar.Quaternion:
        """The quaternion of A₀ exp(hat(β))."""
        x, y, z = coordinates
        return self.restored(scalar.multiply(centre, scalar.exp((x, y, z))))

    def restored(self, centre: scalar.Quaternion) -> scalar.Quaternion:
        """The quaternion brought to unit norm."""
        return scalar.renormalize(centre)
