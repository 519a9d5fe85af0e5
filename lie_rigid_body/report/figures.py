"""Figures of pages: the motion of a recording with a film of the body, and residuals over time and by their sizes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any, Final

import numpy as np

from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.shapes import box_sides
from lie_rigid_body.report.drawing import COLOURS, GREY, RED, svg
from lie_rigid_body.report.html_page import (
    Figure,
    Look,
    axis,
    coordinates,
    drawn,
    figure,
    grid,
    line,
    logarithmic,
    mark,
    paragraph,
)
from lie_rigid_body.report.recorded_motion import (
    FEW_SAMPLES,
    MAX_RESETS,
    LawOverTime,
    Pieces,
    RecordedSegment,
    ResidualsOverTime,
    extremes,
    first_arc,
    path,
    reset_times,
    times,
    usable,
)
from lie_rigid_body.scenario.arcs import largest_of_arcs

_POINTS: Final = 3000
"""Largest number of points of a herpolhode."""
FRAMES: Final = 200
"""Largest number of frames."""
_TURN: Final = 0.25
"""Largest turn, rad, from one frame to the next, if samples are as near."""
_TAIL: Final = 30
"""Number of frames that the bright part of the trace is long."""
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
_LIMIT: Final[Look] = {"line": {"color": GREY, "dash": "dash", "width": 1.4}, "mode": "lines"}


def resets(pieces: Pieces) -> list[Look]:
    """Lines at the resets, for a layout; none where there are too many."""
    t = reset_times(pieces)
    look = {"color": "black", "width": 1, "dash": "dash"}
    shapes = [{"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper", "line": look} for x in t]
    return shapes if len(shapes) <= MAX_RESETS else []


def sections(pieces: Pieces) -> Iterator[str]:
    """HTML of all figures of a recording, of whose segments each has a sample."""
    first = pieces[0]
    whose = " of the first segment" if len(pieces) > 1 else ""
    if film := body(first):
        yield figure(f"The body{whose}", *film, kind="body")
    rates = [piece.states.body_rate for piece in pieces]
    yield figure(
        "Body rate",
        over_time(pieces, rates, "ω<sub>{}</sub>", "body rate [rad/s]"),
        "Angular velocity in the frame of the body.",
    )
    if any(piece.segment.scenario.moves for piece in pieces):
        place = over_time(pieces, [piece.position for piece in pieces], "{}", "position [m]")
        yield figure("Position", place, "Mass centre in the world.")
    if first.segment.scenario.kicks:
        whose = f" of the first moving arc{whose}"
    if across := herpolhode(first):
        seen = "ω in the world, seen along the angular momentum (cross)."
        yield grid([_polhode(first, whose), figure(f"Herpolhode{whose}", across, seen, kind="tall")], wide=True)
    else:
        yield paragraph("There is no polhode and no herpolhode of a body at rest or on a path.")


def _polhode(piece: RecordedSegment, whose: str) -> str:
    """The polhode as it is in the picture of a recording."""
    from lie_rigid_body.report.recording_picture import polhode  # only now: it loads Matplotlib

    what = "ω [rad/s] in the principal frame, on the ellipsoid of the kinetic energy."
    below = f"<figcaption>{what}</figcaption>"
    return f"<figure><h3>Polhode{whose}</h3>{svg(partial(polhode, piece))}{below}</figure>"


def over_time(pieces: Pieces, vectors: Sequence[Array], name: str, label: str) -> Figure:
    """Components of vectors, shape (N, 3) of each piece, over time."""
    t = np.concatenate([times(piece.stamps_ns, pieces) for piece in pieces])
    few = {"mode": "markers" if len(t) <= FEW_SAMPLES else "lines", "cliponaxis": True}
    traces = [
        _over_time(t, component, name.format(axis_name), colour, **few)
        for axis_name, colour, component in zip("xyz", COLOURS, np.concatenate(vectors).T, strict=True)
    ]
    time = axis("time [s]", range=[0.0, float(t[-1]) or 1.0])
    return drawn(traces, xaxis=time, yaxis=axis(label), shapes=resets(pieces))


def _over_time(t: Array, values: Array, name: str, colour: str, **more: Any) -> Look:
    """Line through the extremes of values over time, with a mark at each of 50 points at most."""
    marks = {"mode": "lines+markers" if len(t) <= 50 else "lines", "marker": {"color": colour, "size": 5}}
    points = np.stack([t, values], axis=-1)[extremes(t, values)]
    return line(points, name, colour, 1.2, **{"cliponaxis": False, **marks, **more})


def herpolhode(piece: RecordedSegment) -> Figure | None:
    """Path of ω in the world, seen along the momentum of the first moving arc; none at rest or on a path."""
    scenario = piece.segment.scenario
    arc, begin = first_arc(piece)
    states = path(arc, _POINTS)
    momentum = scenario.body().angular_momentum(begin)
    size = float(np.linalg.norm(momentum))
    fastest = scenario.rate_bound()
    if size == 0.0 or not len(states.body_rate) or scenario.path():
        return None
    upright = momentum / size
    rates = quaternion.rotate(states.attitude_xyzw, states.body_rate)
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
    look: Look = {"range": [-reach, reach], "constrain": "domain", "nticks": 6}
    upwards = axis("[rad/s]", scaleanchor="x", **look)
    return drawn(traces, xaxis=axis("ω across L [rad/s]", **look), yaxis=upwards, showlegend=False)


def body(piece: RecordedSegment) -> tuple[Figure, str] | None:
    """Film of the first part of a segment, and sentences that say what it shows; none if no sample can be drawn."""
    t, states = _frames(piece)
    if not len(t):
        return None
    scenario = piece.segment.scenario
    _, begin = first_arc(piece)
    momentum = scenario.body().angular_momentum(begin)
    followed = int(np.argmax(np.abs(begin.body_rate)))
    moving = _moving(piece, states, followed)[: -1 if scenario.path() else None]
    data = [
        *({**look, **_places(points[0])} for look, points in zip(_LOOKS, moving, strict=False)),
        line(
            moving[2][:, 3 * followed + 1],
            f"path of the {'xyz'[followed]} axis",
            _TRACE,
            2,
            opacity=0.6,
            hoverinfo="name",
        ),
        line(
            _cross(1.0),
            "axes of the world",
            _WORLD,
            2,
            mode="lines+text",
            hoverinfo="name",
            text=["", "X", "", "", "Y", "", "", "Z", ""],
            textfont={"size": 12, "color": _WORLD},
        ),
    ]
    # the eye is across the angular momentum and somewhat above
    azimuth = float(np.arctan2(momentum[1], momentum[0])) + np.radians(60.0)
    eye = coordinates(1.1 * np.array([np.cos(azimuth), np.sin(azimuth), 0.45]))
    hidden = {f"{name}axis": {"visible": False, "range": [-_REACH, _REACH]} for name in "xyz"}
    scene = {**hidden, "aspectmode": "cube", "camera": {"eye": eye}}
    content = drawn(data, scene=scene, uirevision="kept", margin={"l": 0, "r": 0, "t": 30, "b": 0})
    digits = max(0, 2 - int(np.floor(np.log10(t[-1])))) if t[-1] > 0.0 else 0
    duration = float(np.clip(1e3 * t[-1], *_DURATION_MS))
    each = [[_places(points[k]) for points in moving] for k in range(len(t))]
    film = {
        "times": [f"{seconds:.{digits}f} s" for seconds in t.tolist()],
        "duration": duration,
        "pictures": [{name: [place[name] for place in places] for name in "xyz"} for places in each],
    }
    return {**content, "film": film}, (
        f"The first {t[-1]:.4g} s, as recorded, played in {1e-3 * duration:.3g} s: a box of the body's principal "
        "moments in the world. Drag to turn, scroll to come nearer."
    )


def _frames(piece: RecordedSegment) -> tuple[Array, State]:
    """Times since the first sample, s, and states of the frames."""
    t = times(piece.stamps_ns, [piece])
    fastest = piece.segment.scenario.rate_bound()
    horizon = min(float(t.max(initial=0.0)), FRAMES * _TURN / fastest if fastest else np.inf)
    at = np.unique(np.searchsorted(t, np.linspace(0.0, horizon, FRAMES) - 1e-9))[: len(t)]  # of no sample none
    states, sane = usable(piece, at)
    return t[at[sane]], states


def _moving(piece: RecordedSegment, states: State, followed: int) -> tuple[Array, ...]:
    """Points at each frame of the box, its edges, the axes, the rate, the latest tips of an axis, and the momentum.

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
    latest = np.maximum(0, np.arange(len(rates))[:, np.newaxis] + np.arange(-_TAIL, 1))
    return (
        corners,
        corners[:, _EDGES],
        axes,
        np.concatenate([np.zeros_like(rates), rates], axis=1),
        axes[latest, 3 * followed + 1],
        np.concatenate([np.zeros_like(momenta), momenta], axis=1),
    )


