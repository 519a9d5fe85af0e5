"""What a step of the moving chart costs on SO(n), and how that grows with n.

    python benchmarks/group_steps.py

The rotation chart, which is SO(3) written out in plain floats, is the unit.
"""

from __future__ import annotations

import time

import numpy as np

from lie_rigid_body import MovingChart, RigidBody, State
from lie_rigid_body.groups import SO, GroupMovingChart, GroupState, Lagrangian, mass_matrix

STEPS = 2000
STEP_NS = 1_000_000


def group_motion(n: int) -> GroupMovingChart:
    """A body in n dimensions."""
    group = SO(n)
    lagrangian = Lagrangian(group, mass_matrix(np.diag(np.linspace(0.5, 1.0, n)), group.generators))
    rate = np.random.default_rng(n).normal(size=group.dimension)
    return GroupMovingChart(lagrangian, GroupState(group.identity, rate / np.linalg.norm(rate)))


def seconds_per_step(motion: GroupMovingChart | MovingChart) -> float:
    """Measured over many steps after a short warm-up."""
    motion.at(50 * STEP_NS)
    begin = time.perf_counter()
    motion.at((50 + STEPS) * STEP_NS)
    return (time.perf_counter() - begin) / STEPS


def main() -> None:
    """Print the table."""
    unit = seconds_per_step(MovingChart(RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], [0.6, 0.5, -0.6])))
    print(f"{'group':<18}{'dimension':>10}{'µs a step':>12}{'steps a second':>16}{'relative cost':>15}")
    print(f"{'SO(3) in floats':<18}{3:>10}{1e6 * unit:>12.1f}{1 / unit:>16.0f}{1.0:>15.1f}")
    for n in range(3, 9):
        cost = seconds_per_step(group_motion(n))
        print(f"{f'SO({n})':<18}{n * (n - 1) // 2:>10}{1e6 * cost:>12.1f}{1 / cost:>16.0f}{cost / unit:>15.1f}")


if __name__ == "__main__":
    main()
