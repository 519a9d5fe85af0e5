"""The body in three dimensions, which can be turned and played in time: a box of its principal moments."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report.html_page import Figure
from lie_rigid_body.report.plotly_parts import layout, line, space
from lie_rigid_body.report.recorded_motion import COLOURS, RED, times, usable, world_rates

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
_SHORTEST: Final = 8e3
_LONGEST: Final = 16e3
"""Shortest and longest duration of the film, ms."""

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
_SKIP: Final[dict[str, Any]] = {"showlegend": False, "hoverinfo": "skip"}


def body(piece: RecordedSegment) -> Figure | None:
    """Film of the first part of a segment; none if no sample can be drawn.

    Parameters
    ----------
    piece : RecordedSegment

    Returns
    -------
    mapping or None
    """
    t, states = _frames(piece)
    if not len(t):
        return None
    scenario = piece.segment.scenario
    momentum = scenario.body().angular_momentum(scenario.start())
    momentum = momentum / (float(np.linalg.norm(momentum)) or 1.0)
    followed = int(np.argmax(np.abs(scenario.initial_body_rate)))
    moving = _moving(piece, states, followed)
    trace = moving[2][:, 3 * followed + 1]
    data = [
        *({**look, **_places(points[0])} for look, points in zip(_LOOKS, moving, strict=True)),
        _arrow(np.stack([_NONE[0], _ARROW * momentum]), "angular momentum L (fixed)", _MOMENTUM),
        line(trace, f"path of the {'xyz'[followed]} axis", _TRACE, 2, opacity=0.6, hoverinfo="name"),
        _axes_of_the_world(),
    ]
    hidden = {f"{name}axis": {"visible": False, "range": [-_REACH, _REACH]} for name in "xyz"}
    scene = space(_eye(momentum), {**hidden, "aspectmode": "cube"})
    each = [[_places(points[k]) for points in moving] for k in range(len(t))]
    film = {
        "times": _texts(t),
        "duration": _duration(t),
        "pictures": [{name: [place[name] for place in places] for name in "xyz"} for places in each],
    }
    margin = {"l": 0, "r": 0, "t": 30, "b": 0}
    return {"data": data, "layout": layout(scene=scene, uirevision="kept", margin=margin), "film": film}


def caption(piece: RecordedSegment) -> str:
    """Sentences that say what the figure shows."""
    t, _ = _frames(piece)
    return (
        f"The first {t[-1]:.4g} s, as recorded, played in {1e-3 * _duration(t):.3g} s: a box of the body's principal "
        "moments in the world. Drag to turn, scroll to come nearer."
    )


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
    corners = _turned(states, (_CORNERS * box_sides(own.principal_moments)) @ own.principal_axes.T)
    axes = _turned(states, _cross(_AXIS))
    rates = world_rates(states)[:, np.newaxis] * (_ARROW / fastest if fastest else 0.0)
    latest = np.maximum(0, np.arange(len(rates))[:, np.newaxis] + np.arange(-_TAIL, 1))
    return (
        corners,
        corners[:, _EDGES],
        axes,
        np.concatenate([np.zeros_like(rates), rates], axis=1),
        axes[latest, 3 * followed + 1],
    )


def _turned(states: State, points: Array) -> Array:
    """Points of the body in the world at each state, shape (N, M, 3)."""
    return quaternion.rotate(states.attitude_xyzw[:, np.newaxis], points[np.newaxis])


def _cross(length: float) -> Array:
    """Three axes from the origin to a length, with a gap after each, shape (9, 3)."""
    return np.stack([np.zeros((3, 3)), length * np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)


def _places(points: Array) -> dict[str, Any]:
    return {name: np.round(points[:, i], 3) for i, name in enumerate("xyz")}


def _arrow(points: Array, name: str, colour: str) -> dict[str, Any]:
    marker = {"size": [0, 5], "color": colour, "symbol": "diamond", "line": {"width": 0}}
    return line(points, name, colour, 8, mode="lines+markers", marker=marker, hoverinfo="name")


_BOX: Final[dict[str, Any]] = {
    "type": "mesh3d",
    "name": "body",
    **dict(zip("ijk", zip(*_FACES, strict=True), strict=True)),
    "facecolor": _TINTS,
    "flatshading": True,
    "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
    "hoverinfo": "skip",
}
_LETTERS: Final[dict[str, Any]] = {
    "mode": "lines+text",
    "line": {"color": [colour for colour in COLOURS for _ in range(3)], "width": 5},
    "text": ["", "x", "", "", "y", "", "", "z", ""],
    "textfont": {"size": 14},
}
_LOOKS: Final = (
    _BOX,
    line(_NONE, "edges", "#3B5B85", 3, **_SKIP),
    line(_NONE, "axes of the body", COLOURS[0], 4, **_LETTERS, **_SKIP),
    _arrow(_NONE, "angular velocity ω", _RATE),
    line(_NONE, "latest part of it", RED, 4, showlegend=False, hoverinfo="name"),
)
"""Looks of what moves, in the order of `_moving`."""


def _axes_of_the_world() -> dict[str, Any]:
    """Axes of the world, thin and grey."""
    letters = {"text": ["", "X", "", "", "Y", "", "", "Z", ""], "textfont": {"size": 12, "color": _WORLD}}
    return line(_cross(1.0), "axes of the world", _WORLD, 2, mode="lines+text", hoverinfo="name", **letters)


def _eye(momentum: Array) -> Array:
    """Place of the eye, across the angular momentum and somewhat above."""
    azimuth = float(np.arctan2(momentum[1], momentum[0])) + np.radians(60.0)
    return 1.1 * np.array([np.cos(azimuth), np.sin(azimuth), 0.45])


def _texts(t: Array) -> list[str]:
    digits = max(0, 2 - int(np.floor(np.log10(t[-1])))) if t[-1] > 0.0 else 0
    return [f"{seconds:.{digits}f} s" for seconds in t.tolist()]


def _duration(t: Array) -> float:
    """Duration of the film, ms: that of what it shows, but neither too fast nor too slow to be followed."""
    return float(np.clip(1e3 * t[-1], _SHORTEST, _LONGEST))
