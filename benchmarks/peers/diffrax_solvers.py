"""diffrax: Euler's equations and the quaternion's as one system, compiled by JAX for the CPU, in double precision."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Final

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from peers.contender import Contender
from peers.scipy_solvers import START, A, B, C
from peers.task import NS, Task

jax.config.update("jax_enable_x64", True)

TOLERANCES: Final = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 3e-14)
SOLVERS: Final = {"Tsit5": diffrax.Tsit5, "Dopri8": diffrax.Dopri8}


def contenders(task: Task) -> Iterator[Contender]:
    """Each solver at each tolerance, the absolute and the relative one; its dense output gives the instants between."""
    for name, solver in SOLVERS.items():
        solve = _compiled(task, solver())
        for tolerance in TOLERANCES:
            yield Contender(f"diffrax, {name}", f"{tolerance:.0e}", tolerance, partial(solve, tolerance))


def _rate(_: Any, y: jax.Array, __: Any) -> jax.Array:
    x, q, z, w, a, b, c = y
    return jnp.stack(
        [
            0.5 * (w * a + q * c - z * b),
            0.5 * (w * b + z * a - x * c),
            0.5 * (w * c + x * b - q * a),
            -0.5 * (x * a + q * b + z * c),
            A * b * c,
            B * c * a,
            C * a * b,
        ]
    )


def _compiled(task: Task, solver: Any) -> Callable[[float], NDArray[np.float64]]:
    """The solution as a function of the tolerance."""

    def solve(start: jax.Array, t: jax.Array, tolerance: jax.Array) -> jax.Array:
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(_rate),
            solver,
            0.0,
            t[-1],
            None,
            start,
            saveat=diffrax.SaveAt(ts=t),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=None,
        )
        return found.ys[:, :4]

    start, t = jnp.asarray(START), jnp.asarray(task.times_ns / NS)
    made = jax.jit(solve).lower(start, t, jnp.asarray(TOLERANCES[0])).compile()
    return lambda tolerance: np.asarray(made(start, t, jnp.asarray(tolerance)))
