"""The loop over samples and steps, the same in plain Python and compiled."""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.arithmetic.double_double import DoubleDouble, divide, fast_two_sum, multiply
from lie_rigid_body.compilation import Loop, kernel
from lie_rigid_body.motion.moser_veselov.restoration import restored_attitude, restored_momentum
from lie_rigid_body.motion.moser_veselov.step import moved_momentum, step_rotation, turned
from lie_rigid_body.motion.moser_veselov.step_constants import step_constants

STEPS_BETWEEN_RESTORATIONS: Final = 64.0
TURN_BETWEEN_RESTORATIONS: Final = 2.0
"""rad, unless these steps turn less: near the separatrix an error grows by as many powers of e at most."""

MOMENTUM: Final = 0
ATTITUDE: Final = 6
DONE: Final = 14
LENGTH: Final = 15
STEP: Final = 17
STATE_SIZE: Final = 37
"""Places in a state: n₁ n₂ n₃ and x y z w, each hi and lo, the steps since a restoration, long ones counted as more
than one, and the latest step's length and constants, so that a step like the one before costs nothing more."""

SPATIAL_MOMENTUM: Final = 18
RATES: Final = 24
"""Their places among the constants of a motion."""

SAMPLE_SIZE: Final = 7


@kernel
def step_length(unit: DoubleDouble, span: int, count: int) -> DoubleDouble:
    """The length of one of ``count`` equal steps in ``span`` nanoseconds, if one nanosecond is ``unit``."""
    low = span & 0xFFFFFFFF
    time = fast_two_sum(float(span - low), float(low))
    return divide(multiply(unit, time), (float(count), 0.0))


@kernel
def prepare(state: Any, constants: Any, span: int, count: int) -> None:
    """Store the constants of a step, unless they are there already."""
    length = step_length((constants[0], constants[1]), span, count)
    if length[0] != state[LENGTH] or length[1] != state[LENGTH + 1]:
        state[LENGTH], state[LENGTH + 1] = length
        step = step_constants(length, constants)
        for j in range(STATE_SIZE - STEP):
            state[STEP + j] = step[j]


@kernel
def pair(values: Any, place: int) -> DoubleDouble:
    """The number at a place and the next."""
    return values[place], values[place + 1]


@kernel
def take_steps(state: Any, constants: Any, count: int) -> None:
    """Move the state by a number of steps."""
    n = (pair(state, MOMENTUM), pair(state, MOMENTUM + 2), pair(state, MOMENTUM + 4))
    q = (pair(state, ATTITUDE), pair(state, ATTITUDE + 2), pair(state, ATTITUDE + 4), pair(state, ATTITUDE + 6))
    done = state[DONE]
    part = max(1.0, STEPS_BETWEEN_RESTORATIONS / TURN_BETWEEN_RESTORATIONS * state[LENGTH])
    for _ in range(count):
        before = n
        n = moved_momentum(n, state, STEP)
        q = turned(q, step_rotation(before, n, state, STEP))
        done += part
        if done >= STEPS_BETWEEN_RESTORATIONS:
            done = 0.0
            world = (
                pair(constants, SPATIAL_MOMENTUM),
                pair(constants, SPATIAL_MOMENTUM + 2),
                pair(constants, SPATIAL_MOMENTUM + 4),
            )
            n = restored_momentum(n, constants)
            q = restored_attitude(q, n, world)
    for j in range(3):
        state[MOMENTUM + 2 * j], state[MOMENTUM + 2 * j + 1] = n[j]
    for j in range(4):
        state[ATTITUDE + 2 * j], state[ATTITUDE + 2 * j + 1] = q[j]
    state[DONE] = done


def advance(state: Any, constants: Any, spans: Any, counts: Any, takes: Any, out: Any) -> None:
    """Steps through the samples, each given back as x … w and the body rate; see `compilation.Loop`."""
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
