"""FRB, algorithm 903, written anew from its formulas: the free body by Legendre's integral of the third kind.

The momentum is Jacobi's, of unit length, (π_c, π₂, π_d) = (d_c cn, d₂ sn, ± d_d dn). It circles about the axis d, which
is the first or the third. The attitude is the rotation that takes the momentum to the axis c, and a rotation about that
axis by 2β:

    β = t/2I_c + (2E − 1/I_c)/(2ν(1 − d_c²)) (Π(φ, n | m) − d_c F₁),    n = d_c²/(d_c² − 1)

between the amplitudes at the start and at t, where F₁ is an arctangent. E. Celledoni, A. Zanna, "Algorithm 903: FRB",
ACM Trans. Math. Softw. 37 (2010) 23; E. Celledoni, F. Fassò, N. Säfström, A. Zanna, SIAM J. Sci. Comput. 30 (2008)
2084. Their choices are kept: double precision, Carlson's RF and RJ at their tolerances, Π by Gauss' quadrature instead
where an order is given, a normalised quaternion, and everything anew in each call. The loop is compiled with numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from peers.compiled import compiled
from peers.contender import Contender, step_text
from peers.elliptic import amplitude, last_angle, means, third_kind
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

Array = NDArray[np.float64]

POINTS: Final = 5
"""Of the quadrature in the examples that come with FRB; its order is twice that."""

STEPS: Final = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001)


def contenders(task: Task) -> Iterator[Contender]:
    """Exact, each instant from the start in one call; and with quadrature, in steps."""
    yield Contender("FRB, exact", "exact", 0.0, lambda: exact(INERTIA, INERTIA * RATE, ATTITUDE, task.times_ns / NS))
    for step in STEPS:
        if step <= task.smallest_interval:
            yield Contender("FRB, Gauss of order 10", step_text(step), step, _in_steps(task, step))


def exact(inertia: Array, momentum: Array, attitude_xyzw: Array, t_s: Array) -> Array:
    """Attitudes of a free body.

    Parameters
    ----------
    inertia : ndarray, shape (3,)
        Principal moments, kg m², ascending and all different.
    momentum : ndarray, shape (3,)
        In the body's axes at the start, kg m²/s; about no axis alone.
    attitude_xyzw : ndarray, shape (4,)
        At the start.
    t_s : ndarray, shape (N,)
        Since the start, s.

    Returns
    -------
    ndarray, shape (N, 4)
        xyzw.
    """
    return _each_from_the_start(inertia, momentum, attitude_xyzw, t_s, np.empty(0), np.empty(0))


def _in_steps(task: Task, step: float) -> Callable[[], Array]:
    counts = np.rint(np.diff(task.times_ns, prepend=0) / (NS * step)).astype(np.int64)

    def run() -> Array:
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        return _one_after_the_other(INERTIA, INERTIA * RATE, ATTITUDE, counts, step, nodes, weights)

    return run


@compiled
def _each_from_the_start(
    inertia: Array, momentum: Array, attitude_xyzw: Array, t_s: Array, nodes: Array, weights: Array
) -> Array:
    found = np.empty((len(t_s), 4))
    length = math.sqrt((momentum * momentum).sum())
    for i in range(len(t_s)):
        _, found[i] = _step(t_s[i] * length, inertia, momentum / length, attitude_xyzw, nodes, weights)
    return found


@compiled
def _one_after_the_other(
    inertia: Array,
    momentum: Array,
    attitude_xyzw: Array,
    counts: NDArray[np.int64],
    step: float,
    nodes: Array,
    weights: Array,
) -> Array:
    found = np.empty((len(counts), 4))
    length = math.sqrt((momentum * momentum).sum())
    pi, q = momentum / length, attitude_xyzw
    for i in range(len(counts)):
        for _ in range(counts[i]):
            pi, q = _step(step * length, inertia, pi, q, nodes, weights)
            # as in the driver of FRB's steps
            pi = pi / math.sqrt((pi * pi).sum())
        found[i] = q
    return found


@compiled
def _step(h: float, inertia: Array, pi: Array, q: Array, nodes: Array, weights: Array) -> tuple[Array, Array]:
    """The momentum, of unit length, and the attitude after a time h, in units of inertia over momentum."""
    I1, I2, I3 = inertia
    share1 = I1 * (I3 - I2) / (I2 * (I3 - I1))
    share3 = I3 * (I2 - I1) / (I2 * (I3 - I1))
    about3 = share3 * (pi[0] ** 2 + share1 * pi[1] ** 2) <= share1 * (pi[2] ** 2 + share3 * pi[1] ** 2)
    # the axes of cn and of dn, about which the momentum circles
    c, d = (0, 2) if about3 else (2, 0)
    share_c, share_d = (share1, share3) if about3 else (share3, share1)
    amplitude_c = math.sqrt(pi[c] ** 2 + share_c * pi[1] ** 2)
    amplitude_d = math.sqrt(pi[d] ** 2 + share_d * pi[1] ** 2)
    amplitude_2 = amplitude_c / math.sqrt(share_c)
    m = share_d / share_c * (amplitude_c / amplitude_d) ** 2
    nu = math.copysign(math.sqrt(share_c) * amplitude_d * (1.0 / I1 - 1.0 / I3), pi[d])

    # Jacobi's functions after h
    a, b, half, n = means(m)
    phi0 = math.atan2(pi[1] / amplitude_2, pi[c] / amplitude_c)
    phi1 = amplitude(last_angle(phi0, a, b, n) + 2.0**n * a[n] * nu * h, a, half, n)
    sn, cn = math.sin(phi1), math.cos(phi1)
    out = np.empty(3)
    out[c] = amplitude_c * cn
    out[1] = amplitude_2 * sn
    out[d] = math.copysign(math.sqrt(share_d * (pi[1] ** 2 - out[1] ** 2) + pi[d] ** 2), pi[d])

    # half of the angle about the axis c
    twice_energy = (pi * pi / inertia).sum()
    rest = 1.0 - amplitude_c**2
    characteristic = -(amplitude_c**2) / rest
    if len(nodes) == 0:
        third = third_kind(phi1, characteristic, m) - third_kind(phi0, characteristic, m)
    else:
        squared = np.sin(phi0 + 0.5 * (phi1 - phi0) * (1.0 + nodes)) ** 2
        values = weights / ((1.0 - characteristic * squared) * np.sqrt(1.0 - m * squared))
        third = 0.5 * (phi1 - phi0) * values.sum()
    slope = math.sqrt(m - characteristic)
    begin = math.atan(slope * pi[1] / amplitude_2 / (abs(pi[d]) / amplitude_d))
    end = math.atan(slope * sn / math.sqrt(1.0 - m * sn * sn))
    factor = (twice_energy - 1.0 / inertia[c]) / (2.0 * nu * rest)
    beta = h / (2.0 * inertia[c]) + factor * (third - amplitude_c * (end - begin) / slope)

    about = np.zeros(4)
    about[c], about[3] = math.sin(beta), math.cos(beta)
    to_axis, from_axis = _to_axis(out, c), _to_axis(pi, c)
    from_axis[:3] *= -1.0
    made = _product(_product(q, from_axis), _product(about, to_axis))
    return out, made / math.sqrt((made * made).sum())


@compiled
def _to_axis(pi: Array, c: int) -> Array:
    """The shortest rotation that takes a unit vector to the first or third axis, xyzw."""
    w = math.sqrt(0.5 * (1.0 + pi[c]))
    found = np.zeros(4)
    if c == 0:
        found[1], found[2] = pi[2] / (2.0 * w), -pi[1] / (2.0 * w)
    else:
        found[0], found[1] = pi[1] / (2.0 * w), -pi[0] / (2.0 * w)
    found[3] = w
    return found


@compiled
def _product(p: Array, q: Array) -> Array:
    """Hamilton's product, xyzw."""
    found = np.empty(4)
    found[0] = p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1]
    found[1] = p[3] * q[1] + p[1] * q[3] + p[2] * q[0] - p[0] * q[2]
    found[2] = p[3] * q[2] + p[2] * q[3] + p[0] * q[1] - p[1] * q[0]
    found[3] = p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2]
    return found
