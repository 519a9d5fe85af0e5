"""The specific force at a point of the body, which an accelerometer there measures."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.parameters import Vector
from lie_rigid_body.sensors.signal import Conditioning, Signal

_PER_RATE: Final = math.sqrt(2.0) + 2.0
"""Change of the acceleration of a point per change of the body rate, in units of the rate and of the lever arm."""
_YZX: Final = np.array([1, 2, 0])
_ZXY: Final = np.array([2, 0, 1])


class SpecificForce:
    """Acceleration less gravitation at a point that moves with the body: ω̇×r + ω×(ω×r) + Aᵀ(0, 0, g).

    The first two terms are the acceleration of the point about the mass centre. The last one is what holds the mass
    centre: nothing in free fall; on a frictionless pivot there, the weight upwards, which makes no torque.

    Parameters
    ----------
    body : RigidBody
    lever_arm : tuple of float, length 3
        r, from the mass centre to the point in the body frame, m.
    support : float
        g with the pivot, 0 in free fall, m/s², along z of the world frame.
    """

    def __init__(self, body: RigidBody, lever_arm: Vector, support: float) -> None:
        moments = body.principal_moments
        # (I₂ − I₃)/I₁, each of size 1 at most, as the moments obey the triangle inequality
        self._euler = (moments[_YZX] - moments[_ZXY]) / moments
        self._to_principal = body.principal_axes.T
        self._across = -so3.hat(lever_arm)
        self._principal_across = self._across @ body.principal_axes
        self._has_lever_arm, self._arm = any(lever_arm), float(so3.norm(np.array(lever_arm)))
        self._support = support

    def at(self, states: State) -> Array:
        """The specific force in the body frame.

        Parameters
        ----------
        states : State
            Of N instants.

        Returns
        -------
        ndarray, shape (N, 3)
            m/s². Exactly 0 at the mass centre in free fall.
        """
        force = self._of_rotation(states.body_rate) if self._has_lever_arm else np.zeros_like(states.body_rate)
        if self._support:
            force = force + self._support * _up_in_body(states.attitude_xyzw)
        return force

    def signal(self, states: State) -> Signal:
        """The specific force as `at` gives it, with its conditioning.

        The quotients of moments in Euler's equations are of size 1 at most. So an error δω of the rate changes ω̇×r by
        at most √2 ‖ω‖‖r‖ δω, and ω×(ω×r) by twice ‖ω‖‖r‖ δω; one of the attitude turns the support.
        """

        def conditioning() -> Conditioning:
            speed = so3.norm(states.body_rate)
            return Conditioning.of(
                3.0 * speed * speed * self._arm + self._support,
                per_attitude=self._support,
                per_rate=_PER_RATE * speed * self._arm,
            )

        return Signal(self.at(states), condition=conditioning)

    def _of_rotation(self, rate: Array) -> Array:
        """Acceleration of the point relative to the mass centre, body frame, m/s²: ω̇×r + ω×(ω×r)."""
        tangential = apply_tensor(self._principal_across, self._angular_acceleration(rate))
        return tangential + _cross(rate, apply_tensor(self._across, rate))

    def _angular_acceleration(self, rate: Array) -> Array:
        """Angular acceleration in principal axes, rad/s², by Euler's equations.

        ω̇₁ = (I₂ − I₃)/I₁ ω₂ω₃ and cyclically (Landau & Lifshitz §36, 36.5).
        """
        principal = apply_tensor(self._to_principal, rate)
        return np.asarray(self._euler * _take(principal, _YZX) * _take(principal, _ZXY))


def _up_in_body(attitudes_xyzw: Array) -> Array:
    """The world's z axis in the body frame: the last row of the rotation matrix."""
    x, y, z, w = attitudes_xyzw.T
    return 2.0 * np.stack([x * z - y * w, y * z + x * w, 0.5 - (x * x + y * y)], axis=-1)


def _cross(a: Array, b: Array) -> Array:
    return _take(a, _YZX) * _take(b, _ZXY) - _take(a, _ZXY) * _take(b, _YZX)


def _take(vectors: Array, order: Integers) -> Array:
    return vectors.take(order, axis=-1)
