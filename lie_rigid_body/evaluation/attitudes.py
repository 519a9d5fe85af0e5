"""Attitudes beside each other: the error of an estimate, and turns from some attitudes to others, as angles and words.

The definition of the error is that of the BROAD benchmark (D. Laidig, M. Caruso, A. Cereatti, T. Seel: BROAD—A
Benchmark for Robust Inertial Orientation Estimation, Data 6(7):72, 2021). With world-from-body quaternions and the
world's z axis up, the error in the world frame is q_e = q_estimate ⊗ q_truth⁻¹ = (x, y, z, w), and

    total       = 2 arccos |w|
    heading     = 2 arctan |z / w|
    inclination = 2 arccos √(w² + z²).

So q_e is a turn about the vertical by the heading after a tilt about a horizontal axis by the inclination, and
cos(total/2) = cos(heading/2) cos(inclination/2). An arccos loses half of the digits near 0, so the angles are computed
by arctan2 of the same sides; they differ from the definition by round-off only.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import unit
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import components, short_repr

ROUND_OFF: Final = 2e-15
"""Round-off of the components of a product of unit quaternions: smaller z and w tell no heading, as their ratio is
arbitrary."""
SAME_AXES_DEG: Final = 5.0
"""Largest angle between a mounting and axes that only change places and signs, to be told in those words, degrees."""


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


def error_vectors(estimate_xyzw: Array, truth_xyzw: Array, axes: str = "world") -> Array:
    """Rotation vectors of errors, shape (..., 3), rad, about the axes of the world or of the body.

    They are log(q_estimate ⊗ q_truth⁻¹) and log(q_truth⁻¹ ⊗ q_estimate).
    """
    back = quaternion.conjugate(truth_xyzw)
    factors = (estimate_xyzw, back) if axes == "world" else (back, estimate_xyzw)
    return quaternion.log(quaternion.multiply(*factors))


def turns(start_xyzw: Array, end_xyzw: Array) -> Array:
    """Rotation vectors from some attitudes to others on the body's axes, log(q_start⁻¹ ⊗ q_end), (..., 3), rad."""
    return error_vectors(end_xyzw, start_xyzw, "body")


def angles_between(start_xyzw: Array, end_xyzw: Array) -> Array:
    """Angles of the turns from some attitudes to others, shape (...), rad."""
    return sizes(turns(start_xyzw, end_xyzw))


def sizes(vectors: Array) -> Array:
    """Norms of vectors of shape (..., 3)."""
    return np.asarray(np.sqrt(np.sum(vectors**2, axis=-1)))


def geodesic(start_xyzw: Array, end_xyzw: Array, fraction: Array) -> Array:
    """Attitude at a fraction of the shortest turn from one attitude to another, shape (..., 4)."""
    return quaternion.multiply(
        start_xyzw, quaternion.exp(turns(start_xyzw, end_xyzw) * np.asarray(fraction)[..., np.newaxis])
    )


def times(ratio: float, digits: int = 3) -> str:
    """Ratio of two rates in words, ``2 times as fast as``."""
    return f"{max(ratio, 1.0 / ratio):.{digits}g} times as {'fast' if ratio > 1.0 else 'slow'} as"


def named(axes: Array) -> str:
    """Rows of a matrix of axes that change places and signs, as ``y, -x, z``."""
    return ", ".join(f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in axes)


def places(mounting: Array) -> str:
    """Body axes of an estimate named by those of the body, where they only change places and signs; else empty."""
    axes = quaternion.rotate(mounting, np.eye(3))  # row by row, on the axes of the body
    nearest = np.round(axes)
    left = float(np.degrees(np.arccos(np.clip((np.sum(axes * nearest) - 1.0) / 2.0, -1.0, 1.0))))
    name = named(nearest)
    if left > SAME_AXES_DEG or name == "x, y, z" or np.abs(nearest).sum() != 3.0:
        return ""
    meaning = ", forward-right-down where the truth's are forward-left-up" if name == "x, -y, -z" else ""
    return f"; its x, y, z are {name} of the body{meaning}" + (f", but for {left:.2g}°" if left >= 0.01 else "")


def angle_and_axis(rotation: Array) -> str:
    """Angle and axis of a rotation, shape (4,), in words."""
    turn = quaternion.log(rotation)
    angle = float(sizes(turn))
    return f"{np.degrees(angle):.4g}° about ({components(turn / angle if angle else turn, 3)})"
