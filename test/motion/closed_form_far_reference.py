"""Torque-free motion after very many turns: whole periods by mpmath's elliptic integrals, the rest by Taylor series.

After n periods the body rate is what it was, and the attitude has turned by n Δφ about the momentum, Δφ being the
growth of the precession angle of the axis that the momentum circles, φ′ = l (2H − I₃ω₃²)/(l² − I₃²ω₃²) (L. D. Landau,
E. M. Lifshitz, Mechanics, §37). The other Euler angle along the way grows by a whole turn, a sign of the quaternion.
"""

from __future__ import annotations

import math
from decimal import Decimal
from functools import cache
from typing import NamedTuple

import numpy as np
from closed_form_reference import Reference, carried, context, dot, inverse, moved, multiply, norm
from mpmath import mp, mpf


class Polhode(NamedTuple):
    """The moments of inertia, the third about the axis that the momentum circles, with 2H, l² and 1 − m."""

    moments: tuple[mpf, mpf, mpf]
    energy: mpf
    square: mpf
    m1: mpf


class Course(NamedTuple):
    """Period in s, growth of the precession angle over it, and 1 − m; the first two infinite on the separatrix."""

    period: mpf
    growth: mpf
    m1: mpf


def digits_for(inertia, rate) -> int:
    sizes = np.log10(np.abs([x for x in [*np.ravel(inertia), *rate] if x]))
    return 80 + 6 * int(np.ptp(sizes) + 1)


def moments_of(inertia) -> list[mpf]:
    if np.array_equal(inertia, np.diag(np.diag(inertia))):
        return [mpf(float(x)) for x in np.sort(np.diag(inertia))]
    return sorted(mp.eigsy(mp.matrix(np.asarray(inertia).tolist()), eigvals_only=True))


def momentum_of(inertia, rate) -> list[mpf]:
    return [sum(mpf(float(x)) * mpf(float(w)) for x, w in zip(row, rate, strict=True)) for row in inertia]


def polhode_of(inertia, rate) -> Polhode:
    """The polhode of a motion that is not steady, in the digits in force."""
    momentum = momentum_of(inertia, rate)
    energy = sum(p * mpf(float(w)) for p, w in zip(momentum, rate, strict=True))
    square = sum(p * p for p in momentum)
    j1, j2, j3 = moments_of(inertia)
    if square < energy * j2:
        j1, j3 = j3, j1
    m1 = (j3 - j1) * (square - energy * j2) / ((j3 - j2) * (square - energy * j1))
    return Polhode((j1, j2, j3), energy, square, m1)


def course_of(inertia, rate) -> Course:
    """The course of a motion that is not steady, in the digits in force."""
    return _course(tuple(map(tuple, np.asarray(inertia, dtype=float).tolist())), tuple(map(float, rate)), mp.prec)


@cache
def _course(inertia, rate, _: int) -> Course:
    (j1, j2, j3), energy, square, m1 = polhode_of(inertia, rate)
    if m1 == 0:
        return Course(mp.inf, mp.inf, m1)
    m = (j2 - j1) * (energy * j3 - square) / ((j3 - j2) * (square - energy * j1))
    w3 = (square - energy * j1) / (j3 * (j3 - j1))
    across, below = energy - j3 * w3, square - j3 * j3 * w3
    # K by the complementary parameter, as 1 − m may be 1e-300
    k, third = mp.pi / (2 * mp.agm(1, mp.sqrt(m1))), mp.ellippi(-j3 * j3 * w3 * m / below, m)
    period = 4 * k / mp.sqrt((j3 - j2) * (square - energy * j1) / (j1 * j2 * j3))
    mean = mp.sqrt(square) * (1 / j3 + (across / below - 1 / j3) * third / k)
    return Course(period, mean * period, m1)


