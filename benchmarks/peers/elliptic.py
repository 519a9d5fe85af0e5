"""Jacobi's amplitude and Legendre's integrals in double precision, as the field's exact solvers evaluate them.

They are the textbook's methods and not those of this package: the scale of arithmetic and geometric means with Landen's
transformation (DLMF 22.20(ii), 19.8(ii)), and Carlson's duplication (DLMF 19.36(i)).
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from peers.compiled import compiled

Array = NDArray[np.float64]

EPSILON: Final = float(np.finfo(float).eps)
LEVELS: Final = 20
RF_TOLERANCE: Final = 0.0025
RJ_TOLERANCE: Final = 0.0015
RC_TOLERANCE: Final = 0.0012
"""Spread of the arguments at which duplication ends, those of FRB: what is left out of the series is round-off."""


@compiled
def means(m: float) -> tuple[Array, Array, Array, int]:
    """The arithmetic means a, the geometric ones b, half differences c, and the last index N, for the parameter m."""
    a, b, c = np.zeros(LEVELS), np.zeros(LEVELS), np.zeros(LEVELS)
    a[0], b[0], c[0] = 1.0, math.sqrt(1.0 - m), math.sqrt(m)
    n = 0
    while c[n] > EPSILON and n < LEVELS - 1:
        a[n + 1] = 0.5 * (a[n] + b[n])
        b[n + 1] = math.sqrt(a[n] * b[n])
        c[n + 1] = 0.5 * (a[n] - b[n])
        n += 1
    return a, b, c, n


@compiled
def last_angle(phi: float, a: Array, b: Array, n: int) -> float:
    """φ_N = 2ᴺ a_N F(φ | m) of an amplitude φ, rad, by tan(φₙ₊₁ − φₙ) = (bₙ/aₙ) tan φₙ."""
    for i in range(n):
        more = math.atan2(b[i] * math.sin(phi), a[i] * math.cos(phi))
        phi += more + 2.0 * math.pi * round((phi - more) / (2.0 * math.pi))
    return phi


@compiled
def amplitude(last: float, a: Array, c: Array, n: int) -> float:
    """φ, rad, from φ_N = 2ᴺ a_N u, by sin(2φₙ₋₁ − φₙ) = (cₙ/aₙ) sin φₙ."""
    phi = last
    for i in range(n, 0, -1):
        phi = 0.5 * (phi + math.asin(c[i] / a[i] * math.sin(phi)))
    return phi


@compiled
def carlson_rf(x: float, y: float, z: float) -> float:
    """Carlson's integral of the first kind (DLMF 19.36.1)."""
    while True:
        mean = (x + y + z) / 3.0
        dx, dy, dz = 1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean
        if max(abs(dx), abs(dy), abs(dz)) < RF_TOLERANCE:
            break
        root = math.sqrt(x * y) + math.sqrt(x * z) + math.sqrt(y * z)
        x, y, z = 0.25 * (x + root), 0.25 * (y + root), 0.25 * (z + root)
    e2 = dx * dy - dz * dz
    e3 = dx * dy * dz
    return (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / math.sqrt(mean)


@compiled
def carlson_rc(x: float, y: float) -> float:
    """Carlson's degenerate integral, for positive y (DLMF 19.2.17)."""
    while True:
        mean = (x + 2.0 * y) / 3.0
        s = y / mean - 1.0
        if abs(s) < RC_TOLERANCE:
            break
        root = 2.0 * math.sqrt(x * y) + y
        x, y = 0.25 * (x + root), 0.25 * (y + root)
    return (1.0 + s * s * (0.3 + s * (1.0 / 7.0 + s * (0.375 + s * 9.0 / 22.0)))) / math.sqrt(mean)


@compiled
def carlson_rj(x: float, y: float, z: float, p: float) -> float:
    """Carlson's integral of the third kind, for positive p (DLMF 19.36.2)."""
    found, share = 0.0, 1.0
    while True:
        mean = 0.2 * (x + y + z + 2.0 * p)
        dx, dy, dz, dp = 1.0 - x / mean, 1.0 - y / mean, 1.0 - z / mean, 1.0 - p / mean
        if max(abs(dx), abs(dy), abs(dz), abs(dp)) < RJ_TOLERANCE:
            break
        rx, ry, rz = math.sqrt(x), math.sqrt(y), math.sqrt(z)
        root = rx * (ry + rz) + ry * rz
        alpha = p * (rx + ry + rz) + rx * ry * rz
        found += share * carlson_rc(alpha * alpha, p * (p + root) ** 2)
        share *= 0.25
        x, y, z, p = 0.25 * (x + root), 0.25 * (y + root), 0.25 * (z + root), 0.25 * (p + root)
    xyz = dx * dy * dz
    e2 = dx * dy + dx * dz + dy * dz - 3.0 * dp * dp
    e3 = xyz + 2.0 * e2 * dp + 4.0 * dp**3
    e4 = (2.0 * xyz + e2 * dp + 3.0 * dp**3) * dp
    e5 = xyz * dp * dp
    series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0
    series += -3.0 * e4 / 22.0 - 9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0
    return 3.0 * found + share * series / (mean * math.sqrt(mean))


@compiled
def third_kind(phi: float, n: float, m: float) -> float:
    """Π(φ, n | m) of any amplitude φ, rad, for n < 1 (DLMF 19.25.14), by whole half turns of it (19.2.10)."""
    half_turns = round(phi / math.pi)
    rest = phi - half_turns * math.pi
    s, c = math.sin(rest), math.cos(rest)
    q = 1.0 - m * s * s
    found = s * carlson_rf(c * c, q, 1.0) + n / 3.0 * s**3 * carlson_rj(c * c, q, 1.0, 1.0 - n * s * s)
    if half_turns == 0:
        return found
    complete = carlson_rf(0.0, 1.0 - m, 1.0) + n / 3.0 * carlson_rj(0.0, 1.0 - m, 1.0, 1.0 - n)
    return found + 2.0 * half_turns * complete
