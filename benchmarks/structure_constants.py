"""How long does it take to know a group? Structure constants and elementary maps of SO(n), n = 3 … 8.

The structure constants of SO(8) are to be found within 1 s. Run it with

    python benchmarks/structure_constants.py

in an environment with scipy. Times are the best of several runs; growth is the exponent p of time ~ dᵖ in the
dimension d = n(n−1)/2 of the group, over the upper half of the table.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from lie_rigid_body.groups import SO, MatrixLieGroup

SIZES = range(3, 9)
BUDGET_S = 1.0


def best_of(function: Callable[[], object], runs: int = 7) -> float:
    """The shortest time of a call, s."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return min(times)


def named(n: int) -> float:
    """Seconds to build SO(n) with its structure constants."""
    return best_of(lambda: SO(n).structure_constants)


def found(n: int) -> float:
    """Seconds to find the structure constants of n×n rotations from generators mixed at random, with all checks."""
    T = SO(n).generators
    mixing = np.random.default_rng(n).normal(size=(len(T), len(T)))
    mixed = np.einsum("ab,bij->aij", mixing, T)
    return best_of(lambda: MatrixLieGroup.from_generators(mixed).structure_constants)


def mapped(n: int, name: str) -> float:
    """Seconds for one map of SO(n) at one point."""
    group = SO(n)
    x = 0.1 * np.random.default_rng(n).normal(size=group.dimension)
    argument = group.exp(x) if name in {"log", "Ad"} else x
    function = getattr(group, name)
    return best_of(lambda: function(argument), runs=200)


def growth(times: list[float]) -> float:
    """Exponent of time against dimension, over the upper half of the sizes."""
    half = len(times) // 2
    dimensions = [n * (n - 1) / 2 for n in SIZES]
    return float(np.polyfit(np.log(dimensions[half:]), np.log(times[half:]), 1)[0])


def main() -> None:
    """Print the table, and whether SO(8) keeps to its time."""
    maps = ("exp", "log", "Ad", "dexp", "dexpinv")
    columns = {
        "f of SO(n), ms": [1e3 * named(n) for n in SIZES],
        "from_generators, ms": [1e3 * found(n) for n in SIZES],
        **{f"{name}, µs": [1e6 * mapped(n, name) for n in SIZES] for name in maps},
    }
    print(f"{'n':>6} {'d':>4}  " + "  ".join(columns))
    for row, n in enumerate(SIZES):
        cells = "  ".join(f"{times[row]:{len(title)}.2f}" for title, times in columns.items())
        print(f"{n:>6} {n * (n - 1) // 2:>4}  {cells}")
    print(f"{'growth':>11}  " + "  ".join(f"{growth(times):{len(title)}.1f}" for title, times in columns.items()))
    longest = 1e-3 * max(columns["f of SO(n), ms"][-1], columns["from_generators, ms"][-1])
    print(f"SO(8) in {longest:.3f} s, {'within' if longest <= BUDGET_S else 'beyond'} {BUDGET_S:g} s")


if __name__ == "__main__":
    main()
