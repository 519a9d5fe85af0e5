"""The state of a rotating body: attitude and body rate; equation numbers are those of A. Lucas, arXiv 1111.1275."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, Sizes, real_array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics.array_input import ArraysOnly

UNIT_NORM_TOLERANCE: Final = 1e-6
"""Largest deviation of a quaternion from unit norm: within it the quaternion is normalised, beyond it refused."""


class State(ArraysOnly):
    """Attitude and body rate, of one instant or of many: A of eq. (3), and ω of eq. (11) in the body frame.

    Parameters
    ----------
    attitude_xyzw : array_like, shape (..., 4)
        Rotation taking body vectors to world vectors, scalar last. Normalised when within 1e-6 of unit norm.
    body_rate : array_like, shape (..., 3)
        Angular velocity in the body frame, rad/s.

    Attributes
    ----------
    attitude_xyzw : ndarray, shape (..., 4)
        Read only.
    body_rate : ndarray, shape (..., 3)
        Read only.

    Raises
    ------
    ParameterError
        If a shape is wrong, a number not finite, or a quaternion not near unit norm.
    """

    __slots__ = ("attitude_xyzw", "body_rate")

    attitude_xyzw: Array
    body_rate: Array

    def __init__(self, attitude_xyzw: ArrayLike, body_rate: ArrayLike) -> None:
        attitude = real_array("attitude_xyzw", attitude_xyzw, (..., 4), empty=True)
        rate = real_array("body_rate", body_rate, (..., 3), empty=True)
        if attitude.shape[:-1] != rate.shape[:-1]:
            raise ParameterError(
                "body_rate",
                f"shape {rate.shape} does not go with attitudes of shape {attitude.shape}: give equal leading axes",
            )
        self._hold(_unit(attitude), rate)

    @property
    def batch_shape(self) -> Sizes:
        """The leading axes: () for one instant."""
        return self.body_rate.shape[:-1]

    def __repr__(self) -> str:
        return call_repr(self, {name: getattr(self, name) for name in self.__slots__})


def _unit(attitude: Array) -> Array:
    norms = np.ravel(quaternion.norm(attitude))
    worst = norms[np.argmax(np.abs(norms - 1.0))] if norms.size else 1.0
    if abs(worst - 1.0) > UNIT_NORM_TOLERANCE:
        raise ParameterError(
            "attitude_xyzw",
            f"norm {worst:.9g} is not 1 within {UNIT_NORM_TOLERANCE:g}: divide the quaternion x y z w by its norm",
        )
    return quaternion.normalize(attitude)
