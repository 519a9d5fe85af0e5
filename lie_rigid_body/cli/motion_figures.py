"""The motion of a recording as figures: body rate over time, polhode and herpolhode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.cli.figure import best_view
from lie_rigid_body.cli.plotly_layout import COLOURS, GREY, RED, axis, layout
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report.html_page import Figure

MOST_RESETS: Final = 12
"""Largest number of resets that are drawn as lines."""
_COLUMNS: Final = 1000
"""Intervals of time of a curve, of each of which the smallest and the largest value are drawn."""
_CURVE: Final = 3000
"""Most points of a polhode or herpolhode."""
_CLOSE: Final = 0.05
"""Turn, rad, from one point of a curve to the next, where the samples are as near."""
_FAR: Final = 1e3
"""How many times as fast as the motion may be a rate must be to be left out: it was damaged."""


def times(stamps_ns: Integers, pieces: Sequence[RecordedSegment]) -> Array:
    """Times since the first sample of a recording, s."""
    return np.asarray((stamps_ns - pieces[0].stamps_ns[0]) * 1e-9, dtype=np.float64)


def resets(pieces: Sequence[RecordedSegment]) -> list[dict[str, Any]]:
    """Lines at the resets, for a layout."""
    starts = times(np.array([piece.segment.start_ns for piece in pieces[1:]], dtype=np.int64), pieces)
    line = {"color": "black", "width": 1, "dash": "dash"}
    shapes = [{"type": "line", "x0": t, "x1": t, "y0": 0, "y1": 1, "yref": "paper", "line": line} for t in starts]
    return shapes if len(shapes) <= MOST_RESETS else []


def rate(pieces: Sequence[RecordedSegment]) -> Figure:
    """The body rate over time."""
    t = np.concatenate([times(piece.stamps_ns, pieces) for piece in pieces])
    rates = np.concatenate([piece.states.body_rate for piece in pieces])
    few = {"mode": "markers"} if len(t) <= 3 else {"mode": "lines"}
    traces = []
    for i, (name, colour) in enumerate(zip("xyz", COLOURS, strict=True)):
        at = extremes(t, rates[:, i])
        trace = {"type": "scatter", "x": _short(t[at]), "y": _short(rates[at, i]), "name": f"ω<sub>{name}</sub>"}
        traces.append({**trace, **few, "line": {"color": colour, "width": 1.3}, "marker": {"color": colour}})
    end = float(t[-1]) or 1.0
    axes = {"xaxis": axis("time [s]", range=[0.0, end]), "yaxis": axis("body rate [rad/s]")}
    return {"data": traces, "layout": layout(**axes, shapes=resets(pieces))}


def extremes(t: Array, values: Array) -> Integers:
    """Places of the smallest and the largest value in each of `_COLUMNS` intervals of time, or of all values if few.

    Parameters
    ----------
    t, values : ndarray, shape (N,)
        Rising times.

    Returns
    -------
    ndarray of int64, shape (M,)
        Rising.
    """
    if len(t) <= 2 * _COLUMNS:
        return np.arange(len(t))
    column = ((t - t[0]) * (_COLUMNS / (t[-1] - t[0]))).astype(np.int64)
    order = np.lexsort((values, column))
    first = np.flatnonzero(np.diff(column[order], prepend=-1))
    return np.union1d(order[first], order[np.append(first[1:], len(t)) - 1])


def curve(piece: RecordedSegment) -> State:
    """The states that a curve is drawn through: the first ones, as dense as a curve needs; damaged ones left out."""
    close = piece.states[: piece.close]
    fastest = piece.segment.scenario.rate_bound()
    with np.errstate(invalid="ignore", over="ignore"):
        sane = np.isfinite(close.attitude_xyzw).all(axis=1) & (np.abs(close.body_rate) <= _FAR * fastest).all(axis=1)
    sane &= (close.attitude_xyzw != 0.0).any(axis=1)
    span = float(piece.stamps_ns[-1 if piece.close > len(piece.stamps_ns) else piece.close - 1] - piece.stamps_ns[0])
    turn = fastest * span * 1e-9 / max(piece.close - 1, 1)
    step = max(1, int(_CLOSE / turn)) if turn > 0.0 else 1
    at = np.flatnonzero(sane)[::step][:_CURVE]
    return State.trusted(close.attitude_xyzw[at], close.body_rate[at])


def polhode(piece: RecordedSegment) -> Figure | None:
    """The path of ω in the principal frame, on the ellipsoid ½ Σ Iᵢωᵢ² = H; none of a body at rest."""
    scenario = piece.segment.scenario
    body, points = scenario.body(), curve(piece)
    energy = float(body.kinetic_energy(scenario.start()))
    if energy == 0.0 or not len(points.body_rate):
        return None
    radii = np.sqrt(2.0 * energy / body.principal_moments)
    path = points.body_rate @ body.principal_axes
    traces = [
        _ellipsoid(radii),
        _line(_principal_circles(radii), "principal planes", "#8A97A8", 1.5),
        _line(path, "polhode", RED, 5),
        {**_line(path[:1], "first sample", "black", 1), "mode": "markers", "marker": {"size": 4, "color": "black"}},
    ]
    elevation, azimuth = np.radians(best_view(path, radii))
    eye = 1.15 * np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    scene = {f"{name}axis": _rate_axis(i, radii[i]) for i, name in enumerate("xyz")}
    view = {"eye": dict(zip("xyz", np.round(eye, 3).tolist(), strict=True)), "projection": {"type": "orthographic"}}
    return {"data": traces, "layout": layout(scene={**scene, "aspectmode": "data", "camera": view}, showlegend=False)}


def _rate_axis(i: int, radius: float) -> dict[str, Any]:
    return {
        "title": {"text": f"ω<sub>{i + 1}</sub>"},
        "range": [-1.08 * radius, 1.08 * radius],
        "nticks": 4,
        "showbackground": False,
        "gridcolor": "#D5DAE0",
        "zeroline": False,
    }


def _ellipsoid(radii: Array) -> dict[str, Any]:
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    sphere = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    x, y, z = _short(0.995 * radii[:, np.newaxis, np.newaxis] * sphere)  # a curve on it is not to sink in
    look = {"colorscale": [[0, "#C9D6E8"], [1, "#C9D6E8"]], "showscale": False, "opacity": 0.75, "hoverinfo": "skip"}
    return {"type": "surface", "x": x, "y": y, "z": z, **look, "lighting": {"specular": 0.1, "diffuse": 0.6}}


def _principal_circles(radii: Array) -> Array:
    """The ellipses in which the principal planes cut the ellipsoid, with gaps between them."""
    angle = np.linspace(0, 2 * np.pi, 91)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    gap = np.full((1, 3), np.nan)
    return np.concatenate([part for plane in range(3) for part in (radii * np.insert(circle, plane, 0.0, 1), gap)])


def _line(points: Array, name: str, colour: str, width: float) -> dict[str, Any]:
    x, y, z = _short(points.T)
    line = {"color": colour, "width": width}
    return {"type": "scatter3d", "mode": "lines", "x": x, "y": y, "z": z, "name": name, "line": line}


def herpolhode(piece: RecordedSegment) -> Figure | None:
    """The path of ω in the world, seen along the angular momentum, on the invariable plane; none of a body at rest."""
    scenario = piece.segment.scenario
    start, points = scenario.start(), curve(piece)
    momentum = scenario.body().angular_momentum(start)
    size = float(np.linalg.norm(momentum))
    if size == 0.0 or not len(points.body_rate):
        return None
    upright = momentum / size
    norms = np.linalg.norm(points.attitude_xyzw, axis=1, keepdims=True)
    rates = quaternion.rotate(points.attitude_xyzw / norms, points.body_rate)
    across = rates - np.outer(rates @ upright, upright)
    right = _right(across[0], upright, scenario.rate_bound())
    path = across @ np.stack([right, np.cross(upright, right)], axis=-1)
    reach = 1.1 * max(float(np.abs(path).max()), 1e-3 * scenario.rate_bound())
    x, y = _short(path.T)
    look = {"type": "scatter", "x": x, "y": y, "name": "herpolhode"}
    first = {**look, "x": x[:1], "y": y[:1], "name": "first sample", "mode": "markers"}
    traces = [
        {**look, "mode": "lines", "line": {"color": RED, "width": 1.5}},
        {**first, "marker": {"color": "black", "size": 7}},
        {**first, "x": [0.0], "y": [0.0], "name": "angular momentum", "marker": {"color": GREY, "symbol": "x"}},
    ]
    axes = {
        "xaxis": axis("ω across L [rad/s]", range=[-reach, reach], constrain="domain", nticks=6),
        "yaxis": axis("[rad/s]", range=[-reach, reach], scaleanchor="x", constrain="domain", nticks=6),
    }
    return {"data": traces, "layout": layout(**axes, showlegend=False)}


def _right(across: Array, upright: Array, fastest: float) -> Array:
    """The direction to the right of the picture: of ω's first part across the momentum, or any if it has none."""
    if np.linalg.norm(across) < 1e-9 * fastest:
        across = np.cross(upright, np.eye(3)[np.argmin(np.abs(upright))])
    right: Array = across / np.linalg.norm(across)
    return right


def _short(values: Array) -> Array:
    """Numbers to six digits of the largest, as a screen needs no more: they take less room in the page."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max(initial=0.0))
    if largest == 0.0 or largest > 1e290:
        return values
    return np.round(values, 5 - int(np.floor(np.log10(largest))))
