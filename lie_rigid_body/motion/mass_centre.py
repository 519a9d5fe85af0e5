"""Position, velocity and acceleration of a point, which a translation and a sum of harmonics tell."""

from __future__ import annotations

from lie_rigid_body.foundation.arrays import Array, Sizes
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.array_input import ArraysOnly


class MassCentre(ArraysOnly):
    """Position, velocity and acceleration of the mass centre in the world frame, of one instant or of many.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (..., 3)
        m, m/s and m/s². Read only.
    """

    __slots__ = ("acceleration", "position", "velocity")

    position: Array
    velocity: Array
    acceleration: Array

    def __init__(self, position: Array, velocity: Array, acceleration: Array) -> None:
        self._hold(acceleration, position, velocity)

    @property
    def batch_shape(self) -> Sizes:
        """The leading axes: () for one instant."""
        return self.position.shape[:-1]

    def body_velocity(self, states: State) -> Array:
        """Velocity along the axes of bodies in some states, m/s, shape (N, 3)."""
        return quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), self.velocity)
