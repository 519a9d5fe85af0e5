"""Residuals that the laws compare, sample by sample: on arrays, or compiled for long bags, with the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, magnitude, quadruple, sqrt, triple
from lie_rigid_body.compilation import Work, kernel
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.taylor_flow import (
    ABREAST,
    FLOW_AREA,
    column_quadruple,
    column_triple,
    flow,
    follow,
    put_columns,
    substeps_and_terms,
)

_SAMPLES_FOR_COMPILING: Final = 1_000_000
"""Number of samples from which on compiling pays. Arrays take some seconds for so many. Numba loads in half a second
and compiles, once, in ten."""
_SAMPLES_FOR_LOADING: Final = 200_000
"""Number of samples from which on loading compiled code from the cache pays."""

_OF_SAMPLES: Final = 8
_OF_STEPS: Final = 4


@dataclass(frozen=True)
class Residuals:
    """Residuals of N consecutive samples, and of the N − 1 steps between them.

    Parameters
    ----------
    norm : ndarray, shape (N,)
        Norm |q| of the recorded quaternion.
    energy : ndarray, shape (N,)
        Kinetic energy, J.
    momentum : tuple of ndarray, shape (N,) each
        World momentum x, y, z, kg m²/s.
    turned : ndarray, shape (N,)
        Angle to the exact attitude, rad.
    by_start : ndarray, shape (N,)
        Scalar product with the exact quaternion.
    step_turned : ndarray, shape (N − 1,)
        Angle to the attitude that the flow predicts from the sample before, rad.
    step_changed : ndarray, shape (N − 1,)
        Distance of the body rate from the predicted one, rad/s.
    by_neighbour : ndarray, shape (N − 1,)
        Scalar product with the predicted quaternion.
    """

    norm: Array
    energy: Array
    momentum: tuple[Array, Array, Array]
    turned: Array
    by_start: Array
    step_turned: Array
    step_changed: Array
    by_neighbour: Array

    @classmethod
    def of(
        cls, body: RigidBody, states: State, exact: State, spans: Array, rate_bound: float, longest: float
    ) -> Residuals:
        """Residuals of recorded states from those of the closed form.

        Parameters
        ----------
        body : RigidBody
        states, exact : State
            Of shapes (N, 4) and (N, 3); the first as recorded, not normalised.
        spans : ndarray, shape (N − 1,)
            Time span of the flow from the sample before, s.
        rate_bound, longest : float
            Bound of the body rate, rad/s, and longest span, s; see `flow`.
        """
        count = len(states.body_rate)
        compiled = WORK.compiled_for(0)
        samples: Any
        steps: Any
        if compiled is None or count == 0:
            samples, steps = _on_arrays(body, states, exact, spans, rate_bound, longest)
        else:
            samples, steps = np.empty((_OF_SAMPLES, count)), np.empty((_OF_STEPS, count - 1))
            substeps, terms = substeps_and_terms(rate_bound * longest)
            inertia, inverse = (np.ascontiguousarray(tensor).ravel() for tensor in (body.inertia, body.inverse_inertia))
            arrays = (np.ascontiguousarray(a) for a in (states.attitude_xyzw, states.body_rate, exact.attitude_xyzw))
            compiled(inertia, inverse, *arrays, spans, substeps, terms, np.zeros(AREA), samples, steps)
        norm, energy, x, y, z, sine, cosine, by_start = samples
        step_sine, step_cosine, changed, by_neighbour = steps
        return cls(
            norm,
            energy,
            (x, y, z),
            2.0 * np.arctan2(sine, cosine),
            by_start,
            2.0 * np.arctan2(step_sine, step_cosine),
            changed,
            by_neighbour,
        )


@kernel
def apply(tensor: Sequence[Number], vector: Triple) -> Triple:
    """The product of a tensor, row by row, with a vector."""
    x, y, z = vector
    return (
        x * tensor[0] + y * tensor[1] + z * tensor[2],
        x * tensor[3] + y * tensor[4] + z * tensor[5],
        x * tensor[6] + y * tensor[7] + z * tensor[8],
    )


@kernel
def norm_of(q: Quadruple) -> Number:
    """The norm of a quaternion."""
    x, y, z, w = q
    return sqrt((x * x + y * y) + (z * z + w * w))


@kernel
def over(q: Quadruple, size: Number) -> Quadruple:
    """Quotient of a quaternion and a number."""
    return q[0] / size, q[1] / size, q[2] / size, q[3] / size


@kernel
def dot(p: Quadruple, q: Quadruple) -> Number:
    """The scalar product."""
    return (p[0] * q[0] + p[1] * q[1]) + (p[2] * q[2] + p[3] * q[3])


@kernel
def rotated(q: Quadruple, v: Triple) -> Triple:
    """The vector rotated by a unit quaternion, eq. (3)."""
    x, y, z, w = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + (w * tx + (y * tz - z * ty)),
        vy + (w * ty + (z * tx - x * tz)),
        vz + (w * tz + (x * ty - y * tx)),
    )


@kernel
def half_angle(p: Quadruple, q: Quadruple) -> tuple[Number, Number]:
    """Sine and cosine of half of the angle between two rotations, of p⁻¹ ⊗ q."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    x = pw * qx - px * qw - py * qz + pz * qy
    y = pw * qy + px * qz - py * qw - pz * qx
    z = pw * qz - px * qy + py * qx - pz * qw
    w = pw * qw + px * qx + py * qy + pz * qz
    return sqrt((x * x + y * y) + z * z), magnitude(w)


