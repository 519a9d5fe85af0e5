"""Colours and axes of pictures, and their formats as files."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.foundation.wording import printable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DISTINCT: Final = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333")
"""Colours of curves, distinct in every kind of colour vision."""
ORANGE, BLUE, GREEN, PINK, _, _, BLACK = DISTINCT
COLOURS: Final = (ORANGE, GREEN, BLUE)
"""Colours of the x, y and z components."""
GREY = "#555555"
RED = "#CC2222"
"""Colours of limits, and of paths and what is broken."""
SURFACE = "#C9D6E8"
FRAME = "#8A97A8"
"""Colours of the ellipsoid, and of its principal circles and the axes of figures."""


def of_axes(draw: Callable[[Axes], None]) -> Figure:
    """Figure of one pair of axes into which a function draws: half a page wide."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.subplots()
    draw(axes)
    finish(axes, 2)
    return figure


def finish(axes: Axes, columns: int) -> None:
    """Give axes a grid, and a legend above them, where it hides nothing."""
    axes.grid(alpha=0.3, lw=0.6)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.1)


def label(text: str) -> str:
    """Text from outside as a label of a curve: no formula, and nothing that a legend leaves out."""
    plain = printable(text).replace("$", r"\$")
    return f" {plain}" if plain.startswith("_") else plain


def png(draw: Callable[[], Figure]) -> bytes:
    """PNG of the figure that a function draws with Matplotlib."""
    return _saved(draw, format="png")


def svg(draw: Callable[[], Figure]) -> str:
    """SVG element of the figure that a function draws with Matplotlib: of equal figures the same bytes.

    A browser can search its text.
    """
    text = _saved(draw, format="svg", metadata={"Date": None}).decode()
    return text[text.index("<svg") :]


def _saved(draw: Callable[[], Figure], **how: Any) -> bytes:
    """File of a figure in Matplotlib's own style, whatever a ``matplotlibrc`` of some folder says.

    There is no warning of characters that the font lacks, such as Chinese ones of a name.
    """
    import matplotlib

    out = BytesIO()
    # recorded numbers may be anything
    with np.errstate(all="ignore"), matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        matplotlib.rcdefaults()
        matplotlib.rcParams.update({"svg.hashsalt": "lie_rigid_body", "svg.fonttype": "none"})
        draw().savefig(out, **how)
    return out.getvalue()
