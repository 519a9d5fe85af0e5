"""Residuals as figures: of one bag over time, of many bags by how often each size occurs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.certificate.law_result import LawOverTime, ResidualsOverTime
from lie_rigid_body.report.html_page import axis, drawn, figure, line, logarithmic, mark, over_time
from lie_rigid_body.report.recorded_motion import COLOURS, GREY, RED

_BINS: Final = 30
_LEAST_SPAN: Final = 0.3
"""Least span of a distribution, decades."""
_ABOVE: Final = 10.0
"""Height at which residuals are drawn that are not finite, as a multiple of all that is."""
_LIMIT: Final[dict[str, Any]] = {"line": {"color": GREY, "dash": "dash", "width": 1.4}, "mode": "lines"}


def figures_over_time(
    certificate: Certificate, residuals: ResidualsOverTime, origin_ns: int, shapes: Sequence[dict[str, Any]]
) -> Iterator[str]:
    """Draw the largest residuals of each law over time, beside their limits.

    Parameters
    ----------
    certificate : Certificate
    residuals : ResidualsOverTime
        Of the same bag.
    origin_ns : int
        Stamp of time 0.
    shapes : sequence of dict
        What else is drawn, such as resets.

    Yields
    ------
    str
        HTML. Laws that have no residual but 0 are left out.
    """
    watched = [law for law in certificate.laws if law.name in residuals.laws]
    for name, laws in groupby(watched, lambda law: re.sub(" [xyz]$", "", law.name)):
        own = [(law, residuals.laws[law.name]) for law in laws]
        if traces := list(_traces(own, origin_ns)):
            unit = own[0][0].unit
            label = {"rel": "relative residual", "1": "residual", "": "residual"}.get(unit, f"residual [{unit}]")
            end = max(float(trace["x"][-1]) for trace in traces)
            values = np.concatenate([trace["y"] for trace in traces])
            axes = {"xaxis": axis("time [s]", range=[0.0, end]), "yaxis": logarithmic(label, values)}
            yield figure(name, drawn(traces, **axes, shapes=list(shapes), showlegend=len(own) > 1))


def _traces(laws: Sequence[tuple[LawResult, LawOverTime]], origin_ns: int) -> Iterator[dict[str, Any]]:
    """Curves of a law, or of its components, marks at what is broken and at the worst, and their limit."""
    limits = []
    for i, (worst, law) in enumerate(laws):
        t, residuals, limit, broken = law.series(origin_ns)
        if not (residuals > 0.0).any():
            continue
        if (limit > 0.0).any():
            limits.append(over_time(t, np.where(limit > 0.0, limit, np.nan), "limit", GREY, **_LIMIT))
        finite = np.isfinite(residuals)
        top = _ABOVE * max(float(residuals[finite].max(initial=0.0)), float(limit.max())) or 1.0
        heights = np.where(finite, np.where(residuals > 0.0, residuals, np.nan), top)
        name, colour = (worst.name[-1], COLOURS[i]) if len(laws) > 1 else ("largest residual", COLOURS[2])
        yield over_time(t, heights, name, colour)
        if broken.any():
            yield over_time(t[broken], heights[broken], "broken", RED, mode="markers", showlegend=False)
        if worst.stamp_ns is not None and 0.0 < worst.worst < np.inf:
            at = np.array([(worst.stamp_ns - origin_ns) * 1e-9, worst.worst])
            circle = {"symbol": "circle-open", "size": 11, "color": colour, "line": {"width": 2}}
            yield {**mark(at, f"worst: number {worst.sample}", **circle), "showlegend": False, "cliponaxis": False}
    yield from limits[-1:]


def distributions(laws: Sequence[tuple[str, Sequence[Sequence[float]]]], whose: str) -> Iterator[str]:
    """Draw how often each size of the worst residual occurs among many bags, beside the limits.

    Parameters
    ----------
    laws : sequence of (str, sequence of pairs of float)
        Name of each law with its unit; of each bag the worst residual and its limit.
    whose : str
        What there are many of, such as ``bags``.

    Yields
    ------
    str
        HTML. Laws that have no residual but 0, as those that hold or do not, are left out.
    """
    for name, pairs in laws:
        residuals, limits = np.array(pairs, dtype=np.float64).T
        finite = np.isfinite(residuals)
        shown = finite & (residuals > 0.0)
        if shown.any() and limits.max() > 0.0:
            left_out = {"0": np.sum(residuals == 0.0), "not finite": np.sum(~finite)}
            caption = ", ".join(f"{what} in {count} {whose}" for what, count in left_out.items() if count)
            yield figure(name, _distribution(residuals[shown], limits[shown], limits, whose), caption)


def _distribution(residuals: Array, own: Array, limits: Array, whose: str) -> dict[str, Any]:
    """Bars of residuals, those within their own limits and those beyond, and the limits of all."""
    exponents = np.log10(residuals)
    low, high = float(exponents.min()), float(exponents.max())
    widen = max(0.0, _LEAST_SPAN - (high - low)) / 2.0 + 1e-9
    edges = np.logspace(low - widen, high + widen, _BINS + 1)
    traces: list[dict[str, Any]] = []
    beyond = residuals > own
    for which, label, colour in ((~beyond, "within the limit", COLOURS[2]), (beyond, "beyond the limit", RED)):
        counts, _ = np.histogram(residuals[which], edges)
        if counts.any():
            look = {"type": "bar", "marker": {"color": colour}, "name": label}
            traces.append({**look, "x": 0.5 * (edges[1:] + edges[:-1]), "width": np.diff(edges), "y": counts})
    top, least, most = max(int(np.max(trace["y"])) for trace in traces), float(limits.min()), float(limits.max())
    corners = np.array([(least, 0), (least, top), (most, top), (most, 0)], dtype=np.float64)
    if least == most:
        traces.append({**line(corners[:2], "limit", GREY, 1.4), **_LIMIT})
    else:
        traces.append({**line(corners, "limits", GREY, 1.4), **_LIMIT, "fill": "toself"})
    axes = {"xaxis": logarithmic("worst residual", np.append(edges, limits)), "yaxis": axis(whose, rangemode="tozero")}
    return drawn(traces, **axes, barmode="stack", bargap=0)
