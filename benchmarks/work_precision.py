"""Work against precision of this package and what one would otherwise use, on one body, in one run: ``make bench``.

Every contender gives the same attitudes, and is held against the same 50-digit truth. Costs are CPU times relative to
the default moving chart's, measured in turns in this run.

    make bench                   prints the tables, some minutes
    make bench ARGS=--save       also writes the pictures of docs/images and the tables of docs/benchmarks.md
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

from peers import pictures, registry
from peers.measurement import Row, costs, left_out, measure
from peers.table import ahead_text, exchanged, full_table, replaced, short_table
from peers.task import SHORT, TASKS, WARM_UP, Task

DOCS: Final = Path(__file__).resolve().parent.parent / "docs"
SOFTWARE: Final = (
    "numpy",
    "scipy",
    "numba",
    "mujoco",
    "drake",
    "dartpy",
    "pybullet",
    "orekit-jpype",
    "jax",
    "diffrax",
    "jaxlie",
)

Results = dict[str, tuple[Task, Sequence[Row]]]


def main() -> None:
    """Run everyone, print the tables, and write what was asked for."""
    parser = argparse.ArgumentParser(description="Work against precision, beside other software.")
    parser.add_argument("--save", action="store_true", help="write the pictures and tables of docs/")
    save = parser.parse_args().save
    print(_software())
    for library in registry.missing():
        print(f"{library} is not installed here, and is left out")
    results = run()
    if save:
        _save(results)


def run() -> Results:
    """The rows of every task, printed as they come."""
    for contender in registry.contenders(WARM_UP):
        contender.run()
    results: Results = {}
    for task in TASKS:
        contenders = list(registry.contenders(task))
        rows = measure(task, contenders, costs(results[SHORT.name][1]) if results else {})
        results[task.name] = (task, rows)
        print(f"\n{task.title}\n\n{full_table(task, rows)}\n\n{short_table(rows)}\n")
        print(ahead_text(rows))
        print(f"Left out, as it takes too long: {', '.join(left_out(contenders, rows)) or 'none'}", flush=True)
    return results


def _software() -> str:
    found = [f"Python {platform.python_version()}"]
    for name in SOFTWARE:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


def _save(results: Results) -> None:
    pictures.work_precision(results).savefig(DOCS / "images" / "work_precision.png")
    pictures.drift(results["long"][1]).savefig(DOCS / "images" / "drift.png")
    page = DOCS / "benchmarks.md"
    text = page.read_text(encoding="utf-8")
    text = exchanged(text, "software", f"Made with {_software()}.")
    for task, rows in results.values():
        text = replaced(text, task, rows)
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
