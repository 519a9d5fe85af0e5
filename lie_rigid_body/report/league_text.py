"""The table of the league for a terminal, and the place of a filter in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.league import GRADES, FilterRow, LeagueTable, standing

HEADINGS: Final = ("filter", "rank", *GRADES, "faults", "overall")
_COLUMNS: Final = "{:<42} {:>4} {:>8} {:>10} {:>8} {:>8} {:>8} {:>8}"
_LONGEST_NAME: Final = 42
_OWN: Final = "> "
"""Mark of one's own rows."""


def as_text(table: LeagueTable, own: Sequence[FilterRow]) -> str:
    """The table with marks at one's own rows, and a paragraph for each of these."""
    return "\n".join(_lines(table, own))


def _lines(table: LeagueTable, own: Sequence[FilterRow]) -> Iterator[str]:
    yield f"RMS of the total error from 30 s on, degrees: medians over the cases of a grade. Edition {table.edition}."
    yield _COLUMNS.format(*HEADINGS).rstrip()
    for row in table.rows:
        name, *others = cells(table, row)
        yield _COLUMNS.format((_OWN * (row in own) + name)[:_LONGEST_NAME], *others)
    yield _COLUMNS.format(table.best_possible.name, "", *numbers(table.best_possible))
    for row in own:
        yield ""
        yield from wrapped(standing(table, row))


def cells(table: LeagueTable, row: FilterRow) -> list[str]:
    """Name, rank and errors of a row, for every table; a star marks filters that see later readings."""
    return [row.name + " *" * row.sees_future, f"{table.rank(row)}", *numbers(row)]


def numbers(row: FilterRow) -> list[str]:
    """Errors of a row: the typical ones of each grade and with faults, and the overall one."""
    typical = [row.typical_deg(grade) for grade in GRADES]
    return [*map(angle, (*typical, row.typical_deg("mems", faults=True), row.overall_deg))]


def angle(degrees: float) -> str:
    """An angle with two digits; 0 below a ten-thousandth of a degree."""
    return "0" if degrees < 5e-5 else f"{degrees:.2g}" if degrees < 99.5 else f"{degrees:.0f}"