def turned(attitude, axis, angle):
    """exp of this rotation in the world, then the attitude, as decimals."""
    size = mp.sqrt(sum(x * x for x in axis))
    turn = [*(x / size * mp.sin(angle / 2) for x in axis), mp.cos(angle / 2)]
    return multiply([decimal(x) for x in turn], [decimal(x) for x in attitude])


def decimal(x) -> Decimal:
    return Decimal(mp.nstr(x, 45, strip_zeros=False))


def world_momentum(inertia, attitude, rate):
    # of a quaternion whose norm is 1 only to round-off, which would be 1e-6 rad after 1e10
    size = mp.sqrt(sum(mpf(float(c)) ** 2 for c in attitude))
    x, y, z, w = (mpf(float(c)) / size for c in attitude)
    vx, vy, vz = momentum_of(inertia, rate)
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx]


def far_time(inertia, rate, angle: float, rest: float) -> int:
    """A time near this angle over |ω|, past the end of a period by another such angle; at most 2⁶³ ns."""
    with mp.workdps(digits_for(inertia, rate)):
        speed, period = mp.sqrt(sum(mpf(float(w)) ** 2 for w in rate)), course_of(inertia, rate).period
        most = min(angle / speed, mpf(2**63 - 1) / 10**9 - abs(rest) / speed)
        endless = math.isinf(period) or nearly_spherical(inertia)
        whole = most if endless else mp.floor(most / period) * period
        return max(min(int((whole + rest / speed) * 10**9), 2**63 - 1), 1)


def far_reference(inertia, attitude, rate, t_ns: int) -> Reference:
    """The state of a motion that is not steady, at any time."""
    with mp.workdps(digits_for(inertia, rate)), context():
        period, growth, _ = course_of(inertia, rate)
        seconds, m = mpf(t_ns) / 10**9, [[Decimal(float(x)) for x in row] for row in np.asarray(inertia)]
        w, axis = [Decimal(float(x)) for x in rate], world_momentum(inertia, attitude, rate)
        q = [Decimal(float(x)) for x in attitude]
        if mp.isinf(period):
            return settled(m, q, w, axis, seconds)
        if nearly_spherical(inertia):
            return slowly_moved(m, q, w, axis, seconds)
        count = int(mp.nint(seconds / period))
        start = turned([mpf(float(x)) for x in attitude], axis, count * growth + 2 * mp.pi * (count % 2))
        return Reference(*moved(m, start, w, decimal(seconds - count * period)))


def nearly_spherical(inertia) -> bool:
    return float(np.linalg.cond(inertia)) < 1 + 1e-6


def slowly_moved(m, q, w, axis, seconds: mpf) -> Reference:
    """Nearly a sphere of moment J: a turn about the momentum l by lt/J, and what M⁻¹ − 1/J leaves of the motion."""
    j, inverse_m, p = m[0][0], inverse(m), [dot(row, w) for row in m]
    slow = [[x - (1 / j if i == k else 0) for k, x in enumerate(row)] for i, row in enumerate(inverse_m)]
    speed = norm([norm(row) for row in slow]) * norm(p)
    q, p = carried(slow, q, p, decimal(seconds), lambda _: speed)
    length = mp.sqrt(sum(x * x for x in axis))
    fast = turned([mpf(str(x)) for x in q], axis, length / mpf(str(j)) * seconds)
    return Reference(fast, [dot(row, p) for row in inverse_m])


def settled(m, q, w, axis, seconds: mpf) -> Reference:
    """On the separatrix: until the body spins about the middle axis to 1e-18 and less, and then that spin."""
    first = mp.sign(seconds) * 130 / mpf(str(max(abs(x) for x in w)))
    q, w = moved(m, q, w, decimal(first))
    middle = max(range(3), key=lambda i: abs(w[i]))
    spin = mp.sqrt(sum(x * x for x in axis)) / mpf(str(m[middle][middle]))
    return Reference(turned([mpf(str(x)) for x in q], axis, spin * (seconds - first)), w)
