"""Answers about filters: the diagnosis of one, and the league."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import cycle
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.diagnosis.filter_diagnosis import degrees
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.league import EDITION, FilterRow, LeagueTable, standing
from lie_rigid_body.league.cases import FAULTY, GROUPS, RANKED, SETTLED_S, WIRING
from lie_rigid_body.league.table import angle, rank_with_ties
from lie_rigid_body.report import html_page
from lie_rigid_body.report.answer import Conclusion, Parts, Picture, Sentences, Table
from lie_rigid_body.report.drawing import BLACK, BLUE, GREEN, ORANGE, PINK, finish

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEADINGS: Final = (
    *("filter", "rank", "overall"),
    *GROUPS,
    *("real", "heading", "inclination", "settles [s]", "faults", "perfect", "lost"),
)
"""Columns of the league."""


def parts_of_diagnosis(found: FilterDiagnosis) -> Parts:
    """Answer about what is wrong with a filter."""
    return [
        Conclusion(found.sentences, found.passed),
        *([Picture(lambda: html_page.picture(partial(_draw, found)))] if found.errors else []),
        Table(
            ("mistake", "repair", "before", "after", "or else"),
            [
                (m.code, m.repair, degrees(m.rms_deg_before), degrees(m.rms_deg_after), ", ".join(m.or_else))
                for m in found.mistakes
            ],
            "Mistakes",
        ),
        Table(
            ("probe", "", "value", ""),
            [
                (
                    p.code,
                    {True: "passed", False: "FAILED", None: "not judged"}[p.passed],
                    "" if p.value is None else f"{p.value:.3g}",
                    p.message,
                )
                for p in found.probes
            ],
            "Probes",
            [probe.passed is False for probe in found.probes],
        ),
        Table(
            ("situation", "RMS error"),
            [(s.name, "failed" if s.rms_deg is None else degrees(s.rms_deg)) for s in found.situations],
            "Situations, with perfect sensors",
        ),
        Sentences([f"{note.code}: {note.message}" for note in found.notes], "Notes"),
        Sentences(found.remarks),
        Sentences(
            [
                f"{counted(found.filter_runs, 'run')} of the filter, {counted(found.updates, 'reading')} of the gyro, "
                "with perfect sensors but where a probe says otherwise. Nothing is looked for below "
                f"{found.floor_deg:.2g}°, a tenth of the turn between two readings."
            ]
        ),
    ]


def _draw(found: FilterDiagnosis) -> Figure:
    """The total error before and after each named repair."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    axes = figure.subplots()
    for each, colour in zip(found.errors, cycle((ORANGE, BLUE, GREEN, BLACK)), strict=False):
        errors = np.maximum(each.error_deg, 1e-4)  # those of a right filter may be 0
        axes.plot(each.t_s, errors, color=colour, label=f"{each.code} repaired" if each.code else "as it is")
    axes.axhline(found.floor_deg, color="#888888", linestyle=":", label="floor")
    axes.set(xlabel="time, s", ylabel="total error, °", yscale="log")
    axes.margins(x=0.0)
    finish(axes, 4)
    return figure


def parts_of_league(table: LeagueTable, own: Sequence[FilterRow]) -> Parts:
    """Answer about the place of one's own rows in the league; they are marked."""
    rows = (*table.rows, table.bound)
    return [
        Sentences([standing(table, row) for row in own]),
        Sentences(
            [
                f"RMS of the total error from {SETTLED_S:g} s on, degrees: medians over the cases of a group, as "
                "geometric means over MEMS and tactical sensors. Filters are ranked by the geometric mean over the "
                "groups; in brackets are the ranks between which no difference is shown, by pairs of cases. "
                f"Edition {EDITION}.",
                "A star marks filters that see later readings. Filters that do not follow perfect sensors stand last. "
                "Real is the median over ten real recordings of the data set BROAD.",
            ]
        ),
        Table(
            HEADINGS,
            [("> " * (row in own) + name, *cells) for row in rows for name, *cells in [cells_of_row(table, row)]],
            marked=[row in own for row in rows],
        ),
        Picture(lambda: html_page.picture(partial(draw_league, table, 10.0))),
    ]


def cells_of_row(table: LeagueTable, row: FilterRow) -> list[str]:
    """Cells of a row; a star marks filters that see later readings, and the bound has no rank."""
    of_groups = map(angle, (row.overall_deg, *map(row.group_deg, GROUPS)))
    if row not in table.rows:
        return [row.name, "", *of_groups, *[""] * 7]
    settles_s = row.median(RANKED, "converged_s")
    return [
        row.name + " *" * row.sees_future,
        rank_with_ties(table, row),
        *of_groups,
        angle(table.real_deg[row.name]) if row.name in table.real_deg else "",
        *(angle(row.median(RANKED, what)) for what in ("heading_deg", "inclination_deg")),
        f"{settles_s:.2g}" if np.isfinite(settles_s) else "never",
        angle(row.median(FAULTY)),
        angle(row.results[str(WIRING)].total_deg),
        str(row.lost or ""),
    ]


def draw_league(table: LeagueTable, width: float) -> Figure:
    """Error of each row in each group, the best first, and on real recordings."""
    from matplotlib.figure import Figure

    rows, places = table.rows, np.arange(len(table.rows))
    of_groups = np.array([[*map(row.group_deg, GROUPS)] for row in rows]).reshape(-1, len(GROUPS))
    real = [table.real_deg.get(row.name, np.nan) for row in rows]
    figure = Figure(figsize=(width, 0.22 * len(rows) + 1.2), layout="constrained")
    axes = figure.subplots()
    axes.hlines(places, of_groups.min(axis=1), of_groups.max(axis=1), color="#cccccc")
    for errors, colour, group in zip(of_groups.T, (BLUE, GREEN, ORANGE, PINK), GROUPS, strict=True):
        axes.scatter(errors, places, s=16, color=colour, label=group)
    axes.scatter([row.overall_deg for row in rows], places, marker="|", color=BLACK, s=60, label="overall")
    axes.scatter(real, places, marker="x", color=BLACK, s=22, label="real recordings")
    axes.set_yticks(places, [row.name + " *" * row.sees_future for row in rows], fontsize=7)
    axes.set(xscale="log", xlabel="RMS of the total error, °: less is better", ylim=(len(rows) - 0.4, -0.6))
    axes.xaxis.set_major_formatter("{x:g}")
    if in_doubt := sum(not row.is_wired for row in rows):  # they stand at the end
        axes.axhline(len(rows) - in_doubt - 0.5, color="#888888", linestyle=":")
    finish(axes, 3)
    return figure
