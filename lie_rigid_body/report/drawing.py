"""Colours of pictures, and their formats as files."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
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
