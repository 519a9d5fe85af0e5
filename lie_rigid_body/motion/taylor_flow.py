"""The flow of Euler's equations and of the attitude over a short time, by Taylor series.

It shares no formula with the moving chart and the closed form, so that it can referee the steps of the one and the
samples of either.

Both equations are quadratic, π̇ = π × M⁻¹π and q̇ = ½ q⊗ω, so that their Taylor coefficients follow from one another by
Cauchy products. With the triangle inequality of the moments the n-th coefficient of ω is at most Ωⁿ⁺¹ for |ω| ≤ Ω,
which gives the number of terms. The series is summed until what is left is below round-off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.polynomial.polynomial import polyval

from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, quadruple, sqrt, triple
from lie_rigid_body.compilation import kernel
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.mechanics import RigidBody, State

LONGEST_TURN: Final = 32.0
"""Largest rotation angle, rad, over which `flow` may be asked for."""

TURN_PER_SUBSTEP: Final = 0.25
"""Largest rotation angle in a substep, rad."""

_REMAINDER: Final = 1e-17
"""Largest remainder of the series, relative to its first term."""

_MOST_TERMS: Final = 40

ABREAST: Final = 32
"""States that compiled code follows together, as a processor computes several at a time. Their coefficients fit into
its nearest cache."""
_Q: Final = 6
"""Column where an attitude begins, behind momentum and rate."""
_ORDER: Final = 10 * ABREAST
_SUMS: Final = _ORDER * (_MOST_TERMS + 1)
FLOW_AREA: Final = _SUMS + 7 * ABREAST
"""Length of the array in which `follow` works."""

_BLOCK: Final = 4096
"""States whose coefficients fit into a processor's cache together."""


def flow(body: RigidBody, states: State, spans: Array, rate_bound: float, longest: float | None = None) -> State:
    """States a time span later, by Taylor series.

    Parameters
    ----------
    body : RigidBody
    states : State
        Shapes (N, 4) and (N, 3).
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
        sums = np.zeros((7, len(span)))
        for i in range(n + 1):
            rate, momentum = triple(list(rates[n - i]), 0), triple(list(momenta[i]), 0)
            products = (*crossed(momentum, rate), *times_vector(quadruple(list(attitudes[i]), 0), rate))
            for total, product in zip(sums, products, strict=True):
                total += product
        momenta.append(sums[:3] / (n + 1))
        attitudes.append(0.5 * sums[3:] / (n + 1))
        rates.append(_apply(body.inverse_inertia, momenta[-1]))
    q, p = (np.asarray(polyval(span, np.stack(series), tensor=False), float) for series in (attitudes, momenta))
    return q / np.sqrt((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3])), p


@kernel
def column_triple(columns: Any, k: int, j: int) -> tuple[float, float, float]:
    """Number j of three columns from the k-th on."""
    return columns[k * ABREAST + j], columns[(k + 1) * ABREAST + j], columns[(k + 2) * ABREAST + j]


@kernel
def column_quadruple(columns: Any, k: int, j: int) -> tuple[float, float, float, float]:
    """Number j of four columns from the k-th on."""
    x, y, z = column_triple(columns, k, j)
    return x, y, z, columns[(k + 3) * ABREAST + j]


@kernel
def put_columns(columns: Any, k: int, j: int, numbers: Sequence[Number]) -> None:
    """Put numbers into place j of columns from the k-th on."""
    for n in range(len(numbers)):
        columns[(k + n) * ABREAST + j] = numbers[n]


@kernel
def follow(work: Any, inverse: Sequence[Number], spans: Any, terms: int) -> None:
    """Move `ABREAST` states a span on, normalised: `_substep` compiled, to the same bits.

    Parameters
    ----------
    work : ndarray, shape (FLOW_AREA,)
        Columns of `ABREAST` numbers: of each order momentum, rate and attitude. Those of order 0 are moved.
    inverse : tuple of float, length 9
        Entries of the inverse inertia, row by row.
    spans : ndarray, shape (ABREAST,)
        s
    terms : int
    """
    for n in range(terms):
        _add_order(work, inverse, n)
    value = work[terms * _ORDER : (terms + 1) * _ORDER]
    for n in range(terms - 1, -1, -1):
        here = work[n * _ORDER : (n + 1) * _ORDER]
        for j in range(ABREAST):
            for k in range(10):
                value[k * ABREAST + j] = value[k * ABREAST + j] * spans[j] + here[k * ABREAST + j]
    for j in range(ABREAST):
        x, y, z, w = column_quadruple(value, _Q, j)
        size = sqrt((x * x + y * y) + (z * z + w * w))
        put_columns(work, 0, j, column_triple(value, 0, j))
        put_columns(work, _Q, j, (x / size, y / size, z / size, w / size))


@kernel
def _add_order(work: Any, inverse: Sequence[Number], n: int) -> None:
    """The rates of order n, and momenta and attitudes of the next."""
    here, later = work[n * _ORDER : (n + 1) * _ORDER], work[(n + 1) * _ORDER : (n + 2) * _ORDER]
    sums = work[_SUMS:FLOW_AREA]
    for j in range(ABREAST):
        x, y, z = column_triple(here, 0, j)
        for k in range(3):
            here[(3 + k) * ABREAST + j] = x * inverse[3 * k] + y * inverse[3 * k + 1] + z * inverse[3 * k + 2]
    for j in range(7 * ABREAST):
        sums[j] = 0.0
    for i in range(n + 1):
        _add_products(sums, work[i * _ORDER : (i + 1) * _ORDER], work[(n - i) * _ORDER : (n - i + 1) * _ORDER])
    for j in range(3 * ABREAST):
        later[j] = sums[j] / (n + 1)
    for j in range(4 * ABREAST):
        later[_Q * ABREAST + j] = 0.5 * sums[3 * ABREAST + j] / (n + 1)


@kernel
def _add_products(sums: Any, one: Any, other: Any) -> None:
    """Add the products of momenta and attitudes of one order with rates of another."""
    for j in range(ABREAST):
        rate = column_triple(other, 3, j)
        products = (*crossed(column_triple(one, 0, j), rate), *times_vector(column_quadruple(one, _Q, j), rate))
        for k in range(7):
            sums[k * ABREAST + j] += products[k]


@kernel
def crossed(a: Triple, b: Triple) -> Triple:
    """The vector product a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def times_vector(q: Quadruple, v: Triple) -> Quadruple:
    """The product of a quaternion with a pure one."""
    x, y, z, w = q
    a, b, c = v
    return w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -(x * a + y * b + z * c)


def _apply(tensor: Array, vectors: Array) -> Array:
    """The product of a tensor with vectors, shape (3, N)."""
    x, y, z = vectors
    return np.stack([x * row[0] + y * row[1] + z * row[2] for row in tensor])
