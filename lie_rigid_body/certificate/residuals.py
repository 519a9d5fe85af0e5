"""What the laws compare, sample by sample: on arrays, or compiled where there is enough of it, to the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, magnitude, quadruple, sqrt, triple
from lie_rigid_body.arrays import Array
from lie_rigid_body.compilation import Work, kernel
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion.taylor_flow import WORK_AREA, flow, follow, substeps_and_terms

_SAMPLES_FOR_COMPILING: Final = 1_000_000
"""Number of samples from which on compiling pays: they take some seconds on arrays, while numba loads in half a second
and compiles, once, in ten."""
_SAMPLES_FOR_LOADING: Final = 200_000
"""The same where it is compiled already."""

_OF_SAMPLES: Final = 8
_OF_STEPS: Final = 4


@dataclass(frozen=True)
class Residuals:
    """What the laws compare, of N samples that follow each other; steps lead to all but the first.

    Parameters
    ----------
    norm : ndarray, shape (N,)
        |q|
    energy : ndarray, shape (N,)
        J
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
        """The residuals of states beside those of the closed form.

        Parameters
        ----------
        body : RigidBody
        states, exact : State
            Of shapes (N, 4) and (N, 3); the first as recorded, not normalised.
        spans : ndarray, shape (N − 1,)
            Time that the flow is to be followed to each but the first, s.
        rate_bound, longest : float
            As of `flow`.
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
            compiled(inertia, inverse, *arrays, spans, substeps, terms, np.empty(WORK_AREA), samples, steps)
        norm, energy, *momentum, sine, cosine, by_start = samples
        step_sine, step_cosine, changed, by_neighbour = steps
        x, y, z = momentum
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
    """Q divided by a number."""
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
    """Fill in the residuals of all samples and steps; what is compiled."""
    before, before_rate = quadruple(attitude[0], 0), triple(rate[0], 0)
    for i in range(len(attitude)):
        q, w = quadruple(attitude[i], 0), triple(rate[i], 0)
        found = of_sample(inertia, q, w, quadruple(exact[i], 0))
        for k in range(_OF_SAMPLES):
            samples[k, i] = found[k]
        if i > 0:
            predicted, momentum = before, apply(inertia, before_rate)
            for _ in range(substeps):
                predicted, momentum = follow(work, inverse, predicted, momentum, spans[i - 1] / substeps, terms)
            compared = of_step(q, w, predicted, apply(inverse, momentum))
            for k in range(_OF_STEPS):
                steps[k, i - 1] = compared[k]
        before, before_rate = over(q, found[0]), w


_READ: Final = "Array(float64, {}, 'C', True)"
"""An array that may be read only, as those of a state are."""
_SIGNATURE: Final = (
    f"void({_READ.format(1)}, {_READ.format(1)}, {_READ.format(2)}, {_READ.format(2)}, {_READ.format(2)}, "
    f"{_READ.format(1)}, int64, int64, float64[::1], float64[:,::1], float64[:,::1])"
)
WORK: Final = Work(fill_residuals, _SIGNATURE, _SAMPLES_FOR_COMPILING, _SAMPLES_FOR_LOADING)
"""`fill_residuals`, compiled as soon as that pays."""
