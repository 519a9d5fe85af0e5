"""Runge–Kutta–Munthe-Kaas steps along Euler's equations and the equation of the chart, in plain numbers.

The attitude is a unit quaternion A₀, the chart about it A₀ exp(hat(β)). A step of length h starts at β = 0, takes β
and the body momentum π by a Runge–Kutta method along

    β̇ = J_r(β)⁻¹ M⁻¹π,     π̇ = π × M⁻¹π,     J_r(β)⁻¹ω = ω + ½ β × ω + c(θ) β × (β × ω),
    c(θ) = (1 − (θ/2) cot(θ/2))/θ²,     θ = |β|

and makes A₀ exp(hat(β)) the next centre (Iserles, Munthe-Kaas, Nørsett, Zanna, Acta Numerica 9 (2000), sec. 4.2 and
app. B).
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple, TypeAlias

from lie_rigid_body.compilation import kernel
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.lie.series import DEXPINV_QUADRATIC, SERIES_LIMIT

Three: TypeAlias = tuple[float, float, float]
Six: TypeAlias = tuple[float, float, float, float, float, float]

Four: TypeAlias = tuple[float, float, float, float]


class ChartState(NamedTuple):
    """The state at the centre of a chart: the quaternion x y z w, and the body momentum π, kg m²/s."""

    attitude: Four
    momentum: Three


class ChartConstants(NamedTuple):
    """The body and the method.

    Attributes
    ----------
    inverse_inertia : 6 floats
        Upper triangle of M⁻¹ by rows.
    stages : pairs of float
        For each Runge–Kutta stage the weight of the slope before it and its own weight in the sum.
    """

    inverse_inertia: Six
    stages: tuple[tuple[float, float], ...]


SHORT_SQUARED: Final = 0.25
"""Limit of θ² for the short series, rad²: up to ½ rad, eight terms of `dexpinv_quadratic` and six of the sine leave
less than 1e-17."""

LONG_SQUARED: Final = SERIES_LIMIT * SERIES_LIMIT
"""Limit of θ² for the long series, rad²: from here on the closed form of `dexpinv_quadratic` does not cancel."""

# c(θ) = Σ |B₂ₖ₊₂| θ²ᵏ/(2k+2)!
C0, C1, C2, C3, C4, C5, C6, C7 = DEXPINV_QUADRATIC[:8]

# sin(θ/2)/θ = ½ Σ (−1)ᵏ (θ/2)²ᵏ/(2k+1)!
S0, S1, S2, S3, S4, S5 = ((-0.25) ** k / (2.0 * math.factorial(2 * k + 1)) for k in range(6))


@kernel
def dexpinv_quadratic(s: float) -> float:
    """The coefficient c = (1 − (θ/2) cot(θ/2))/θ² as a function of s = θ²; see `lie.series.dexpinv_quadratic`."""
    if s < SHORT_SQUARED:
        # Estrin's scheme: a processor adds pairs side by side, and waits for each step of Horner's
        t = s * s
        return ((C0 + s * C1) + t * (C2 + s * C3)) + (t * t) * ((C4 + s * C5) + t * (C6 + s * C7))
    if s < LONG_SQUARED:
        value = 0.0
        for k in range(len(DEXPINV_QUADRATIC) - 1, -1, -1):
            value = value * s + DEXPINV_QUADRATIC[k]
        return value
    half = 0.5 * math.sqrt(s)
    return (1.0 - half / math.tan(half)) / s if s < math.inf else math.nan


@kernel
def chart_field(x: float, y: float, z: float, px: float, py: float, pz: float, inverse: Six) -> Six:
    """The slopes at a point β, π: β̇ = J_r(β)⁻¹ω with ω = M⁻¹π, and Euler's equations π̇ = π × ω."""
    xx, xy, xz, yy, yz, zz = inverse
    wx = xx * px + xy * py + xz * pz
    wy = xy * px + yy * py + yz * pz
    wz = xz * px + yz * py + zz * pz
    # β × ω, and with it β × (β × ω)
    cx = y * wz - z * wy
    cy = z * wx - x * wz
    cz = x * wy - y * wx
    c = dexpinv_quadratic(x * x + y * y + z * z)
    return (
        wx + 0.5 * cx + c * (y * cz - z * cy),
        wy + 0.5 * cy + c * (z * cx - x * cz),
        wz + 0.5 * cz + c * (x * cy - y * cx),
        py * wz - pz * wy,
        pz * wx - px * wz,
        px * wy - py * wx,
    )


