"""What the figures of all pages share: colours, margins, axes."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array

COLOURS: Final = ("#D55E00", "#009E73", "#0072B2")
"""Colours of the x, y and z components, distinct in every kind of colour vision."""
GREY: Final = "#555555"
RED: Final = "#CC2222"

_GRID: Final = "#E4E7EB"
_MARKS: Final = 6
"""Most decades that are labelled."""


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis of a plane figure."""
    return {
        "title": {"text": title, "standoff": 6},
        "gridcolor": _GRID,
        "zeroline": False,
        "showline": True,
        "linecolor": "#8A97A8",
        "ticks": "outside",
        "tickcolor": "#8A97A8",
        "automargin": True,
        "ticklabeloverflow": "allow",  # where all were hidden, plotly.js would put the title at infinity
        **more,
    }


def logarithmic(title: str, values: Array, **more: Any) -> dict[str, Any]:
    """An axis of powers of ten, of whole decades around positive values."""
    found = np.log10(values[np.isfinite(values) & (values > 0.0)])
    low, high = int(np.floor(found.min())), int(np.ceil(found.max() + 1e-9))
    marks = {"dtick": -(-(high - low) // _MARKS), "exponentformat": "power"}
    return axis(title, type="log", range=[low, high], **marks, **more)


def layout(**more: Any) -> dict[str, Any]:
    """The layout of a figure: room for the axes and for a legend above them, and no more."""
    return {
        "font": {"family": "sans-serif", "size": 12, "color": "#222"},
        "margin": {"l": 10, "r": 24, "t": 28, "b": 10},
        "legend": {"orientation": "h", "x": 0, "xanchor": "left", "y": 1, "yanchor": "bottom"},
        "paper_bgcolor": "white",
        "plot_bgcolor": "white",
        **more,
    }
