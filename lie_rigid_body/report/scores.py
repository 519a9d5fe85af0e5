"""Scores of one estimate or of several: a table for people, JSON for programs, and a page that needs no network."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from itertools import chain, combinations
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.differences import Difference, of_run
from lie_rigid_body.evaluation.score import HEADINGS, angles, facts, findings, numbers, table, verdict, wrapped
from lie_rigid_body.report import html_page
from lie_rigid_body.report.score_picture import curves, draw
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate
from lie_rigid_body.wording import printable

Scored: TypeAlias = Sequence[tuple[RecordedEstimate, Score]]
"""Estimates with their scores."""

_COLUMNS: Final = ("estimate", "total", "heading", "inclination", "95 %", "converges", "lag", "NEES", "findings")
_WIDTHS: Final = "{:<28} {:>9} {:>9} {:>11} {:>9} {:>9} {:>9} {:>7}  {}"
_SOURCE: Final = "Errors as defined by BROAD (Data 6(7):72, 2021)"


def as_table(title: str, read: RecordedEstimate, score: Score) -> str:
    """Lines of a score for a terminal, without a final newline."""
    notes = chain.from_iterable(wrapped(note, "note: ") for note in read.notes)
    head = [printable(title), *wrapped(extent(read, score)), "", *table(score), "", *notes]
    return "\n".join([*head, *findings(score), *_lines(verdict(score))])


def table_of_several(title: str, scored: Scored) -> str:
    """Lines of several scores for a terminal, without a final newline."""
    rows = [_WIDTHS.format(*cells) for cells in (_COLUMNS, *(_cells(*each) for each in scored))]
    return "\n".join([printable(title), "", *rows, "", *_lines(_sentences(scored))])


def _lines(sentences: Iterable[str]) -> Iterator[str]:
    return chain.from_iterable(map(wrapped, sentences))


def _cells(read: RecordedEstimate, score: Score) -> list[str]:
    """Cells of a score under `_COLUMNS`."""
    converged, lag = score.time_to_converge_s, score.lag_s
    return [
        printable(read.track.topic),
        *(f"{angle.rms:.4g}°" for angle in (score.total_deg, score.heading_deg, score.inclination_deg)),
        f"{score.total_deg.p95:.4g}°",
        "never" if converged is None else f"{converged:.3g} s",
        "" if lag is None else f"{lag:+.2g} s",
        "" if score.consistency is None else f"{score.consistency.mean:.3g}",
        " ".join(finding.code for finding in score.findings),
    ]


def _sentences(scored: Scored) -> Iterator[str]:
    """What is said of several scores: the difference of each pair, and the limits that are broken."""
    yield from (f"{difference.sentence(*names)}." for names, difference in differences(scored))
    for read, score in scored:
        yield from (f"{read.track.topic}: {sentence}" for sentence in verdict(score) if not score.passed)


def differences(scored: Scored) -> Iterator[tuple[tuple[str, str], Difference]]:
    """Differences of the RMS of the total error, degrees, of every pair at the stamps that both have, by the topics."""
    for (first, left), (second, right) in combinations(scored, 2):
        _, of_left, of_right = np.intersect1d(left.stamps_ns, right.stamps_ns, return_indices=True)
        errors = np.degrees(left.error.total[of_left]), np.degrees(right.error.total[of_right])
        yield (first.track.topic, second.track.topic), of_run(*errors)


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


def json_of_several(bag: str, scored: Scored, *, series: bool) -> dict[str, object]:
    """Data of several scores and of the differences of each pair, for JSON; an interval may be infinite."""
    return {
        "estimates": [as_json(bag, *each, series=series) for each in scored],
        "differences": [
            {
                "first": first,
                "second": second,
                "value_deg": difference.value,
                "low_deg": difference.low,
                "high_deg": difference.high,
                "sentence": difference.sentence("the first", "the second"),
            }
            for (first, second), difference in differences(scored)
        ],
        "passed": all(score.passed for _, score in scored),
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
    """Make the page of a score.

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
        _findings("Findings", score, "None."),
        html_page.listing("Notes", map(escape, read.notes if read else ())),
        "<h2>Errors</h2>",
        *tables(score),
        html_page.paragraph(f"{extent(read, score)}."),
        *map(html_page.scenario, read.motion.segments if read else ()),
        html_page.paragraph(f"{_SOURCE}."),
    ]
    return html_page.document(title, parts)


def page_of_several(title: str, scored: Scored) -> bytes:
    """Make the page of several scores."""
    parts = [
        *map(html_page.paragraph, _sentences(scored)),
        html_page.picture(lambda width: curves("", scored, width)),
        *(_findings(escape(read.track.topic), score, "No findings.") for read, score in scored),
        "<h2>Errors</h2>",
        html_page.table(_COLUMNS, [(_cells(*each), each[1].passed) for each in scored]),
        html_page.paragraph(f"{_SOURCE}; RMS and 95 % of the total error, degrees."),
    ]
    return html_page.document(title, parts)


def _findings(heading: str, score: Score, none: str) -> str:
    return html_page.listing(heading, (f"<code>{f.code}</code> {escape(f.message)}" for f in score.findings), none)
