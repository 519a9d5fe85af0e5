"""The dimensionless motion of a body, and Taylor series of it with many digits."""

from __future__ import annotations

from mpmath import mp, mpf

from lie_rigid_body import RigidBody, State
from lie_rigid_body.motion.moser_veselov.principal_frame import CyclicFrame, DimensionlessMotion
from lie_rigid_body.motion.motion import exact_inertia


def dimensionless(body: RigidBody, start: State) -> DimensionlessMotion:
    return DimensionlessMotion.of(CyclicFrame.of(exact_inertia(body)), start.body_rate.tolist())


def exact_series(motion: DimensionlessMotion) -> tuple[list, list]:
    """Taylor coefficients of the momentum and the quaternion, by Euler's equations in the frame's units."""
    e = [mpf(str(v)) for v in motion.inverse_moments]
    m, q = [[mpf(str(v))] for v in motion.momentum], [[mpf(0)], [mpf(0)], [mpf(0)], [mpf(1)]]
    for n in range(60):
        # from the last to the first, so that a Cauchy product is a dot product
        w = [[e[j] * v for v in reversed(m[j])] for j in range(3)]
        torque = [mp.fdot(m[j - 2], w[j - 1]) - mp.fdot(m[j - 1], w[j - 2]) for j in range(3)]
        a, b, c, d = q
        turn = [
            mp.fdot(d, w[0]) + mp.fdot(b, w[2]) - mp.fdot(c, w[1]),
            mp.fdot(d, w[1]) + mp.fdot(c, w[0]) - mp.fdot(a, w[2]),
            mp.fdot(d, w[2]) + mp.fdot(a, w[1]) - mp.fdot(b, w[0]),
            -mp.fdot(a, w[0]) - mp.fdot(b, w[1]) - mp.fdot(c, w[2]),
        ]
        for part, rates, factor in ((m, torque, 1), (q, turn, 2)):
            for j, rate in enumerate(rates):
                part[j].append(rate / (factor * (n + 1)))
    return m, q


def exact_step(series: tuple[list, list], x: mpf) -> tuple[list, list]:
    """Momentum and quaternion after a time."""
    powers = [x**n for n in range(61)]
    m, q = ([mp.fdot(v, powers) for v in part] for part in series)
    return m, q


def off_the_step(motion: DimensionlessMotion, alpha: list, beta: list, series: tuple[list, list], x: mpf) -> mpf:
    """|ρ₀ρⱼ − (α + βeⱼ) m̄ⱼ| after a step x, with α and β as series of odd powers from x³ and x on."""
    a = sum(mpf(str(c)) * x ** (2 * k + 3) for k, c in enumerate(alpha))
    b = sum(mpf(str(c)) * x ** (2 * k + 1) for k, c in enumerate(beta))
    e, (after, q) = [mpf(str(v)) for v in motion.inverse_moments], exact_step(series, x)
    return mp.norm([q[3] * q[j] - (a + b * e[j]) * (series[0][j][0] + after[j]) / 2 for j in range(3)])
