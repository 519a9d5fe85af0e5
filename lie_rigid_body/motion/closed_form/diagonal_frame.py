"""Principal frames of ordinary motions whose inertia is diagonal: axes of the body, and numbers exactly as given."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.numbers import Quadruple, Triple
from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form.ordinary import Shape, about_largest, judged
from lie_rigid_body.motion.closed_form.ordinary_motion import OrdinaryFrame


def one_diagonal(diagonal: list[float], rate: list[float]) -> tuple[OrdinaryFrame, Shape] | None:
    """The frame and the shape of one motion, or None if it is not ordinary."""
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
    return OrdinaryFrame(*exact, sense, axes, frame), Shape(hyperbolic, steps)


def judged_diagonal(diagonal: Array, body_rate: Array) -> tuple[NDArray[np.bool_], Array, NDArray[np.intp]]:
    """See `ordinary.judged`, from diagonals and rates of shape (B, 3)."""
    order, sense = _orders(diagonal, body_rate)
    fits, hyperbolic, steps = judged(_taken(diagonal, order), _taken(np.abs(body_rate), order), sense)
    return fits, hyperbolic, steps


def diagonal_frames(diagonal: Array, body_rate: Array) -> OrdinaryFrame:
    """The frames of many motions, as one, from diagonals and rates of shape (B, 3)."""
    order, sense = _orders(diagonal, body_rate)
    zero = np.zeros(len(order))
    j1, j2, j3 = _taken(diagonal, order)
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


def _orders(diagonal: Array, body_rate: Array) -> tuple[NDArray[np.intp], Array]:
    """The body's axes in the order of the frame, shape (B, 3), and its sense."""
    order = np.argsort(diagonal, axis=1, kind="stable")
    ascends = about_largest(_taken(diagonal, order), _taken(np.abs(body_rate), order))
    return np.where(ascends[:, np.newaxis], order, order[:, ::-1]), np.where(ascends, 1.0, -1.0)


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
    # + 0.0 makes −0 a plain 0
    matrix[:, 1] = np.cross(matrix[:, 2], matrix[:, 0]) + 0.0
    first, second, third = ((x, y, z) for x, y, z in matrix.tolist())
    x, y, z, w = quaternion.conjugate(quaternion.from_matrix(matrix)).tolist()
    return (first, second, third), (x, y, z, w), float(matrix[:, 1].sum())
