"""The picture of a score: the errors over time, with the limits, and the NEES with its bounds."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.estimate import GAP
from lie_rigid_body.wording import counted, printable, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS: Final = {"total": "#333333", "heading": "#0072B2", "inclination": "#D55E00"}
"""Distinct in every kind of colour vision."""
_LIMIT: Final = "#CC2222"
_MOST_POINTS: Final = 4000
"""Points of a curve: more are drawn as the largest of neighbours, so that no peak is lost."""
_LONGEST_LINE: Final = 110
"""Characters of a line of the title that the figure has room for."""
_WIDE_SPAN: Final = 30.0
"""Ratio of the largest error to the median above which the axis is logarithmic."""


def png(title: str, score: Score) -> bytes:
    """The picture as a PNG."""
    out = BytesIO()
    with _without_glyphs():
        _draw(title, score).savefig(out, format="png", dpi=120)
    return out.getvalue()


def svg(title: str, score: Score) -> str:
    """The picture as an SVG element."""
    import matplotlib

    out = StringIO()
    # the same bytes for the same score, and text that a browser can search
    with matplotlib.rc_context({"svg.hashsalt": "lie_rigid_body", "svg.fonttype": "none"}), _without_glyphs():
        _draw(title, score).savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


@contextmanager
def _without_glyphs() -> Iterator[None]:
    """No warnings of characters that the font lacks, such as Chinese ones of a name: a PNG shows boxes for them."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        yield


def _draw(title: str, score: Score) -> Figure:
    from matplotlib.figure import Figure

    rows = 2 if score.consistency is None else 3
    figure = Figure(figsize=(10.0, 2.2 + 2.0 * rows), layout="constrained")
    total, parts, *rest = figure.subplots(rows, sharex=True)
    _draw_angles(total, score, ("total",))
    _draw_best(total, score)
    _draw_limits(total, score)
    _draw_angles(parts, score, ("heading", "inclination"))
    if rest:
        _draw_nees(rest[0], score)
    for axes in (total, parts, *rest):
        if axes.get_yscale() == "linear":
            axes.set_ylim(bottom=0.0)  # when all is drawn: from here on it no longer makes room
        axes.grid(alpha=0.3, lw=0.6)
        axes.margins(x=0.0)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, frameon=False, borderaxespad=0.1)
    (rest[0] if rest else parts).set_xlabel("time since the first estimate [s]")
    rms = score.total_deg.rms
    _name(figure, f"{title}\nattitude error {rms:.4g}° rms, {counted(score.samples, 'sample')}")
    return figure


def _name(figure: Figure, text: str) -> None:
    """Write the title, which has the names of a file and a topic: they may hold anything, and ``$`` is no formula."""
    lines = (shortened(printable(line), _LONGEST_LINE) for line in text.rsplit("\n", 1))
    figure.suptitle("\n".join(lines), fontsize=11, parse_math=False)


def _draw_angles(axes: Axes, score: Score, names: tuple[str, ...]) -> None:
    largest = median = 0.0
    for name in names:
        degrees = np.degrees(getattr(score.error, name))
        axes.plot(*_thinned(score.t_s, degrees), color=COLOURS[name], lw=1.1, label=name, **_marker(degrees))
        largest, median = max(largest, float(degrees.max())), max(median, float(np.median(degrees)))
    axes.set_ylabel("error [deg]")
    if median > 0.0 and largest > _WIDE_SPAN * median:
        axes.set_yscale("log")


def _draw_best(axes: Axes, score: Score) -> None:
    if score.best is not None and not score.best.unobserved:
        axes.plot(*_thinned(score.t_s, score.best.filtered_deg), color="#CC79A7", lw=0.8, label="best by noise")


def _draw_limits(axes: Axes, score: Score) -> None:
    end, limits = float(score.t_s[-1]), score.limits
    if score.time_to_converge_s is not None and score.time_to_converge_s > 0.0:
        axes.axvline(score.time_to_converge_s, color="#009E73", lw=1.0, ls="--", label="converged")
    if limits.max_rms_deg is not None:
        axes.plot([0.0, end], [limits.max_rms_deg] * 2, color=_LIMIT, lw=1.0, ls=":", label="limit of the rms")
    for i, (start, limit) in enumerate(limits.max_after):
        label = "limit" if i == 0 else None
        axes.plot([min(start, end), end], [limit] * 2, color=_LIMIT, lw=1.4, label=label)


def _draw_nees(axes: Axes, score: Score) -> None:
    consistency = score.consistency
    assert consistency is not None
    axes.plot(*_thinned(score.t_s, consistency.nees), color=COLOURS["total"], lw=0.9, label="NEES")
    low, high = consistency.bounds
    label = f"{consistency.probability:.0%} bounds"
    axes.axhspan(low, high, color="#009E73", alpha=0.2, lw=0.0, label=label)
    axes.set_yscale("log")
    axes.set_ylabel("NEES")


def _thinned(t_s: Array, values: Array) -> tuple[Array, Array]:
    """At most some thousand points, each the largest of its neighbours, and none where there is a gap."""
    steps = np.diff(t_s)
    behind = np.flatnonzero(steps > GAP * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.intp)
    size = -(-len(values) // _MOST_POINTS)
    if size > 1:
        starts = np.union1d(np.arange(0, len(values), size), behind)
        behind = np.searchsorted(starts, behind)
        t_s, values = t_s[starts], np.maximum.reduceat(values, starts)
    return np.insert(t_s, behind, np.nan), np.insert(values, behind, np.nan)


def _marker(values: Array) -> dict[str, Any]:
    return {"marker": "o", "ms": 4.0} if len(values) <= 3 else {}
