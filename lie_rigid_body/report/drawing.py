"""Colours and axes of pictures, and their formats as files."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import GAP_PERIODS
from lie_rigid_body.foundation.arrays import Array
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

_FEW_SAMPLES: Final = 3
"""Largest number of samples that a line alone would hardly show."""
_MANY_SAMPLES: Final = 20_000
"""Number of samples above which the curves of a fast motion fill whole areas."""
_MAX_DRAWN: Final = 1e300
"""Largest magnitude that is drawn: the length of an axis, a difference of two numbers, must be finite as well."""
_JOINED_PX: Final = 0.5
"""Distance, pixels, up to which points of a curve are joined: millions of samples keep their peaks in a small file."""


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


def draw_curve(
    axes: Axes, t_s: Array, values: Array, colour: str, label: str | None, width: float = 1.1, **look: Any
) -> None:
    """Draw a curve over rising times: a few samples as dots, very many thin, and no line across a gap between them."""
    steps = np.diff(t_s, append=t_s[-1:])
    behind = np.flatnonzero(steps > GAP_PERIODS * np.median(steps)) + 1
    drawable = np.where(np.abs(values) < _MAX_DRAWN, values, np.nan)
    style: dict[str, Any] = {"lw": width}
    if len(t_s) > _MANY_SAMPLES:
        style = {"lw": 0.5 * width, "alpha": 0.6}  # so that no curve hides the others
    elif len(t_s) <= _FEW_SAMPLES:
        style |= {"marker": "o", "ms": 4.0}
    points = (np.insert(each, behind, np.nan) for each in (t_s, drawable))
    axes.plot(*points, color=colour, label=label, **style | look)


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
        matplotlib.rcParams["path.simplify_threshold"] = _JOINED_PX
        draw().savefig(out, **how)
    return out.getvalue()
