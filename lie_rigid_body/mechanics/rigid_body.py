"""The rigid body: its inertia, and the quantities that a torque-free motion conserves."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics.inertia import apply_tensor, inertia_matrix, principal_decomposition, require_physical
from lie_rigid_body.mechanics.second_moment import inertia_from_second_moment, second_moment_from_inertia
from lie_rigid_body.mechanics.state import State

Array = NDArray[np.float64]


class RigidBody:
    """A free rigid body, known by its inertia about its centre of mass.

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
        If the inertia is not finite, not positive definite, or breaks the triangle inequality.
    """

    __slots__ = ("inertia", "inverse_inertia", "principal_axes", "principal_moments")

    def __init__(self, inertia: ArrayLike) -> None:
        self.inertia: Array = inertia_matrix(inertia)
        self.principal_moments, self.principal_axes = principal_decomposition(self.inertia)
        require_physical(self.principal_moments)
        self.inverse_inertia: Array = np.linalg.inv(self.inertia)
        for array in (self.inertia, self.inverse_inertia, self.principal_moments, self.principal_axes):
            array.setflags(write=False)

    @classmethod
    def from_second_moment(cls, second_moment: ArrayLike) -> RigidBody:
        """The body with a given second moment K about its centre of mass, of inertia tr(K) 1 − K.

        Parameters
        ----------
        second_moment : array_like, shape (3, 3)
            K = ∫ρ x xᵀ in the body frame, kg m².

        Returns
        -------
        RigidBody

        Raises
        ------
        InputError
            If K is not symmetric or not positive semidefinite, or its rank is below 2 (a rod, a point).
        """
        return cls(inertia_from_second_moment(second_moment))

    @property
    def second_moment(self) -> Array:
        """K = ∫ρ x xᵀ = ½ tr(M) 1 − M about the centre of mass in the body frame, shape (3, 3), kg m²."""
        return second_moment_from_inertia(self.inertia)

    def __repr__(self) -> str:
        return f"RigidBody({self.inertia.tolist()})"

    def body_momentum(self, states: State) -> Array:
        """Angular momentum in the body frame, M ω.

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (..., 3)
            kg m²/s.
        """
        return apply_tensor(self.inertia, states.body_rate)

    def angular_momentum(self, states: State) -> Array:
        """Angular momentum in the world frame, A M ω: conserved, component by component.

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (..., 3)
            kg m²/s.
        """
        return quaternion.rotate(states.attitude_xyzw, self.body_momentum(states))

    def kinetic_energy(self, states: State) -> Array:
        """Kinetic energy ½ ω·Mω: conserved.

        Parameters
        ----------
        states : State

        Returns
        -------
        ndarray, shape (...)
            J.
        """
        w, p = states.body_rate, self.body_momentum(states)
        return np.asarray(0.5 * (w[..., 0] * p[..., 0] + w[..., 1] * p[..., 1] + w[..., 2] * p[..., 2]))
