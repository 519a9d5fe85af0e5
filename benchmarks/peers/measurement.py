"""Errors and costs of all contenders for one task, measured side by side."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from peers.contender import Contender
from peers.task import Task
from peers.truth import errors

ROUNDS: Final = 7
ALLOWANCE: Final = 0.4
"""CPU time, s, after which a contender takes part in no further round."""

PATIENCE: Final = 12.0
"""What would take more CPU time than this, s, is left out, and the run says so."""

Costs = Mapping[tuple[str, str], float]


@dataclass(frozen=True)
class Row:
    """What one contender did.

    Attributes
    ----------
    contender : Contender
    errors : ndarray, shape (M,)
        At the judged instants, rad.
    cost : float
        CPU time per simulated time; the smallest of several runs.
    """

    contender: Contender
    errors: NDArray[np.float64]
    cost: float

    @property
    def largest(self) -> float:
        """The largest error, rad."""
        return float(self.errors.max())


def measure(task: Task, contenders: Iterable[Contender], known: Costs) -> list[Row]:
    """Run everyone in turn, several times.

    Parameters
    ----------
    task : Task
    contenders : iterable of Contender
        Made for this task.
    known : mapping
        Costs of an earlier task by family and setting: who would take too long is not begun.
    """
    chosen = [c for c in contenders if c.unit or _expected(c, known) * task.span < PATIENCE]
    found: list[NDArray[np.float64]] = []
    spent, best = [0.0] * len(chosen), [np.inf] * len(chosen)
    for turn in range(ROUNDS):
        for i, contender in enumerate(chosen):
            if spent[i] > ALLOWANCE:
                continue
            begin = time.process_time()
            attitudes = contender.run()
            cost = time.process_time() - begin
            spent[i], best[i] = spent[i] + cost, min(best[i], cost)
            if turn == 0:
                found.append(errors(task, attitudes))
            _progress(f"{task.name}: round {turn + 1} of {ROUNDS}, {i + 1} of {len(chosen)}, {contender.family}")
    _progress("")
    return [Row(c, e, b / task.span) for c, e, b in zip(chosen, found, best, strict=True)]


def left_out(contenders: Iterable[Contender], rows: Sequence[Row]) -> list[str]:
    """Who was not begun."""
    begun = {(row.contender.family, row.contender.setting) for row in rows}
    return [f"{c.family}, {c.setting}" for c in contenders if (c.family, c.setting) not in begun]


def costs(rows: Iterable[Row]) -> dict[tuple[str, str], float]:
    """By family and setting."""
    return {(row.contender.family, row.contender.setting): row.cost for row in rows}


def unit(rows: Iterable[Row]) -> float:
    """The cost of the contender that is the unit."""
    return next(row.cost for row in rows if row.contender.unit)


def ahead(rows: Sequence[Row]) -> list[Row]:
    """The peers that none of ours matches: none is both as accurate and as cheap."""
    ours = [row for row in rows if row.contender.ours]
    peers = [row for row in rows if not row.contender.ours]
    return [p for p in peers if not any(o.largest <= p.largest and o.cost <= p.cost for o in ours)]


def _expected(contender: Contender, known: Costs) -> float:
    return known.get((contender.family, contender.setting), 0.0)


def _progress(text: str) -> None:
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)
