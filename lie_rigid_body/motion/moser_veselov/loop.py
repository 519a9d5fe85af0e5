"""The loop over samples and steps of the discrete Moser–Veselov algorithm, the same in plain Python and compiled."""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.arithmetic.double_double import DoubleDouble, divide, from_integer, multiply
from lie_rigid_body.compilation import Loop, kernel
from lie_rigid_body.motion.moser_veselov.layout import (
    ATTITUDE,
    MOMENTUM,
    MOMENTUM_STEP,
    NANOSECOND,
    RATES,
    ROTATION_STEP,
    SINCE_RESTORATION,
    SPATIAL_MOMENTUM,
    STEP_LENGTH,
    four,
    pair,
    seven,
    store,
    three,
)
from lie_rigid_body.motion.moser_veselov.restoration import restored_attitude, restored_momentum
from lie_rigid_body.motion.moser_veselov.step import moved_momentum, step_constants, step_rotation, turned

STEPS_BETWEEN_RESTORATIONS: Final = 64.0
"""Largest number of steps between two projections onto the invariants."""
TURN_BETWEEN_RESTORATIONS: Final = 2.0
"""Largest turn between two projections, rad: near the separatrix an error grows by as many powers of e at most."""

SAMPLE_SIZE: Final = 7
"""Floats of a sample: x y z w, scalar last, and the body rate, rad/s, in the principal frame."""


@kernel
def step_length(unit: DoubleDouble, span: int, count: int) -> DoubleDouble:
    """The length of one of ``count`` equal steps in ``span`` nanoseconds, if one nanosecond is ``unit``."""
    return divide(multiply(unit, from_integer(span)), (float(count), 0.0))


@kernel
def prepare(state: Any, constants: Any, span: int, count: int) -> None:
    """Store the constants of a step, unless they are there already."""
    length = step_length(pair(constants, NANOSECOND), span, count)
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
