"""Torque-free motion by Taylor series in decimal arithmetic: an independent reference for the closed form.

It integrates M ω′ = Mω × ω and q′ = ½ q ⊗ ω in the body frame, with 45 digits, order 22 and steps of a quarter radian,
and knows nothing of principal axes, regimes or elliptic functions. Its quaternion is the continuous lift.

By the triangle inequality of the moments |ωᵢ′| ≤ |ωⱼωₖ|, so |ω′| ≤ |ω|²/√3: the series converges for √3/|ω|, and what a
step leaves out is at most some (0.25/√3)²³ = 5e-20.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, localcontext
from operator import mul
from typing import NamedTuple

import numpy as np

ORDER = 22
STEP = Decimal("0.25")


class Reference(NamedTuple):
    attitude_xyzw: list[Decimal]
    body_rate: list[Decimal]


def context():
    return localcontext(Context(prec=45, Emax=MAX_EMAX, Emin=MIN_EMIN))


def dot(a, b):
    return sum(map(mul, a, b), Decimal(0))


def norm(a):
    return dot(a, a).sqrt()


def multiply(p, q):
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return [
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    ]


def inverse(m):
    (a, b, c), (_, d, e), (_, _, f) = m
    cofactors = [
        [d * f - e * e, c * e - b * f, b * e - c * d],
        [c * e - b * f, a * f - c * c, b * c - a * e],
        [b * e - c * d, b * c - a * e, a * d - b * b],
    ]
    determinant = a * cofactors[0][0] + b * cofactors[0][1] + c * cofactors[0][2]
    return [[x / determinant for x in row] for row in cofactors]


def series(inverse_m, attitude, momentum):
    """Taylor coefficients of q, Mω at a state, by the recurrences of the two equations.

    Each component is a list of its own, and those of ω begin with the last, so that a Cauchy product is a dot product.
    """
    q, p = [[x] for x in attitude], [[x] for x in momentum]
    x, y, z, s = q
    a, b, c = p
    u, v, w = ([dot(row, momentum)] for row in inverse_m)
    for k in range(1, ORDER + 1):
        torque = dot(b, w) - dot(c, v), dot(c, u) - dot(a, w), dot(a, v) - dot(b, u)
        turn = (
            dot(s, u) + dot(y, w) - dot(z, v),
            dot(s, v) + dot(z, u) - dot(x, w),
            dot(s, w) + dot(x, v) - dot(y, u),
            -dot(x, u) - dot(y, v) - dot(z, w),
        )
        for component, rate in zip(p, torque, strict=True):
            component.append(rate / k)
        for component, rate in zip(q, turn, strict=True):
            component.append(rate / (2 * k))
        for component, row in zip((u, v, w), inverse_m, strict=True):
            component.insert(0, dot(row, (a[-1], b[-1], c[-1])))
    return q, p


def horner(coefficients, h):
    value = Decimal(0)
    for c in reversed(coefficients):
        value = value * h + c
    return value


def carried(inverse_m, q, p, seconds: Decimal, speed):
    """The attitude and momentum of q′ = ½ q ⊗ ω, p′ = p × ω with ω = M⁻¹p this much later.

    A step is a quarter over `speed(p)`.
    """
    now = Decimal(0)
    while now != seconds:
        step = STEP / (speed(p) or 1)
        h = max(min(seconds - now, step), -step)
        qs, ps = series(inverse_m, q, p)
        q, p, now = [horner(c, h) for c in qs], [horner(c, h) for c in ps], now + h
    return q, p


def moved(m, q, w, seconds: Decimal):
    """The state q, ω this much later, in the context in force."""
    inverse_m, p = inverse(m), [dot(row, w) for row in m]
    q, p = carried(inverse_m, q, p, seconds, lambda p: norm([dot(row, p) for row in inverse_m]))
    return q, [dot(row, p) for row in inverse_m]


def reference(inertia, attitude, rate, t_ns: Sequence[int]) -> list[Reference]:
    """The states at times of one sign, in order of growing size."""
    with context():
        m = [[Decimal(float(x)) for x in row] for row in np.asarray(inertia)]
        q, w = [Decimal(float(x)) for x in attitude], [Decimal(float(x)) for x in rate]
        now, states = Decimal(0), []
        for goal in (Decimal(int(t)).scaleb(-9) for t in t_ns):
            q, w = moved(m, q, w, goal - now)
            now = goal
            states.append(Reference(q, w))
        return states


def attitude_error(truth: Sequence[Decimal], attitude_xyzw) -> float:
    """Angle in rad from the truth, on the double cover: near 2π where the sign is wrong."""
    with context():
        x, y, z, w = truth
        *vector, scalar = multiply([-x, -y, -z, w], [Decimal(float(c)) for c in attitude_xyzw])
        return float(4 - 2 * norm(vector)) if scalar < 0 else float(2 * norm(vector))


def rate_error(truth: Sequence[Decimal], body_rate) -> float:
    """Error relative to the norm of the truth."""
    with context():
        difference = [x - Decimal(float(y)) for x, y in zip(truth, body_rate, strict=True)]
        return float(norm(difference) / norm(truth)) if any(truth) else float(norm(difference))
