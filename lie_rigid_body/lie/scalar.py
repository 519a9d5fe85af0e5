"""The maps of SO(3) on plain tuples of floats, for loops that carry one state step by step.

They say the same as `quaternion` and `rotation_vector`, without array overhead: a test holds the two against
each other and against multiprecision.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from lie_rigid_body.lie.series import DEXPINV_QUADRATIC, SERIES_LIMIT

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]

# on steps of at most ½ rad these many terms of the series leave less than 1e-17
_SHORT_LIMIT_SQUARED = 0.25
_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7 = DEXPINV_QUADRATIC[:8]


def dexpinv_quadratic(squared: float) -> float:
    """(1 − (θ/2) cot(θ/2))/θ² as a function of θ²; see `series.dexpinv_quadratic`."""
    s = squared
    if s < _SHORT_LIMIT_SQUARED:
        return _C0 + s * (_C1 + s * (_C2 + s * (_C3 + s * (_C4 + s * (_C5 + s * (_C6 + s * _C7))))))
    if s < SERIES_LIMIT * SERIES_LIMIT:
        value = 0.0
        for c in reversed(DEXPINV_QUADRATIC):
            value = value * s + c
        return value
    half = 0.5 * math.sqrt(s)
    return (1.0 - half / math.tan(half)) / s


def right_dexpinv(v: Vector, w: Vector) -> Vector:
    """The chart rate v̇ for which A exp(v) turns with body rate w; `rotation_vector.right_jacobian_inverse` times w."""
    vx, vy, vz = v
    wx, wy, wz = w
    cx, cy, cz = vy * wz - vz * wy, vz * wx - vx * wz, vx * wy - vy * wx
    q = dexpinv_quadratic(vx * vx + vy * vy + vz * vz)
    return (
        wx + 0.5 * cx + q * (vy * cz - vz * cy),
        wy + 0.5 * cy + q * (vz * cx - vx * cz),
        wz + 0.5 * cz + q * (vx * cy - vy * cx),
    )


def exp(v: Vector) -> Quaternion:
    """Unit quaternion of a rotation vector; see `quaternion.exp`."""
    x, y, z = v
    theta = math.hypot(x, y, z)
    ratio = math.sin(0.5 * theta) / theta if theta else 0.5
    return (ratio * x, ratio * y, ratio * z, math.cos(0.5 * theta))


def multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    """Hamilton product, scalar last; see `quaternion.multiply`."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return (
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    )


def renormalize(q: Quaternion) -> Quaternion:
    """One Newton step towards unit norm, exact to round-off for a quaternion within 1e-8 of it."""
    x, y, z, w = q
    scale = 1.5 - 0.5 * (x * x + y * y + z * z + w * w)
    return (scale * x, scale * y, scale * z, scale * w)
