"""The body in three dimensions, which can be turned and played in time: a box of its principal moments."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.cli.plotly_layout import COLOURS, RED, layout
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report.html_page import Figure

FRAMES: Final = 200
"""Most frames."""
_TURN: Final = 0.25
"""Largest turn, rad, from one frame to the next, if samples are as near."""
_TAIL: Final = 30
"""Frames that the bright part of the trace is long."""
_ARROW: Final = 1.15
"""Length of the angular momentum, and the greatest of the angular velocity, in longest sides of the box."""
_AXIS: Final = 0.8
"""Length of the body's axes."""
_REACH: Final = 1.25
"""Half of the picture's width."""
_SHORTEST: Final = 8e3
_LONGEST: Final = 16e3
"""Durations of the film, ms."""

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


def body(piece: RecordedSegment) -> Figure | None:
    """The figure of the first part of a segment; none if no sample can be drawn.

    Parameters
    ----------
    piece : RecordedSegment

    Returns
    -------
    mapping or None
    """
    t, states = _shown(piece)
    if not len(t):
        return None
    moving = _Moving(piece, states)
    looks = [{**look, **trace} for look, trace in zip(_LOOKS, moving.traces(0), strict=True)]
    pictures = [moving.traces(k) for k in range(len(t))]
    scene = {
        **{f"{name}axis": {"visible": False, "range": [-_REACH, _REACH]} for name in "xyz"},
        "aspectmode": "cube",
        "camera": {"eye": _eye(moving.momentum)},
    }
    return {
        "data": [*looks, *moving.standing(), _world()],
        "layout": layout(scene=scene, uirevision="kept", margin={"l": 0, "r": 0, "t": 30, "b": 0}),
        "film": {
            "times": _texts(t),
            "duration": _duration(t),
            "pictures": [{name: [trace[name] for trace in traces] for name in "xyz"} for traces in pictures],
        },
    }


def caption(piece: RecordedSegment) -> str:
    """What the figure shows."""
    t, _ = _shown(piece)
    end = float(t[-1])
    speed = 1e-3 * _duration(t)
    return (
        f"The first {end:.4g} s, as recorded, played in {speed:.3g} s: a box of the body's principal moments in the "
        "world. Drag to turn, scroll to come nearer."
    )


def _shown(piece: RecordedSegment) -> tuple[Array, State]:
    """Times since the first sample, s, and states of the frames, with unit quaternions."""
    t = (piece.stamps_ns[: piece.close] - piece.stamps_ns[0]) * 1e-9
    if not len(t):
        return t, piece.states[:0]
    fastest = piece.segment.scenario.rate_bound()
    horizon = min(float(t[-1]), FRAMES * _TURN / fastest) if fastest else float(t[-1])
    at = np.unique(np.searchsorted(t, np.linspace(0.0, horizon, FRAMES) - 1e-9))
    attitudes, rates = piece.states.attitude_xyzw[at], piece.states.body_rate[at]
    with np.errstate(invalid="ignore", over="ignore"):
        norms = np.linalg.norm(attitudes, axis=1)
        sane = np.isfinite(norms) & (norms > 0.0) & (np.abs(rates) <= 10.0 * fastest).all(axis=1)
    states = State.trusted(attitudes[sane] / norms[sane, np.newaxis], rates[sane])
    return t[at[sane]], states


