"""League: its table for a terminal, and as a page with the errors of every filter in every case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import Final

import numpy as np

from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.league import CASES, EDITION, GRADES, FilterRow, LeagueTable, standing
from lie_rigid_body.report import html_page

HEADINGS: Final = ("filter", "rank", *GRADES, "faults", "overall")
_COLUMNS: Final = "{:<42} {:>4} {:>8} {:>10} {:>8} {:>8} {:>8} {:>8}"
_LONGEST_NAME: Final = 42
_OWN: Final = "> "
"""Mark of one's own rows."""


def as_text(table: LeagueTable, own: Sequence[FilterRow]) -> str:
    """The table with marks at one's own rows, and a paragraph for each of these."""
    return "\n".join(_lines(table, own))


def _lines(table: LeagueTable, own: Sequence[FilterRow]) -> Iterator[str]:
    yield f"RMS of the total error from 30 s on, degrees: medians over the cases of a grade. Edition {EDITION}."
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


def page(table: LeagueTable, own: Sequence[FilterRow]) -> bytes:
    """Make the page.

    Parameters
    ----------
    table : LeagueTable
    own : sequence of FilterRow
        Rows of one's own, which are marked.

    Returns
    -------
    bytes
        HTML.
    """
    return html_page.document(f"League of attitude filters {EDITION}", _parts(table, own), with_figures=False)


def _parts(table: LeagueTable, own: Sequence[FilterRow]) -> Iterator[str]:
    yield from (html_page.paragraph(standing(table, row)) for row in own)
    yield "<h2>Errors</h2>"
    yield html_page.paragraph(
        "RMS of the total error from 30 s on, degrees: medians over the cases of a grade of sensors. Filters are "
        "ranked by the geometric mean over the grades of real sensors. A star marks those that see later readings."
    )
    rows = [(cells(table, row), row not in own) for row in table.rows]
    yield html_page.table(HEADINGS, [*rows, ([table.best_possible.name, "", *numbers(table.best_possible)], True)])
    yield f"<h2>Every case</h2>{_heat_map(table)}"


def _heat_map(table: LeagueTable) -> str:
    """A table of all errors, each cell in a shade of its size."""
    head = "".join(f'<th class="case"><span>{case}</span></th>' for case in CASES)
    lines = []
    for row in table.rows:
        errors = [row.results[str(case)].total_deg for case in CASES]
        lines.append(f"<tr><td>{escape(row.name)}</td>{''.join(map(_shaded, errors))}</tr>")
    body = f"<thead><tr><th></th>{head}</tr></thead><tbody>{''.join(lines)}</tbody>"
    return f'<div class="table heat"><table>{body}</table></div>'


def _shaded(degrees: float) -> str:
    share = float(np.clip(np.log10(max(degrees, 1e-3) / 0.03) / np.log10(180.0 / 0.03), 0.0, 1.0))
    return f'<td style="background: hsl({220 - 200 * share:.0f} 70% {96 - 36 * share:.0f}%)">{angle(degrees)}</td>'
