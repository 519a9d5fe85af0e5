"""Physics engines judged by `lie_rigid_body.conformance`: ``python benchmarks/engines.py``.

A row for each engine of `judged` that is installed here: docs/explanation/engines.md has those of several environments.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec

import numpy as np

from lie_rigid_body.conformance import Conformance, judge
from lie_rigid_body.conformance.results import Simulate

NEEDS = {
    "mujoco_joint": "mujoco",
    "mjx_joint": "mujoco.mjx",
    "newton_body": "newton",
    "dart_skeleton": "dartpy",
    "drake_plant": "pydrake",
    "pybullet_body": "pybullet",
    "genesis_body": "genesis",
}
HEADER = "| engine | order | median error, rad | precision | mistakes | notes |\n| --- | --- | --- | --- | --- | --- |"


def engines() -> Iterator[tuple[str, Simulate]]:
    for module, needed in NEEDS.items():
        if find_spec(needed.partition(".")[0]) and find_spec(needed):
            yield from import_module(f"judged.{module}").engines()


def row(name: str, found: Conformance) -> str:
    """Medians over the cases that are judged, and what is named, with the number of cases."""
    cells = [name]
    for field in ("order", "error_rad", "precision"):
        values = [value for each in found.rows if isinstance(value := getattr(each, field), float)]
        cells.append(f"{np.median(values):.2g}" if values else "not judged")
    for named in (found.mistakes, found.notes):
        cells.append(", ".join(f"`{each.code}` {len(each.cases)}" for each in named) or "–")
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table; with --all, everything that is found of each; words choose engines by name."""
    print(HEADER)
    chosen = [word for word in sys.argv[1:] if word != "--all"]
    for name, simulate in engines():
        if not all(word in name for word in chosen):
            continue
        begin = time.process_time()
        found = judge(simulate)
        print(row(name, found), flush=True)
        if "--all" in sys.argv:
            print(f"{found}\n{time.process_time() - begin:.0f} s of CPU\n", flush=True)


if __name__ == "__main__":
    main()
