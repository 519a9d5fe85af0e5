"""The results as tables of a page, a file of numbers, and a heat map."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Final

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from league.contender import Filter
from league.tournament import Result, by_filter
from lie_rigid_body.league.cases import CASES, FAULTS, GRADES, MOTIONS, REAL, Case, readings_hash, run_of
from lie_rigid_body.league.table import BOUND, MIN_DEG, CaseResult, FilterRow, LeagueTable, angle, is_of
from lie_rigid_body.sensors import PERFECT

BEGIN: Final = "<!-- begin of the league -->"
END: Final = "<!-- end of the league -->"
BLURRED: Final = 5.0
"""With perfect sensors a filter errs by no more than this, degrees, or its wiring is in doubt."""
DIGITS: Final = 10
"""Decimals of a number in the file: what is smaller is round-off, which is another on other machines."""

Ranking = Sequence[tuple[Filter, list[Result], list[Result]]]


def ranking(defaults: Sequence[Result], best: Sequence[Result]) -> Ranking:
    """Filters with their results at the defaults and at the best setting, the most accurate first."""
    pairs = zip(by_filter(defaults), by_filter(best), strict=True)
    rows = [(each, plain, tuned) for (each, plain), (_, tuned) in pairs]
    return sorted(rows, key=lambda row: (bool(doubt(row[2])), overall(row[2])))


def overall(results: Sequence[Result]) -> float:
    """What filters are ranked by: geometric mean over the grades of real sensors of the median errors, degrees."""
    return float(np.exp(np.mean([np.log(typical(results, [grade])) for grade in REAL])))


def typical(results: Iterable[Result], grades: Sequence[str], fault: bool = False) -> float:
    """Median of the total errors over the cases of some grades, degrees."""
    found = [r.total for r in results if r.case.grade in grades and bool(r.case.fault) == fault]
    return float(np.median(found)) if found else float("nan")


def doubt(tuned: Iterable[Result]) -> str:
    """Why a filter's conventions are not proved by perfect sensors at its best setting, or nothing."""
    slow = next(r for r in tuned if r.case == Case("slow_tumble", "perfect"))
    return f"{slow.total:.2g}° with perfect sensors" if slow.total > BLURRED else ""


def table(rows: Ranking, bounds: Mapping[str, float]) -> str:
    """One line for each filter."""
    head = ["filter", *GRADES, *(["faults"] if FAULTS else []), "heading", "inclination", "settles [s]"]
    head.append("µs")
    lines = [head, ["---"] * len(head)]
    for each, plain, tuned in rows:
        mems = [r for r in tuned if r.case.grade == "mems" and not r.case.fault]
        columns = [f"{each.library} `{each.name}`" + " *" * each.sees_future]
        columns += [both(typical(plain, [grade]), typical(tuned, [grade])) for grade in GRADES]
        if FAULTS:
            columns.append(both(typical(plain, ["mems"], True), typical(tuned, ["mems"], True)))
        columns += [
            angle(float(np.median([getattr(r.errors, axis) for r in mems])))
            for axis in ("heading_deg", "inclination_deg")
        ]
        settled = float(np.median([np.inf if r.errors.converged_s is None else r.errors.converged_s for r in mems]))
        columns.append(f"{settled:.2g}" if np.isfinite(settled) else "never")
        cost = float(np.nanmedian([r.cost for r in plain]))
        columns.append(f"{cost:.2g}" if cost < 10.0 else f"{cost:.0f}")
        lines.append(columns)
    floor = [angle(each) for each in floors(bounds)]
    lines.append([f"**{BOUND}**", "0", *floor, *([""] if FAULTS else []), "", "", "", ""])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def floors(bounds: Mapping[str, float]) -> list[float]:
    """Medians of the bounds with each grade of real sensors, degrees."""
    return [float(np.median([bounds[str(case)] for case in CASES if is_of(case, grade)])) for grade in REAL]


def both(default: float, tuned: float) -> str:
    """The error at the defaults, and at the best setting if it is another."""
    return angle(default) if angle(default) == angle(tuned) else f"{angle(default)} → {angle(tuned)}"


