"""A figure of Matplotlib that notebooks show wherever it was made; this module loads Matplotlib."""

from __future__ import annotations

from matplotlib.figure import Figure

from lie_rigid_body.report.drawing import png


class Picture(Figure):
    """Figure that no window and no backend of a notebook knows of: it shows itself."""

    def _repr_png_(self) -> bytes:
        return png(self)
