"""The largest error in 10 s of each integrator of the MuJoCo that is installed, at 2 ms: a row of docs/benchmarks.md.

    pip install numpy mujoco==3.10.0 && python benchmarks/mujoco_versions.py

It imports nothing of this package, so that any environment with MuJoCo will do.
"""

from __future__ import annotations

import mujoco

from peers.mujoco_joint import INTEGRATORS, contenders
from peers.task import SHORT
from peers.truth import errors

STEP = 0.002


def main() -> None:
    """Print the row."""
    found = {c.family: errors(SHORT, c.run()).max() for c in contenders(SHORT) if c.size == STEP}
    cells = (f"{found[f'MuJoCo, {name}']:.1e} rad" for name in INTEGRATORS)
    print(f"| {' | '.join((mujoco.__version__, *cells))} |")


if __name__ == "__main__":
    main()
