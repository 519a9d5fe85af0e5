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
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import StepLoop, kernel
from lie_rigid_body.motion.moser_veselov.records import Four, Step, StepperConstants, StepperState, Three
from lie_rigid_body.motion.moser_veselov.step import (
    add_increment,
    step_attitude,
    step_momentum,
    step_of_length,
    step_rotation,
)

STEPS_BETWEEN_PROJECTIONS: Final = 64.0
"""Largest number of steps between two projections onto the invariants."""

TURN_BETWEEN_PROJECTIONS: Final = 2.0
"""Largest turn between two projections, rad: near the separatrix an error grows by as many powers of e at most."""

MIN_SQUARED_GRADIENT: Final = 1e-250
"""Smallest squared gradient of the energy at which the energy is corrected; that of a steady rotation is 0."""


@kernel
def prepared(state: StepperState, constants: StepperConstants, span: int, count: int) -> StepperState:
    """The state with the constants of a step; they are as they were if the length is."""
    length = divide(multiply(constants.nanosecond, from_integer(span)), (float(count), 0.0))
    if length[0] == state.step.length[0] and length[1] == state.step.length[1]:
        return state
    return StepperState(state.momentum, state.attitude, state.since_projection, step_of_length(length, constants))


@kernel
def take_steps(state: StepperState, constants: StepperConstants, count: int) -> StepperState:
    """The state after a number of steps of the length that is prepared."""
    n = state.momentum
    q = state.attitude
    step = state.step
    done: Number = state.since_projection
    part = max(1.0, STEPS_BETWEEN_PROJECTIONS / TURN_BETWEEN_PROJECTIONS * step.length[0])
    for _ in range(count):
        before = n
        n = step_momentum(n, step)
        q = step_attitude(q, step_rotation(before, n, step.half_inertia))
        done += part
        if done >= STEPS_BETWEEN_PROJECTIONS:
            done = 0.0
            n = project_momentum(n, constants)
            q = project_attitude(q, n, constants.world_momentum)
    return StepperState(n, q, done, step)


@kernel
def project_momentum(n: Three, constants: StepperConstants) -> Three:
    """The momentum projected onto unit length and the energy of the start.

    The energy is counted from that of a spin about the axis k nearest to the momentum, 2H − eₖ = Σ (eⱼ − eₖ) nⱼ². So
    nothing cancels in it, however near that is, and however near the start to the separatrix.
    """
    a = multiply(n[0], n[0])
    b = multiply(n[1], n[1])
    c = multiply(n[2], n[2])
    length = subtract(add(a, add(b, c)), ONE)[0]
    d1, d2, d3, level = from_nearest_axis(a[0], b[0], c[0], constants)
    energy = add(multiply(d1, a), add(multiply(d2, b), multiply(d3, c)))
    mean = energy[0]
    # what the energy is off, less what the length accounts for; g is half its gradient along the unit sphere
    across = subtract(energy, level)[0] - mean * length
    g1 = n[0][0] * (d1[0] - mean)
    g2 = n[1][0] * (d2[0] - mean)
    g3 = n[2][0] * (d3[0] - mean)
    square = g1 * g1 + g2 * g2 + g3 * g3
    shift = 0.5 * across / square if square > MIN_SQUARED_GRADIENT else 0.0
    return (
        add_increment(n[0], -(0.5 * length * n[0][0] + shift * g1), 0.0),
        add_increment(n[1], -(0.5 * length * n[1][0] + shift * g2), 0.0),
        add_increment(n[2], -(0.5 * length * n[2][0] + shift * g3), 0.0),
    )


@kernel
def from_nearest_axis(
    a: Number, b: Number, c: Number, constants: StepperConstants
) -> tuple[DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble]:
    """The differences eⱼ − eₖ for j = 1, 2, 3, and 2H − eₖ of the start, where k is the axis with the largest nₖ²."""
    e12, e13, e23 = constants.differences
    if a >= b and a >= c:
        # 2H − e₁ = −(e₁ − e₃) m₃, and 2H − e₃ = (e₁ − e₃) m₁
        return ZERO, scaled(e12, -1.0), scaled(e13, -1.0), multiply(scaled(e13, -1.0), constants.m3)
    if c >= b:
        return e13, e23, ZERO, multiply(e13, constants.m1)
    return e12, ZERO, scaled(e23, -1.0), constants.energy


