"""The motion of a recording as figures of a page: body rate over time, polhode and herpolhode."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report.html_page import Figure
from lie_rigid_body.report.plotly_parts import axis, coordinates, layout, line, mark, over_time, space
from lie_rigid_body.report.recorded_motion import (
    CIRCLES,
    COLOURS,
    FEW_SAMPLES,
    GREY,
    MOST_RESETS,
    RED,
    SURFACE,
    Ellipsoid,
    extremes,
    path,
    reset_times,
    times,
    world_rates,
)

_POINTS: Final = 3000
"""Largest number of points of a polhode or herpolhode."""
_ABOVE: Final = 0.995
"""Size of the surface that is drawn, as a share of the ellipsoid: the polhode lies on that and is not to sink in."""
_DISTANCE: Final = 1.15
"""Distance of the eye, in sizes of the figure."""


def resets(pieces: Sequence[RecordedSegment]) -> list[dict[str, Any]]:
    """Lines at the resets, for a layout; none where there are too many."""
    t, look = reset_times(pieces), {"color": "black", "width": 1, "dash": "dash"}
    shapes = [{"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper", "line": look} for x in t]
    return shapes if len(shapes) <= MOST_RESETS else []


def rate(pieces: Sequence[RecordedSegment]) -> Figure:
    """Body rate over time."""
    t = np.concatenate([times(piece.stamps_ns, pieces) for piece in pieces])
    rates = np.concatenate([piece.states.body_rate for piece in pieces])
    few = {"mode": "markers" if len(t) <= FEW_SAMPLES else "lines", "cliponaxis": True}
    traces = []
    for name, colour, component in zip("xyz", COLOURS, rates.T, strict=True):
        at = extremes(t, component)
        traces.append(over_time(t[at], component[at], f"ω<sub>{name}</sub>", colour, **few))
    axes = {"xaxis": axis("time [s]", range=[0.0, float(t[-1]) or 1.0]), "yaxis": axis("body rate [rad/s]")}
    return {"data": traces, "layout": layout(**axes, shapes=resets(pieces))}


def polhode(piece: RecordedSegment) -> Figure | None:
    """Path of ω in the principal frame, on the ellipsoid of the energy; none of a body at rest."""
    ellipsoid = Ellipsoid.of(piece, _POINTS)
    if ellipsoid is None:
        return None
    circles = np.insert(ellipsoid.principal_circles(), 0, np.nan, axis=1).reshape(-1, 3)
    traces = [
        _surface(ellipsoid),
        line(circles, "principal planes", CIRCLES, 1.5),
        line(ellipsoid.polhode, "polhode", RED, 5),
        mark(ellipsoid.polhode[0], "first sample", size=4, color="black"),
    ]
    axes = {f"{name}axis": _rate_axis(i, ellipsoid.radii[i]) for i, name in enumerate("xyz")}
    eye = _DISTANCE * ellipsoid.best_view().axes[0]
    scene = space(eye, {**axes, "aspectmode": "data"}, projection={"type": "orthographic"})
    return {"data": traces, "layout": layout(scene=scene, showlegend=False)}


def _rate_axis(i: int, radius: float) -> dict[str, Any]:
    return {
        "title": {"text": f"ω<sub>{i + 1}</sub>"},
        "range": [-1.08 * radius, 1.08 * radius],
        "nticks": 4,
        "showbackground": False,
        "gridcolor": "#D5DAE0",
        "zeroline": False,
    }


def _surface(ellipsoid: Ellipsoid) -> dict[str, Any]:
    points = coordinates(np.moveaxis(ellipsoid.surface(_ABOVE), 0, -1))
    look = {"colorscale": [[0, SURFACE], [1, SURFACE]], "showscale": False, "opacity": 0.75, "hoverinfo": "skip"}
    return {"type": "surface", **points, **look, "lighting": {"specular": 0.1, "diffuse": 0.6}}


def herpolhode(piece: RecordedSegment) -> Figure | None:
    """Path of ω in the world, seen along the angular momentum, on the invariable plane; none of a body at rest."""
    scenario, states = piece.segment.scenario, path(piece, _POINTS)
    momentum = scenario.body().angular_momentum(scenario.start())
    size, fastest = float(np.linalg.norm(momentum)), scenario.rate_bound()
    if size == 0.0 or not len(states.body_rate):
        return None
    upright = momentum / size
    rates = world_rates(states)
    across = rates - np.outer(rates @ upright, upright)
    right = _right(across[0], upright, fastest)
    points = across @ np.stack([right, np.cross(upright, right)], axis=-1)
    traces = [
        line(points, "herpolhode", RED, 1.5),
        mark(points[0], "first sample", color="black", size=7),
        mark(np.zeros(2), "angular momentum", color=GREY, symbol="x"),
    ]
    reach = 1.1 * max(float(np.abs(points).max()), 1e-3 * fastest)
    look: dict[str, Any] = {"range": [-reach, reach], "constrain": "domain", "nticks": 6}
    axes = {"xaxis": axis("ω across L [rad/s]", **look), "yaxis": axis("[rad/s]", scaleanchor="x", **look)}
    return {"data": traces, "layout": layout(**axes, showlegend=False)}


def _right(across: Array, upright: Array, fastest: float) -> Array:
    """Direction to the right of the picture: of ω's first part across the momentum, or any if it has none."""
    if np.linalg.norm(across) < 1e-9 * fastest:
        across = np.cross(upright, np.eye(3)[np.argmin(np.abs(upright))])
    return np.asarray(across / np.linalg.norm(across))