class _Moving:
    """What moves, at each frame: the box, its edges, the body's axes, the angular velocity, the tip of an axis."""

    def __init__(self, piece: RecordedSegment, states: State) -> None:
        scenario = piece.segment.scenario
        body, start, fastest = scenario.body(), scenario.start(), scenario.rate_bound()
        momentum = body.angular_momentum(start)
        self.momentum = momentum / (float(np.linalg.norm(momentum)) or 1.0)
        corners = (_CORNERS * box_sides(body.principal_moments)) @ body.principal_axes.T
        self._corners = _turned(states, corners)
        axes = np.stack([np.zeros((3, 3)), _AXIS * np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)
        self._axes = _turned(states, axes)
        self._rate = _turned_each(states, states.body_rate * (_ARROW / fastest if fastest else 0.0))
        self.followed = int(np.argmax(np.abs(start.body_rate)))
        self._tips = self._axes[:, 3 * self.followed + 1]

    def traces(self, k: int) -> list[dict[str, Any]]:
        """The coordinates of what moves, at frame k."""
        origin = np.zeros((1, 3))
        parts = (
            self._corners[k],
            self._corners[k][list(_EDGES)],
            self._axes[k],
            np.concatenate([origin, self._rate[k : k + 1]]),
            self._tips[max(0, k - _TAIL) : k + 1],
        )
        return [_coordinates(points) for points in parts]

    def standing(self) -> list[dict[str, Any]]:
        """What does not move: the angular momentum, and all of the trace."""
        momentum = np.stack([np.zeros(3), _ARROW * self.momentum])
        name = f"path of the {'xyz'[self.followed]} axis"
        return [
            {**_line("angular momentum L (fixed)", _MOMENTUM, 8), **_coordinates(momentum)},
            {**_line(name, _TRACE, 2), **_coordinates(self._tips), "opacity": 0.6},
        ]


def _turned(states: State, points: Array) -> Array:
    """Points of the body in the world at each state, shape (N, M, 3)."""
    return quaternion.rotate(states.attitude_xyzw[:, np.newaxis], points[np.newaxis])


def _turned_each(states: State, vectors: Array) -> Array:
    """A vector of the body for each state, in the world, shape (N, 3)."""
    return quaternion.rotate(states.attitude_xyzw, vectors)


def _coordinates(points: Array) -> dict[str, Any]:
    return {name: np.round(points[:, i], 3) for i, name in enumerate("xyz")}


def _line(name: str, colour: str, width: float) -> dict[str, Any]:
    line = {"color": colour, "width": width}
    marker = {"size": [0, 5], "color": colour, "symbol": "diamond", "line": {"width": 0}}
    arrow = {"mode": "lines+markers", "marker": marker} if width > 4 else {"mode": "lines"}
    return {"type": "scatter3d", "name": name, "line": line, "hoverinfo": "name", **arrow}


_LOOKS: Final[tuple[dict[str, Any], ...]] = (
    {
        "type": "mesh3d",
        "name": "body",
        **dict(zip("ijk", zip(*_FACES, strict=True), strict=True)),
        "facecolor": _TINTS,
        "flatshading": True,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
        "hoverinfo": "skip",
    },
    {**_line("edges", "#3B5B85", 3), "showlegend": False, "hoverinfo": "skip"},
    {
        **_line("axes of the body", COLOURS[0], 4),
        "mode": "lines+text",
        "line": {"color": [colour for colour in COLOURS for _ in range(3)], "width": 5},
        "text": ["", "x", "", "", "y", "", "", "z", ""],
        "textfont": {"size": 14},
        "showlegend": False,
        "hoverinfo": "skip",
    },
    _line("angular velocity ω", _RATE, 8),
    {**_line("latest part of it", RED, 4), "showlegend": False},
)


def _world() -> dict[str, Any]:
    """The axes of the world, thin and grey."""
    points = np.stack([np.zeros((3, 3)), np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)
    text = {"text": ["", "X", "", "", "Y", "", "", "Z", ""], "textfont": {"size": 12, "color": _WORLD}}
    return {**_line("axes of the world", _WORLD, 2), **_coordinates(points), "mode": "lines+text", **text}


def _eye(momentum: Array) -> dict[str, float]:
    """A view across the angular momentum, from somewhat above."""
    azimuth = float(np.arctan2(momentum[1], momentum[0])) + np.radians(60.0)
    eye = 1.1 * np.array([np.cos(azimuth), np.sin(azimuth), 0.45])
    return dict(zip("xyz", np.round(eye, 3).tolist(), strict=True))


def _texts(t: Array) -> list[str]:
    digits = max(0, 2 - int(np.floor(np.log10(t[-1])))) if t[-1] > 0.0 else 0
    return [f"{seconds:.{digits}f} s" for seconds in t.tolist()]


def _duration(t: Array) -> float:
    """How long the film takes, ms: as long as what it shows, but neither too fast nor too slow to be followed."""
    return float(np.clip(1e3 * t[-1], _SHORTEST, _LONGEST))
