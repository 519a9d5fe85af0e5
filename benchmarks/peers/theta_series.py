"""The free body by theta series in the nome, as R. van Zon and J. Schofield have it, written anew from their formulas.

Body rates are Jacobi's functions. The attitude is A(t) = T₁(t)ᵀ T₂(ψ) T₁(0) A(0) from the world to the body. T₁ takes
the momentum to the third axis by its own components. ψ is a phase in proportion to time less the argument of a theta
function at a complex place. J. Comput. Phys. 225 (2007) 145; the constants are A₁, A₂, q, ξ and η of that paper. Their
choices are kept: double precision, series until a term is below its spacing ε, at most ½ + ln ε/ln q terms, sines and
cosines of multiples by recursion. The loop is compiled with numba; the constants are computed in each run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from peers.compiled import compiled
from peers.contender import Contender
from peers.elliptic import EPSILON, amplitude, last_angle, means
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

Array = NDArray[np.float64]

MAX_TERMS: Final = 10_000


def contenders(task: Task) -> Iterator[Contender]:
    """One, exact: each instant from the start."""
    yield Contender("van Zon, Schofield", "exact", 0.0, lambda: attitudes(INERTIA, RATE, ATTITUDE, task.times_ns / NS))


def attitudes(inertia: Array, rate: Array, attitude_xyzw: Array, t_s: Array) -> Array:
    """Attitudes of a free body.

    Parameters
    ----------
    inertia : ndarray, shape (3,)
        Principal moments, kg m², ascending and all different.
    rate : ndarray, shape (3,)
        In the body's axes at the start, rad/s; about no axis alone.
    attitude_xyzw : ndarray, shape (4,)
        At the start.
    t_s : ndarray, shape (N,)
        Since the start, s.

    Returns
    -------
    ndarray, shape (N, 4)
        xyzw.
    """
    to_body = Rotation.from_quat(attitude_xyzw).as_matrix().T
    if rate @ (inertia * rate) * inertia[1] > (inertia * rate) @ (inertia * rate):
        # the momentum circles about the smallest moment: a half turn that exchanges the first and the third axis
        exchange = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
        found = exchange @ _to_body(inertia[::-1].copy(), exchange @ rate, exchange @ to_body, t_s)
    else:
        found = _to_body(inertia, rate, to_body, t_s)
    return Rotation.from_matrix(found.transpose(0, 2, 1)).as_quat()


@compiled
def _to_body(inertia: Array, rate: Array, start: Array, t_s: Array) -> Array:
    """A(t), shape (N, 3, 3), for moments in Jacobi's order: the momentum circles about the third axis."""
    I1, I2, I3 = inertia
    momentum = inertia * rate
    L2 = (momentum * momentum).sum()
    twice_energy = (momentum * rate).sum()
    L = math.sqrt(L2)

    # body rates: ω₁ cn, ω₂ sn, ω₃ dn of ωₚt + ε
    over, under = L2 - twice_energy * I3, L2 - twice_energy * I1
    sign1, sign3 = math.copysign(1.0, rate[0]), math.copysign(1.0, rate[2])
    rate1 = sign1 * math.sqrt(over / (I1 * (I1 - I3)))
    rate2 = -sign1 * math.sqrt(over / (I2 * (I2 - I3)))
    rate3 = sign3 * math.sqrt(under / (I3 * (I3 - I1)))
    frequency = math.copysign(1.0, I2 - I3) * sign3 * math.sqrt(under * (I3 - I2) / (I1 * I2 * I3))
    m = over * (I1 - I2) / (under * (I3 - I2))
    a, b, c, n = means(m)
    complementary_a, complementary_b, _, complementary_n = means(1.0 - m)
    scale = 2.0**n * a[n]
    K = 0.5 * math.pi / a[n]
    other_K = 0.5 * math.pi / complementary_a[complementary_n]
    begin = last_angle(math.atan2(rate[1] / rate2, rate[0] / rate1), a, b, n) / scale

    # the phase's constants
    q = math.exp(-math.pi * other_K / K)
    leaning = last_angle(math.asin(I3 * rate3 / L), complementary_a, complementary_b, complementary_n)
    eta = sign3 * other_K - leaning / (2.0**complementary_n * complementary_a[complementary_n])
    xi = math.exp(math.pi * eta / K)
    unit = 0.5 * math.pi * frequency / K
    slope = L / I1 + unit * (xi + 1.0) / (xi - 1.0)
    for k in range(1, MAX_TERMS):
        power = q ** (2 * k)
        more = -2.0 * unit * power / (1.0 - power) * (xi**k - xi**-k)
        slope += more
        if abs(more) <= EPSILON * abs(slope):
            break
    count = 1 + int(math.log(EPSILON) / math.log(q) + 0.5)
    real, imaginary = np.zeros(count), np.zeros(count)
    for k in range(count):
        term = (-1.0) ** k * q ** (k * (k + 1))
        real[k] = term * (xi ** (k + 0.5) + xi ** -(k + 0.5))
        imaginary[k] = -term * (xi ** (k + 0.5) - xi ** -(k + 0.5))
        if abs(real[k]) < EPSILON and abs(imaginary[k]) < EPSILON:
            count = k
            break
    r, i = _theta(0.5 * math.pi * begin / K, real[:count], imaginary[:count])
    offset = math.atan2(i, r)

    to_momentum = _by_momentum(momentum, L) @ start
    found = np.empty((len(t_s), 3, 3))
    for row in range(len(t_s)):
        u = frequency * t_s[row] + begin
        phi = amplitude(scale * u, a, c, n)
        sn, cn = math.sin(phi), math.cos(phi)
        now = np.array([I1 * rate1 * cn, I2 * rate2 * sn, I3 * rate3 * math.sqrt(1.0 - m * sn * sn)])
        r, i = _theta(0.5 * math.pi * u / K, real[:count], imaginary[:count])
        psi = offset + slope * t_s[row] - math.atan2(i, r)
        turn = np.zeros((3, 3))
        turn[0, 0] = turn[1, 1] = math.cos(psi)
        turn[0, 1] = math.sin(psi)
        turn[1, 0] = -turn[0, 1]
        turn[2, 2] = 1.0
        found[row] = _by_momentum(now, L).T @ (turn @ to_momentum)
    return found


@compiled
def _theta(x: float, real: Array, imaginary: Array) -> tuple[float, float]:
    """Real and imaginary part of the series Σ real sin(2k + 1)x + i Σ imaginary cos(2k + 1)x."""
    s, c = math.sin(x), math.cos(x)
    s2, c2 = 2.0 * c * s, 2.0 * c * c - 1.0
    r, i = real[0] * s, imaginary[0] * c
    for k in range(1, len(real)):
        s, c = c2 * s + s2 * c, c2 * c - s2 * s
        r += real[k] * s
        i += imaginary[k] * c
    return r, i


@compiled
def _by_momentum(momentum: Array, L: float) -> Array:
    """T₁: the matrix that takes a momentum of length L to the third axis."""
    x, y, z = momentum
    across = math.hypot(x, y)
    return np.array(
        [
            [x * z / (L * across), y * z / (L * across), -across / L],
            [-y / across, x / across, 0.0],
            [x / L, y / L, z / L],
        ]
    )