@kernel
def of_sample(inertia: Sequence[Number], q: Quadruple, w: Triple, exact: Quadruple) -> tuple[Number, ...]:
    """|q|, kinetic energy, world momentum, half of the angle to the exact attitude, and the sign towards it."""
    size = norm_of(q)
    unit = over(q, size)
    p = apply(inertia, w)
    x, y, z = rotated(unit, p)
    sine, cosine = half_angle(exact, unit)
    energy = 0.5 * (w[0] * p[0] + w[1] * p[1] + w[2] * p[2])
    return size, energy, x, y, z, sine, cosine, dot(exact, unit)


@kernel
def of_step(q: Quadruple, w: Triple, predicted: Quadruple, rate: Triple) -> tuple[Number, Number, Number, Number]:
    """Half of the angle to the predicted attitude, the distance to the predicted rate, and the sign towards it."""
    unit = over(q, norm_of(q))
    sine, cosine = half_angle(predicted, unit)
    a, b, c = w[0] - rate[0], w[1] - rate[1], w[2] - rate[2]
    return sine, cosine, sqrt((a * a + b * b) + c * c), dot(predicted, unit)


def _on_arrays(
    body: RigidBody, states: State, exact: State, spans: Array, rate_bound: float, longest: float
) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
    inertia: Any = body.inertia.ravel()
    q, w = _columns(states)
    unit = np.stack(over(q, norm_of(q)), axis=-1)
    predicted = flow(body, State.trusted(unit[:-1], states.body_rate[:-1]), spans, rate_bound, longest)
    return of_sample(inertia, q, w, _columns(exact)[0]), of_step(*_columns(states[1:]), *_columns(predicted))


def _columns(states: State) -> tuple[Quadruple, Triple]:
    attitude, rate = states.attitude_xyzw.T, states.body_rate.T
    return (attitude[0], attitude[1], attitude[2], attitude[3]), (rate[0], rate[1], rate[2])


_EXACT, _UNIT, _MOMENTUM, _FOUND = 7, 11, 15, 18
"""First columns of the exact attitude, the normalised attitude, the body momentum and the residuals in the work array
of `fill_residuals`. The recorded attitude and body rate stand before them."""
_COLUMNS: Final = _FOUND + _OF_SAMPLES + _OF_STEPS
AREA: Final = FLOW_AREA + (_COLUMNS + 1) * ABREAST
"""Length of the work array of `fill_residuals`: the work area of `follow`, then `_COLUMNS` columns, then the spans."""


