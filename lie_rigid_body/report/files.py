"""Files of a score in arrays: its picture and its page."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body.command_line import require_suffix
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import program, shown
from lie_rigid_body.system.output_file import write_file

if TYPE_CHECKING:
    from lie_rigid_body.evaluation import Score

TITLE: Final = "attitude estimate"
"""Title of a picture or a page that is given none."""
_INSTEAD: Final = {
    "Run": "give run.score(attitude_xyzw)",
    "Certificate": f"{program('check')} BAG --report OUT.html writes its page",
    "FilterDiagnosis": f"{program('diagnose')} ESTIMATOR --report OUT.html writes its page",
}
"""Remedies where another result is given for a score, by its class."""


def _write(
    score: object, path: str | Path, suffix: str, title: object, content: Callable[[], bytes], *, overwrite: bool
) -> None:
    """Write what shows a score, unless it is none, the title no text, or the name of the file ends otherwise."""
    from lie_rigid_body.evaluation import Score

    if not isinstance(title, str):
        raise InputError(f"title {shown(title)} is no text: give one, or leave it out")
    if not isinstance(score, Score):
        kind = type(score).__name__
        raise InputError(f"a {kind} is no score: {_INSTEAD.get(kind, 'give what evaluate() or run.score() returns')}")
    require_suffix("path", str(path), suffix)
    write_file(path, content(), overwrite=overwrite)


def write_plot(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Draw the errors over time, with the limits and the Cramér–Rao bound, as a PNG.

    Parameters
    ----------
    score : Score
    path : str or Path
        Its name ends in ``.png``.
    title : str, optional
    overwrite : bool, optional
        Whether an existing file is replaced.

    Raises
    ------
    InputError, BagError
        If it is no score, the title no text, the name ends otherwise, or the file exists or cannot be written.
    """
    from lie_rigid_body.report import drawing, scores

    picture = partial(scores.draw, title, score)
    _write(score, path, ".png", title, partial(drawing.png, picture), overwrite=overwrite)


def write_report(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Write score, findings and picture as one HTML page, which needs no network.

    Parameters and errors are those of `write_plot`, but the name of the file ends in ``.html``.
    """
    from lie_rigid_body.report import scores
    from lie_rigid_body.report.answer import as_page

    _write(score, path, ".html", title, lambda: as_page(title, scores.parts(None, score)), overwrite=overwrite)
