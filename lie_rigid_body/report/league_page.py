"""The table of the league as one HTML page, with a heat map of every filter in every case."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lie_rigid_body.league import CASES, FilterRow, LeagueTable, standing
from lie_rigid_body.report import html_page
from lie_rigid_body.report.league_text import HEADINGS, angle, cells, numbers


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
    return html_page.document(f"League of attitude filters {table.edition}", _parts(table, own), with_figures=False)


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
        lines.append(f"<tr><td>{html_page.text(row.name)}</td>{''.join(map(_shaded, errors))}</tr>")
    body = f"<thead><tr><th></th>{head}</tr></thead><tbody>{''.join(lines)}</tbody>"
    return f'<div class="table heat"><table>{body}</table></div>'


def _shaded(degrees: float) -> str:
    share = float(np.clip(np.log10(max(degrees, 1e-3) / 0.03) / np.log10(180.0 / 0.03), 0.0, 1.0))
    return f'<td style="background: hsl({220 - 200 * share:.0f} 70% {96 - 36 * share:.0f}%)">{angle(degrees)}</td>'
