"""Work against precision, and drift over time, as pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from peers.measurement import Row, unit
from peers.table import families
from peers.task import LONG, NS, Task

Style = tuple[str, str, str]

STYLES: Final = {
    "ours, closed form": ("black", "*", "-"),
    "ours, moving chart rkmk4": ("#08519C", "o", "-"),
    "ours, moving chart dmv2": ("#B2EBF2", "8", "-"),
    "ours, moving chart dmv10": ("#04626B", "p", "-"),
    "ours, moving chart dmv20": ("#013338", "H", "-"),
    "FRB, exact": ("#B8860B", "*", "-."),
    "FRB, Gauss of order 10": ("#DAA520", "2", "-."),
    "van Zon, Schofield": ("#6B8E23", "*", "-."),
    "Orekit, TorqueFree": ("#556B2F", "3", "-."),
    "MuJoCo, Euler": ("#FDAE6B", "s", "--"),
    "MuJoCo, implicit": ("#FDD0A2", "p", "--"),
    "MuJoCo, implicitfast": ("#A63603", "x", "--"),
    "MuJoCo, RK4": ("#E6550D", "D", "--"),
    "Drake, discrete": ("#FCBBA1", "v", "--"),
    "Drake, continuous RK3": ("#EF3B2C", "^", "--"),
    "Drake, continuous RK5": ("#99000D", "o", "--"),
    "DART, free joint": ("#969696", "1", "-."),
    "PyBullet, multibody": ("#31A354", "<", "-."),
    "PyBullet, rigid body": ("#006D2C", "+", "-."),
    "diffrax, Tsit5": ("#E7298A", "4", ":"),
    "diffrax, Dopri8": ("#CE1256", "s", ":"),
    "jaxlie, RKMK4": ("#2B8CBE", "v", "--"),
    "SciPy, solve_ivp RK45": ("#DD1C77", "P", ":"),
    "SciPy, solve_ivp DOP853": ("#7A0177", "X", ":"),
    "SciPy, odeint (LSODA)": ("#C994C7", "h", ":"),
    "SciPy, ode dop853": ("#54278F", "d", ":"),
    "SciPy, RotationSpline": ("#8C6D31", ">", ":"),
}
"""Colour, marker and line: blue, teal and black are ours."""

FOR_A_NEW_METHOD: Final = (("#00CED1", "p", "-"), ("#3F007D", "8", "-"), ("#17BECF", "H", "-"))
MARKED_EVERY: Final = 4
"""Every so manieth point of a curve of the drift has a marker."""

ALIKE: Final = 1e-15
"""rad: curves of one kind of stepper that are nowhere farther apart are at round-off, and drawn as one."""

GUIDES: Final = ((0.5, "√t"), (1.0, "t"), (2.0, "t²"))


def work_precision(results: Mapping[str, tuple[Task, Sequence[Row]]]) -> Figure:
    """For each task, the cost of every setting over its largest error: the lower left corner is the best place."""
    figure = Figure(figsize=(16.0, 8.2), dpi=110, layout="constrained")
    styles = _styles([rows for _, rows in results.values()])
    panels = figure.subplots(1, len(results), sharex=True, squeeze=False)[0]
    for axes, (task, rows) in zip(panels, results.values(), strict=True):
        for family, members in families(rows).items():
            shown = [row for row in members if np.isfinite(row.largest)]
            cost = [row.cost / unit(rows) for row in shown]
            axes.loglog([row.largest for row in shown], cost, **_look(styles[family]))
        axes.axhline(1.0, color="0.6", lw=0.8, zorder=0)
        axes.set(title=task.title, xlabel="largest error of the attitude [rad]")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel(f"CPU time for a simulated second,\nin units of {_unit_name(next(iter(results.values()))[1])}")
    figure.suptitle("Work against precision: further left is more accurate, further down is cheaper")
    _legend(figure, styles, {})
    return figure


def drift(rows: Sequence[Row]) -> Figure:
    """The error over time of each family at the setting that is the most accurate on the whole."""
    figure = Figure(figsize=(13.0, 7.6), dpi=110, layout="constrained")
    axes = figure.subplots()
    t = np.array(LONG.judged_ns) / NS
    best = {
        family: min(members, key=lambda row: np.log(row.errors).mean()) for family, members in families(rows).items()
    }
    groups = coinciding({family: row.errors for family, row in best.items() if row.contender.ours})
    hidden = {family for group in groups for family in group[:-1]}
    best = {family: row for family, row in best.items() if family not in hidden}
    styles = {family: style for family, style in _styles([rows]).items() if family in best}
    labels = {family: f"{family}, {row.contender.setting}" for family, row in best.items()}
    for first, *_, last in groups:
        labels[last] = f"{first} … {last.split()[-1]}, {best[last].contender.setting}"
    count = len(best)
    for i, (family, row) in enumerate(best.items()):
        # curves that coincide are all seen: the first drawn are the widest, and markers take turns
        look = {**_look(styles[family]), "lw": 1.2 + 4.8 * (1.0 - i / count)}
        axes.loglog(t, row.errors, markevery=(i % MARKED_EVERY, MARKED_EVERY), **look)
    for power, name in GUIDES:
        axes.loglog(t, 3e-17 * t**power, color="0.55", lw=1.0, zorder=0)
        axes.annotate(name, (t[-1], 3e-17 * t[-1] ** power), (12, -3), textcoords="offset points", color="0.35")
    axes.set(xlabel="simulated time [s]", ylabel="error of the attitude [rad]", xlim=(0.8 * t[0], 1.35 * t[-1]))
    axes.set_title("Drift: every contender at its most accurate setting that was run")
    axes.grid(alpha=0.3)
    _legend(figure, styles, labels)
    return figure


def coinciding(errors: Mapping[str, NDArray[np.float64]]) -> list[tuple[str, ...]]:
    """Runs of two or more families of ours, one after the other, whose errors are `ALIKE`: all are at round-off."""
    runs: list[list[str]] = []
    for family, values in errors.items():
        if runs and np.abs(values - errors[runs[-1][0]]).max() <= ALIKE and _kind(family) == _kind(runs[-1][0]):
            runs[-1].append(family)
        else:
            runs.append([family])
    return [tuple(run) for run in runs if len(run) > 1]


def _kind(family: str) -> str:
    """The name of a family without its order."""
    return family.rstrip("0123456789")


def _styles(tables: Sequence[Sequence[Row]]) -> dict[str, Style]:
    """How each family that takes part is drawn; a method of ours that is new here gets a look of its own."""
    seen = dict.fromkeys(row.contender.family for rows in tables for row in rows)
    spare = iter(FOR_A_NEW_METHOD * len(seen))
    return {family: STYLES.get(family) or next(spare) for family in seen}


def _look(style: Style) -> dict[str, Any]:
    colour, marker, line = style
    ours = line == "-"
    size = 15 if marker == "*" else 7
    return {"color": colour, "marker": marker, "ls": line, "lw": 2.2 if ours else 1.4, "ms": size, "mew": 1.5}


def _legend(figure: Figure, styles: Mapping[str, Style], labels: Mapping[str, str]) -> None:
    """Below the picture, in columns."""
    entries = [Line2D([], [], label=labels.get(name, name), **_look(style)) for name, style in styles.items()]
    figure.legend(handles=entries, loc="outside lower center", ncols=4, frameon=False, fontsize=10)


def _unit_name(rows: Sequence[Row]) -> str:
    return next(f"{r.contender.family}, {r.contender.setting}" for r in rows if r.contender.unit)
