"""League: its table for a terminal, and as a page with the errors of every filter in every case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.league import CASES, EDITION, GRADES, FilterRow, LeagueTable, standing
from lie_rigid_body.report import html_page

_HEADINGS: Final = ("filter", "rank", *GRADES, "faults", "overall")
_COLUMNS: Final = "{:<42.42} {:>4} {:>8} {:>10} {:>8} {:>8} {:>8} {:>8}"
_OWN: Final = "> "
"""Mark of one's own rows."""


def lines(table: LeagueTable, own: Sequence[FilterRow]) -> Iterator[str]:
    """Lines of the table for a terminal, with marks at one's own rows, and a paragraph for each of these."""
    yield f"RMS of the total error from 30 s on, degrees: medians over the cases of a grade. Edition {EDITION}."
    yield _COLUMNS.format(*_HEADINGS).rstrip()
    for row in table.rows:
        name, *others = _cells(table, row)
        yield _COLUMNS.format(_OWN * (row in own) + name, *others)
    yield _COLUMNS.format(*_cells(table, table.best_possible))
    for row in own:
        yield from ("", *wrapped(standing(table, row)))


def _cells(table: LeagueTable, row: FilterRow) -> list[str]:
    """Name, rank and errors: the typical ones of each grade and with faults, and the overall one.

    A star marks filters that see later readings; the best possible has no rank.
    """
    rank = f"{table.rank(row)}" if row in table.rows else ""
    typical = [row.typical_deg(grade) for grade in GRADES]
    errors = (*typical, row.typical_deg("mems", faults=True), row.overall_deg)
    return [row.name + " *" * row.sees_future, rank, *map(angle, errors)]


def angle(degrees: float) -> str:
    """An angle with two digits; 0 below a ten-thousandth of a degree."""
    return "0" if degrees < 5e-5 else f"{degrees:.2g}" if degrees < 99.5 else f"{degrees:.0f}"


def page(table: LeagueTable, own: Sequence[FilterRow]) -> bytes:
    """The page as HTML, on which one's own rows are marked."""
    rows = [(_cells(table, row), row not in own) for row in (*table.rows, table.best_possible)]
    parts = [
        *(html_page.paragraph(standing(table, row)) for row in own),
        "<h2>Errors</h2>",
        html_page.paragraph(
            "RMS of the total error from 30 s on, degrees: medians over the cases of a grade of sensors. Filters are "
            "ranked by the geometric mean over the grades of real sensors. A star marks those that see later readings."
        ),
        html_page.table(_HEADINGS, rows),
        f"<h2>Every case</h2>{_heat_map(table)}",
    ]
    return html_page.document(f"League of attitude filters {EDITION}", parts)


def _heat_map(table: LeagueTable) -> str:
    """A table of all errors, each cell in a shade of its size."""
    head = "".join(f'<th class="case"><span>{case}</span></th>' for case in CASES)
    rows = []
    for row in table.rows:
        cells = "".join(_shaded(row.results[str(case)].total_deg) for case in CASES)
        rows.append(f"<tr><td>{escape(row.name)}</td>{cells}</tr>")
    body = f"<thead><tr><th></th>{head}</tr></thead><tbody>{''.join(rows)}</tbody>"
    return f'<div class="table heat"><table>{body}</table></div>'


def _shaded(degrees: float) -> str:
    share = float(np.clip(np.log10(max(degrees, 1e-3) / 0.03) / np.log10(180.0 / 0.03), 0.0, 1.0))
    return f'<td style="background: hsl({220 - 200 * share:.0f} 70% {96 - 36 * share:.0f}%)">{angle(degrees)}</td>'
