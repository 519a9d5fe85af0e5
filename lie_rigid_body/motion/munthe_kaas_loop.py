"""The Runge–Kutta–Munthe-Kaas steps of a rotating body in plain numbers: the generic stepper and chart written out."""

from __future__ import annotations

import math
from typing import Any, Final, TypeAlias

from lie_rigid_body.compilation import Loop, kernel
from lie_rigid_body.lie.series import DEXPINV_QUADRATIC, SERIES_LIMIT

Six: TypeAlias = tuple[float, float, float, float, float, float]
Seven: TypeAlias = tuple[float, float, float, float, float, float, float]

STAGES: Final = 6
"""Where the stages begin among the constants: after the inverse inertia's six entries. Each is the weight of the slope
before it, and its own."""

SHORT_SQUARED: Final = 0.25
"""On steps of at most ½ rad eight terms of dexp⁻¹'s series, and six of the sine's, leave less than 1e-17."""

LONG_SQUARED: Final = SERIES_LIMIT * SERIES_LIMIT
C0, C1, C2, C3, C4, C5, C6, C7 = DEXPINV_QUADRATIC[:8]
TERMS: Final = len(DEXPINV_QUADRATIC)
S0, S1, S2, S3, S4, S5 = ((-0.25) ** k / (2.0 * math.factorial(2 * k + 1)) for k in range(6))


@kernel
def dexpinv_quadratic(s: float) -> float:
    """(1 − (θ/2) cot(θ/2))/θ² as a function of θ²; see `lie.series.dexpinv_quadratic`."""
    if s < SHORT_SQUARED:
        # by pairs: a processor does not wait for one after the other
        t = s * s
        return ((C0 + s * C1) + t * (C2 + s * C3)) + (t * t) * ((C4 + s * C5) + t * (C6 + s * C7))
    if s < LONG_SQUARED:
        value = 0.0
        for k in range(TERMS - 1, -1, -1):
            value = value * s + DEXPINV_QUADRATIC[k]
        return value
    half = 0.5 * math.sqrt(s)
    return (1.0 - half / math.tan(half)) / s if s < math.inf else math.nan


@kernel
def field_at_centre(px: float, py: float, pz: float, constants: Any) -> Six:
    """The rate ω = M⁻¹π, and Euler's equations π̇ = π × ω."""
    wx = constants[0] * px + constants[1] * py + constants[2] * pz
    wy = constants[1] * px + constants[3] * py + constants[4] * pz
    wz = constants[2] * px + constants[4] * py + constants[5] * pz
    return wx, wy, wz, py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx


@kernel
def chart_field(point: Six, constants: Any) -> Six:
    """The chart rate J_r(β)⁻¹ω, and Euler's equations."""
    x, y, z, px, py, pz = point
    wx, wy, wz, tx, ty, tz = field_at_centre(px, py, pz, constants)
    cx, cy, cz = y * wz - z * wy, z * wx - x * wz, x * wy - y * wx
    c = dexpinv_quadratic(x * x + y * y + z * z)
    return (
        wx + 0.5 * cx + c * (y * cz - z * cy),
        wy + 0.5 * cy + c * (z * cx - x * cz),
        wz + 0.5 * cz + c * (x * cy - y * cx),
        tx,
        ty,
        tz,
    )


@kernel
def increment(px: float, py: float, pz: float, h: float, constants: Any) -> Six:
    """What one Runge–Kutta step adds to the coordinates, which are 0, and to the momentum."""
    k = field_at_centre(px, py, pz, constants)
    own = constants[STAGES + 1]
    a, b, c, d, e, f = own * k[0], own * k[1], own * k[2], own * k[3], own * k[4], own * k[5]
    for stage in range(STAGES + 2, len(constants), 2):
        before, own = h * constants[stage], constants[stage + 1]
        beta = before * k[0], before * k[1], before * k[2]
        k = chart_field((*beta, px + before * k[3], py + before * k[4], pz + before * k[5]), constants)
        a, b, c = a + own * k[0], b + own * k[1], c + own * k[2]
        d, e, f = d + own * k[3], e + own * k[4], f + own * k[5]
    return h * a, h * b, h * c, h * d, h * e, h * f


@kernel
def half_angle(s: float) -> tuple[float, float]:
    """The quotient sin(θ/2)/θ, and cos(θ/2), as functions of θ²."""
    if s < SHORT_SQUARED:
        t = s * s
        ratio = ((S0 + s * S1) + t * (S2 + s * S3)) + (t * t) * (S4 + s * S5)
        return ratio, math.sqrt(1.0 - s * ratio * ratio)
    theta = math.sqrt(s)
    return math.sin(0.5 * theta) / theta, math.cos(0.5 * theta)


@kernel
def recentred(x: float, y: float, z: float, w: float, step: Six) -> tuple[float, float, float, float]:
    """The quaternion of A₀ exp(hat(β)), brought to unit norm by one Newton step."""
    a, b, c = step[0], step[1], step[2]
    ratio, d = half_angle(a * a + b * b + c * c)
    a, b, c = ratio * a, ratio * b, ratio * c
    p, q = w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a
    r, s = w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c
    scale = 1.5 - 0.5 * (p * p + q * q + r * r + s * s)
    return scale * p, scale * q, scale * r, scale * s


@kernel
def take_munthe_kaas_steps(state: Any, constants: Any, h: float, count: int) -> None:
    """Move the state by a number of steps, or make it nan where they lead to infinity."""
    x, y, z, w, px, py, pz = state[0], state[1], state[2], state[3], state[4], state[5], state[6]
    for _ in range(count):
        step = increment(px, py, pz, h, constants)
        px, py, pz = px + step[3], py + step[4], pz + step[5]
        if not math.isfinite(px + py + pz + (step[0] * step[0] + step[1] * step[1] + step[2] * step[2])):
            x = math.nan
            break
        x, y, z, w = recentred(x, y, z, w, step)
    state[0], state[1], state[2], state[3], state[4], state[5], state[6] = x, y, z, w, px, py, pz


def advance(state: Any, constants: Any, spans: Any, counts: Any, takes: Any, out: Any) -> None:
    """Steps through the samples, each given back as the state, x … w and the body momentum; see `compilation.Loop`."""
    for i in range(len(spans)):
        if counts[i] > 0 and not math.isnan(state[0]):
            take_munthe_kaas_steps(state, constants, 1e-9 * spans[i] / counts[i], takes[i])
        for j in range(len(state)):
            out[i, j] = state[j]


LOOP: Final = Loop(advance)
