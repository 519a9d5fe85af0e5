"""The results as tables of a page, a file of numbers, and a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from importlib.metadata import version
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from league.contender import Setting
from league.tournament import Entry
from lie_rigid_body.evaluation.differences import Difference
from lie_rigid_body.league.cases import CASES, FAULTY, GROUPS, RANKED, WIRING, Case
from lie_rigid_body.league.table import BOUND, CaseResult, FilterRow, LeagueTable, angle, rank_with_ties

BEGIN: Final = "<!-- begin of the league -->"
END: Final = "<!-- end of the league -->"
DIGITS: Final = 4
"""Significant digits of a number in the file; each machine has others beyond the tenth."""
TUNED: Final = "tuned"
"""Setting of the rows with what is advised."""
Real = Mapping[str, float]
"""Median error of rows on real recordings, degrees, by their names."""


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
        entry.defaults[WIRING].constant,
    )


def reference(entries: Sequence[Entry], hashes: Mapping[Case, str], bounds: Mapping[str, float]) -> LeagueTable:
    """The reference set: a row at the defaults of each filter, and one with what is advised where something is."""
    rows = [row_of(entry, tuned=False) for entry in entries]
    rows += [row_of(entry, tuned=True) for entry in entries if entry.advice]
    floors = {name: short(value) for name, value in bounds.items()}
    return LeagueTable((), {str(case): hashes[case] for case in CASES}, floors).with_rows(rows)


def rounded(errors: CaseResult) -> CaseResult:
    """Errors without the digits of round-off."""
    shortened: dict[str, Any] = {k: short(v) for k, v in asdict(errors).items() if isinstance(v, float)}
    return replace(errors, **shortened)


def short(value: float) -> float:
    """A number with few digits; 0 below what is round-off."""
    return float(f"{round(value, 6):.{DIGITS}g}")


def table(entries: Sequence[Entry], league: LeagueTable, real: Real) -> str:
    """One line for each filter, the best at the defaults first."""
    rows = {row.name: row for row in league.rows}
    head = ["filter", "rank", "overall", *GROUPS, *(["real"] if real else [])]
    head += ["heading", "inclination", "settles [s]", "faults", "perfect", "lost", "µs"]
    lines = [head, ["---"] * len(head)]
    defaults = LeagueTable((), league.readings, league.bound_deg).with_rows(
        row for row in league.rows if row.setting != TUNED
    )
    by_name = {entry.filter.full_name: entry for entry in entries}
    for row in defaults.rows:
        entry = by_name[row.filter]
        best = rows.get(f"{row.filter}, {TUNED}", row)
        cells = [both(row.overall_deg, best.overall_deg)]
        cells += [both(row.group_deg(group), best.group_deg(group)) for group in GROUPS]
        if real:
            cells.append(both(real[row.name], real.get(best.name, real[row.name])))
        cells += [angle(row.median(RANKED, what)) for what in ("heading_deg", "inclination_deg")]
        settles = row.median(RANKED, "converged_s")
        cells.append(f"{settles:.2g}" if np.isfinite(settles) else "never")
        cells += [both(row.median(FAULTY), best.median(FAULTY)), angle(row.results[str(WIRING)].total_deg)]
        cost = float(np.nanmedian([each.cost for each in entry.defaults.values()]))
        cells += [str(row.lost or ""), f"{cost:.2g}" if cost < 10.0 else f"{cost:.0f}"]
        name = f"{entry.filter.library} `{entry.filter.name}`" + " *" * row.sees_future
        lines.append([name, rank_with_ties(defaults, row), *cells])
    bound = [angle(each) for each in (league.bound.overall_deg, *map(league.bound.group_deg, GROUPS))]
    lines.append([f"**{BOUND}**", "", *bound, *[""] * (len(head) - len(bound) - 2)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def both(default: float, tuned: float) -> str:
    """The error at the defaults, and with what is advised if it is another."""
    return angle(default) if angle(default) == angle(tuned) else f"{angle(default)} → {angle(tuned)}"


def advice(entries: Sequence[Entry]) -> str:
    """What the users of each filter should know, and settings that are shown to be better than the defaults."""
    lines = []
    for entry in sorted(entries, key=lambda entry: entry.filter.full_name):
        found = [
            f"with {grade} sensors {in_words(each.setting)}: {share(each.difference)}"
            for grade, each in entry.advice.items()
        ]
        nothing = "no point of its grid is shown to be better than the defaults" if entry.filter.grid else ""
        said = [entry.filter.advice, "; ".join(found) or nothing]
        if any(said):
            lines.append(f"- {entry.filter.library} `{entry.filter.name}`: {'; '.join(filter(None, said))}.")
    return "\n".join(lines)


def in_words(setting: Setting) -> str:
    """A setting as one would write it."""
    return ", ".join(
        f"`{name}={value if isinstance(value, bool) else format(value, 'g')}`" for name, value in setting.items()
    )


def share(difference: Difference) -> str:
    """How large an error is beside that at the defaults."""
    return f"{difference.ratio:.2g} of the default error ({difference.low:.2g} to {difference.high:.2g})"


def replaced(page: str, *parts: str) -> str:
    """A page with its part on the league exchanged."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return "\n\n".join([f"{before}{BEGIN}", *parts, f"{END}{after}"])


def picture(league: LeagueTable, real: Real) -> Figure:
    """Error of each filter at the defaults in each group, and on real recordings, the best first."""
    rows = [row for row in league.rows if row.setting != TUNED]
    places = np.arange(len(rows))
    figure = Figure(figsize=(8.5, 0.26 * len(rows) + 1.4), dpi=110, layout="constrained")
    axes = figure.subplots()
    of_groups = np.array([[*map(row.group_deg, GROUPS)] for row in rows])
    axes.hlines(places, of_groups.min(axis=1), of_groups.max(axis=1), color="#cccccc", lw=2, zorder=1)
    for group, colour, marker in zip(GROUPS, ("#0072b2", "#009e73", "#e69f00", "#cc79a7"), "osD^", strict=True):
        axes.scatter(
            [row.group_deg(group) for row in rows], places, c=colour, marker=marker, s=22, label=group, zorder=2
        )
    axes.scatter([row.overall_deg for row in rows], places, c="black", marker="|", s=90, label="overall", zorder=3)
    if real:
        axes.scatter(
            [real[row.name] for row in rows],
            places,
            c="#d55e00",
            marker="x",
            s=34,
            label="ten real recordings",
            zorder=4,
        )
    axes.axvline(league.bound.overall_deg, color="#888888", ls=":", label=BOUND)
    axes.set_yticks(places, [row.filter + " *" * row.sees_future for row in rows], fontsize=8)
    axes.set(xscale="log", xlabel="RMS of the total error at the library's defaults, °", ylim=(len(rows) - 0.4, -0.6))
    axes.grid(axis="x", which="both", lw=0.3)
    axes.legend(loc="lower left", fontsize=8, framealpha=0.95)
    return figure


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
