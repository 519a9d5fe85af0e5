"""Motion of a recording as figures of a page: rate, polhode, herpolhode, and a film of the body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report.html_page import (
    Figure,
    axis,
    coordinates,
    drawn,
    figure,
    grid,
    line,
    mark,
    over_time,
    paragraph,
)
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
    usable,
    world_rates,
)

_POINTS: Final = 3000
"""Largest number of points of a polhode or herpolhode."""
_ABOVE: Final = 0.995
"""Size of the surface that is drawn, as a share of the ellipsoid: the polhode lies on that and is not to sink in."""
_DISTANCE: Final = 1.15
"""Distance of the eye, in sizes of the figure."""

FRAMES: Final = 200
"""Largest number of frames."""
_TURN: Final = 0.25
"""Largest turn, rad, from one frame to the next, if samples are as near."""
_TAIL: Final = 30
"""Number of frames that the bright part of the trace is long."""
_ARROW: Final = 1.15
"""Length of the angular momentum, and the greatest of the angular velocity, in longest sides of the box."""
_AXIS: Final = 0.8
"""Length of the body's axes, in longest sides of the box."""
_REACH: Final = 1.25
"""Half of the picture's width, in longest sides of the box."""
_DURATION_MS: Final = (8e3, 16e3)
"""Shortest and longest duration of the film, ms: neither too fast nor too slow to be followed."""

_MOMENTUM, _RATE, _TRACE, _WORLD = "#8C5AA8", "#E69F00", "#56606B", "#9AA5B1"
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))
_FACES: Final = (
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5)),  # across x
    *((0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)),  # across y
    *((0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),  # across z
)
_TINTS: Final = tuple(tint for tint in ("#7FA6D9", "#B5CBE8", "#E3ECF7") for _ in range(4))
_EDGES: Final = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 6, 2, 3, 7, 5, 1)
"""Corners along a path through all edges."""
_NONE: Final = np.zeros((1, 3))


def resets(pieces: Sequence[RecordedSegment]) -> list[dict[str, Any]]:
    """Lines at the resets, for a layout; none where there are too many."""
    t, look = reset_times(pieces), {"color": "black", "width": 1, "dash": "dash"}
    shapes = [{"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper", "line": look} for x in t]
    return shapes if len(shapes) <= MOST_RESETS else []


def sections(pieces: Sequence[RecordedSegment]) -> Iterator[str]:
    """HTML of all figures of a recording, of whose segments each has a sample."""
    first = pieces[0]
    whose = " of the first segment" if len(pieces) > 1 else ""
    if film := body(first):
        yield figure(f"The body{whose}", *film, kind="body")
    yield figure("Body rate", rate(pieces), "Angular velocity in the frame of the body.")
    paths = (
        (polhode(first), "Polhode", "ω [rad/s] in the principal frame, on the ellipsoid of the kinetic energy."),
        (herpolhode(first), "Herpolhode", "ω in the world, seen along the angular momentum (cross)."),
    )
    figures = [figure(f"{name}{whose}", content, text, kind="tall") for content, name, text in paths if content]
    yield grid(figures, wide=True) if figures else paragraph("The body is at rest: no polhode, no herpolhode.")


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
    return drawn(traces, **axes, shapes=resets(pieces))


