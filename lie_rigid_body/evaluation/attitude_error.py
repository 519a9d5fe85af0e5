"""The error of an attitude estimate: total, heading and inclination angle, and as a rotation vector.

The definition is that of the BROAD benchmark (D. Laidig, M. Caruso, A. Cereatti, T. Seel: BROAD—A Benchmark for Robust
Inertial Orientation Estimation, Data 6(7):72, 2021). With world-from-body quaternions and the world's z axis up, the
error in the world frame is q_e = q_estimate ⊗ q_truth⁻¹ = (x, y, z, w), and

    total       = 2 arccos |w|
    heading     = 2 arctan |z / w|
    inclination = 2 arccos √(w² + z²).

So q_e is a turn about the vertical by the heading after a tilt about a horizontal axis by the inclination, and
cos(total/2) = cos(heading/2) cos(inclination/2). An arccos loses half of the digits near 0, so the angles are computed
by arctan2 of the same sides; they differ from the definition by round-off only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import real_numbers, shape_remedy
from lie_rigid_body.evaluation.attitudes import turns
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr


class AttitudeError(NamedTuple):
    """Error angles of attitude estimates, all from 0 to π.

    Attributes
    ----------
    total : ndarray, shape (...)
        Angle of the rotation that takes the true attitude to the estimate, rad.
    heading : ndarray, shape (...)
        Its part about the world's vertical, rad. An inclination error of π has no heading error; within `ROUND_OFF` of
        it 0 is given.
    inclination : ndarray, shape (...)
        Its part about a horizontal axis, rad: the angle between the true and the estimated vertical.
    """

    total: Array
    heading: Array
    inclination: Array

    def __repr__(self) -> str:
        return short_repr(self)


def attitude_error(estimate_xyzw: ArrayLike, truth_xyzw: ArrayLike) -> AttitudeError:
    """Total, heading and inclination error of attitude estimates.

    Parameters
    ----------
    estimate_xyzw, truth_xyzw : array_like, shape (N, 4) or (..., 4)
        World-from-body quaternions of the same instants, scalar last, world z up. Norm and sign are ignored. Leading
        axes broadcast.

    Returns
    -------
    AttitudeError

    Raises
    ------
    InputError
        If the shapes do not go together, a number is not finite, or a quaternion is zero.
    """
    estimate, truth = pairs(estimate_xyzw, truth_xyzw)
    return angles(quaternion.multiply(estimate, quaternion.conjugate(truth)))


def pairs(estimate_xyzw: ArrayLike, truth_xyzw: ArrayLike) -> tuple[Array, Array]:
    """Read estimates and true attitudes of shapes that go together, and divide them by their norms.

    Raises
    ------
    InputError
        As `attitude_error`.
    """
    estimate, truth = unit("estimate_xyzw", estimate_xyzw), unit("truth_xyzw", truth_xyzw)
    try:
        np.broadcast_shapes(estimate.shape, truth.shape)
    except ValueError:
        raise InputError(
            f"estimate_xyzw of shape {estimate.shape} does not go with truth_xyzw of shape {truth.shape}: "
            "give both at the same instants, one row each"
        ) from None
    return estimate, truth


def angles(error_xyzw: Array) -> AttitudeError:
    """Error angles of an error quaternion in the world frame, shape (..., 4)."""
    # of each component its own array: arctan2 of a strided one, on NumPy 1.26 with AVX-512, has other last bits where
    # its result happens to lie behind it in memory
    x, y, z, w = np.ascontiguousarray(np.moveaxis(np.abs(error_xyzw), -1, 0))
    tilt, turn = np.hypot(x, y), np.hypot(z, w)
    heading = 2.0 * np.arctan2(np.where(turn > ROUND_OFF, z, 0.0), w)
    return AttitudeError(2.0 * np.arctan2(np.hypot(tilt, z), w), heading, 2.0 * np.arctan2(tilt, turn))


def world_error(estimate_xyzw: Array, truth_xyzw: Array) -> Array:
    """Rotation vector of the error on the world's axes, log(q_estimate ⊗ q_truth⁻¹), shape (..., 3), rad."""
    return quaternion.log(quaternion.multiply(estimate_xyzw, quaternion.conjugate(truth_xyzw)))


def body_error(estimate_xyzw: Array, truth_xyzw: Array) -> Array:
    """Rotation vector of the error on the body's axes, log(q_truth⁻¹ ⊗ q_estimate), shape (..., 3), rad."""
    return turns(truth_xyzw, estimate_xyzw)


def numbers(name: str, value: ArrayLike, *size: int) -> Array:
    """Read finite numbers whose last axes have the given size, as float64.

    Raises
    ------
    InputError
        With the first row that is at fault.
    """
    wanted = f"(..., {', '.join(map(str, size))})"
    array = real_numbers(name, value, wanted)
    if array.shape[-len(size) :] != size:
        raise InputError(f"{name}: shape {array.shape} is not {wanted}: {shape_remedy(array.shape, size)}")
    if array.size == 0:
        raise InputError(f"{name}: empty: give at least one row")
    bad = np.flatnonzero(~np.isfinite(array.reshape(-1, int(np.prod(size)))).all(axis=-1))
    if bad.size:
        total = array.size // int(np.prod(size))
        raise InputError(
            f"{name}: {bad.size} of {total} rows are not finite, the first is row {bad[0]}: "
            "leave them out, or find out why the filter gave them"
        )
    return array


def unit(name: str, value: ArrayLike) -> Array:
    """Read quaternions, and divide them by their norm.

    Raises
    ------
    InputError
        If one is not finite, or zero, or its norm is beyond float64.
    """
    array = numbers(name, value, 4)
    norms = quaternion.norm(array).ravel()
    bad = np.flatnonzero((norms < SMALLEST_NORM) | np.isinf(norms))
    if bad.size:
        raise InputError(
            f"{name}: {bad.size} of {array.size // 4} quaternions are zero or overflow, the first is row {bad[0]}: "
            "leave them out, or fill in the orientation"
        )
    return quaternion.normalize(array)


ROUND_OFF = 2e-15
"""Round-off of the components of a product of unit quaternions: smaller z and w tell no heading, as their ratio is
arbitrary."""
SMALLEST_NORM = 1e-12
"""Least norm of a quaternion; one of a smaller norm is taken for a quaternion that nobody has set."""
