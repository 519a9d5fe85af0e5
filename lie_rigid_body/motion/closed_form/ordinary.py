"""Ordinary motions: those whose constants come out right in double-double, without 80 decimal digits.

A body turns ordinarily if its inertia is diagonal, sizes are such that no product overflows or underflows, and the
motion keeps away from the separatrix: 1 − m ≥ 2⁻¹⁰. Then nothing cancels but l² − 2HJ₂, by a factor of at most 2¹¹, and
every iteration takes a number of steps that is known beforehand. Each body is judged by its own numbers, in plain
doubles, so that it is judged the same alone and in any ensemble.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form.columns import Quadruple, Triple
from lie_rigid_body.motion.closed_form.double_double import Array, Number
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.ordinary_motion import OrdinaryFrame, Shape, ordinary_motion

Verdict: TypeAlias = Any
"""A bool, or an array of them."""

NEAREST: Final = 2.0**-10
"""1 − m of the motions nearest to the separatrix."""

_FLATTEST: Final = 1e3
"""Ratio of moments."""

_LIGHTEST, _HEAVIEST = 1e-20, 1e20
_SLOWEST, _FASTEST = 1e-20, 1e5

_SUM_RATIOS: Final = (2.5, 8.0, 30.0, 120.0)
"""Of (1 − ν)/√m1, above each of which the sum in the mean precession takes a step more."""
_LARGEST_RATIO: Final = 400.0

FEW: Final = 24
"""So many motions are sooner computed one by one, in floats."""

AT_ONCE: Final = 4096
"""Motions: their numbers then stay in a processor's cache."""


def about_largest(j: Triple, w: Triple) -> Verdict:
    """Whether the momentum circulates about the axis of the largest moment, from ascending moments; to round-off."""
    return j[2] * (j[2] - j[1]) * (w[2] * w[2]) > j[0] * (j[1] - j[0]) * (w[0] * w[0])


def judged(j: Triple, w: Triple, sense: Number) -> tuple[Verdict, Verdict, Any]:
    """Whether a motion is ordinary, whether m > ½, and the steps of `Shape`.

    Parameters
    ----------
    j, w : 3 numbers
        Moments and the sizes of the initial ω, in the order of a `PrincipalFrame`.
    sense : number
        ±1, its sense.
    """
    (j1, j2, j3), (w1, w2, w3) = j, w
    d21, d31, d32 = sense * (j2 - j1), sense * (j3 - j1), sense * (j3 - j2)
    q1, q2, q3 = j1 * (w1 * w1), j2 * (w2 * w2), j3 * (w3 * w3)
    c1, c2, c3 = d21 * q2 + d31 * q3, d32 * q3 - d21 * q1, d31 * q1 + d32 * q2
    whole, complement = d32 * c1, d31 * c2
    one, swollen = j1 * d32, j1 * d32 + j3 * d21
    # squares of (1 − ν)/√m1 and of 1, times the same
    spread, unit = swollen * swollen * whole, one * one * complement
    steps: Any = 3
    for ratio in _SUM_RATIOS:
        steps = steps + (spread > ratio * ratio * unit)
    fits = (c3 > 0.0) & (whole > 0.0) & (complement >= NEAREST * whole)
    return fits & (spread < _LARGEST_RATIO**2 * unit) & _is_of_ordinary_size(j, w), 2.0 * complement < whole, steps


def _is_of_ordinary_size(j: Triple, w: Triple) -> Verdict:
    j1, _, j3 = j
    fits: Verdict = True
    for moment in j:
        fits = fits & (moment >= _LIGHTEST) & (moment <= _HEAVIEST)
    for rate in w:
        fits = fits & ((rate >= _SLOWEST) | (rate == 0.0)) & (rate <= _FASTEST)
    return fits & (j1 <= _FLATTEST * j3) & (j3 <= _FLATTEST * j1)


