"""What is told of filters: the diagnosis of one, and the league; lines for a terminal, and pages without a network."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.diagnosis.examination import degrees
from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.league import CASES, EDITION, GRADES, FilterRow, LeagueTable, standing
from lie_rigid_body.league.table import angle
from lie_rigid_body.report import html_page
from lie_rigid_body.report.drawing import BLACK, BLUE, GREEN, ORANGE
from lie_rigid_body.report.html_page import escaped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MISTAKES: Final = "{:<20} {:<18.18} {:>10} {:>10}  {}"
_PROBES: Final = "{:<20} {:<8} {:>10}  "
_HEADINGS: Final = ("filter", "rank", *GRADES, "faults", "overall")
_ROWS: Final = "{:<42.42} {:>4} {:>8} {:>10} {:>8} {:>8} {:>8} {:>8}"


def lines_of_diagnosis(found: FilterDiagnosis) -> Iterator[str]:
    """Lines of the sentences, the mistakes, the probes and the notes for a terminal."""
    for sentence in found.sentences:
        yield from wrapped(sentence)
    if found.mistakes:
        rows = [("mistake", "repair", "before", "after", "or else"), *_cells_of_mistakes(found)]
        yield from ("", *(_MISTAKES.format(*cells).rstrip() for cells in rows))
    if found.probes:
        yield from ("", _PROBES.format("probe", "", "value").rstrip())
    for p in found.probes:
        value = "" if p.value is None else f"{p.value:.3g}"
        yield from wrapped(p.message, _PROBES.format(p.code, "passed" if p.passed else "FAILED", value))
    yield ""
    for note in found.notes:
        yield from wrapped(note.message, f"note: {note.code}: ")
    yield from found.remarks  # each on one line, as it may be a command
    yield f"{counted(found.filter_runs, 'run')} of the filter."


def _cells_of_mistakes(found: FilterDiagnosis) -> list[tuple[str, ...]]:
    """Code, repair, error before and after, and what explains each mistake as well."""
    return [
        (m.code, m.repair, degrees(m.rms_deg_before), degrees(m.rms_deg_after), ", ".join(m.or_else))
        for m in found.mistakes
    ]


def page_of_diagnosis(name: str, found: FilterDiagnosis) -> bytes:
    """The page of the filter that is called so, as HTML."""
    probes = [
        f"<strong>{'passed' if p.passed else 'FAILED'}</strong> <code>{p.code}</code> {escaped(p.message)}"
        for p in sorted(found.probes, key=lambda probe: probe.passed)
    ]
    parts = [
        *(html_page.badge(sentence, passed=found.passed) for sentence in found.sentences),
        html_page.picture(lambda width: _draw(found, width)) if found.errors else "",
        f"<h2>Mistakes</h2>{mistakes(found)}" if found.mistakes else "",
        html_page.listing("Probes", probes),
        html_page.listing("Notes", (f"<code>{note.code}</code> {escaped(note.message)}" for note in found.notes)),
        *map(html_page.paragraph, found.remarks),
        html_page.paragraph(
            f"{found.filter_runs} runs of the filter, with perfect sensors but where a probe says otherwise. Nothing "
            f"is looked for below {found.floor_deg:.2g}°, a tenth of the turn between two readings."
        ),
    ]
    return html_page.document(f"Diagnosis of {name}", filter(None, parts))


def mistakes(found: FilterDiagnosis) -> str:
    """Table of the mistakes as HTML."""
    return html_page.table(
        ("mistake", "repair", "error before", "error after", "or else"),
        [(cells, True) for cells in _cells_of_mistakes(found)],
    )


def _draw(found: FilterDiagnosis, width: float) -> Figure:
    """The total error before and after each named repair."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, 3.8), layout="constrained")
    axes = figure.subplots()
    for each, colour in zip(found.errors, cycle((ORANGE, BLUE, GREEN, BLACK)), strict=False):
        errors = np.maximum(each.error_deg, 1e-4)  # those of a right filter may be 0
        axes.plot(each.t_s, errors, color=colour, label=f"{each.code} repaired" if each.code else "as it is")
    axes.axhline(found.floor_deg, color="#888888", linestyle=":", label="floor")
    axes.set(xlabel="time, s", ylabel="total error, °", yscale="log")
    axes.margins(x=0.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4 if width > 5.0 else 2, frameon=False)
    return figure


def lines_of_league(table: LeagueTable, own: Sequence[FilterRow]) -> Iterator[str]:
    """Lines of the table for a terminal, with marks at one's own rows, and a paragraph for each of these."""
    yield f"RMS of the total error from 30 s on, degrees: medians over the cases of a grade. Edition {EDITION}."
    yield "A star marks filters that see later readings."
    yield _ROWS.format(*_HEADINGS).rstrip()
    for row in table.rows:
        name, *others = _cells_of_row(table, row)
        yield _ROWS.format("> " * (row in own) + name, *others)
    yield _ROWS.format(*_cells_of_row(table, table.best_possible))
    for row in own:
        yield from ("", *wrapped(standing(table, row)))


def _cells_of_row(table: LeagueTable, row: FilterRow) -> list[str]:
    """Name, rank and errors: the typical ones of each grade and with faults, and the overall one.

    A star marks filters that see later readings; the best possible has no rank.
    """
    rank = f"{table.rank(row)}" if row in table.rows else ""
    errors = (*map(row.typical_deg, GRADES), row.typical_deg("mems", faults=True), row.overall_deg)
    return [row.name + " *" * row.sees_future, rank, *map(angle, errors)]


def page_of_league(table: LeagueTable, own: Sequence[FilterRow]) -> bytes:
    """The page as HTML, on which one's own rows are marked."""
    rows = [(_cells_of_row(table, row), row not in own) for row in (*table.rows, table.best_possible)]
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
    cases = "".join(f'<th class="case"><span>{case}</span></th>' for case in CASES)
    body = "".join(
        f"<tr><td>{escaped(row.name)}</td>{''.join(_shaded(row.results[str(case)].total_deg) for case in CASES)}</tr>"
        for row in table.rows
    )
    head = f"<thead><tr><th></th>{cases}</tr></thead>"
    return f'<div class="table heat"><table>{head}<tbody>{body}</tbody></table></div>'


def _shaded(error_deg: float) -> str:
    share = float(np.clip(np.log10(max(error_deg, 1e-3) / 0.03) / np.log10(180.0 / 0.03), 0.0, 1.0))
    return f'<td style="background: hsl({220 - 200 * share:.0f} 70% {96 - 36 * share:.0f}%)">{angle(error_deg)}</td>'
