"""jaxlie: a Runge–Kutta–Munthe-Kaas method of order 4 on its SO(3), compiled by JAX for the CPU, in double precision.

In a step the attitude is R Exp(u) with u' = J_r⁻¹(u) ω from u = 0, which the classical Runge–Kutta method takes
together with Euler's equations. Exp is `jaxlie.SO3.exp` and J_r⁻¹ `jaxlie.SO3.jlog`. H. Munthe-Kaas, Appl. Numer. Math.
29 (1999) 115.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

import jax
import jax.numpy as jnp
import jaxlie
import numpy as np
from numpy.typing import NDArray

from peers.contender import Contender, step_text
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

jax.config.update("jax_enable_x64", True)

State = tuple[jax.Array, jax.Array]

STEPS: Final = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005)
XYZW: Final = (1, 2, 3, 0)
"""Where jaxlie, which writes the quaternion scalar first, has its components."""


def contenders(task: Task) -> Iterator[Contender]:
    """Each step that fits."""
    solve = _compiled(task)
    for step in STEPS:
        if step <= task.smallest_interval:
            yield Contender("jaxlie, RKMK4", step_text(step), step, partial(solve, step))


def _rates(u: jax.Array, rate: jax.Array) -> State:
    inertia = jnp.asarray(INERTIA)
    return jaxlie.SO3.exp(u).jlog() @ rate, jnp.cross(inertia * rate, rate) / inertia


def _step(state: State, h: jax.Array) -> State:
    wxyz, rate = state
    u1, a1 = _rates(jnp.zeros(3), rate)
    u2, a2 = _rates(0.5 * h * u1, rate + 0.5 * h * a1)
    u3, a3 = _rates(0.5 * h * u2, rate + 0.5 * h * a2)
    u4, a4 = _rates(h * u3, rate + h * a3)
    u = h / 6.0 * (u1 + 2.0 * u2 + 2.0 * u3 + u4)
    turned = jaxlie.SO3(wxyz) @ jaxlie.SO3.exp(u)
    return turned.normalize().wxyz, rate + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


def _compiled(task: Task) -> Callable[[float], NDArray[np.float64]]:
    """The attitudes as a function of the step."""

    def solve(wxyz: jax.Array, rate: jax.Array, counts: jax.Array, step: jax.Array) -> jax.Array:
        def interval(state: State, count: jax.Array) -> tuple[State, jax.Array]:
            state = jax.lax.fori_loop(0, count, lambda _, each: _step(each, step), state)
            return state, state[0]

        return jax.lax.scan(interval, (wxyz, rate), counts)[1]

    def given(step: float) -> tuple[jax.Array, ...]:
        counts = np.rint(np.diff(task.times_ns, prepend=0) / (NS * step)).astype(np.int64)
        return jnp.asarray(np.roll(ATTITUDE, 1)), jnp.asarray(RATE), jnp.asarray(counts), jnp.asarray(step)

    made = jax.jit(solve).lower(*given(STEPS[0])).compile()
    return lambda step: np.asarray(made(*given(step)))[:, XYZW]
