"""Picture and page of a score from Python: those that ``evaluate --plot`` and ``--report`` write."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from lie_rigid_body.console import require_suffix

if TYPE_CHECKING:
    from lie_rigid_body.evaluation import Score

TITLE = "attitude estimate"


def write_plot(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Draw the errors over time, with the limits and the best that the noise allows, as a PNG.

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
        If the name ends otherwise, or the file exists or cannot be written.
    """
    from lie_rigid_body.recording.output_file import write_file
    from lie_rigid_body.report.score_picture import png

    require_suffix("path", str(path), ".png")
    write_file(path, png(title, score), overwrite=overwrite)


def write_report(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Write score, findings and picture as one HTML page, which needs no network.

    Parameters and errors are those of `write_plot`, but the name of the file ends in ``.html``.
    """
    from lie_rigid_body.recording.output_file import write_file
    from lie_rigid_body.report.score_page import page

    require_suffix("path", str(path), ".html")
    write_file(path, page(title, None, score), overwrite=overwrite)