@kernel
def project_attitude(q: Four, n: Three, world: Three) -> Four:
    """The nearest unit quaternion that turns the momentum n into the spatial momentum of the start."""
    x, y, z, w = unit(q)
    t1, t2, t3 = cross((x, y, z), n)
    # u = w n + v × n, and the momentum in the world is A n = w u + v(v·n) + v × u
    u1 = add(t1, multiply(w, n[0]))
    u2 = add(t2, multiply(w, n[1]))
    u3 = add(t3, multiply(w, n[2]))
    c1, c2, c3 = cross((x, y, z), (u1, u2, u3))
    dot = add(multiply(x, n[0]), add(multiply(y, n[1]), multiply(z, n[2])))
    r1 = subtract(add(add(multiply(w, u1), multiply(x, dot)), c1), world[0])[0]
    r2 = subtract(add(add(multiply(w, u2), multiply(y, dot)), c2), world[1])[0]
    r3 = subtract(add(add(multiply(w, u3), multiply(z, dot)), c3), world[2])[0]
    # ½ (A n − L) × L is half the rotation vector, in the world, that takes A n back to L
    a = 0.5 * (r2 * world[2][0] - r3 * world[1][0])
    b = 0.5 * (r3 * world[0][0] - r1 * world[2][0])
    c = 0.5 * (r1 * world[1][0] - r2 * world[0][0])
    return (
        add_increment(x, w[0] * a + b * z[0] - c * y[0], 0.0),
        add_increment(y, w[0] * b + c * x[0] - a * z[0], 0.0),
        add_increment(z, w[0] * c + a * y[0] - b * x[0], 0.0),
        add_increment(w, -(a * x[0] + b * y[0] + c * z[0]), 0.0),
    )


@kernel
def unit(q: Four) -> Four:
    """The quaternion, scaled to unit norm by one Newton step."""
    x, y, z, w = q
    square = add(add(multiply(x, x), multiply(y, y)), add(multiply(z, z), multiply(w, w)))
    # 1/|q| − 1 = −½(|q|² − 1) + O((|q|² − 1)²)
    less = -0.5 * subtract(square, ONE)[0]
    return (
        add_increment(x, less * x[0], 0.0),
        add_increment(y, less * y[0], 0.0),
        add_increment(z, less * z[0], 0.0),
        add_increment(w, less * w[0], 0.0),
    )


@kernel
def cross(a: Three, b: Three) -> Three:
    """The product a × b."""
    return minor(a[1], b[2], a[2], b[1]), minor(a[2], b[0], a[0], b[2]), minor(a[0], b[1], a[1], b[0])


@kernel
def minor(a: DoubleDouble, b: DoubleDouble, c: DoubleDouble, d: DoubleDouble) -> DoubleDouble:
    """The difference ab − cd."""
    return subtract(multiply(a, b), multiply(c, d))


def advance(
    state: StepperState, constants: StepperConstants, spans: Any, counts: Any, takes: Any, out: Any
) -> tuple[Three, Four, Number, tuple[Any, ...]]:
    """Step through the samples, and give attitude and body rate at each as a row of ``out``; see `StepLoop`."""
    for i in range(len(spans)):
        if counts[i] > 0:
            state = take_steps(prepared(state, constants, spans[i], counts[i]), constants, takes[i])
        for j in range(4):
            out[i, j] = state.attitude[j][0]
        for j in range(3):
            out[i, 4 + j] = multiply(state.momentum[j], constants.rates[j])[0]
    return state.momentum, state.attitude, state.since_projection, state.step[:]


def named(state: tuple[Three, Four, Number, tuple[Any, ...]]) -> StepperState:
    """The state that `advance` returns in plain tuples."""
    momentum, attitude, since_projection, step = state
    return StepperState(momentum, attitude, since_projection, Step(*step))


LOOP: Final = StepLoop(advance, named)
