"""Attitudes beside each other: the turns from some to others, as vectors and as angles."""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion


def turns(start_xyzw: Array, end_xyzw: Array) -> Array:
    """Rotation vectors from some attitudes to others on the body's axes, log(q_start⁻¹ ⊗ q_end), (..., 3), rad."""
    return quaternion.log(quaternion.multiply(quaternion.conjugate(start_xyzw), end_xyzw))


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
