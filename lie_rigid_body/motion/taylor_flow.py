"""The flow of Euler's equations and of the attitude over a short time, by Taylor series.

It shares no formula with the moving chart and the closed form, so that it can referee the steps of the one and the
samples of either.

Both equations are quadratic, π̇ = π × M⁻¹π and q̇ = ½ q⊗ω, so that their Taylor coefficients follow from one another by
Cauchy products. With the triangle inequality of the moments the n-th coefficient of ω is at most Ωⁿ⁺¹ for |ω| ≤ Ω,
which gives the number of terms: the series is summed until what is left is below round-off.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import RigidBody, State

LONGEST_TURN: Final = 32.0
"""Largest rotation angle, rad, over which the flow is followed."""

TURN_PER_SUBSTEP: Final = 0.25
"""Largest rotation angle in a substep, rad."""

_REMAINDER: Final = 1e-17
"""Largest remainder of the series, relative to its first term."""

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
    turn = rate_bound * (float(np.max(spans, initial=0.0)) if longest is None else longest)
    substeps = max(1, math.ceil(turn / TURN_PER_SUBSTEP))
    terms = _terms(turn / substeps)
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


def _terms(turn: float) -> int:
    """The number of terms: the n-th of the rate is at most Ω turnⁿ."""
    return 2 if turn == 0.0 else min(40, 2 + math.ceil(math.log(_REMAINDER) / math.log(turn)))


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
    return quaternion.normalize(_horner(attitudes, span).T).T, _horner(momenta, span)


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
