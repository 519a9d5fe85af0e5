"""The rotation group SO(3): hat and vee maps, exponential and logarithm, and the Jacobians of the exponential.

Conventions
-----------
``hat`` is the map with ``hat(v) @ x == cross(v, x)``. Its basis Tᵃ obeys [Tᵃ, Tᵇ] = +εᵃᵇᶜTᶜ, which is eq. (26) of
A. Lucas, arXiv 1111.1275; the matrices printed in eq. (25) are −Tᵃ, and obey −ε. Equation numbers are those of that
paper.

All functions are batched: leading axes of the arguments are carried to the result. They are accurate to a few units
in the last place of the largest entry for every angle from the smallest double to π.

References
----------
A. Iserles, H. Z. Munthe-Kaas, S. P. Nørsett, A. Zanna, "Lie-group methods", Acta Numerica 9 (2000), app. B.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion, series
from lie_rigid_body.lie.vectors import as_matrices, as_vectors, matrix_polynomial, norm


def hat(v: ArrayLike) -> Array:
    """The antisymmetric matrix vᵃTᵃ of a vector, ``hat(v) @ x == cross(v, x)``; eq. (25) has −Tᵃ.

    With these signs [hat v, hat w] = hat(v × w), as after eq. (30); with the printed ones it is the opposite.

    Parameters
    ----------
    v : array_like, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    v = as_vectors(v)
    m = np.zeros((*v.shape, 3))
    m[..., 2, 1], m[..., 0, 2], m[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    m[..., 1, 2], m[..., 2, 0], m[..., 0, 1] = -v[..., 0], -v[..., 1], -v[..., 2]
    return m


def vee(m: ArrayLike) -> Array:
    """The vector of the antisymmetric part of a matrix, eq. (41); inverse of `hat`.

    Parameters
    ----------
    m : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3)
    """
    m = as_matrices(m)
    return 0.5 * np.stack(
        [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]], axis=-1
    )


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
    theta = norm(v)
    # vectors are scaled by powers of 2 to norms from ½ to 1, so that no square overflows or underflows
    exponent = np.frexp(theta)[1]
    scaled = np.ldexp(v, -exponent[..., np.newaxis])
    length = np.where(theta == 0.0, 1.0, np.ldexp(theta, -exponent))
    squared = np.where(theta == 0.0, 1.0, np.sum(scaled * scaled, axis=-1))
    return matrix_polynomial(scaled, np.sin(theta) / length, 2.0 * np.sin(0.5 * theta) ** 2 / squared)


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


def left_jacobian(v: ArrayLike) -> Array:
    """The left Jacobian J_l(v), ``dexp`` of SO(3): d/dt exp(hat v) = hat(J_l v̇) exp(hat v) (Iserles et al., app. B).

    It is eq. (11) away from the centre of the chart, where J_l = 1.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Rotation vector, rad.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    v = as_vectors(v)
    theta = norm(v)
    return matrix_polynomial(v, series.dexp_linear(theta), series.dexp_quadratic(theta))


def right_jacobian(v: ArrayLike) -> Array:
    """The right Jacobian J_r(v): d/dt exp(hat v) = exp(hat v) hat(J_r v̇); equals ``left_jacobian(-v)``.

    It is eq. (11) away from the centre of the chart, for the rate in the body frame.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Rotation vector, rad.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    return left_jacobian(-as_vectors(v))


def left_jacobian_inverse(v: ArrayLike) -> Array:
    """The inverse J_l⁻¹(v) of `left_jacobian`, ``dexpinv`` (Iserles et al., app. B).

    It maps the angular velocity in the world frame to v̇: eq. (11), solved for the rate of the coordinates.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Rotation vector, rad, of norm below 2π, where the map ceases to be invertible.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    v = as_vectors(v)
    theta = norm(v)
    return matrix_polynomial(v, np.full_like(theta, -0.5), series.dexpinv_quadratic(theta))


def right_jacobian_inverse(v: ArrayLike) -> Array:
    """The inverse J_r⁻¹(v) of `right_jacobian`; equals ``left_jacobian_inverse(-v)``.

    It maps the angular velocity in the body frame to v̇: eq. (11), solved for the rate of the coordinates.

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Rotation vector, rad, of norm below 2π.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    return left_jacobian_inverse(-as_vectors(v))
