"""Torque-free motion by Taylor series in decimal arithmetic: an independent reference for the closed form.

It integrates M ω′ = Mω × ω and q′ = ½ q ⊗ ω in the body frame, with 45 digits, order 36 and steps of a quarter radian,
and knows nothing of principal axes, regimes or elliptic functions. Its quaternion is the continuous lift.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, localcontext
from typing import NamedTuple

import numpy as np

ORDER = 36
STEP = Decimal("0.25")


class Reference(NamedTuple):
    attitude_xyzw: list[Decimal]
    body_rate: list[Decimal]


def context():
    return localcontext(Context(prec=45, Emax=MAX_EMAX, Emin=MIN_EMIN))


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), Decimal(0))


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
    """Taylor coefficients of q, Mω at a state, by the recurrences of the two equations."""
    w, p, q = [[dot(row, momentum) for row in inverse_m]], [momentum], [attitude]
    for k in range(ORDER):
        torque = [Decimal(0)] * 3
        turn = [Decimal(0)] * 4
        for j in range(k + 1):
            (a, b, c), (x, y, z) = p[j], w[k - j]
            torque = [torque[0] + b * z - c * y, torque[1] + c * x - a * z, torque[2] + a * y - b * x]
            turn = [s + t for s, t in zip(turn, multiply(q[j], [*w[k - j], Decimal(0)]), strict=True)]
        p.append([t / (k + 1) for t in torque])
        w.append([dot(row, p[-1]) for row in inverse_m])
        q.append([t / (2 * (k + 1)) for t in turn])
    return q, p


def horner(coefficients, h):
    value = coefficients[-1]
    for row in reversed(coefficients[:-1]):
        value = [v * h + c for v, c in zip(value, row, strict=True)]
    return value


def carried(inverse_m, q, p, seconds: Decimal, speed: Decimal):
    """The attitude and momentum of q′ = ½ q ⊗ ω, p′ = p × ω with ω = M⁻¹p this much later."""
    step, now = STEP / speed if speed else Decimal(1), Decimal(0)
    while now != seconds:
        h = max(min(seconds - now, step), -step)
        qs, ps = series(inverse_m, q, p)
        q, p, now = horner(qs, h), horner(ps, h), now + h
    return q, p


def moved(m, q, w, seconds: Decimal):
    """The state q, ω this much later, in the context in force."""
    inverse_m, p = inverse(m), [dot(row, w) for row in m]
    # by the triangle inequality of the moments |ω′| ≤ |ω|², and |ω| stays within the ratio of the moments
    q, p = carried(inverse_m, q, p, seconds, norm(w))
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
