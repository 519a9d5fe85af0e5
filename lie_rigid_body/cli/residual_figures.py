"""Residuals as figures: of one bag over time, of many bags by how often each size occurs."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.certificate.residuals_over_time import LawOverTime, ResidualsOverTime
from lie_rigid_body.cli.plotly_layout import COLOURS, GREY, RED, axis, layout, logarithmic
from lie_rigid_body.report.html_page import figure

_BINS: Final = 30
_ABOVE: Final = 10.0
"""How many times as high as all that is finite the residuals are drawn that are not."""
_COMPONENTS: Final = ("x", "y", "z")


def over_time(
    certificate: Certificate, residuals: ResidualsOverTime, origin_ns: int, shapes: Sequence[dict[str, Any]]
) -> Iterator[str]:
    """The largest residuals of each law over time, beside their limits.

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
    for name, laws in itertools.groupby(watched, lambda law: _family(law.name)):
        own = [(law, residuals.laws[law.name]) for law in laws]
        traces = list(_over_time(own, origin_ns))
        if traces:
            unit = own[0][0].unit
            ends = [t for trace in traces for t in (trace["x"][0], trace["x"][-1])]
            values = np.concatenate([trace["y"] for trace in traces])
            axes = {
                "xaxis": axis("time [s]", range=[0.0, max(ends)]),
                "yaxis": logarithmic(_label(unit), values),
            }
            look = layout(**axes, shapes=list(shapes), showlegend=len(own) > 1)
            yield figure(name, {"data": traces, "layout": look})


def _family(name: str) -> str:
    """The name of a law without the component that it is of."""
    head, _, last = name.rpartition(" ")
    return head if last in _COMPONENTS else name


def _label(unit: str) -> str:
    return {"rel": "relative residual", "1": "residual", "": "residual"}.get(unit, f"residual [{unit}]")


def _over_time(laws: Sequence[tuple[LawResult, LawOverTime]], origin_ns: int) -> Iterator[dict[str, Any]]:
    limits: tuple[Array, Array] | None = None
    for i, (worst, law) in enumerate(laws):
        t, residuals, limit, broken = law.series(origin_ns)
        if not (residuals > 0.0).any():
            continue
        if (limit > 0.0).any():
            limits = t, np.where(limit > 0.0, limit, np.nan)
        finite = residuals[np.isfinite(residuals)]
        top = _ABOVE * max(float(finite.max(initial=0.0)), float(limit.max())) or 1.0
        drawn = np.where(np.isfinite(residuals), np.where(residuals > 0.0, residuals, np.nan), top)
        colour = COLOURS[i] if len(laws) > 1 else COLOURS[2]
        yield _dots(t, drawn, worst.name.rpartition(" ")[2] if len(laws) > 1 else "largest residual", colour)
        if broken.any():
            yield {**_dots(t[broken], drawn[broken], "broken", RED), "mode": "markers", "showlegend": False}
        if worst.stamp_ns is not None and 0.0 < worst.worst < np.inf:
            at = np.array([(worst.stamp_ns - origin_ns) * 1e-9]), np.array([worst.worst])
            marker = {"symbol": "circle-open", "size": 11, "color": colour, "line": {"width": 2}}
            text = f"worst: number {worst.sample}"
            yield {**_dots(*at, text, colour), "mode": "markers", "marker": marker, "showlegend": False}
    if limits is not None:
        line = {"color": GREY, "dash": "dash", "width": 1.4}
        yield {**_dots(*limits, "limit", GREY), "mode": "lines", "line": line}


def _dots(t: Array, values: Array, name: str, colour: str) -> dict[str, Any]:
    few = {"mode": "lines+markers"} if len(t) <= 50 else {"mode": "lines"}
    look = {"marker": {"color": colour, "size": 5}, "line": {"color": colour, "width": 1.2}}
    x, y = (np.array([float(f"{v:.6g}") for v in values]) for values in (t, values))
    return {"type": "scatter", "x": x, "y": y, "name": name, "cliponaxis": False, **few, **look}


def distributions(laws: Sequence[tuple[str, Sequence[Sequence[float]]]], whose: str) -> Iterator[str]:
    """How often each size of the worst residual occurs among many bags, beside the limits.

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
        shown = np.isfinite(residuals) & (residuals > 0.0)
        if shown.any() and limits.max() > 0.0:
            content, caption = _distribution(residuals, limits, shown, whose), _left_out(residuals, whose)
            yield figure(name, content, caption)


def _distribution(residuals: Array, limits: Array, shown: Any, whose: str) -> dict[str, Any]:
    exponents = np.log10(residuals[shown])
    low, high = float(exponents.min()), float(exponents.max())
    if high - low < 0.3:
        low, high = 0.5 * (low + high) - 0.15, 0.5 * (low + high) + 0.15
    edges = 10.0 ** np.linspace(low - 1e-9, high + 1e-9, _BINS + 1)
    kept = ~(residuals > limits)
    traces = []
    for which, label, colour in ((kept, "within the limit", COLOURS[2]), (~kept, "beyond the limit", RED)):
        counts, _ = np.histogram(residuals[shown & which], edges)
        if counts.any():
            look = {"type": "bar", "marker": {"color": colour}, "name": label}
            traces.append({**look, "x": 0.5 * (edges[1:] + edges[:-1]), "width": np.diff(edges), "y": counts})
    traces.append(_limits(limits, max(int(np.max(trace["y"])) for trace in traces)))
    axes = {"xaxis": logarithmic("worst residual", np.append(edges, limits)), "yaxis": axis(whose, rangemode="tozero")}
    return {"data": traces, "layout": layout(**axes, barmode="stack", bargap=0)}


def _limits(limits: Array, height: int) -> dict[str, Any]:
    """A line at the limit, or a band from the smallest to the largest."""
    low, high = float(limits.min()), float(limits.max())
    look = {"type": "scatter", "mode": "lines", "name": "limit", "line": {"color": GREY, "dash": "dash", "width": 1.4}}
    if low == high:
        return {**look, "x": [low, low], "y": [0, height]}
    return {**look, "x": [low, low, high, high], "y": [0, height, height, 0], "fill": "toself", "name": "limits"}


def _left_out(residuals: Array, whose: str) -> str:
    zero, endless = int(np.count_nonzero(residuals == 0.0)), int(np.count_nonzero(~np.isfinite(residuals)))
    parts = [f"0 in {zero} {whose}"] * (zero > 0) + [f"not finite in {endless} {whose}"] * (endless > 0)
    return ", ".join(parts)
