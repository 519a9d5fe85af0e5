"""The picture of a score: the errors over time, with the limits, and the NEES with its bounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.attitudes import GAP
from lie_rigid_body.report.recorded_motion import COLOURS as OF_AXES
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
"""Ratio of the largest error to the median above which the axis is logarithmic, and of a limit that is far beyond."""
_DEEPEST: Final = 1e-6
"""Least end of a logarithmic axis, as a share of the largest value."""
_NARROW: Final = 5.0
"""Width, inches, up to which a figure is for the screen of a phone."""


def draw(title: str, score: Score, width: float = 10.0) -> Figure:
    """Figure of a score.

    Parameters
    ----------
    title : str
        It may hold anything; without one nothing is above the panels.
    score : Score
    width : float, optional
        Width, inches; a narrow one is for the screen of a phone.
    """
    from lie_rigid_body.report.picture import Picture

    panels = [_draw_total, _draw_parts]
    panels += [_draw_nees] if score.consistency else []
    panels += [_draw_bias] if score.gyro_bias else []
    size = (width, 1.0 * bool(title) + 1.2 + (2.0 if width > _NARROW else 1.7) * len(panels))
    figure = Picture(figsize=size, dpi=120, layout="constrained")
    for panel, axes in zip(panels, figure.subplots(len(panels), sharex=True), strict=True):
        panel(axes, score)
        axes.grid(alpha=0.3, lw=0.6)
        axes.set_xlim(0.0, float(score.t_s[-1]) or 1.0)
        columns = 3 if panel is _draw_bias else 5 if width > _NARROW else 2
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.1)
    axes.set_xlabel("time since the first estimate [s]")
    if title:
        # the names of a file and a topic may hold anything, and ``$`` is no formula
        rms = f"attitude error {score.total_deg.rms:.4g}° rms, {counted(score.samples, 'sample')}"
        figure.suptitle(f"{shortened(printable(title), _LONGEST_LINE)}\n{rms}", fontsize=11, parse_math=False)
    return figure


def curves(title: str, scores: Sequence[tuple[str, Score]], width: float = 10.0) -> Figure:
    """Figure of the total errors of several estimates, under their names; see `draw`."""
    from lie_rigid_body.report.picture import Picture

    columns = 2 if width > _NARROW else 1
    figure = Picture(figsize=(width, 3.4 + 0.25 * len(scores) / columns), dpi=120, layout="constrained")
    axes = figure.subplots()
    first_ns = min(int(score.stamps_ns[0]) for _, score in scores)
    for number, (name, score) in enumerate(scores):
        t_s, degrees = (score.stamps_ns - first_ns) / 1e9, np.degrees(score.error.total)
        label = f"{shortened(printable(name), 30)}, {score.total_deg.rms:.4g}° rms".replace("$", r"\$")
        axes.plot(*_thinned(t_s, degrees), label=label, color=f"C{number % 10}", **curve_style(len(degrees), 1.0))
    _scale(axes, [np.degrees(score.error.total) for _, score in scores])
    axes.set(xlabel="time since the first estimate [s]", ylabel="total error [deg]")
    axes.grid(alpha=0.3, lw=0.6)
    axes.margins(x=0.0)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.1)
    if title:
        figure.suptitle(shortened(printable(title), _LONGEST_LINE), fontsize=11, parse_math=False)
    return figure


def _plot(axes: Axes, t_s: Array, values: Array, label: str, width: float = 1.1) -> None:
    """Plot a curve over time."""
    axes.plot(*_thinned(t_s, values), color=COLOURS[label], label=label, **curve_style(len(values), width))


def _draw_total(axes: Axes, score: Score) -> None:
    """Draw the total error, the best by noise and the limits, on a logarithmic axis where one of these is shown."""
    total, end = np.degrees(score.error.total), float(score.t_s[-1])
    drawn = [total]
    _plot(axes, score.t_s, total, "total")
    if score.best is not None and not score.best.unobserved:
        drawn.append(score.best.filtered_deg)
        _plot(axes, score.t_s, score.best.filtered_deg, "best by noise")
    rms = score.limits.max_rms_deg
    limits = [] if rms is None else [(0.0, rms, ":", f"limit {rms:g}° rms")]
    limits += [(start, limit, "-", f"limit {limit:g}° from {start:g} s") for start, limit in score.limits.max_after]
    low, high = _scale(axes, drawn, [limit for _, limit, _, _ in limits])
    for start, limit, style, name in limits:
        where = ", far above" if limit > high else ", far below" if limit < low else ""
        axes.plot([min(start, end), end], [limit] * 2, color=RED, lw=1.3, ls=style, label=f"{name}{where}")
    if score.time_to_converge_s is not None and score.time_to_converge_s > 0.0:
        axes.axvline(score.time_to_converge_s, color=_GREEN, lw=1.0, ls="--", label="converged")
    axes.set_ylabel("error [deg]")


def _draw_parts(axes: Axes, score: Score) -> None:
    """Draw the heading and the inclination error."""
    parts = {name: np.degrees(getattr(score.error, name)) for name in ("heading", "inclination")}
    for name, degrees in parts.items():
        _plot(axes, score.t_s, degrees, name)
    _scale(axes, [np.maximum(*parts.values())])
    axes.set_ylabel("error [deg]")


def _draw_nees(axes: Axes, score: Score) -> None:
    consistency = score.consistency
    assert consistency is not None
    _plot(axes, score.t_s, consistency.nees, "NEES", 0.9)
    label = f"{consistency.probability:.0%} bounds"
    axes.axhspan(*consistency.bounds, color=_GREEN, alpha=0.2, lw=0.0, label=label)
    axes.set(yscale="log", ylabel="NEES")


def _draw_bias(axes: Axes, score: Score) -> None:
    """Draw the estimated biases of the gyro, each beside the true one."""
    bias = score.gyro_bias
    assert bias is not None
    t_s = (bias.stamps_ns - score.stamps_ns[0]) / 1e9
    for name, colour, estimate, truth in zip("xyz", OF_AXES, bias.estimate.T, bias.truth.T, strict=True):
        style = curve_style(len(t_s), 1.1)
        axes.plot(*_thinned(t_s, estimate), color=colour, label=f"estimated {name}", **style)
        axes.plot(*_thinned(t_s, truth), color=colour, ls="--", label=f"true {name}", **style)
    axes.set_ylabel("gyro bias [rad/s]")


def _scale(axes: Axes, curves: Sequence[Array], limits: Sequence[float] = ()) -> tuple[float, float]:
    """Choose the scale and the range of an axis of errors, and return its ends.

    Several curves, or one and limits, may be of any sizes: they have a logarithmic axis. The range is that of the
    curves, so that no limit flattens them: the legend alone tells of one that is far beyond.
    """
    top = max(float(curve.max()) for curve in curves)
    positive = [curve[curve > 0.0] for curve in curves if (curve > 0.0).any()]
    wide = top > _WIDE_SPAN * float(np.median(curves[0])) > 0.0
    if not positive or not (wide or limits or len(curves) > 1):
        high = 1.05 * top or 1.0
        axes.set_ylim(0.0, high)
        return 0.0, high
    bottom = max(min(float(np.percentile(curve, 1.0)) for curve in positive), _DEEPEST * top)
    near = [limit for limit in limits if bottom / _WIDE_SPAN <= limit <= _WIDE_SPAN * top]
    low, high = min([bottom, *near]) / 1.5, max([top, *near]) * 1.5
    axes.set(yscale="log", ylim=(low, high))
    return low, high


def _thinned(t_s: Array, values: Array) -> tuple[Array, Array]:
    """Some thousand points, the smallest and the largest of their neighbours, and none where there is a gap."""
    steps = np.diff(t_s)
    behind = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.int64)
    kept = np.union1d(extremes(t_s, values, _COLUMNS), behind)
    places = np.searchsorted(kept, behind)
    return np.insert(t_s[kept], places, np.nan), np.insert(values[kept], places, np.nan)
