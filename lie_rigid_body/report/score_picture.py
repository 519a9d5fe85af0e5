"""The picture of a score: the errors over time, with the limits, and the NEES with its bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation import Consistency, Score
from lie_rigid_body.evaluation.estimate import GAP
from lie_rigid_body.report.recorded_motion import RED, curve_style, extremes
from lie_rigid_body.wording import counted, printable, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS: Final = {
    "total": "#333333",
    "heading": "#0072B2",
    "inclination": "#D55E00",
    "best by noise": "#CC79A7",
    "NEES": "#333333",
}
"""Colours of the curves, distinct in every kind of colour vision."""
_GREEN: Final = "#009E73"
_COLUMNS: Final = 2000
"""Number of intervals of time of a long curve, so that no peak is lost."""
_LONGEST_LINE: Final = 110
"""Number of characters of a line of the title that the figure has room for."""
_WIDE_SPAN: Final = 30.0
"""Ratio of the largest error to the median above which the axis is logarithmic."""


def draw(title: str, score: Score) -> Figure:
    """Figure of a score, under a title that may hold anything."""
    from matplotlib.figure import Figure

    rows = 2 if score.consistency is None else 3
    figure = Figure(figsize=(10.0, 2.2 + 2.0 * rows), dpi=120, layout="constrained")
    panels: list[Axes] = list(figure.subplots(rows, sharex=True))
    _draw_angles(panels[0], score, "total")
    if score.best is not None and not score.best.unobserved:
        _plot(panels[0], score.t_s, score.best.filtered_deg, "best by noise", 0.8)
    _draw_limits(panels[0], score)
    _draw_angles(panels[1], score, "heading", "inclination")
    if score.consistency is not None:
        _draw_nees(panels[2], score.t_s, score.consistency)
    for axes in panels:
        if axes.get_yscale() == "linear":
            axes.set_ylim(bottom=0.0)  # when all is drawn: from here on it no longer makes room
        axes.grid(alpha=0.3, lw=0.6)
        axes.margins(x=0.0)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, frameon=False, borderaxespad=0.1)
    panels[-1].set_xlabel("time since the first estimate [s]")
    # the names of a file and a topic may hold anything, and ``$`` is no formula
    rms = f"attitude error {score.total_deg.rms:.4g}° rms, {counted(score.samples, 'sample')}"
    figure.suptitle(f"{shortened(printable(title), _LONGEST_LINE)}\n{rms}", fontsize=11, parse_math=False)
    return figure


def curves(title: str, scores: Sequence[tuple[str, Score]]) -> Figure:
    """Figure of the total errors of several estimates, under their names."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 4.6), dpi=120, layout="constrained")
    axes = figure.subplots()
    first_ns = min(int(score.stamps_ns[0]) for _, score in scores)
    for number, (name, score) in enumerate(scores):
        t_s, degrees = (score.stamps_ns - first_ns) / 1e9, np.degrees(score.error.total)
        label = f"{shortened(printable(name), 30)}, {score.total_deg.rms:.4g}° rms".replace("$", r"\$")
        axes.plot(*_thinned(t_s, degrees), label=label, color=f"C{number % 10}", **curve_style(len(degrees), 1.0))
    errors = np.concatenate([score.error.total for _, score in scores])
    if np.median(errors) > 0.0 and errors.max() > _WIDE_SPAN * np.median(errors):
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    axes.set(xlabel="time since the first estimate [s]", ylabel="total error [deg]")
    axes.grid(alpha=0.3, lw=0.6)
    axes.margins(x=0.0)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)
    figure.suptitle(shortened(printable(title), _LONGEST_LINE), fontsize=11, parse_math=False)
    return figure


def _plot(axes: Axes, t_s: Array, values: Array, label: str, width: float = 1.1) -> None:
    """Plot a curve over time."""
    axes.plot(*_thinned(t_s, values), color=COLOURS[label], label=label, **curve_style(len(values), width))


def _draw_angles(axes: Axes, score: Score, *names: str) -> None:
    errors = [np.degrees(getattr(score.error, name)) for name in names]
    for name, degrees in zip(names, errors, strict=True):
        _plot(axes, score.t_s, degrees, name)
    axes.set_ylabel("error [deg]")
    median = max(float(np.median(degrees)) for degrees in errors)
    if median > 0.0 and float(np.max(errors)) > _WIDE_SPAN * median:
        axes.set_yscale("log")


def _draw_limits(axes: Axes, score: Score) -> None:
    end, limits = float(score.t_s[-1]), score.limits
    if score.time_to_converge_s is not None and score.time_to_converge_s > 0.0:
        axes.axvline(score.time_to_converge_s, color=_GREEN, lw=1.0, ls="--", label="converged")
    if limits.max_rms_deg is not None:
        axes.plot([0.0, end], [limits.max_rms_deg] * 2, color=RED, lw=1.0, ls=":", label="limit of the rms")
    for i, (start, limit) in enumerate(limits.max_after):
        label = "limit" if i == 0 else None
        axes.plot([min(start, end), end], [limit] * 2, color=RED, lw=1.4, label=label)


def _draw_nees(axes: Axes, t_s: Array, consistency: Consistency) -> None:
    _plot(axes, t_s, consistency.nees, "NEES", 0.9)
    label = f"{consistency.probability:.0%} bounds"
    axes.axhspan(*consistency.bounds, color=_GREEN, alpha=0.2, lw=0.0, label=label)
    axes.set_yscale("log")
    axes.set_ylabel("NEES")


def _thinned(t_s: Array, values: Array) -> tuple[Array, Array]:
    """Some thousand points, the smallest and the largest of their neighbours, and none where there is a gap."""
    steps = np.diff(t_s)
    behind = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.int64)
    kept = np.union1d(extremes(t_s, values, _COLUMNS), behind)
    places = np.searchsorted(kept, behind)
    return np.insert(t_s[kept], places, np.nan), np.insert(values[kept], places, np.nan)
