"""How surely `judge` names mistakes, on integrators of our own: ``python benchmarks/conformance.py``.

A line for each integrator and mistake: what is named, in how many cases, and how far results at step 0 are from the
exact motion, in the unit that `MAX_REMAINS` limits: the largest and the median over the cases that are judged.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

from judged.own import MISTAKES, ONE_SIDED, RIGHT, engine, expected
from lie_rigid_body.conformance import CASES, judge
from lie_rigid_body.conformance.results import STEPS, CaseResults

KINDS = {"float64": "", "float32": ", float32"}


def engines() -> Iterator[tuple[str, str, str]]:
    """Integrator, mistake, and type of its numbers."""
    for kind in KINDS:
        for name in RIGHT:
            for mistake in MISTAKES:
                yield name, mistake, kind
        for name in ONE_SIDED:
            yield name, "", kind


def line(name: str, mistake: str, kind: str) -> str:
    """What is found of one of them."""
    simulate = engine(name, mistake, kind)
    found = judge(simulate)
    results = [CaseResults(simulate, case, STEPS[0], STEPS[1] // STEPS[0]) for case in CASES]
    remains = [each.remains(each.truth) for each in results if each.judged]
    named = {f"{each.code} {len(each.cases)}" for each in found.mistakes}
    notes = {f"{each.code} {len(each.cases)}" for each in found.notes}
    is_right = {each.code for each in found.mistakes} == expected(name, mistake, kind)
    cells = (
        "as expected" if is_right else "OTHER",
        f"{name}{KINDS[kind]}",
        mistake or "right",
        ", ".join(sorted(named)) or "–",
        ", ".join(sorted(notes)) or "–",
        f"{max(remains, default=np.nan):.2g}",
        f"{np.median(remains) if remains else np.nan:.2g}",
        str(len(remains)),
    )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table; an argument chooses integrators whose names contain it."""
    for given in engines():
        if all(word in f"{given[0]} {given[2]}" for word in sys.argv[1:]):
            print(line(*given), flush=True)


if __name__ == "__main__":
    main()
