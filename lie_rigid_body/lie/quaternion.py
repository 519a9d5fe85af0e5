"""Unit quaternions, scalar last (x, y, z, w), as the double cover of SO(3).

The product is Hamilton's: ``multiply(p, q)`` rotates by q first, then by p, as matrices do. An attitude quaternion
takes body vectors to world vectors. All functions are batched over leading axes, and use elementwise arithmetic only,
so that a batch gives the same bits as its rows one by one. Equation numbers are those of A. Lucas, arXiv 1111.1275;
unit quaternions are the group SU(2) of its eq. (31), as `groups.double_cover` writes out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, shaped
from lie_rigid_body.lie import series, vectors


def _quaternions(q: ArrayLike) -> Array:
    return shaped("quaternions", q, (..., 4))


def _components(q: ArrayLike) -> tuple[Array, Array, Array, Array]:
    q = _quaternions(q)
    return q[..., 0], q[..., 1], q[..., 2], q[..., 3]


def product(p: Any, q: Any) -> tuple[Any, Any, Any, Any]:
    """Hamilton product p⊗q, as in eq. (31), of components x, y, z, w of any kind: floats, arrays or decimals."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return (
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    )


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product p⊗q, the product of SU(2), eq. (31).

    Parameters
    ----------
    p, q : array_like, shape (..., 4)
        Scalar last; leading axes broadcast.

    Returns
    -------
    ndarray, shape (..., 4)
    """
    return np.stack(product(_components(p), _components(q)), axis=-1)


def running_product(q: ArrayLike) -> Array:
    """Products q_0, q_0⊗q_1, q_0⊗q_1⊗q_2, … in SU(2), eq. (31), by a scan that doubles its reach.

    Parameters
    ----------
    q : array_like, shape (N, 4)

    Returns
    -------
    ndarray, shape (N, 4)
    """
    found = _quaternions(q).copy()
    reach = 1
    while reach < len(found):
        found[reach:] = multiply(found[:-reach], found[reach:])
        reach *= 2
    return found


def conjugate(q: ArrayLike) -> Array:
    """The conjugate, which for unit quaternions is the inverse in SU(2), eq. (31), and the inverse rotation.

    Parameters
    ----------
    q : array_like, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 4)
    """
    return np.asarray(_quaternions(q) * np.array([-1.0, -1.0, -1.0, 1.0]))


def norm(q: ArrayLike) -> Array:
    """Euclidean norm over the last axis, 1 on SU(2), eq. (31); infinite where it is beyond float64.

    Parameters
    ----------
    q : array_like, shape (..., 4)

    Returns
    -------
    ndarray, shape (...)
    """
    x, y, z, w = _components(q)
    with np.errstate(over="ignore"):
        return np.asarray(np.hypot(np.hypot(x, y), np.hypot(z, w)))


def normalize(q: ArrayLike) -> Array:
    """The quaternion divided by its norm: the nearest element of SU(2), eq. (31).

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Not zero.

    Returns
    -------
    ndarray, shape (..., 4)
    """
    q = _quaternions(q)
    return q / norm(q)[..., np.newaxis]


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """The vector v rotated by the unit quaternion q: u = Av, eq. (3).

    Parameters
    ----------
    q : array_like, shape (..., 4)
    v : array_like, shape (..., 3)
        Leading axes broadcast with those of q.

    Returns
    -------
    ndarray, shape (..., 3)
    """
    x, y, z, w = _components(q)
    v = vectors.as_vectors(v)
    vx = v[..., 0]
    vy = v[..., 1]
    vz = v[..., 2]
    tx = 2.0 * (y * vz - z * vy)
    ty = 2.0 * (z * vx - x * vz)
    tz = 2.0 * (x * vy - y * vx)
    return np.stack(
        [
            vx + (w * tx + (y * tz - z * ty)),
            vy + (w * ty + (z * tx - x * tz)),
            vz + (w * tz + (x * ty - y * tx)),
        ],
        axis=-1,
    )


def exp(v: ArrayLike) -> Array:
    """Unit quaternion of a rotation vector; a rotation by 2π is −1, as on the double cover, eq. (31).

    Parameters
    ----------
    v : array_like, shape (..., 3)
        Axis times angle, rad.

    Returns
    -------
    ndarray, shape (..., 4)
    """
    v = vectors.as_vectors(v)
    theta = vectors.norm(v)
    ratio = series.half_angle_sine_ratio(theta)
    return np.concatenate([v * ratio[..., np.newaxis], np.cos(0.5 * theta)[..., np.newaxis]], axis=-1)


def log(q: ArrayLike) -> Array:
    """Rotation vector of a unit quaternion, of norm at most π (q and −q give the same, as both cover it: eq. (31)).

    Parameters
    ----------
    q : array_like, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 3)
        Axis times angle, rad.
    """
    q = _quaternions(q)
    q = np.where(np.signbit(q[..., 3:]), -q, q)
    # arctan2 of a strided array, on NumPy 1.26 with AVX-512, has other last bits where its result lies behind it
    vector = q[..., :3]
    w = q[..., 3].copy()
    sine = vectors.norm(vector)
    safe = np.where(sine == 0.0, 1.0, sine)
    ratio = np.where(sine == 0.0, 2.0, 2.0 * np.arctan2(sine, w) / safe)
    return vector * ratio[..., np.newaxis]


def to_matrix(q: ArrayLike) -> Array:
    """Rotation matrix of a unit quaternion: the map from SU(2), eq. (31), to SO(3), eq. (6).

    Parameters
    ----------
    q : array_like, shape (..., 4)

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    q = _quaternions(q)
    return vectors.matrix_polynomial(q[..., :3], 2.0 * q[..., 3], 2.0)


def shepperd_matrix(m: Any) -> tuple[tuple[Any, Any, Any, Any], ...]:
    """The matrix 4qqᵀ of the quaternion q, eq. (31), of a rotation matrix, whose rows have entries of any kind.

    Row i is 4qᵢq, so that each is parallel to the quaternion q, and the longest, whose entry on the diagonal is the
    largest, is the best conditioned (S. W. Shepperd, J. Guidance and Control 1 (1978) 223).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = m
    return (
        (1 + xx - yy - zz, xy + yx, xz + zx, zy - yz),
        (xy + yx, 1 - xx + yy - zz, yz + zy, xz - zx),
        (xz + zx, yz + zy, 1 - xx - yy + zz, yx - xy),
        (zy - yz, xz - zx, yx - xy, 1 + xx + yy + zz),
    )


def from_matrix(m: ArrayLike) -> Array:
    """Unit quaternion of a rotation matrix, eqs. (31) and (6), the one with the largest component positive.

    It is the longest row of `shepperd_matrix`, normalised, so that no angle loses digits.

    Parameters
    ----------
    m : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 4)
    """
    entries = np.moveaxis(vectors.as_matrices(m), (-2, -1), (0, 1))
    rows = np.stack([np.stack(row, axis=-1) for row in shepperd_matrix(entries)], axis=-2)
    best = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)
    chosen = np.take_along_axis(rows, best[..., np.newaxis, np.newaxis], axis=-2)[..., 0, :]
    return normalize(chosen)
