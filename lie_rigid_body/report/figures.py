"""Figures of a recording: the film of the body, its curves, and residuals of its laws."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.certificate.certification import Certificate
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.foundation.arrays import Array, Booleans
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.report.drawing import BLACK, BLUE, COLOURS, GREY, RED, svg
from lie_rigid_body.report.html_page import figure, film, grid, paragraph, plane
from lie_rigid_body.report.recorded_motion import (
    Pieces,
    RecordedSegment,
    ResidualsOverTime,
    first_arc,
    path,
    times,
    usable,
)
from lie_rigid_body.scenario.arcs import largest_of_arcs

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Look = dict[str, Any]
"""A trace of plotly.js."""

_POINTS: Final = 3000
"""Largest number of points of a herpolhode."""
FRAMES: Final = 200
"""Largest number of frames."""
_TURN: Final = 0.25
"""Largest turn, rad, from one frame to the next, if samples are as near."""
_ARROW: Final = 1.15
"""Length of the arrow of the angular momentum, and of the longest arrow of the angular velocity, in longest sides of
the box."""
_AXIS: Final = 0.8
"""Length of the body's axes, in longest sides of the box."""
_REACH: Final = 1.25
"""Half of the picture's width, in longest sides of the box."""
_DURATION_MS: Final = (8e3, 16e3)
"""Shortest and longest duration of the film, ms: neither too fast nor too slow to be followed."""

_MOMENTUM = "#8C5AA8"
_RATE = "#E69F00"
_TRACE = "#56606B"
_WORLD = "#9AA5B1"
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))
_FACES: Final = (
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5)),  # across x
    *((0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)),  # across y
    *((0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),  # across z
)
_EDGES: Final = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 6, 2, 3, 7, 5, 1)
"""Numbers of a box's corners along a path through all its edges."""
_NONE: Final = np.zeros((1, 3))

_BEYOND: Final = 10.0
"""Height at which infinite residuals are drawn, as a multiple of the largest finite one."""
_HIGHEST: Final = 1e300
"""Largest residual that is drawn: an axis around it is of finite numbers as well."""


def sections(pieces: Pieces) -> Iterator[str]:
    """HTML of all figures of a recording, of whose segments each has a sample."""
    from lie_rigid_body.report.recording_picture import curves, polhode  # only now: it loads Matplotlib

    first = pieces[0]
    whose = " of the first segment" if len(pieces) > 1 else ""
    if found := body(first):
        content, labels, caption = found
        yield figure(f"The body{whose}", film(content, labels), caption)
    shown = [figure("Curves", svg(partial(curves, pieces)))]
    if first.segment.scenario.kicks:
        whose = f" of the first moving arc{whose}"
    across = herpolhode(first)
    if across is not None:
        on_ellipsoid = "ω [rad/s] in the principal frame, on the ellipsoid of the kinetic energy."
        seen = "ω in the world, seen along the angular momentum (cross)."
        draw = partial(_draw_herpolhode, points=across)
        shown += [
            figure(f"Polhode{whose}", svg(partial(polhode, first)), on_ellipsoid),
            plane(f"Herpolhode{whose}", draw, seen),
        ]
    yield grid(shown)
    if across is None:
        yield paragraph("There is no polhode and no herpolhode of a body at rest or on a path.")


def herpolhode(piece: RecordedSegment) -> Array | None:
    """Path of ω in the world, rad/s, shape (N, 2), across the momentum of the first moving arc.

    None at rest or on a path.
    """
    scenario = piece.segment.scenario
    arc, begin = first_arc(piece)
    states = path(arc, _POINTS)
    momentum = scenario.body().angular_momentum(begin)
    if not momentum.any() or not len(states.body_rate) or scenario.path():
        return None
    right = scipy.linalg.null_space(momentum[np.newaxis])[:, 0]
    other = np.cross(momentum / np.linalg.norm(momentum), right)
    return quaternion.rotate(states.attitude_xyzw, states.body_rate) @ np.stack([right, other], axis=1)


