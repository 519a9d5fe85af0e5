"""The flow of Euler's equations and of the attitude over a short time, by Taylor series.

It shares no formula with the moving chart and the closed form, so that it can referee the steps of the one and the
samples of either.

Both equations are quadratic, π̇ = π × M⁻¹π and q̇ = ½ q⊗ω, so that their Taylor coefficients follow from one another by
Cauchy products. With the triangle inequality of the moments the n-th coefficient of ω is at most Ωⁿ⁺¹ for |ω| ≤ Ω,
which gives the number of terms: the series is summed until what is left is below round-off.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from lie_rigid_body.arithmetic.numbers import Quadruple, Triple, sqrt
from lie_rigid_body.arrays import Array
from lie_rigid_body.compilation import kernel
from lie_rigid_body.mechanics import RigidBody, State

LONGEST_TURN: Final = 32.0
"""Largest rotation angle, rad, over which the flow is followed."""

TURN_PER_SUBSTEP: Final = 0.25
"""Largest rotation angle in a substep, rad."""

_REMAINDER: Final = 1e-17
"""Largest remainder of the series, relative to its first term."""

_MOST_TERMS: Final = 40

WORK_AREA: Final = 10 * (_MOST_TERMS + 1)
"""Length of the array in which `follow` works."""

_BLOCK: Final = 4096
"""States whose coefficients fit into a processor's cache together."""


def flow(body: RigidBody, states: State, spans: Array, rate_bound: float, longest: float | None = None) -> State:
    """The states a time span later.

    Parameters
    ----------
    body : RigidBody
    states : State
        Of shapes (N, 4) and (N, 3).
    spans : ndarray, shape (N,)
        Time to go, s; not negative.
    rate_bound : float
        Bound of the body rate, rad/s.
    longest : float, optional
        The longest span, s, of all calls that are to give the same bits: it decides on substeps and terms.

    Returns
    -------
    State
        Attitudes on the continuous path from the given ones, so with the sign that continuity asks for.
    """
    longest = float(np.max(spans, initial=0.0)) if longest is None else longest
    substeps, terms = substeps_and_terms(rate_bound * longest)
    # components in rows: each operation then runs along memory
    attitude, momentum = (np.array(v.T, order="C") for v in (states.attitude_xyzw, body.body_momentum(states)))
    for first in range(0, len(spans), _BLOCK):
        block = slice(first, first + _BLOCK)
        for _ in range(substeps):
            attitude[:, block], momentum[:, block] = _substep(
                body, attitude[:, block], momentum[:, block], spans[block] / substeps, terms
            )
    return State.trusted(
        np.ascontiguousarray(attitude.T), np.ascontiguousarray(_apply(body.inverse_inertia, momentum).T)
    )


def substeps_and_terms(turn: float) -> tuple[int, int]:
    """The number of substeps over a turn, rad, and of terms in each."""
    substeps = max(1, math.ceil(turn / TURN_PER_SUBSTEP))
    return substeps, _terms(turn / substeps)


def _terms(turn: float) -> int:
    """The number of terms: the n-th of the rate is at most Ω turnⁿ."""
    return 2 if turn == 0.0 else min(_MOST_TERMS, 1 + math.ceil(math.log(_REMAINDER) / math.log(turn)))


def _substep(body: RigidBody, q: Array, p: Array, span: Array, terms: int) -> tuple[Array, Array]:
    """Attitude q, shape (4, N), and body momentum p, shape (3, N), a span later, normalised."""
    momenta, attitudes = [p], [q]
    rates = [_apply(body.inverse_inertia, p)]
    for n in range(terms):
        # (n + 1) π₍ₙ₊₁₎ = Σ πᵢ × ωₙ₋ᵢ and (n + 1) q₍ₙ₊₁₎ = ½ Σ qᵢ ⊗ ωₙ₋ᵢ
        dp, dq = np.zeros_like(p), np.zeros_like(q)
        for i in range(n + 1):
            _add_cross(dp, momenta[i], rates[n - i])
            _add_times_vector(dq, attitudes[i], rates[n - i])
        momenta.append(dp / (n + 1))
        attitudes.append(0.5 * dq / (n + 1))
        rates.append(_apply(body.inverse_inertia, momenta[-1]))
    q = _horner(attitudes, span)
    return q / np.sqrt((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3])), _horner(momenta, span)


@kernel
def follow(work: Any, inverse: Any, q: Quadruple, p: Triple, span: float, terms: int) -> tuple[Quadruple, Triple]:
    """Attitude and body momentum of one state a span later, normalised: `_substep` compiled, to the same bits.

    Parameters
    ----------
    work : ndarray, shape (WORK_AREA,)
        To keep coefficients in: of each order momentum, rate and attitude.
    inverse : ndarray, shape (9,)
        Of the inertia, row by row.
    q, p, span, terms
        As of `_substep`.
    """
    for k in range(3):
        work[k] = p[k]
    for k in range(4):
        work[6 + k] = q[k]
    for n in range(terms + 1):
        at = 10 * n
        for k in range(3):
            work[at + 3 + k] = (
                work[at] * inverse[3 * k] + work[at + 1] * inverse[3 * k + 1] + work[at + 2] * inverse[3 * k + 2]
            )
        if n == terms:
            break
        px = py = pz = qx = qy = qz = qw = 0.0
        for i in range(n + 1):
            m, r = 10 * i, 10 * (n - i) + 3
            a, b, c = work[r], work[r + 1], work[r + 2]
            px += work[m + 1] * c - work[m + 2] * b
            py += work[m + 2] * a - work[m] * c
            pz += work[m] * b - work[m + 1] * a
            x, y, z, w = work[m + 6], work[m + 7], work[m + 8], work[m + 9]
            qx += w * a + y * c - z * b
            qy += w * b + z * a - x * c
            qz += w * c + x * b - y * a
            qw += -(x * a + y * b + z * c)
        at += 10
        work[at], work[at + 1], work[at + 2] = px / (n + 1), py / (n + 1), pz / (n + 1)
        work[at + 6], work[at + 7] = 0.5 * qx / (n + 1), 0.5 * qy / (n + 1)
        work[at + 8], work[at + 9] = 0.5 * qz / (n + 1), 0.5 * qw / (n + 1)
    for n in range(terms - 1, -1, -1):
        for k in range(10):
            work[10 * terms + k] = work[10 * terms + k] * span + work[10 * n + k]
    at = 10 * terms
    x, y, z, w = work[at + 6], work[at + 7], work[at + 8], work[at + 9]
    size = sqrt((x * x + y * y) + (z * z + w * w))
    return (x / size, y / size, z / size, w / size), (work[at], work[at + 1], work[at + 2])


def _apply(tensor: Array, vectors: Array) -> Array:
    """The product of a tensor with vectors, shape (3, N)."""
    x, y, z = vectors
    return np.stack([x * row[0] + y * row[1] + z * row[2] for row in tensor])


def _horner(coefficients: list[Array], x: Array) -> Array:
    """The polynomial of these coefficients, the constant one first, at x of shape (N,)."""
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value


def _add_cross(to: Array, a: Array, b: Array) -> None:
    ax, ay, az = a
    bx, by, bz = b
    to[0] += ay * bz - az * by
    to[1] += az * bx - ax * bz
    to[2] += ax * by - ay * bx


def _add_times_vector(to: Array, q: Array, v: Array) -> None:
    """Add the product of a quaternion with a pure one."""
    x, y, z, w = q
    a, b, c = v
    to[0] += w * a + y * c - z * b
    to[1] += w * b + z * a - x * c
    to[2] += w * c + x * b - y * a
    to[3] += -(x * a + y * b + z * c)