def advice(rows: Ranking) -> str:
    """What the users of each filter should know, and the setting for MEMS sensors if it is better than the defaults."""
    lines = []
    for each, plain, tuned in rows:
        setting = next(r.setting for r in tuned if r.case == Case("slow_tumble", "mems"))
        better = typical(tuned, ["mems"]) < typical(plain, ["mems"])
        chosen = ", ".join(f"`{name}={value:g}`" for name, value in setting.items() if better)
        said = [doubt(tuned), each.advice, f"with MEMS sensors {chosen}" if chosen else ""]
        if any(said):
            lines.append(f"- {each.library} `{each.name}`: {'; '.join(filter(None, said))}.")
    return "\n".join(lines)


def replaced(page: str, rows: Ranking, bounds: Mapping[str, float]) -> str:
    """A page with its part on the league exchanged."""
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    return f"{before}{BEGIN}\n\n{table(rows, bounds)}\n\n{advice(rows)}\n\n{END}{after}"


def heat_map(rows: Ranking, bounds: Mapping[str, float]) -> Figure:
    """The total error of each filter, at its best setting, in each case."""
    shown = [Case(motion, grade) for grade in GRADES for motion in MOTIONS]
    shown += [Case("slow_tumble", "mems", fault) for fault in FAULTS]
    numbers = [[{r.case: r.total for r in tuned}[case] for case in shown] for _, _, tuned in rows]
    numbers.append([0.0 if case.grade == PERFECT else bounds.get(str(case), np.nan) for case in shown])
    names = [each.full_name for each, _, _ in rows] + [BOUND]
    figure = Figure(figsize=(0.42 * len(shown) + 4.0, 0.27 * len(names) + 2.6), dpi=110, layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(np.maximum(numbers, 1e-3), norm=LogNorm(1e-3, 180.0), cmap="viridis_r", aspect="auto")
    for row, line in enumerate(numbers):
        for column, value in enumerate(line):
            text = "" if np.isnan(value) else angle(value if value >= 5e-4 else 0.0)
            color = "white" if value > 0.5 else "black"
            axes.text(column, row, text, ha="center", va="center", fontsize=6, color=color)
    axes.set_xticks(
        range(len(shown)), [case.fault or case.motion for case in shown], rotation=60, ha="right", fontsize=7
    )
    axes.set_yticks(range(len(names)), names, fontsize=7)
    ends = [len(MOTIONS) * (i + 1) - 0.5 for i in range(len(GRADES))] + [len(shown) - 0.5]
    for begin, end, title in zip([-0.5, *ends], ends, [*GRADES, "mems, slow tumble, with a fault"], strict=False):
        if end > begin:
            axes.axvline(end, color="white", lw=2)
            axes.text((begin + end) / 2, -0.8, title, ha="center", va="bottom", fontsize=8)
    figure.colorbar(image, ax=axes, label="RMS of the total error after 30 s [°]", pad=0.01, extend="min")
    return figure


def reference(defaults: Sequence[Result], best: Sequence[Result], bounds: Mapping[str, float]) -> LeagueTable:
    """The results as the reference set of the package: a row at the defaults, and one at the best settings."""
    rows = []
    for results, setting in ((defaults, ""), (best, "tuned")):
        for each, found in by_filter(results):
            if not setting or any(result.setting for result in found):
                errors = {str(result.case): rounded(result.errors) for result in found}
                rows.append(FilterRow(each.full_name, errors, version(each.library), setting, each.sees_future))
    return LeagueTable((), {str(case): readings_hash(run_of(case)) for case in CASES}, bounds).with_rows(rows)


def rounded(errors: CaseResult) -> CaseResult:
    """Errors without the digits of round-off, of which each machine has its own."""
    short = {k: float(f"{round(v, DIGITS):.6g}") for k, v in asdict(errors).items() if isinstance(v, float)}
    return CaseResult(**{**asdict(errors), **short})


def change(before: LeagueTable, after: LeagueTable, tolerance: float = 1e-3) -> Sequence[str]:
    """What differs between two tables: readings, rows, versions, and errors and bounds by more than a share."""
    old, new = ({row.name: row for row in table.rows} for table in (before, after))
    lines = [f"{case}: other readings" for case in CASES if before.readings[str(case)] != after.readings[str(case)]]
    for case, now in after.bound_deg.items():
        was = before.bound_deg.get(case, 0.0)
        if abs(now - was) > tolerance * max(was, MIN_DEG):
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
