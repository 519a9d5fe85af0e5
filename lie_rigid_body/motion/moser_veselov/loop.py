"""The loop over samples and steps of the discrete Moser–Veselov algorithm, and the projection onto its invariants.

Invariants are the length of the momentum, the energy, the spatial momentum and the norm of the quaternion. Between two
projections they go wrong by some 1e-17, so that one Newton step is enough (E. Hairer, C. Lubich, G. Wanner, Geometric
Numerical Integration, 2nd ed., sec. IV.4). What a projection cannot undo is an error of the place of the momentum on
its orbit, and of the angle of the body about the spatial momentum. Round-off makes these two, and nothing else, a
random walk.
"""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.arithmetic.double_double import (
    ONE,
    ZERO,
    DoubleDouble,
    add,
    divide,
    from_integer,
    multiply,
    scaled,
    subtract,
)
from lie_rigid_body.arithmetic.numbers import Number, pair
from lie_rigid_body.compilation import Loop, kernel
from lie_rigid_body.motion.moser_veselov.layout import (
    ATTITUDE,
    DIFFERENCES,
    ENERGY,
    M1,
    M3,
    MOMENTUM,
    MOMENTUM_STEP,
    RATES,
    ROTATION_STEP,
    SCALED_NANOSECOND,
    SINCE_RESTORATION,
    SPATIAL_MOMENTUM,
    STEP_LENGTH,
    Four,
    Three,
    four,
    seven,
    store,
    three,
)
from lie_rigid_body.motion.moser_veselov.step import (
    increased,
    moved_momentum,
    step_constants,
    step_rotation,
    turned,
)

STEPS_BETWEEN_RESTORATIONS: Final = 64.0
"""Largest number of steps between two projections onto the invariants."""
TURN_BETWEEN_RESTORATIONS: Final = 2.0
"""Largest turn between two projections, rad: near the separatrix an error grows by as many powers of e at most."""

SAMPLE_SIZE: Final = 7
"""Floats of a sample: x y z w, scalar last, and the body rate, rad/s, in the principal frame."""

SMALLEST: Final = 1e-250
"""Smallest squared gradient of the energy at which the energy is corrected; that of a steady rotation is 0."""


@kernel
def prepare(state: Any, constants: Any, span: int, count: int) -> None:
    """Store the constants of a step, unless they are there already."""
    length = divide(multiply(pair(constants, SCALED_NANOSECOND), from_integer(span)), (float(count), 0.0))
    if length[0] != state[STEP_LENGTH] or length[1] != state[STEP_LENGTH + 1]:
        state[STEP_LENGTH], state[STEP_LENGTH + 1] = length
        momentum_step, rotation_step = step_constants(length, constants)
        store(state, MOMENTUM_STEP, momentum_step)
        store(state, ROTATION_STEP, rotation_step)


@kernel
def take_steps(state: Any, constants: Any, count: int) -> None:
    """Move the state by a number of steps of the length that is prepared."""
    n, q = three(state, MOMENTUM), four(state, ATTITUDE)
    momentum_step, rotation_step = seven(state, MOMENTUM_STEP), three(state, ROTATION_STEP)
    done = state[SINCE_RESTORATION]
    part = max(1.0, STEPS_BETWEEN_RESTORATIONS / TURN_BETWEEN_RESTORATIONS * state[STEP_LENGTH])
    for _ in range(count):
        before = n
        n = moved_momentum(n, momentum_step)
        q = turned(q, step_rotation(before, n, rotation_step))
        done += part
        if done >= STEPS_BETWEEN_RESTORATIONS:
            done = 0.0
            n = restored_momentum(n, constants)
            q = restored_attitude(q, n, three(constants, SPATIAL_MOMENTUM))
    store(state, MOMENTUM, n)
    store(state, ATTITUDE, q)
    state[SINCE_RESTORATION] = done


@kernel
def restored_momentum(n: Three, constants: Any) -> Three:
    """The momentum projected onto unit length and the energy of the start.

    The energy is counted from that of a spin about the axis k nearest to the momentum, 2H − eₖ = Σ (eⱼ − eₖ) nⱼ². So
    nothing cancels in it, however near that is, and however near the start to the separatrix.
    """
    a, b, c = multiply(n[0], n[0]), multiply(n[1], n[1]), multiply(n[2], n[2])
    length = subtract(add(a, add(b, c)), ONE)[0]
    d1, d2, d3, level = from_nearest_axis(a[0], b[0], c[0], constants)
    energy = add(multiply(d1, a), add(multiply(d2, b), multiply(d3, c)))
    mean = energy[0]
    # what the energy is off, less what the length accounts for; g is half its gradient along the unit sphere
    across = subtract(energy, level)[0] - mean * length
    g1, g2, g3 = n[0][0] * (d1[0] - mean), n[1][0] * (d2[0] - mean), n[2][0] * (d3[0] - mean)
    square = g1 * g1 + g2 * g2 + g3 * g3
    shift = 0.5 * across / square if square > SMALLEST else 0.0
    return (
        increased(n[0], -(0.5 * length * n[0][0] + shift * g1), 0.0),
        increased(n[1], -(0.5 * length * n[1][0] + shift * g2), 0.0),
        increased(n[2], -(0.5 * length * n[2][0] + shift * g3), 0.0),
    )


