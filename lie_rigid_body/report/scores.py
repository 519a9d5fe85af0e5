"""Scores: a table for people, JSON for programs, and a page that needs no other file and no network."""

from __future__ import annotations

from html import escape

from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.score import HEADINGS, angles, facts, findings, numbers, table, verdict, wrapped
from lie_rigid_body.report import html_page
from lie_rigid_body.report.score_picture import draw
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate
from lie_rigid_body.wording import printable


def as_table(title: str, read: RecordedEstimate, score: Score) -> str:
    """Lines of a score for a terminal, without a final newline."""
    lines = [printable(title), *wrapped(extent(read, score)), ""]
    lines += [*table(score), ""]
    for note in read.notes:
        lines += wrapped(note, "note: ")
    lines += findings(score)
    lines += [line for sentence in verdict(score) for line in wrapped(sentence)]
    return "\n".join(lines)


def as_json(bag: str | None, read: RecordedEstimate, score: Score, *, series: bool) -> dict[str, object]:
    """JSON-serialisable data of a score, with its source."""
    return {
        "bag": bag,
        "topic": read.track.topic,
        "type": read.track.message_type,
        "truth": read.motion.source,
        **score.to_dict(series=series),
        "notes": list(read.notes),
    }


def extent(read: RecordedEstimate | None, score: Score) -> str:
    """Sentence that says what was compared with what; without an estimate that was read for one in arrays."""
    kind = "attitudes" if read is None else read.track.message_type.replace("/msg/", "/")
    source = "" if read is None else f" ({read.motion.source})"
    first, last = (int(score.stamps_ns[i]) / 1e9 for i in (0, -1))  # times of day to milliseconds
    left_out = f"; {score.outside} more are outside of the truth's times" if score.outside else ""
    return (
        f"{score.samples} of {kind}, stamped {first:.13g} s to {last:.13g} s, against the truth{source} at "
        f"these stamps{left_out}"
    )


def summary(score: Score) -> str:
    """Sentence that tells the size of the error."""
    heading, inclination = (f"{angle.rms:.3g}°" for angle in (score.heading_deg, score.inclination_deg))
    best = "" if score.best is None or score.best.filtered is None else score.best.filtered.rms
    least = f"; the noise of the sensors leaves {best:.3g}° to the best filter" if best else ""
    return f"The attitude error is {score.total_deg.rms:.3g}° rms: heading {heading}, inclination {inclination}{least}."


def tables(score: Score) -> list[str]:
    """Statistics of the errors, and what else the score tells, as tables of HTML."""
    rows = [((name, *numbers(found)), True) for name, found in angles(score)]
    return [
        html_page.table(("error, deg", *HEADINGS), rows),
        html_page.table(("", ""), [((name, value), True) for name, value in facts(score)]),
    ]


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
        html_page.paragraph(summary(score)),
        html_page.picture(lambda width: draw("", score, width)),
        html_page.listing("Findings", (f"<code>{f.code}</code> {escape(f.message)}" for f in score.findings), "None."),
        html_page.listing("Notes", map(escape, read.notes if read else ())),
        "<h2>Errors</h2>",
        *tables(score),
        html_page.paragraph(f"{extent(read, score)}."),
        *map(html_page.scenario, read.motion.segments if read else ()),
        html_page.paragraph("Errors as defined by BROAD (Data 6(7):72, 2021)."),
    ]
    return html_page.document(title, parts, with_figures=False)
