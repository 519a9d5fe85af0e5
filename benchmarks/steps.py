"""What a step of the moving chart costs, compiled and in plain Python, and what the closed form costs for a sample.

The problem: inertia 0.6, 0.8, 1 kg m², body momentum 1.8, 0.4, −0.9 kg m²/s, steps of 0.01 s. Run it with

    python benchmarks/steps.py

Times are of this process on one core. Without numba the compiled column stays empty.
"""

from __future__ import annotations

import time

import numpy as np

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.motion import munthe_kaas_loop
from lie_rigid_body.motion.moser_veselov import loop as moser_veselov_loop

BODY = RigidBody([0.6, 0.8, 1.0])
START = State([0, 0, 0, 1], [1.8 / 0.6, 0.4 / 0.8, -0.9])
STEP_NS = 10_000_000
METHODS = ("dmv20", "rkmk4", "rkmk2")
PLAIN_STEPS = 20_000
COMPILED_STEPS = 2_000_000


def microseconds_a_step(method: str, steps: int) -> float:
    """The best of three runs."""
    best = np.inf
    for _ in range(3):
        chart = MovingChart(BODY, START, method=method, max_step=1e-9 * STEP_NS)
        begin = time.process_time()
        chart.at(steps * STEP_NS)
        best = min(best, time.process_time() - begin)
    return 1e6 * best / steps


def microseconds_a_sample(samples: int) -> float:
    """Of the closed form, all asked for at once."""
    motion = ClosedForm(BODY, START)
    times = STEP_NS * np.arange(samples)
    begin = time.process_time()
    motion.at(times)
    return 1e6 * (time.process_time() - begin) / samples


def main() -> None:
    """Print the table."""
    plain = {method: microseconds_a_step(method, PLAIN_STEPS) for method in METHODS}
    compiled = [loop.LOOP.compile() for loop in (moser_veselov_loop, munthe_kaas_loop)]
    print(f"{'µs a step':<28}{'plain':>9}{'compiled':>11}")
    for method in METHODS:
        fast = f"{microseconds_a_step(method, COMPILED_STEPS):.3f}" if all(compiled) else "–"
        print(f"{method:<28}{plain[method]:>9.1f}{fast:>11}")
    print(f"{'closed form, a sample':<28}{microseconds_a_sample(1_000_000):>9.2f}")


if __name__ == "__main__":
    main()
