"""The rotation group SO(3): matrices, their exponential and logarithm, and the Jacobians of the exponential.

The algebra and the Jacobians are those of `rotation_vector`, under the names of the group; the logarithm goes through
`quaternion`. Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion, series
from lie_rigid_body.lie.rotation_vector import (
    as_vectors,
    hat,
    left_jacobian,
    left_jacobian_inverse,
    matrix_polynomial,
    norm,
    right_jacobian,
    right_jacobian_inverse,
    vee,
)

__all__ = [
    "exp",
    "hat",
    "left_jacobian",
    "left_jacobian_inverse",
    "log",
    "norm",
    "right_jacobian",
    "right_jacobian_inverse",
    "vee",
]


def exp(v: ArrayLike) -> Array:
    """Rotation matrix of a rotation vector, eq. (38) beyond first order (Rodrigues; Iserles et al., app. B).

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Axis times angle, rad.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    v = as_vectors(v)
    theta, squared = norm(v), np.sum(v * v, axis=-1)
    return matrix_polynomial(v, series.sine_ratio(theta), series.versine_ratio(theta, squared))


def log(m: ArrayLike) -> Array:
    """Rotation vector of a rotation matrix, eq. (6), of norm at most π.

    Parameters
    ----------
    m : array_like, shape (..., 3, 3)
        Rotation matrices.

    Returns
    -------
    ndarray, shape (..., 3)
        Axis times angle, rad. At an angle of π either sign of the axis is right; one is returned.
    """
    return quaternion.log(quaternion.from_matrix(m))
