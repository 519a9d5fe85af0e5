"""What a step of the moving chart, a sample of the closed form and a start of the program cost, beside what they may.

The problem: inertia 0.6, 0.8, 1 kg m², body momentum 1.8, 0.4, −0.9 kg m²/s, steps of 0.01 s. Run it with

    python benchmarks/steps.py

Steps and samples are in processor time on one core, without making the motion or compiling; starts are in wall time. A
ratio of at most 1 meets the limit. Rows stay empty where numba is not installed.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State

BODY: Final = RigidBody([0.6, 0.8, 1.0])
START: Final = State([0, 0, 0, 1], [1.8 / 0.6, 0.4 / 0.8, -0.9])
STEP_NS: Final = 10_000_000
PLAIN_STEPS: Final = 900
"""So few that the loop does not count them, and does not compile."""
COMPILED_STEPS: Final = 2_000_000
SAMPLES: Final = 200_000
RUNS: Final = 3

PLAIN_US: Final = 50.0
"""20 000 steps a second."""

COMPILED_US: Final = {"dmv20": 0.2, "dmv10": 0.2, "rkmk4": 0.1}
SAMPLE_US: Final = 2.0
HELP_US: Final = 300_000.0


class Row(NamedTuple):
    """A cost and its limit, µs; no cost where it cannot be measured."""

    name: str
    cost: float | None
    limit: float

    def __str__(self) -> str:
        if self.cost is None:
            return f"{self.name:<34}{'–':>12}{self.limit:>12.5g}{'–':>9}"
        ratio = self.cost / self.limit
        return f"{self.name:<34}{self.cost:>12.4g}{self.limit:>12.5g}{ratio:>9.2f}   {'yes' if ratio <= 1.0 else 'NO'}"


def best(run: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Microseconds of the shortest of several runs."""
    found = []
    for _ in range(RUNS):
        begin = clock()
        run()
        found.append(clock() - begin)
    return 1e6 * min(found)


def step(method: str, steps: int) -> float:
    """Of one step."""
    charts = iter([MovingChart(BODY, START, method=method, max_step=1e-9 * STEP_NS) for _ in range(RUNS)])
    return best(lambda: next(charts).at(steps * STEP_NS)) / steps


def sample() -> float:
    """Of one sample of the closed form, all asked for at once."""
    motion, times = ClosedForm(BODY, START), STEP_NS * np.arange(SAMPLES)
    return best(lambda: motion.at(times)) / SAMPLES


def start(*arguments: str) -> float:
    """Of a process."""
    command = [sys.executable, *arguments]
    return best(lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL), time.perf_counter)


def rows() -> Iterator[Row]:
    """All costs, plain ones first: compiled loops stay compiled."""
    for method in COMPILED_US:
        yield Row(f"{method}, a step, plain Python", step(method, PLAIN_STEPS), PLAIN_US)
    compiled = {MovingChart(BODY, START, method=method).compile() for method in COMPILED_US} == {True}
    for method, limit in COMPILED_US.items():
        yield Row(f"{method}, a step, compiled", step(method, COMPILED_STEPS) if compiled else None, limit)
    yield Row("closed form, a sample, NumPy", sample(), SAMPLE_US)
    yield Row("--help", start("-m", "lie_rigid_body", "--help"), HELP_US)
    yield Row("record --help", start("-m", "lie_rigid_body", "record", "--help"), HELP_US)


def main() -> None:
    """Print the table, each row as it comes."""
    print(f"{'':<34}{'µs':>12}{'limit, µs':>12}{'ratio':>9}   met")
    for row in rows():
        print(row, flush=True)


if __name__ == "__main__":
    main()
