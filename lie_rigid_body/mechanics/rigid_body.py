"""The rigid body: its inertia, momentum and kinetic energy.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import MAX_LINE, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics.array_input import Immutable
from lie_rigid_body.mechanics.inertia import (
    apply_tensor,
    inertia_matrix,
    principal_decomposition,
    require_physical,
)
from lie_rigid_body.mechanics.second_moment import inertia_from_second_moment, second_moment_from_inertia
from lie_rigid_body.mechanics.state import State


class RigidBody(Immutable):
    """A free rigid body, given by its inertia about its centre of mass, eq. (28).

    Parameters
    ----------
    inertia : array_like, shape (3,), (6,) or (3, 3)
        Principal moments along the body axes, or ``ixx ixy ixz iyy iyz izz``, or the symmetric tensor; kg m².

    Attributes
    ----------
    inertia : ndarray, shape (3, 3)
        Tensor in the body frame, kg m².
    inverse_inertia : ndarray, shape (3, 3)
        Its inverse, 1/(kg m²).
    principal_moments : ndarray, shape (3,)
        Ascending, kg m².
    principal_axes : ndarray, shape (3, 3)
        Columns are the principal axes in the body frame, right-handed, in the order of the moments.

    Raises
    ------
    ParameterError
        If an inertia is not finite, not positive definite, or breaks the triangle inequality.
    """

    __slots__ = ("inertia", "inverse_inertia", "principal_axes", "principal_moments")

    def __init__(self, inertia: ArrayLike) -> None:
        self.inertia = inertia_matrix(inertia)
        self.principal_moments, self.principal_axes = principal_decomposition(self.inertia)
        require_physical(self.principal_moments)
        self.inverse_inertia = np.linalg.inv(self.inertia)
        for array in (self.inertia, self.inverse_inertia, self.principal_moments, self.principal_axes):
            array.setflags(write=False)

    @classmethod
    def from_second_moment(cls, second_moment: ArrayLike) -> RigidBody:
        """The body with a given second moment K about its centre of mass, of inertia tr(K) 1 − K, eq. (28).

        Parameters
        ----------
        second_moment : array_like, shape (3, 3)
            K = ∫ρ x xᵀ in the body frame, kg m².

        Returns
        -------
        RigidBody

        Raises
        ------
        ParameterError
            If K is not symmetric or not positive semidefinite, or its rank is below 2 (a rod, a point).
        """
        return cls(inertia_from_second_moment(second_moment))

    @property
    def second_moment(self) -> Array:
        """The second moment ½ tr(M) 1 − M, eq. (10), about the centre of mass, body frame, shape (3, 3), kg m²."""
        return second_moment_from_inertia(self.inertia)

    def __reduce__(self) -> tuple[type[RigidBody], tuple[Array]]:
        return RigidBody, (self.inertia,)

    def __repr__(self) -> str:
        return f"RigidBody({shown(self.inertia.tolist(), MAX_LINE - 12)})"

    def body_momentum(self, states: State) -> Array:
        """Angular momentum in the body frame, π = Mω, eq. (19).

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (..., 3)
            kg m²/s.

        Raises
        ------
        ParameterError
            If the argument is no state, as are rates alone; so do the methods below.
        """
        if not isinstance(states, State):
            raise ParameterError("states", f"{shown(states)} is no State: give State(attitude_xyzw, body_rate)")
        return apply_tensor(self.inertia, states.body_rate)

    def angular_acceleration(self, states: State) -> Array:
        """Angular acceleration ω̇ in the body frame, by Euler's equations M ω̇ = (M ω) × ω, eq. (29).

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (..., 3)
            rad/s².
        """
        torque = np.cross(self.body_momentum(states), states.body_rate)
        return np.linalg.solve(self.inertia, torque[..., np.newaxis])[..., 0]

    def angular_momentum(self, states: State) -> Array:
        """Angular momentum in the world frame, L = A M ω: every component is conserved, by the symmetry
        A ↦ BA of eq. (9).

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (..., 3)
            kg m²/s.
        """
        momentum = self.body_momentum(states)
        return quaternion.rotate(states.attitude_xyzw, momentum)

    def kinetic_energy(self, states: State) -> Array:
        """Kinetic energy ½ ω·Mω, which is conserved, eq. (14).

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (...)
            J.
        """
        p = self.body_momentum(states)
        w = states.body_rate
        return np.asarray(0.5 * (w[..., 0] * p[..., 0] + w[..., 1] * p[..., 1] + w[..., 2] * p[..., 2]))