def _draw_herpolhode(axes: Axes, points: Array) -> None:
    axes.plot(*points.T, color=RED, lw=1.0)
    axes.plot(*points[:1].T, "o", color=BLACK, ms=4, label="first sample")
    axes.plot(0.0, 0.0, "x", color=GREY, label="angular momentum")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="ω across L [rad/s]", ylabel="[rad/s]")
    axes.locator_params(nbins=5)


def body(piece: RecordedSegment) -> tuple[Look, list[str], str] | None:
    """Film of the first part of a segment, its times, and what it shows; none if no sample can be drawn."""
    t, states = _frames(piece)
    if not len(t):
        return None
    scenario = piece.segment.scenario
    _, begin = first_arc(piece)
    momentum = scenario.body().angular_momentum(begin)
    followed = np.argmax(np.abs(begin.body_rate))
    moving = _moving(piece, states)[: -1 if scenario.path() else None]
    data = [
        *({**look, **_places(points[0])} for look, points in zip(_LOOKS, moving, strict=False)),
        _line(moving[2][:, 3 * followed + 1], f"path of the {'xyz'[followed]} axis", _TRACE, 2, opacity=0.6),
        _line(_cross(1.0), "axes of the world", _WORLD, 2, **_letters("XYZ", 12)),
    ]
    # the eye is across the angular momentum and somewhat above
    azimuth = np.arctan2(momentum[1], momentum[0]) + np.radians(60.0)
    eye = _places(1.1 * np.array([np.cos(azimuth), np.sin(azimuth), 0.45]))
    hidden = {f"{name}axis": {"visible": False, "range": [-_REACH, _REACH]} for name in "xyz"}
    layout = {
        "scene": {**hidden, "aspectmode": "cube", "camera": {"eye": eye}, "hovermode": False},
        "uirevision": "kept",
        "margin": {"l": 0, "r": 0, "t": 30, "b": 0},
        "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom"},
    }
    duration = float(np.clip(1e3 * t[-1], *_DURATION_MS))
    pictures = [
        {name: [np.round(points[k, :, i], 3) for points in moving] for i, name in enumerate("xyz")}
        for k in range(len(t))
    ]
    return (
        {"data": data, "layout": layout, "film": {"duration": duration, "pictures": pictures}},
        [f"{seconds:.4g} s" for seconds in t.tolist()],
        f"The first {t[-1]:.4g} s, as recorded, played in {1e-3 * duration:.3g} s: a box of the body's principal "
        "moments in the world. Drag to turn, scroll to come nearer.",
    )


def _frames(piece: RecordedSegment) -> tuple[Array, State]:
    """Times since the first sample, s, and states of the frames."""
    t = times(piece.stamps_ns, [piece])
    fastest = piece.segment.scenario.rate_bound()
    horizon = min(t.max(initial=0.0), FRAMES * _TURN / fastest if fastest else np.inf)
    at = np.unique(np.searchsorted(t, np.linspace(0.0, horizon, FRAMES) - 1e-9))[: len(t)]  # of no sample none
    states, sane = usable(piece, at)
    return t[at[sane]], states


def _moving(piece: RecordedSegment, states: State) -> tuple[Array, ...]:
    """Points at each frame of the box, its edges, the axes, the rate, and the momentum.

    Each has shape (N, M, 3), on the axes of the world, in longest sides of the box.
    """
    own = piece.segment.scenario.body()
    fastest = piece.segment.scenario.rate_bound()
    box = (_CORNERS * box_sides(own.principal_moments)) @ own.principal_axes.T
    corners, axes = (quaternion.rotate(states.attitude_xyzw[:, np.newaxis], points) for points in (box, _cross(_AXIS)))
    _, largest = largest_of_arcs(piece.segment.scenario)
    momenta = (_ARROW / (largest or 1.0)) * own.angular_momentum(states)[:, np.newaxis]
    scale = _ARROW / fastest if fastest else 0.0
    rates = scale * quaternion.rotate(states.attitude_xyzw, states.body_rate)[:, np.newaxis]
    return (
        corners,
        corners[:, _EDGES],
        axes,
        np.concatenate([np.zeros_like(rates), rates], axis=1),
        np.concatenate([np.zeros_like(momenta), momenta], axis=1),
    )