@kernel
def from_nearest_axis(
    a: Number, b: Number, c: Number, constants: Any
) -> tuple[DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble]:
    """The differences eⱼ − eₖ for j = 1, 2, 3, and 2H − eₖ of the start, where k is the axis with the largest nₖ²."""
    e12, e13, e23 = three(constants, DIFFERENCES)
    if a >= b and a >= c:
        # 2H − e₁ = −(e₁ − e₃) m₃, and 2H − e₃ = (e₁ − e₃) m₁
        return ZERO, scaled(e12, -1.0), scaled(e13, -1.0), multiply(scaled(e13, -1.0), pair(constants, M3))
    if c >= b:
        return e13, e23, ZERO, multiply(e13, pair(constants, M1))
    return e12, ZERO, scaled(e23, -1.0), pair(constants, ENERGY)


@kernel
def restored_attitude(q: Four, n: Three, world: Three) -> Four:
    """The nearest unit quaternion that turns the momentum n into the spatial momentum of the start."""
    x, y, z, w = unit(q)
    t1, t2, t3 = cross((x, y, z), n)
    u1, u2, u3 = add(t1, multiply(w, n[0])), add(t2, multiply(w, n[1])), add(t3, multiply(w, n[2]))
    # u = w n + v × n, and the momentum in the world is A n = w u + v(v·n) + v × u
    c1, c2, c3 = cross((x, y, z), (u1, u2, u3))
    dot = add(multiply(x, n[0]), add(multiply(y, n[1]), multiply(z, n[2])))
    r1 = subtract(add(add(multiply(w, u1), multiply(x, dot)), c1), world[0])[0]
    r2 = subtract(add(add(multiply(w, u2), multiply(y, dot)), c2), world[1])[0]
    r3 = subtract(add(add(multiply(w, u3), multiply(z, dot)), c3), world[2])[0]
    l1, l2, l3 = world[0][0], world[1][0], world[2][0]
    # ½ (A n − L) × L is half the rotation vector, in the world, that takes A n back to L
    a, b, c = 0.5 * (r2 * l3 - r3 * l2), 0.5 * (r3 * l1 - r1 * l3), 0.5 * (r1 * l2 - r2 * l1)
    return (
        increased(x, w[0] * a + b * z[0] - c * y[0], 0.0),
        increased(y, w[0] * b + c * x[0] - a * z[0], 0.0),
        increased(z, w[0] * c + a * y[0] - b * x[0], 0.0),
        increased(w, -(a * x[0] + b * y[0] + c * z[0]), 0.0),
    )


@kernel
def unit(q: Four) -> Four:
    """The quaternion, scaled to unit norm by one Newton step."""
    x, y, z, w = q
    square = add(add(multiply(x, x), multiply(y, y)), add(multiply(z, z), multiply(w, w)))
    # 1/|q| − 1 = −½(|q|² − 1) + O((|q|² − 1)²)
    less = -0.5 * subtract(square, ONE)[0]
    return (
        increased(x, less * x[0], 0.0),
        increased(y, less * y[0], 0.0),
        increased(z, less * z[0], 0.0),
        increased(w, less * w[0], 0.0),
    )


@kernel
def cross(a: Three, b: Three) -> Three:
    """The product a × b."""
    return minor(a[1], b[2], a[2], b[1]), minor(a[2], b[0], a[0], b[2]), minor(a[0], b[1], a[1], b[0])


@kernel
def minor(a: DoubleDouble, b: DoubleDouble, c: DoubleDouble, d: DoubleDouble) -> DoubleDouble:
    """The difference ab − cd."""
    return subtract(multiply(a, b), multiply(c, d))


def advance(state: Any, constants: Any, spans: Any, counts: Any, takes: Any, out: Any) -> None:
    """Step through the samples, and give attitude and body rate at each as a row of ``out``; see `compilation.Loop`."""
    for i in range(len(spans)):
        if counts[i] > 0:
            prepare(state, constants, spans[i], counts[i])
            take_steps(state, constants, takes[i])
        for j in range(4):
            out[i, j] = state[ATTITUDE + 2 * j]
        for j in range(3):
            rate = multiply(pair(state, MOMENTUM + 2 * j), pair(constants, RATES + 2 * j))
            out[i, 4 + j] = rate[0]


LOOP: Final = Loop(advance)
