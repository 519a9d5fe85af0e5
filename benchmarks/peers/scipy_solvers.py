"""SciPy: Euler's equations and the quaternion's as one system, for its solvers of any equation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import ode, odeint, solve_ivp

from peers.compiled import compiled
from peers.contender import Contender
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

TOLERANCES: Final = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
TIGHTEST: Final = 3e-14
"""solve_ivp takes no relative tolerance below 100 times the spacing of doubles."""

Array = NDArray[np.float64]
Rate = Callable[[float, Array], Array]
START: Final = np.concatenate([ATTITUDE, RATE])
A, B, C = ((INERTIA - np.roll(INERTIA, -1))[[1, 2, 0]] / INERTIA).tolist()


def _rate(_: float, y: Array) -> Array:
    x, q, z, w, a, b, c = y
    out = np.empty(7)
    out[0] = 0.5 * (w * a + q * c - z * b)
    out[1] = 0.5 * (w * b + z * a - x * c)
    out[2] = 0.5 * (w * c + x * b - q * a)
    out[3] = -0.5 * (x * a + q * b + z * c)
    out[4] = A * b * c
    out[5] = B * c * a
    out[6] = C * a * b
    return out


def contenders(task: Task) -> Iterator[Contender]:
    """Each solver at each tolerance; the right-hand side is compiled where numba is installed."""
    rate = compiled(_rate)
    for method, tolerances in (("RK45", TOLERANCES), ("DOP853", (*TOLERANCES, TIGHTEST))):
        yield Contender(f"SciPy, solve_ivp {method}", "defaults", 1e-3, _solve_ivp(task, rate, method, None))
        for tolerance in tolerances:
            run = _solve_ivp(task, rate, method, tolerance)
            yield Contender(f"SciPy, solve_ivp {method}", f"{tolerance:.0e}", tolerance, run)
    for tolerance in (*TOLERANCES, TIGHTEST):
        yield Contender("SciPy, odeint (LSODA)", f"{tolerance:.0e}", tolerance, _odeint(task, rate, tolerance))
        yield Contender("SciPy, ode dop853", f"{tolerance:.0e}", tolerance, _ode(task, rate, tolerance))


def _solve_ivp(task: Task, rate: Rate, method: str, tolerance: float | None) -> Callable[[], Array]:
    t = task.times_ns / NS
    options = {} if tolerance is None else {"rtol": tolerance, "atol": tolerance}

    def run() -> Array:
        return solve_ivp(rate, (0.0, t[-1]), START, method=method, t_eval=t, **options).y[:4].T

    return run


def _odeint(task: Task, rate: Rate, tolerance: float) -> Callable[[], Array]:
    """A compiled loop, and its own interpolation between steps."""
    t = np.concatenate([[0.0], task.times_ns / NS])

    def run() -> Array:
        states = odeint(rate, START, t, tfirst=True, rtol=tolerance, atol=tolerance, mxstep=10**9)
        return np.asarray(states)[1:, :4]

    return run


def _ode(task: Task, rate: Rate, tolerance: float) -> Callable[[], Array]:
    """A compiled loop, which has to be stopped at each time."""
    t = (task.times_ns / NS).tolist()

    def run() -> Array:
        solver = ode(rate).set_integrator("dop853", rtol=tolerance, atol=tolerance, nsteps=10**9)
        solver.set_initial_value(START, 0.0)
        return np.array([solver.integrate(instant)[:4] for instant in t])

    return run
