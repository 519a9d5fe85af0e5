"""Colours of pictures, their formats as files, and the files of a verb with its answer."""

from __future__ import annotations

import argparse
import json
import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.command_line import require_suffix
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.system import console
from lie_rigid_body.system.output_file import require_other, require_room, write_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DISTINCT: Final = ("#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333")
"""Colours of curves, distinct in every kind of colour vision."""
ORANGE, BLUE, GREEN, PINK, _, _, BLACK = DISTINCT
COLOURS: Final = (ORANGE, GREEN, BLUE)
"""Colours of the x, y and z components."""
GREY, RED = "#555555", "#CC2222"
"""Colours of limits, and of paths and what is broken."""
SURFACE, FRAME = "#C9D6E8", "#8A97A8"
"""Colours of the ellipsoid, and of its principal circles and the axes of figures."""

_SUFFIXES: Final = {"report": ".html", "plot": ".png", "out": ".mcap"}


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


def require_outputs(
    given: argparse.Namespace,
    inputs: Iterable[str | Path],
    names: Iterable[str] = ("report",),
    *,
    with_figures: bool = False,
) -> None:
    """Refuse files before the work that are of another kind, inputs, one file, or could not be written after it.

    Parameters
    ----------
    given : argparse.Namespace
    inputs : iterable of str or Path
    names : iterable of str, optional
        Names of the options that name files.
    with_figures : bool, optional
        Whether plotly draws some of them, and has to be installed.

    Raises
    ------
    InputError, BagError
    """
    outputs = {name: path for name in names if (path := getattr(given, name)) is not None}
    for name, path in outputs.items():
        require_suffix(f"--{name}", path, _SUFFIXES[name])
    if outputs and with_figures and not find_spec("plotly"):
        raise InputError("--report needs plotly: pip install 'lie-rigid-body[report]'")
    paths, read = [*outputs.values()], [*inputs] if outputs else []
    for number, path in enumerate(paths):
        require_room(path, read, overwrite=given.force)
        require_other(path, paths[:number], "output")


def answer(
    given: argparse.Namespace,
    files: Mapping[str | None, Callable[[], bytes | None]],
    text: Callable[[], str] | None = None,
    content: Callable[[], object] | None = None,
    *,
    passed: bool = True,
) -> int:
    """Write the files of a verb, print its answer on stdout, and return its exit status.

    Parameters
    ----------
    given : argparse.Namespace
        Arguments: whether the answer is ``json``, and by ``force`` existing files are replaced.
    files : mapping of str or None to callable
        What gives the content of each file, by its path, or writes it itself; None where it is not wanted.
    text : callable, optional
        Gives the answer for people; lines that name the files follow it.
    content : callable, optional
        Gives the answer for programs, for JSON; a number that is not finite becomes null.
    passed : bool, optional
        Whether no law and no limit is broken, and no mistake is named.
    """
    os.environ["MPLBACKEND"] = "agg"  # no window is needed, and the one that Jupyter names may not be installed
    made = {path: make() for path, make in files.items() if path is not None}
    if content and given.json:
        lines = [json.dumps(json.loads(json.dumps(content()), parse_constant=lambda name: None), indent=2)]
    else:
        lines = [*([text()] if text else []), *(f"wrote {printable(name)}" for name in made)]
    for path, data in made.items():
        if data is not None:
            write_file(path, data, overwrite=given.force)
    console.say("\n".join(lines), done=", ".join(f"{name} is written" for name in made))
    return console.SUCCESS if passed else console.BROKEN