@kernel
def increment(px: float, py: float, pz: float, h: float, constants: ChartConstants) -> Six:
    """The change h Σ bᵢkᵢ of β, which starts at 0, and of π, with slopes kᵢ at h aᵢ kᵢ₋₁ from the start."""
    k = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    total = k
    for before, own in constants.stages:
        x, y, z, dx, dy, dz = scaled(h * before, k)
        k = chart_field(x, y, z, px + dx, py + dy, pz + dz, constants.inverse_inertia)
        a, b, c, d, e, f = scaled(own, k)
        total = (total[0] + a, total[1] + b, total[2] + c, total[3] + d, total[4] + e, total[5] + f)
    return scaled(h, total)


@kernel
def scaled(factor: float, k: Six) -> Six:
    """Six numbers times a factor."""
    return factor * k[0], factor * k[1], factor * k[2], factor * k[3], factor * k[4], factor * k[5]


@kernel
def half_angle(s: float) -> tuple[float, float]:
    """The quotient sin(θ/2)/θ, and cos(θ/2), as functions of s = θ²."""
    if s < SHORT_SQUARED:
        t = s * s
        ratio = ((S0 + s * S1) + t * (S2 + s * S3)) + (t * t) * (S4 + s * S5)
        return ratio, math.sqrt(1.0 - s * ratio * ratio)
    theta = math.sqrt(s)
    return math.sin(0.5 * theta) / theta, math.cos(0.5 * theta)


kernel(product)


@kernel
def recentred(attitude: Four, beta: Three) -> Four:
    """The next centre A₀ exp(hat(β)), as q ⊗ (β sin(θ/2)/θ, cos(θ/2)), brought to unit norm by one Newton step."""
    a, b, c = beta
    ratio, cosine = half_angle(a * a + b * b + c * c)
    p, q, r, s = product(attitude, (ratio * a, ratio * b, ratio * c, cosine))
    # 1/|q| = 1 − ½(|q|² − 1) + O((|q|² − 1)²)
    scale = 1.5 - 0.5 * (p * p + q * q + r * r + s * s)
    return scale * p, scale * q, scale * r, scale * s


@kernel
def take_munthe_kaas_steps(state: ChartState, constants: ChartConstants, h: float, count: int) -> ChartState:
    """The state after a number of steps, or one whose attitude is nan where they lead to infinity."""
    attitude = state.attitude
    px, py, pz = state.momentum
    for _ in range(count):
        a, b, c, d, e, f = increment(px, py, pz, h, constants)
        px = px + d
        py = py + e
        pz = pz + f
        if not math.isfinite(px + py + pz + (a * a + b * b + c * c)):
            attitude = (math.nan, math.nan, math.nan, math.nan)
            break
        attitude = recentred(attitude, (a, b, c))
    return ChartState(attitude, (px, py, pz))


def advance(
    state: ChartState, constants: ChartConstants, spans: Any, counts: Any, takes: Any, out: Any
) -> tuple[Four, Three]:
    """Step through the samples, and give attitude and momentum at each as a row of ``out``; see `StepLoop`."""
    for i in range(len(spans)):
        if counts[i] > 0 and not math.isnan(state.attitude[0]):
            state = take_munthe_kaas_steps(state, constants, 1e-9 * spans[i] / counts[i], takes[i])
        for j in range(4):
            out[i, j] = state.attitude[j]
        for j in range(3):
            out[i, 4 + j] = state.momentum[j]
    return state.attitude, state.momentum
