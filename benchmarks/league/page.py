"""The results as tables of a page, a file of numbers, and a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from importlib.metadata import version
from typing import Any, Final

import numpy as np

from league.contender import Setting
from league.tournament import Entry
from lie_rigid_body.evaluation.differences import Difference
from lie_rigid_body.league.cases import CASES, Case
from lie_rigid_body.league.table import BOUND, CaseResult, FilterRow, LeagueTable, rank_with_ties
from lie_rigid_body.report.filters import HEADINGS, cells_of_row

BEGIN: Final = "<!-- begin of the league -->"
END: Final = "<!-- end of the league -->"
DIGITS: Final = 4
"""Significant digits of a number in the file; each machine has others beyond the tenth."""
TUNED: Final = "tuned"
"""Setting of the rows with what is advised."""


def row_of(entry: Entry, *, tuned: bool) -> FilterRow:
    """A filter as a row of the reference set, at the defaults or with the settings that are advised."""
    found = entry.tuned if tuned else entry.defaults
    return FilterRow(
        entry.filter.full_name,
        {str(case): rounded(found[case].errors) for case in CASES},
        version(entry.filter.library),
        TUNED * tuned,
        {grade: dict(each.setting) for grade, each in entry.advice.items()} if tuned else {},
        entry.filter.sees_future,
    )


def reference(
    entries: Sequence[Entry], hashes: Mapping[Case, str], bounds: Mapping[str, float], real: Mapping[str, float]
) -> LeagueTable:
    """The reference set: a row at the defaults of each filter, and one with what is advised where something is."""
    rows = [row_of(entry, tuned=False) for entry in entries]
    rows += [row_of(entry, tuned=True) for entry in entries if entry.advice]
    floors = {name: short(value) for name, value in bounds.items()}
    names = {row.name for row in rows}
    real = {name: value for name, value in real.items() if name in names}
    return LeagueTable((), {str(case): hashes[case] for case in CASES}, floors, real).with_rows(rows)


def rounded(errors: CaseResult) -> CaseResult:
    """Errors without the digits of round-off."""
    shortened: dict[str, Any] = {k: short(v) for k, v in asdict(errors).items() if isinstance(v, float)}
    return replace(errors, **shortened)


def short(value: float) -> float:
    """A number with few digits; 0 below what is round-off."""
    return float(f"{round(value, 6):.{DIGITS}g}")


def table(entries: Sequence[Entry], league: LeagueTable) -> str:
    """One line for each filter, the best at the defaults first, with the errors at the settings that are advised."""
    rows = {row.name: row for row in league.rows}
    defaults = plain(league)
    by_name = {entry.filter.full_name: entry for entry in entries}
    lines = [[*HEADINGS, "µs"], ["---"] * (len(HEADINGS) + 1)]
    for row in defaults.rows:
        entry = by_name[row.filter]
        cells = cells_of_row(defaults, row)
        best = rows.get(f"{row.filter}, {TUNED}")
        if best:
            cells = [
                one if other in (one, "") else f"{one} → {other}"
                for one, other in zip(cells, cells_of_row(league, best), strict=True)
            ]
        cost = float(np.nanmedian([each.cost for each in entry.defaults.values()]))
        name = f"{entry.filter.library} `{entry.filter.name}`" + " *" * row.sees_future
        rank = rank_with_ties(defaults, row)
        lines.append([name, rank, *cells[2:], f"{cost:.2g}" if cost < 10.0 else f"{cost:.0f}"])
    lines.append([f"**{BOUND}**", *cells_of_row(league, league.bound)[1:], ""])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plain(league: LeagueTable) -> LeagueTable:
    """The rows at the defaults of their libraries."""
    return replace(league, rows=tuple(row for row in league.rows if row.setting != TUNED))


def advice(entries: Sequence[Entry], real: Mapping[str, float]) -> str:
    """Settings that are shown to be better than the defaults, and how much, also on real recordings."""
    lines = [["filter", "sensors", "setting", "of the default error", "real"], ["---"] * 5]
    for entry in sorted(entries, key=lambda entry: entry.filter.full_name):
        name = entry.filter.full_name
        for grade, each in entry.advice.items():
            tuned = real.get(f"{name}, {TUNED}") if grade == "mems" else None
            of_real = f"{tuned / real[name]:.2g}" if tuned else ""
            lines.append([name, grade, in_words(each.setting), share(each.difference), of_real])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def remarks(entries: Sequence[Entry]) -> str:
    """What the users of each filter should know."""
    told = sorted((entry.filter.full_name, entry.filter.advice) for entry in entries if entry.filter.advice)
    return "\n".join(f"- {name}: {words}." for name, words in told)


def in_words(setting: Setting) -> str:
    """A setting as one would write it."""
    return ", ".join(
        f"`{name}={value if isinstance(value, bool) else format(value, 'g')}`" for name, value in setting.items()
    )


def share(difference: Difference) -> str:
    """How large an error is beside that at the defaults."""
    return f"{difference.ratio:.2g} ({difference.low:.2g} to {difference.high:.2g})"


def replaced(page: str, *parts: str) -> str:
    """A page with its part on the league exchanged."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return "\n\n".join([f"{before}{BEGIN}", *parts, f"{END}{after}"])


def change(before: LeagueTable, after: LeagueTable, tolerance: float = 1e-3) -> Sequence[str]:
    """What differs between two tables: readings, rows, versions, and errors and bounds by more than a share."""
    old, new = ({row.name: row for row in table.rows} for table in (before, after))
    lines = [
        f"{case}: other readings" for case, digest in after.readings.items() if before.readings.get(case) != digest
    ]
    for case, now in after.bound_deg.items():
        was = before.bound_deg.get(case, 0.0)
        if abs(now - was) > tolerance * max(was, 1e-3):
            lines.append(f"{BOUND}, {case}: {was:.4g}° is {now:.4g}° now")
    lines += [f"gone: {name}" for name in old if name not in new] + [f"new: {name}" for name in new if name not in old]
    for name in sorted(old.keys() & new.keys()):
        if old[name].version != new[name].version:
            lines.append(f"{name}: version {old[name].version or 'unknown'} is {new[name].version} now")
        for case, result in new[name].results.items():
            was, now = old[name].results[case].total_deg, result.total_deg
            if abs(now - was) > tolerance * max(was, 1e-3):
                lines.append(f"{name}, {case}: {was:.4g}° is {now:.4g}° now")
    return lines
