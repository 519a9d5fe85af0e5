"""A score as one HTML page, which needs no other file and no network."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.score import HEADINGS, angles, facts, numbers, verdict
from lie_rigid_body.report import html_page, score_text
from lie_rigid_body.report.drawing import svg
from lie_rigid_body.report.score_picture import draw
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate


def page(title: str, read: RecordedEstimate | None, score: Score) -> bytes:
    """Make the page.

    Parameters
    ----------
    title : str
    read : RecordedEstimate or None
        None of an estimate in arrays.
    score : Score

    Returns
    -------
    bytes
        HTML.
    """
    parts = [
        *(html_page.badge(sentence, passed=score.passed) for sentence in verdict(score)),
        html_page.paragraph(f"{score_text.extent(read, score)}."),
        *_table(score),
        html_page.listing("Findings", (f"<code>{f.code}</code> {escape(f.message)}" for f in score.findings), "None."),
        html_page.listing("Notes", map(escape, read.notes if read else ())),
        f"<h2>Errors over time</h2><figure>{svg(draw(title, score))}</figure>",
        *map(html_page.scenario, read.segments if read else ()),
        html_page.paragraph("Errors as defined by BROAD (Data 6(7):72, 2021)."),
    ]
    return html_page.document(title, parts, with_figures=False)


def _table(score: Score) -> Iterator[str]:
    rows = [((name, *numbers(statistics)), True) for name, statistics in angles(score)]
    yield html_page.table(("error, deg", *HEADINGS), rows)
    yield html_page.table(("", ""), [((name, value), True) for name, value in facts(score)])
