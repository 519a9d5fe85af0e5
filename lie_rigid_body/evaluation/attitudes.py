"""Attitudes beside each other: the turns from some to others, as vectors, as angles and in words."""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import components

SAME_AXES_DEG: Final = 5.0
"""Largest angle between a mounting and axes that only change places and signs, to be told in those words, degrees."""


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
    angle = float(np.sqrt(turn @ turn))
    return f"{np.degrees(angle):.4g}° about ({components(turn / angle if angle else turn, 3)})"