def _cross(length: float) -> Array:
    """Three axes from the origin to a length, with a gap after each, shape (9, 3)."""
    return np.stack([np.zeros((3, 3)), length * np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)


def _places(points: Array) -> Look:
    return {name: np.round(points[..., i], 3) for i, name in enumerate("xyz")}


def _line(points: Array, name: str, colour: str, width: float, **more: Any) -> Look:
    """Line through points of shape (N, 3)."""
    style = {"color": colour, "width": width}
    return {"type": "scatter3d", "name": name, "mode": "lines", "line": style, **_places(points), **more}


def _letters(names: str, size: int) -> Look:
    """Names at the ends of three axes."""
    return {
        "mode": "lines+text",
        "text": [each for name in names for each in ("", name, "")],
        "textfont": {"size": size},
    }


def _arrow(name: str, colour: str) -> Look:
    marker = {"size": [0, 5], "color": colour, "symbol": "diamond", "line": {"width": 0}}
    return _line(_NONE, name, colour, 8, mode="lines+markers", marker=marker)


_LOOKS: Final = (
    {
        "type": "mesh3d",
        "name": "body",
        **dict(zip("ijk", zip(*_FACES, strict=True), strict=True)),
        "facecolor": [tint for tint in ("#7FA6D9", "#B5CBE8", "#E3ECF7") for _ in range(4)],
        "flatshading": True,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
    },
    _line(_NONE, "edges", "#3B5B85", 3, showlegend=False),
    _line(
        _NONE,
        "axes of the body",
        COLOURS[0],
        5,
        line={"color": [colour for colour in COLOURS for _ in range(3)], "width": 5},
        showlegend=False,
        **_letters("xyz", 14),
    ),
    _arrow("angular velocity ω", _RATE),
    _arrow("angular momentum L, which kicks alone change", _MOMENTUM),  # not along a path
)
"""Looks of what moves, in the order of `_moving`."""


def residuals_over_time(certificate: Certificate, residuals: ResidualsOverTime, pieces: Pieces) -> Iterator[str]:
    """Draw the largest residuals of each law over time, beside their limits.

    Parameters
    ----------
    certificate : Certificate
    residuals : ResidualsOverTime
        Of the same bag.
    pieces : sequence of RecordedSegment
        Of the same bag, with samples, the first of which has the time 0.

    Yields
    ------
    str
        HTML. Laws that have no residual but 0 are left out.
    """
    for law in certificate.laws:
        if law.name in residuals.pieces:
            series = residuals.series(law.name, int(pieces[0].stamps_ns[0]))
            if (series[1] > 0.0).any():
                yield plane(law.name, partial(draw_law, law=law, series=series, pieces=pieces))


def draw_law(axes: Axes, law: LawResult, series: tuple[Array, Array, Array, Booleans], pieces: Pieces) -> None:
    """Draw the curve of a law with marks at what is broken, and its limit."""
    from lie_rigid_body.report.recording_picture import draw_resets

    t, residuals, limits, broken = series
    finite = np.concatenate([residuals, limits])
    top = min(_BEYOND * finite[np.isfinite(finite)].max(initial=0.0) or 1.0, _HIGHEST)
    heights = np.minimum(residuals, top)
    axes.set_yscale("log", nonpositive="mask")
    axes.plot(t, heights, ".-", color=BLUE, lw=1.2, ms=3, label="largest residual")
    axes.plot(t[broken], heights[broken], ".", color=RED, label="broken" if broken.any() else None)
    if np.isfinite(limits).any():
        axes.plot(t, limits, "--", color=GREY, lw=1.2, label="limit")
    axes.set(xlabel="time [s]", ylabel=f"residual [{law.unit}]" if len(law.unit) > 1 else "residual")
    draw_resets(axes, pieces)