def polhode(piece: RecordedSegment) -> Figure | None:
    """Path of ω in the principal frame, on the ellipsoid of the energy; none of a body at rest."""
    ellipsoid = Ellipsoid.of(piece, _POINTS)
    if ellipsoid is None:
        return None
    circles = np.insert(ellipsoid.principal_circles(), 0, np.nan, axis=1).reshape(-1, 3)
    surface = {
        "type": "surface",
        **coordinates(np.moveaxis(ellipsoid.surface(_ABOVE), 0, -1)),
        "colorscale": [[0, SURFACE], [1, SURFACE]],
        "showscale": False,
        "opacity": 0.75,
        "hoverinfo": "skip",
        "lighting": {"specular": 0.1, "diffuse": 0.6},
    }
    traces = [
        surface,
        line(circles, "principal planes", CIRCLES, 1.5),
        line(ellipsoid.polhode, "polhode", RED, 5),
        mark(ellipsoid.polhode[0], "first sample", size=4, color="black"),
    ]
    look = {"nticks": 4, "showbackground": False, "gridcolor": "#D5DAE0", "zeroline": False}
    axes = {
        f"{name}axis": {"title": {"text": f"ω<sub>{i}</sub>"}, "range": [-1.08 * radius, 1.08 * radius], **look}
        for i, (name, radius) in enumerate(zip("xyz", ellipsoid.radii, strict=True), 1)
    }
    eye = coordinates(_DISTANCE * ellipsoid.best_view().axes[0])
    camera = {"eye": eye, "projection": {"type": "orthographic"}}
    return drawn(traces, scene={**axes, "aspectmode": "data", "camera": camera}, showlegend=False)


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
    right = across[0]  # of ω's first part across the momentum, or any if it has none
    if np.linalg.norm(right) < 1e-9 * fastest:
        right = np.cross(upright, np.eye(3)[np.argmin(np.abs(upright))])
    right = right / np.linalg.norm(right)
    points = across @ np.stack([right, np.cross(upright, right)], axis=-1)
    traces = [
        line(points, "herpolhode", RED, 1.5),
        mark(points[0], "first sample", color="black", size=7),
        mark(np.zeros(2), "angular momentum", color=GREY, symbol="x"),
    ]
    reach = 1.1 * max(float(np.abs(points).max()), 1e-3 * fastest)
    look: dict[str, Any] = {"range": [-reach, reach], "constrain": "domain", "nticks": 6}
    axes = {"xaxis": axis("ω across L [rad/s]", **look), "yaxis": axis("[rad/s]", scaleanchor="x", **look)}
    return drawn(traces, **axes, showlegend=False)


def body(piece: RecordedSegment) -> tuple[Figure, str] | None:
    """Film of the first part of a segment, and sentences that say what it shows; none if no sample can be drawn."""
    t, states = _frames(piece)
    if not len(t):
        return None
    scenario = piece.segment.scenario
    momentum = scenario.body().angular_momentum(scenario.start())
    momentum = momentum / (float(np.linalg.norm(momentum)) or 1.0)
    followed = int(np.argmax(np.abs(scenario.initial_body_rate)))
    moving = _moving(piece, states, followed)
    trace = moving[2][:, 3 * followed + 1]
    world = {"text": ["", "X", "", "", "Y", "", "", "Z", ""], "textfont": {"size": 12, "color": _WORLD}}
    data = [
        *({**look, **_places(points[0])} for look, points in zip(_LOOKS, moving, strict=True)),
        _arrow(np.stack([_NONE[0], _ARROW * momentum]), "angular momentum L (fixed)", _MOMENTUM),
        line(trace, f"path of the {'xyz'[followed]} axis", _TRACE, 2, opacity=0.6, hoverinfo="name"),
        line(_cross(1.0), "axes of the world", _WORLD, 2, mode="lines+text", hoverinfo="name", **world),
    ]
    # the eye is across the angular momentum and somewhat above
    azimuth = float(np.arctan2(momentum[1], momentum[0])) + np.radians(60.0)
    eye = coordinates(1.1 * np.array([np.cos(azimuth), np.sin(azimuth), 0.45]))
    hidden = {f"{name}axis": {"visible": False, "range": [-_REACH, _REACH]} for name in "xyz"}
    scene = {**hidden, "aspectmode": "cube", "camera": {"eye": eye}}
    digits = max(0, 2 - int(np.floor(np.log10(t[-1])))) if t[-1] > 0.0 else 0
    duration = float(np.clip(1e3 * t[-1], *_DURATION_MS))
    each = [[_places(points[k]) for points in moving] for k in range(len(t))]
    film = {
        "times": [f"{seconds:.{digits}f} s" for seconds in t.tolist()],
        "duration": duration,
        "pictures": [{name: [place[name] for place in places] for name in "xyz"} for places in each],
    }
    shown = (
        f"The first {t[-1]:.4g} s, as recorded, played in {1e-3 * duration:.3g} s: a box of the body's principal "
        "moments in the world. Drag to turn, scroll to come nearer."
    )
    margin = {"l": 0, "r": 0, "t": 30, "b": 0}
    return {**drawn(data, scene=scene, uirevision="kept", margin=margin), "film": film}, shown


