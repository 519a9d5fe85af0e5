"""Runge–Kutta–Munthe-Kaas steps along Euler's equations and the equation of the chart, in plain numbers.

The attitude is a unit quaternion A₀, the chart about it A₀ exp(hat(β)). A step of length h starts at β = 0, takes β
and the body momentum π by a Runge–Kutta method along

    β̇ = J_r(β)⁻¹ M⁻¹π,     π̇ = π × M⁻¹π,     J_r(β)⁻¹ω = ω + ½ β × ω + c(θ) β × (β × ω),
    c(θ) = (1 − (θ/2) cot(θ/2))/θ²,     θ = |β|

and makes A₀ exp(hat(β)) the next centre (Iserles, Munthe-Kaas, Nørsett, Zanna, Acta Numerica 9 (2000), sec. 4.2 and
app. B).

Vectors of the loop

- state: the quaternion x y z w, scalar last, and the body momentum π₁ π₂ π₃, kg m²/s;
- constants: the upper triangle of M⁻¹ by rows, then for each Runge–Kutta stage the weight of the slope before it and
  its own weight in the sum.
"""

from __future__ import annotations

import math
from typing import Any, Final, TypeAlias

from lie_rigid_body.compilation import Loop, kernel
from lie_rigid_body.lie.series import DEXPINV_QUADRATIC, SERIES_LIMIT

Three: TypeAlias = tuple[float, float, float]
Six: TypeAlias = tuple[float, float, float, float, float, float]

ATTITUDE: Final = 0
MOMENTUM: Final = 4
STATE_SIZE: Final = 7
"""Places of x and π₁ in the state, and its size."""

INVERSE_INERTIA: Final = 0
STAGES: Final = 6
"""Places of the inverse inertia and of the first stage among the constants."""

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
def field_at_centre(px: float, py: float, pz: float, inverse: Six) -> Six:
    """The slopes at β = 0, where J_r = 1: ω = M⁻¹π, and Euler's equations π̇ = π × ω."""
    xx, xy, xz, yy, yz, zz = inverse
    wx = xx * px + xy * py + xz * pz
    wy = xy * px + yy * py + yz * pz
    wz = xz * px + yz * py + zz * pz
    return wx, wy, wz, py * wz - pz * wy, pz * wx - px * wz, px * wy - py * wx


@kernel
def chart_field(point: Six, inverse: Six) -> Six:
    """The slopes at a point β, π: β̇ = J_r(β)⁻¹ω, and Euler's equations π̇ = π × ω."""
    x, y, z, px, py, pz = point
    wx, wy, wz, tx, ty, tz = field_at_centre(px, py, pz, inverse)
    # β × ω, and with it β × (β × ω)
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
def increment(px: float, py: float, pz: float, h: float, inverse: Six, constants: Any) -> Six:
    """The change h Σ bᵢkᵢ of β, which starts at 0, and of π, with slopes kᵢ at h aᵢ kᵢ₋₁ from the start."""
    k = field_at_centre(px, py, pz, inverse)
    own = constants[STAGES + 1]
    a, b, c, d, e, f = own * k[0], own * k[1], own * k[2], own * k[3], own * k[4], own * k[5]
    for stage in range(STAGES + 2, len(constants), 2):
        before, own = h * constants[stage], constants[stage + 1]
        beta = before * k[0], before * k[1], before * k[2]
        k = chart_field((*beta, px + before * k[3], py + before * k[4], pz + before * k[5]), inverse)
        a, b, c = a + own * k[0], b + own * k[1], c + own * k[2]
        d, e, f = d + own * k[3], e + own * k[4], f + own * k[5]
    return h * a, h * b, h * c, h * d, h * e, h * f


@kernel
def half_angle(s: float) -> tuple[float, float]:
    """The quotient sin(θ/2)/θ, and cos(θ/2), as functions of s = θ²."""
    if s < SHORT_SQUARED:
        t = s * s
        ratio = ((S0 + s * S1) + t * (S2 + s * S3)) + (t * t) * (S4 + s * S5)
        return ratio, math.sqrt(1.0 - s * ratio * ratio)
    theta = math.sqrt(s)
    return math.sin(0.5 * theta) / theta, math.cos(0.5 * theta)


@kernel
def recentred(x: float, y: float, z: float, w: float, beta: Three) -> tuple[float, float, float, float]:
    """The next centre A₀ exp(hat(β)), as q ⊗ (β sin(θ/2)/θ, cos(θ/2)), brought to unit norm by one Newton step."""
    a, b, c = beta
    ratio, d = half_angle(a * a + b * b + c * c)
    a, b, c = ratio * a, ratio * b, ratio * c
    p, q = w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a
    r, s = w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c
    # 1/|q| = 1 − ½(|q|² − 1) + O((|q|² − 1)²)
    scale = 1.5 - 0.5 * (p * p + q * q + r * r + s * s)
    return scale * p, scale * q, scale * r, scale * s


@kernel
def take_munthe_kaas_steps(state: Any, constants: Any, h: float, count: int) -> None:
    """Move the state by a number of steps, or make its x nan where they lead to infinity."""
    x, y, z, w = state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3]
    px, py, pz = state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2]
    inverse = (
        constants[INVERSE_INERTIA], constants[INVERSE_INERTIA + 1], constants[INVERSE_INERTIA + 2],
        constants[INVERSE_INERTIA + 3], constants[INVERSE_INERTIA + 4], constants[INVERSE_INERTIA + 5],
    )  # fmt: skip
    for _ in range(count):
        a, b, c, d, e, f = increment(px, py, pz, h, inverse, constants)
        px, py, pz = px + d, py + e, pz + f
        if not math.isfinite(px + py + pz + (a * a + b * b + c * c)):
            x = math.nan
            break
        x, y, z, w = recentred(x, y, z, w, (a, b, c))
    state[ATTITUDE], state[ATTITUDE + 1], state[ATTITUDE + 2], state[ATTITUDE + 3] = x, y, z, w
    state[MOMENTUM], state[MOMENTUM + 1], state[MOMENTUM + 2] = px, py, pz


def advance(state: Any, constants: Any, spans: Any, counts: Any, takes: Any, out: Any) -> None:
    """Step through the samples, and give the state at each as a row of ``out``; see `compilation.Loop`."""
    for i in range(len(spans)):
        if counts[i] > 0 and not math.isnan(state[ATTITUDE]):
            take_munthe_kaas_steps(state, constants, 1e-9 * spans[i] / counts[i], takes[i])
        for j in range(STATE_SIZE):
            out[i, j] = state[j]


LOOP: Final = Loop(advance)