def ordinary_motions(
    inertia: Array, attitude_xyzw: Array, body_rate: Array
) -> Iterator[tuple[GeneralMotion, NDArray[np.intp]]]:
    """The ordinary motions among these: as one those that go together, and which they are.

    Parameters
    ----------
    inertia, attitude_xyzw, body_rate : ndarray, shapes (B, 3, 3), (B, 4) and (B, 3)
    """
    kinds = _kinds(inertia, body_rate) if len(inertia) >= FEW else np.zeros(len(inertia), dtype=np.intp)
    for kind in np.unique(kinds[kinds >= 0]).tolist():
        members = np.flatnonzero(kinds == kind)
        if len(members) < FEW:
            yield from _one_by_one(inertia, attitude_xyzw, body_rate, members)
            continue
        for begin in range(0, len(members), AT_ONCE):
            some = members[begin : begin + AT_ONCE]
            x, y, z, w = attitude_xyzw[some].T
            start = _frames(inertia[some], body_rate[some])
            yield ordinary_motion(start, (x, y, z, w), Shape(bool(kind % 2), kind // 2)), some


def _one_by_one(
    inertia: Array, attitude_xyzw: Array, body_rate: Array, members: NDArray[np.intp]
) -> Iterator[tuple[GeneralMotion, NDArray[np.intp]]]:
    for i in members:
        motion = ordinary_one(inertia[i].tolist(), attitude_xyzw[i].tolist(), body_rate[i].tolist())
        if motion is not None:
            yield motion, np.array([i])


def ordinary_one(inertia: list[list[float]], attitude: list[float], rate: list[float]) -> GeneralMotion | None:
    """The motion of one body, or None if it is not ordinary."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    if xy != 0.0 or xz != 0.0 or yz != 0.0:
        return None
    diagonal = (xx, yy, zz)
    i, j, k = sorted(range(3), key=diagonal.__getitem__)
    moments, sizes = (diagonal[i], diagonal[j], diagonal[k]), (abs(rate[i]), abs(rate[j]), abs(rate[k]))
    sense = 1.0
    if not about_largest(moments, sizes):
        i, k, moments, sizes, sense = k, i, moments[::-1], sizes[::-1], -1.0
    fits, hyperbolic, steps = judged(moments, sizes, sense)
    if not fits:
        return None
    axes, frame, sign = _axes(i, k, rate[i] < 0.0, rate[k] < 0.0)
    (j1, j2, j3), (w1, _, w3) = moments, sizes
    exact = ((j1, 0.0), (j2, 0.0), (j3, 0.0)), ((w1, 0.0), (sign * rate[j], 0.0), (w3, 0.0))
    x, y, z, w = attitude
    return ordinary_motion(OrdinaryFrame(*exact, sense, axes, frame), (x, y, z, w), Shape(hyperbolic, steps))


def _kinds(inertia: Array, body_rate: Array) -> NDArray[np.intp]:
    """The `Shape` of each motion as a number, twice its steps and 1 where m > ½; negative where it is not ordinary."""
    order, sense = _orders(inertia, body_rate)
    diagonal, sizes = np.diagonal(inertia, axis1=1, axis2=2), np.abs(body_rate)
    with np.errstate(all="ignore"):
        fits, hyperbolic, steps = judged(_taken(diagonal, order), _taken(sizes, order), sense)
    straight = (inertia[:, [0, 0, 1], [1, 2, 2]] == 0.0).all(axis=1)
    return np.where(fits & straight, 2 * steps + hyperbolic, -1)


def _orders(inertia: Array, body_rate: Array) -> tuple[NDArray[np.intp], Array]:
    """The body's axes in the order of the frame, shape (B, 3), and its sense."""
    diagonal = np.diagonal(inertia, axis1=1, axis2=2)
    order = np.argsort(diagonal, axis=1, kind="stable")
    with np.errstate(all="ignore"):
        ascends = about_largest(_taken(diagonal, order), _taken(np.abs(body_rate), order))
    return np.where(ascends[:, np.newaxis], order, order[:, ::-1]), np.where(ascends, 1.0, -1.0)


def _frames(inertia: Array, body_rate: Array) -> OrdinaryFrame:
    order, sense = _orders(inertia, body_rate)
    zero = np.zeros(len(order))
    j1, j2, j3 = _taken(np.diagonal(inertia, axis1=1, axis2=2), order)
    w1, w2, w3 = _taken(body_rate, order)
    keys = np.stack([order[:, 0], order[:, 2], w1 < 0.0, w3 < 0.0], axis=-1)
    places, inverse = np.unique(keys, axis=0, return_inverse=True)
    known = [_axes(i, k, bool(p), bool(q)) for i, k, p, q in places.tolist()]
    numbers = np.array([[*axes[0], *axes[1], *axes[2], *frame, sign] for axes, frame, sign in known])[inverse.ravel()].T
    x, y, z, w = numbers[9:13]
    return OrdinaryFrame(
        moments=((j1, zero), (j2, zero), (j3, zero)),
        rate=((np.abs(w1), zero), (numbers[13] * w2, zero), (np.abs(w3), zero)),
        sense=sense,
        axes=(_triple(numbers[0:3]), _triple(numbers[3:6]), _triple(numbers[6:9])),
        frame=(x, y, z, w),
    )


def _taken(values: Array, order: NDArray[np.intp]) -> Triple:
    return _triple(np.take_along_axis(values, order, axis=1).T)


def _triple(rows: Array) -> Triple:
    first, second, third = rows
    return first, second, third


@lru_cache(maxsize=24)
def _axes(i: int, k: int, i_back: bool, k_back: bool) -> tuple[tuple[Triple, Triple, Triple], Quadruple, float]:
    """The frame with axes ±i and ±k of the body: its matrix, conj(F), and the sign of its second axis."""
    matrix = np.zeros((3, 3))
    matrix[i, 0], matrix[k, 2] = (-1.0 if i_back else 1.0), (-1.0 if k_back else 1.0)
    matrix[:, 1] = np.cross(matrix[:, 2], matrix[:, 0])
    first, second, third = (_triple_of(row) for row in matrix.tolist())
    x, y, z, w = quaternion.conjugate(quaternion.from_matrix(matrix)).tolist()
    return (first, second, third), (x, y, z, w), float(matrix[:, 1].sum())


def _triple_of(row: list[float]) -> Triple:
    # + 0.0 makes −0 a plain 0
    return row[0] + 0.0, row[1] + 0.0, row[2] + 0.0