def _frames(piece: RecordedSegment) -> tuple[Array, State]:
    """Times since the first sample, s, and states of the frames."""
    t = times(piece.stamps_ns[: piece.close], [piece])
    if not len(t):
        return t, piece.states[:0]
    fastest = piece.segment.scenario.rate_bound()
    horizon = min(float(t[-1]), FRAMES * _TURN / fastest) if fastest else float(t[-1])
    at = np.unique(np.searchsorted(t, np.linspace(0.0, horizon, FRAMES) - 1e-9))
    states, sane = usable(piece, at)
    return t[at[sane]], states


def _moving(piece: RecordedSegment, states: State, followed: int) -> tuple[Array, ...]:
    """Points at each frame of the box, its edges, the axes, the angular velocity and the latest tips of an axis.

    Each has shape (N, M, 3), on the axes of the world, in longest sides of the box.
    """
    own, fastest = piece.segment.scenario.body(), piece.segment.scenario.rate_bound()
    box = (_CORNERS * box_sides(own.principal_moments)) @ own.principal_axes.T
    corners, axes = (quaternion.rotate(states.attitude_xyzw[:, np.newaxis], points) for points in (box, _cross(_AXIS)))
    rates = world_rates(states)[:, np.newaxis] * (_ARROW / fastest if fastest else 0.0)
    latest = np.maximum(0, np.arange(len(rates))[:, np.newaxis] + np.arange(-_TAIL, 1))
    return (
        corners,
        corners[:, _EDGES],
        axes,
        np.concatenate([np.zeros_like(rates), rates], axis=1),
        axes[latest, 3 * followed + 1],
    )


def _cross(length: float) -> Array:
    """Three axes from the origin to a length, with a gap after each, shape (9, 3)."""
    return np.stack([np.zeros((3, 3)), length * np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)


def _places(points: Array) -> dict[str, Any]:
    return {name: np.round(points[:, i], 3) for i, name in enumerate("xyz")}


def _arrow(points: Array, name: str, colour: str) -> dict[str, Any]:
    marker = {"size": [0, 5], "color": colour, "symbol": "diamond", "line": {"width": 0}}
    return line(points, name, colour, 8, mode="lines+markers", marker=marker, hoverinfo="name")


_LETTERS: Final[dict[str, Any]] = {
    "mode": "lines+text",
    "line": {"color": [colour for colour in COLOURS for _ in range(3)], "width": 5},
    "text": ["", "x", "", "", "y", "", "", "z", ""],
    "textfont": {"size": 14},
}
_LOOKS: Final = (
    {
        "type": "mesh3d",
        "name": "body",
        **dict(zip("ijk", zip(*_FACES, strict=True), strict=True)),
        "facecolor": _TINTS,
        "flatshading": True,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
        "hoverinfo": "skip",
    },
    line(_NONE, "edges", "#3B5B85", 3, showlegend=False, hoverinfo="skip"),
    line(_NONE, "axes of the body", COLOURS[0], 4, **_LETTERS, showlegend=False, hoverinfo="skip"),
    _arrow(_NONE, "angular velocity ω", _RATE),
    line(_NONE, "latest part of it", RED, 4, showlegend=False, hoverinfo="name"),
)
"""Looks of what moves, in the order of `_moving`."""
