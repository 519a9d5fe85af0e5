"""The results of a task as a Markdown table that also reads well on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from peers.measurement import Row, ahead, unit
from peers.task import Task

MARK: Final = "<!-- {edge} of table {name} -->"


LEVELS: Final = (1e-3, 1e-6, 1e-9, 1e-12)
"""The accuracies, rad, at which costs are compared."""


def full_table(task: Task, rows: Sequence[Row]) -> str:
    """One line for each contender: its errors, and its cost beside the unit's."""
    end = f"error at {task.judged_ns[-1] / 1e9:g} s"
    head = ("", "setting", f"{end} [rad]", "largest error [rad]", "relative cost")
    return markdown([head, *(_cells(row, unit(rows)) for row in rows)])


def short_table(rows: Sequence[Row]) -> str:
    """One line for each family: what it costs to err by no more than each level, and how accurate it gets."""
    head = ("relative cost at an error, rad, of", *(f"{level:.0e}" for level in LEVELS), "best error, rad", "at cost")
    lines = []
    for family, members in families(rows).items():
        best = min(members, key=lambda row: (row.largest, row.cost))
        reached = [_cheapest(members, level, unit(rows)) for level in LEVELS]
        lines.append((family, *reached, f"{best.largest:.1e}", f"{best.cost / unit(rows):.2g}"))
    return markdown([head, *lines])


def ahead_text(rows: Sequence[Row]) -> str:
    """Which peers are ahead, and with how many of their settings."""
    settings = families(rows)
    names = [
        f"{name} ({len(found)} of {len(settings[name])} settings)" for name, found in families(ahead(rows)).items()
    ]
    return f"Ahead of all of ours: {'; '.join(names) or 'nobody'}."


def families(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows by software and method."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.contender.family, []).append(row)
    return found


def replaced(page: str, task: Task, rows: Sequence[Row]) -> str:
    """A page with its table of this task exchanged for the one of these rows."""
    return exchanged(page, task.name, f"{short_table(rows)}\n\n{ahead_text(rows)}")


def exchanged(page: str, name: str, table: str) -> str:
    """A page with the table between the marks of a name exchanged for another."""
    first, last = (MARK.format(edge=edge, name=name) for edge in ("begin", "end"))
    before, rest = page.split(first)
    _, after = rest.split(last)
    return f"{before}{first}\n\n{table}\n\n{last}{after}"


def _cells(row: Row, unit_cost: float) -> tuple[str, ...]:
    errors = (f"{row.errors[-1]:.1e}", f"{row.largest:.1e}")
    cost = "1 (unit)" if row.contender.unit else f"{row.cost / unit_cost:.2g}"
    return (row.contender.family, row.contender.setting, *errors, cost)


def _cheapest(rows: Sequence[Row], level: float, unit_cost: float) -> str:
    """What a family has to pay for a level of accuracy."""
    costs = [row.cost for row in rows if row.largest <= level]
    return f"{min(costs) / unit_cost:.2g}" if costs else "–"


def markdown(lines: Sequence[tuple[str, ...]]) -> str:
    """A table of these lines, the first of which is its head."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = [" | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in lines]
    text.insert(1, " | ".join("-" * width for width in widths))
    return "\n".join(f"| {line} |" for line in text)
