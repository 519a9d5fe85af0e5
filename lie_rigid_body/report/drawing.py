"""Pictures in the formats of files, and the files of a verb with its answer."""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lie_rigid_body import console
from lie_rigid_body.command_line import require_suffix
from lie_rigid_body.errors import InputError
from lie_rigid_body.recording.output_file import require_room, write_file
from lie_rigid_body.wording import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@np.errstate(all="ignore")  # recorded numbers may be anything
def png(figure: Figure) -> bytes:
    """PNG of a figure of Matplotlib."""
    return _saved(figure, format="png")


def svg(figure: Figure) -> str:
    """SVG element of a figure of Matplotlib: the same bytes for the same figure, and text that a browser can search."""
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "lie_rigid_body", "svg.fonttype": "none"}):
        text = _saved(figure, format="svg", metadata={"Date": None}).decode()
    return text[text.index("<svg") :]


def _saved(figure: Figure, **how: Any) -> bytes:
    """File of a figure, without a warning of characters that the font lacks, such as Chinese ones of a name."""
    out = BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        figure.savefig(out, **how)
    return out.getvalue()


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
    files: Mapping[str | None, Callable[[], bytes]],
    text: Callable[[], str] | None = None,
    content: Callable[[], object] | None = None,
    written: Iterable[str] = (),
) -> None:
    """Write the files of a verb, and print its answer on stdout.

    Parameters
    ----------
    given : argparse.Namespace
        Arguments: whether the answer is ``json``, and by ``force`` existing files are replaced.
    files : mapping of str or None to callable
        What gives the content of each file, by its path; None where it is not wanted.
    text : callable, optional
        Gives the answer for people; lines that name the files follow it.
    content : callable, optional
        Gives the answer for programs, for JSON; a number that is not finite becomes null.
    written : iterable of str, optional
        Files that are written already.
    """
    made = {path: make() for path, make in files.items() if path is not None}
    names = [*written, *made]
    if content and given.json:
        lines = [json.dumps(json.loads(json.dumps(content()), parse_constant=lambda name: None), indent=2)]
    else:
        lines = [*([text()] if text else []), *(f"wrote {printable(name)}" for name in names)]
    for path, data in made.items():
        write_file(path, data, overwrite=given.force)
    console.say("\n".join(lines), done=", ".join(f"{name} is written" for name in names))
