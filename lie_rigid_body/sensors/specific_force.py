"""The specific force at a point of the body: what an accelerometer there is after."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.sensors.vectors import Vector

Array = NDArray[np.float64]

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
        self._axes = body.principal_axes
        # each of size 1 at most, as the moments obey the triangle inequality
        self._euler = (moments[_YZX] - moments[_ZXY]) / moments
        self._has_lever_arm = any(lever_arm)
        self._lever = so3.hat(lever_arm)
        self._support = np.array([0.0, 0.0, support])

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
        if self._support[2]:
            force = force + quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self._support)
        return force

    def _of_rotation(self, rate: Array) -> Array:
        centripetal = _cross(rate, -apply_tensor(self._lever, rate))
        return centripetal - apply_tensor(self._lever, self._angular_acceleration(rate))

    def _angular_acceleration(self, rate: Array) -> Array:
        """Euler's equations in principal axes, ω̇₁ = (I₂ − I₃)/I₁ ω₂ω₃ and so on (Landau & Lifshitz §36, 36.5)."""
        along = apply_tensor(self._axes.T, rate)
        return apply_tensor(self._axes, self._euler * _take(along, _YZX) * _take(along, _ZXY))


def _cross(a: Array, b: Array) -> Array:
    return _take(a, _YZX) * _take(b, _ZXY) - _take(a, _ZXY) * _take(b, _YZX)


def _take(vectors: Array, order: NDArray[np.int64]) -> Array:
    return vectors.take(order, axis=-1)
