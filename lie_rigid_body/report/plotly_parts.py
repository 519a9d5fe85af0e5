"""Parts of which the figures of all pages are made: layouts, axes, lines and arrows for plotly.js."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array

_GRID: Final = "#E4E7EB"
_FRAME: Final = "#8A97A8"
_MARKS: Final = 6
"""Largest number of decades that are labelled."""
_FEW: Final = 50
"""Number of points up to which each is marked on a line of time."""


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Axis of a plane figure."""
    return {
        "title": {"text": title, "standoff": 6},
        "gridcolor": _GRID,
        "zeroline": False,
        "showline": True,
        "linecolor": _FRAME,
        "ticks": "outside",
        "tickcolor": _FRAME,
        "automargin": True,
        "ticklabeloverflow": "allow",  # where all were hidden, plotly.js would put the title at infinity
        **more,
    }


def logarithmic(title: str, values: Array, **more: Any) -> dict[str, Any]:
    """Axis of powers of ten, of whole decades around positive values."""
    found = np.log10(values[np.isfinite(values) & (values > 0.0)])
    low, high = int(np.floor(found.min())), int(np.ceil(found.max() + 1e-9))
    marks = {"dtick": -(-(high - low) // _MARKS), "exponentformat": "power"}
    return axis(title, type="log", range=[low, high], **marks, **more)


def layout(**more: Any) -> dict[str, Any]:
    """Layout of a figure: room for the axes and for a legend above them, and no more."""
    return {
        "font": {"family": "sans-serif", "size": 12, "color": "#222"},
        "margin": {"l": 10, "r": 24, "t": 28, "b": 10},
        "legend": {"orientation": "h", "x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom"},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        **more,
    }


def space(eye: Array, axes: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Scene of a figure in space, seen from a point in units of its size."""
    return {**axes, "camera": {"eye": coordinates(eye), **more}}


def line(points: Array, name: str, colour: str, width: float, **more: Any) -> dict[str, Any]:
    """Line through points of shape (N, 2) or (N, 3), in a plane or in space."""
    kind = "scatter3d" if points.shape[-1] == 3 else "scatter"
    look = {"mode": "lines", "line": {"color": colour, "width": width}}
    return {"type": kind, "name": name, **look, **coordinates(points), **more}


def over_time(t: Array, values: Array, name: str, colour: str, **more: Any) -> dict[str, Any]:
    """Line of values over time, with a mark at each where there are few."""
    marks = {"mode": "lines+markers" if len(t) <= _FEW else "lines", "marker": {"color": colour, "size": 5}}
    return line(np.stack([t, values], axis=-1), name, colour, 1.2, **{"cliponaxis": False, **marks, **more})


def mark(point: Array, name: str, **look: Any) -> dict[str, Any]:
    """Mark at a point of shape (2,) or (3,)."""
    return line(point[np.newaxis], name, "black", 1, mode="markers", marker=look)


def coordinates(points: Array) -> dict[str, Any]:
    """Components of points of shape (..., 2) or (..., 3) by the names of the axes.

    They have six digits, which take less room in a page and are as many as a screen needs.
    """
    short = np.array([float(f"{value:.6g}") for value in points.ravel()]).reshape(points.shape)
    return dict(zip("xyz", np.moveaxis(short, -1, 0), strict=False))
