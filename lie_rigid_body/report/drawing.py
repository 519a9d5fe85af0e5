"""Pictures in the formats of files, and the files of a verb with its answer."""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.console import require_suffix, say
from lie_rigid_body.errors import InputError
from lie_rigid_body.recording.output_file import require_room, write_file
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


@np.errstate(all="ignore")  # recorded numbers may be anything
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


def require_page(given: argparse.Namespace, inputs: Iterable[str | Path], *, with_figures: bool = False) -> None:
    """Refuse a page, if one is wanted, that is of another kind, is an input or could not be written after the work.

    Parameters
    ----------
    given : argparse.Namespace
    inputs : iterable of str or Path
    with_figures : bool, optional
        Whether plotly draws some of it, and has to be installed.

    Raises
    ------
    InputError, BagError
    """
    if given.report is not None:
        require_suffix("--report", given.report, ".html")
        if with_figures and not find_spec("plotly"):
            raise InputError("--report needs plotly: pip install 'lie-rigid-body[report]'")
        require_room(given.report, inputs, overwrite=given.force)


def answer(
    given: argparse.Namespace,
    text: Callable[[], str],
    content: Callable[[], object],
    files: Mapping[str | None, Callable[[], bytes]] | None = None,
) -> None:
    """Write the files of a verb, and print its answer on stdout.

    Parameters
    ----------
    given : argparse.Namespace
        Arguments: whether the answer is ``json``, and by ``force`` existing files are replaced.
    text : callable
        Gives the answer for people; lines that name the files follow it.
    content : callable
        Gives the answer for programs, for JSON; a number that is not finite becomes null.
    files : mapping of str or None to callable, optional
        What gives the content of each file, by its path; None where it is not wanted.
    """
    made = {path: make() for path, make in (files or {}).items() if path is not None}
    if given.json:
        finite = json.loads(json.dumps(content()), parse_constant=lambda name: None)
        lines = [json.dumps(finite, indent=2)]
    else:
        lines = [text(), *(f"wrote {printable(path)}" for path in made)]
    for path, data in made.items():
        write_file(path, data, overwrite=given.force)
    say("\n".join(lines), done=", ".join(f"{path} is written" for path in made))
