"""Pictures in the formats of files, and the files of a verb with its answer."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from io import BytesIO, StringIO
from typing import TYPE_CHECKING

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.console import say
from lie_rigid_body.wording import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_LARGEST = 1e300
"""Largest number that is drawn: the length of an axis is a number as well."""
_NO_GLYPH = "Glyph .* missing from"
"""Warning of characters that the font lacks, such as Chinese ones of a name."""


def drawable(values: Array) -> Array:
    """Numbers that an axis can have, NaN in place of those that are too large."""
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(values) < _LARGEST, values, np.nan)


def png(figure: Figure) -> bytes:
    """PNG of a figure of Matplotlib."""
    out = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", _NO_GLYPH, UserWarning)
        figure.savefig(out, format="png")
    return out.getvalue()


def svg(figure: Figure) -> str:
    """SVG element of a figure of Matplotlib: the same bytes for the same figure, and text that a browser can search."""
    import matplotlib

    out = StringIO()
    with warnings.catch_warnings(), matplotlib.rc_context({"svg.hashsalt": "lie_rigid_body", "svg.fonttype": "none"}):
        warnings.filterwarnings("ignore", _NO_GLYPH, UserWarning)
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :]


def answer(text: str, files: Mapping[str, bytes], *, overwrite: bool, named: bool = True) -> None:
    """Write the files of a verb, and print its answer on stdout.

    Parameters
    ----------
    text : str
    files : mapping of str to bytes
        Contents by path.
    overwrite : bool
        Whether existing files are replaced.
    named : bool, optional
        Whether lines that name the files follow the text.
    """
    from lie_rigid_body.recording.output_file import write_file

    for path, content in files.items():
        write_file(path, content, overwrite=overwrite)
    lines = [text, *(f"wrote {printable(path)}" for path in files if named)]
    say("\n".join(lines), done=", ".join(f"{path} is written" for path in files))