@kernel
def _nine(tensor: Any) -> tuple[Number, ...]:
    """The nine entries of a tensor as scalars, which compiled code keeps in registers."""
    (a, b, c), (d, e, f), (g, h, i) = triple(tensor, 0), triple(tensor, 3), triple(tensor, 6)
    return a, b, c, d, e, f, g, h, i


@kernel
def _compare_samples(inertia: Sequence[Number], columns: Any) -> None:
    for j in range(ABREAST):
        q, w = column_quadruple(columns, 0, j), column_triple(columns, 4, j)
        found = of_sample(inertia, q, w, column_quadruple(columns, _EXACT, j))
        put_columns(columns, _FOUND, j, found)
        put_columns(columns, _UNIT, j, over(q, found[0]))
        put_columns(columns, _MOMENTUM, j, apply(inertia, w))


@kernel
def _start_steps(columns: Any, before: Any) -> None:
    """Place the start of each step, which is the sample before. Place 0 keeps the last sample of the block before."""
    for j in range(1, ABREAST):
        put_columns(before, 6, j, column_quadruple(columns, _UNIT, j - 1))
        put_columns(before, 0, j, column_triple(columns, _MOMENTUM, j - 1))


@kernel
def _compare_steps(inverse: Sequence[Number], columns: Any, predicted: Any) -> None:
    for j in range(ABREAST):
        q, w = column_quadruple(columns, 0, j), column_triple(columns, 4, j)
        rate = apply(inverse, column_triple(predicted, 0, j))
        found = of_step(q, w, column_quadruple(predicted, 6, j), rate)
        put_columns(columns, _FOUND + _OF_SAMPLES, j, found)


def fill_residuals(
    inertia: Any,
    inverse: Any,
    attitude: Any,
    rate: Any,
    exact: Any,
    spans: Any,
    substeps: int,
    terms: int,
    work: Any,
    samples: Any,
    steps: Any,
) -> None:
    """Fill in the residuals of all samples and steps; numba compiles this function."""
    tensor, inverted = _nine(inertia), _nine(inverse)
    flow_area, columns, parts = work[:FLOW_AREA], work[FLOW_AREA : AREA - ABREAST], work[AREA - ABREAST : AREA]
    for first in range(0, len(attitude), ABREAST):
        count = min(ABREAST, len(attitude) - first)
        put_columns(flow_area, 6, 0, column_quadruple(columns, _UNIT, ABREAST - 1))
        put_columns(flow_area, 0, 0, column_triple(columns, _MOMENTUM, ABREAST - 1))
        for j in range(count):
            put_columns(columns, 0, j, quadruple(attitude[first + j], 0))
            put_columns(columns, 4, j, triple(rate[first + j], 0))
            put_columns(columns, _EXACT, j, quadruple(exact[first + j], 0))
            parts[j] = spans[first + j - 1] / substeps if first + j > 0 else 0.0
        _compare_samples(tensor, columns)
        _start_steps(columns, flow_area)
        for _ in range(substeps):
            follow(flow_area, inverted, parts, terms)
        _compare_steps(inverted, columns, flow_area)
        for k in range(_OF_SAMPLES):
            for j in range(count):
                samples[k, first + j] = columns[(_FOUND + k) * ABREAST + j]
        for k in range(_OF_STEPS):
            for j in range(int(first == 0), count):
                steps[k, first + j - 1] = columns[(_FOUND + _OF_SAMPLES + k) * ABREAST + j]


_READ: Final = "Array(float64, {}, 'C', True)"
"""An array that may be read only, as those of a state are."""
_SIGNATURE: Final = (
    f"void({_READ.format(1)}, {_READ.format(1)}, {_READ.format(2)}, {_READ.format(2)}, {_READ.format(2)}, "
    f"{_READ.format(1)}, int64, int64, float64[::1], float64[:,::1], float64[:,::1])"
)
WORK: Final = Work(fill_residuals, _SIGNATURE, _SAMPLES_FOR_COMPILING, _SAMPLES_FOR_LOADING)
"""Compiled code of `fill_residuals`, from the number of samples on for which it pays."""