def _cross(length: float) -> Array:
    """Three axes from the origin to a length, with a gap after each, shape (9, 3)."""
    return np.stack([np.zeros((3, 3)), length * np.eye(3), np.full((3, 3), np.nan)], axis=1).reshape(9, 3)


def _places(points: Array) -> Look:
    return {name: np.round(points[:, i], 3) for i, name in enumerate("xyz")}


def _arrow(points: Array, name: str, colour: str) -> Look:
    marker = {"size": [0, 5], "color": colour, "symbol": "diamond", "line": {"width": 0}}
    return line(points, name, colour, 8, mode="lines+markers", marker=marker, hoverinfo="name")


_LOOKS: Final = (
    {
        "type": "mesh3d",
        "name": "body",
        **dict(zip("ijk", zip(*_FACES, strict=True), strict=True)),
        "facecolor": [tint for tint in ("#7FA6D9", "#B5CBE8", "#E3ECF7") for _ in range(4)],
        "flatshading": True,
        "lighting": {"ambient": 0.75, "diffuse": 0.5, "specular": 0.05},
        "hoverinfo": "skip",
    },
    line(_NONE, "edges", "#3B5B85", 3, showlegend=False, hoverinfo="skip"),
    line(
        _NONE,
        "axes of the body",
        COLOURS[0],
        5,
        mode="lines+text",
        line={"color": [colour for colour in COLOURS for _ in range(3)], "width": 5},
        text=["", "x", "", "", "y", "", "", "z", ""],
        textfont={"size": 14},
        showlegend=False,
        hoverinfo="skip",
    ),
    _arrow(_NONE, "angular velocity ω", _RATE),
    line(_NONE, "latest part of it", RED, 4, showlegend=False, hoverinfo="name"),
    _arrow(_NONE, "angular momentum L, which kicks alone change", _MOMENTUM),  # not along a path
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
    watched = [law for law in certificate.laws if law.name in residuals.laws]
    for law in watched:
        if traces := list(_traces(law, residuals.laws[law.name], int(pieces[0].stamps_ns[0]))):
            label = {"rel": "relative residual", "1": "residual", "": "residual"}.get(
                law.unit, f"residual [{law.unit}]"
            )
            time = axis("time [s]", range=[0.0, max(float(trace["x"][-1]) for trace in traces)])
            size = logarithmic(label, np.concatenate([trace["y"] for trace in traces]))
            yield figure(law.name, drawn(traces, xaxis=time, yaxis=size, shapes=resets(pieces), showlegend=False))


def _traces(worst: LawResult, law: LawOverTime, origin_ns: int) -> Iterator[Look]:
    """Curve of a law, marks at what is broken and at the worst, and its limit, if it has a residual but 0."""
    t, residuals, limit, broken = law.series(origin_ns)
    if not (residuals > 0.0).any():
        return
    limit = np.where(np.isfinite(limit), limit, 0.0)
    finite = np.isfinite(residuals)
    top = _BEYOND * max(float(residuals[finite].max(initial=0.0)), float(limit.max())) or 1.0
    heights = np.where(finite, np.where(residuals > 0.0, residuals, np.nan), top)
    yield _over_time(t, heights, "largest residual", COLOURS[2])
    if broken.any():
        yield _over_time(t[broken], heights[broken], "broken", RED, mode="markers", showlegend=False)
    if worst.stamp_ns is not None and 0.0 < worst.worst < np.inf:
        at = np.array([(worst.stamp_ns - origin_ns) * 1e-9, worst.worst])
        circle = {"symbol": "circle-open", "size": 11, "color": COLOURS[2], "line": {"width": 2}}
        yield {**mark(at, f"worst: number {worst.sample}", **circle), "showlegend": False, "cliponaxis": False}
    if (limit > 0.0).any():
        yield _over_time(t, np.where(limit > 0.0, limit, np.nan), "limit", GREY, **_LIMIT)


def distributions(laws: Mapping[str, Sequence[Sequence[float]]], whose: str) -> Iterator[str]:
    """Draw how many of many bags have a worst residual up to each size, beside the limits.

    Parameters
    ----------
    laws : mapping of str to sequence of pairs of float
        Of each law, by its name with the unit, the worst residual and its limit in each bag.
    whose : str
        What there are many of, such as ``bags``.

    Yields
    ------
    str
        HTML. Laws that have no residual but 0, as those that hold or do not, are left out.
    """
    for name, pairs in laws.items():
        residuals, limits = np.array(pairs, dtype=np.float64).T
        finite = np.isfinite(residuals)
        shown = finite & (residuals > 0.0)
        if shown.any() and limits.max() > 0.0:
            left_out = {"0": np.sum(residuals == 0.0), "not finite": np.sum(~finite)}
            caption = ", ".join(f"{what} in {count} {whose}" for what, count in left_out.items() if count)
            yield figure(name, _distribution(residuals[shown], limits[shown], limits, whose), caption)


def _distribution(residuals: Array, own: Array, limits: Array, whose: str) -> Look:
    """Number of residuals up to each size, with marks at those beyond their own limits, and the limits of all."""
    order = np.argsort(residuals)
    points = np.column_stack([residuals[order], np.arange(1, len(order) + 1)])
    beyond = points[(residuals > own)[order]]
    ends = limits[[np.argmin(limits), np.argmax(limits)]]
    corners = np.column_stack([np.repeat(ends, 2), [0.0, len(order), len(order), 0.0]])
    traces = [
        line(points, "worst residuals", COLOURS[2], 1.4, mode="lines+markers"),
        line(beyond, "beyond the limit", RED, 1.0, mode="markers", showlegend=len(beyond) > 0),
        {**line(corners, "limits", GREY, 1.4), "fill": "toself", **_LIMIT},
    ]
    size = logarithmic("worst residual, up to", np.append(residuals, limits))
    return drawn(traces, xaxis=size, yaxis=axis(whose, rangemode="tozero"))
