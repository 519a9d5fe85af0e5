"""Several estimates of one run: a table with a row each, their differences, a picture and a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from itertools import combinations
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.score import verdict, wrapped
from lie_rigid_body.evaluation.statistics import Difference, of_run
from lie_rigid_body.report import html_page
from lie_rigid_body.report.score_picture import curves
from lie_rigid_body.report.scores import as_json
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate
from lie_rigid_body.wording import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS: Final = ("estimate", "total", "heading", "inclination", "95 %", "converges", "lag", "NEES", "findings")
_WIDTHS: Final = "{:<28} {:>9} {:>9} {:>11} {:>9} {:>9} {:>9} {:>7}  {}"


class Scored(NamedTuple):
    """An estimate with its score."""

    read: RecordedEstimate
    score: Score

    @property
    def name(self) -> str:
        """The topic."""
        return self.read.track.topic


def differences(scored: Sequence[Scored]) -> Iterator[tuple[Scored, Scored, Difference]]:
    """Differences of the RMS of the total error, degrees, of every pair at the stamps that both have."""
    for first, second in combinations(scored, 2):
        _, of_first, of_second = np.intersect1d(
            first.score.stamps_ns, second.score.stamps_ns, assume_unique=False, return_indices=True
        )
        left, right = first.score.error.total[of_first], second.score.error.total[of_second]
        yield first, second, of_run(np.degrees(left), np.degrees(right))


def as_table(title: str, scored: Sequence[Scored]) -> str:
    """Lines for a terminal, without a final newline."""
    lines = [printable(title), "", _WIDTHS.format(*_COLUMNS), *(_WIDTHS.format(*_cells(each)) for each in scored), ""]
    for sentence in _sentences(scored):
        lines += wrapped(sentence)
    return "\n".join(lines)


def _cells(each: Scored) -> list[str]:
    score = each.score
    converged, lag = score.time_to_converge_s, score.lag_s
    return [
        printable(each.name),
        *(f"{angle.rms:.4g}°" for angle in (score.total_deg, score.heading_deg, score.inclination_deg)),
        f"{score.total_deg.p95:.4g}°",
        "never" if converged is None else f"{converged:.3g} s",
        "" if lag is None else f"{lag:+.2g} s",
        "" if score.consistency is None else f"{score.consistency.mean:.3g}",
        " ".join(finding.code for finding in score.findings),
    ]


def _sentences(scored: Sequence[Scored]) -> Iterator[str]:
    for first, second, difference in differences(scored):
        yield difference.sentence(first.name, second.name) + "."
    for each in scored:
        yield from (f"{each.name}: {sentence}" for sentence in verdict(each.score) if not each.score.passed)


def to_json(bag: str, scored: Sequence[Scored], *, series: bool) -> dict[str, object]:
    """JSON-serialisable data of all scores and of the differences of each pair."""
    return {
        "estimates": [as_json(bag, each.read, each.score, series=series) for each in scored],
        "differences": [
            {"first": first.name, "second": second.name, **_finite(difference)}
            for first, second, difference in differences(scored)
        ],
        "passed": all(each.score.passed for each in scored),
    }


def _finite(difference: Difference) -> dict[str, object]:
    """The difference in degrees; an interval that does not end is None."""
    content = difference.to_dict()
    bounds = {f"{name}_deg": content[name] if np.isfinite(content[name]) else None for name in ("value", "low", "high")}
    return {**bounds, "sentence": difference.sentence("the first", "the second")}


def draw(title: str, scored: Sequence[Scored], width: float = 10.0) -> Figure:
    """Figure of the total errors over time."""
    return curves(title, [(each.name, each.score) for each in scored], width)


def page(title: str, scored: Sequence[Scored]) -> bytes:
    """Make the page."""
    parts = [
        *(html_page.paragraph(sentence) for sentence in _sentences(scored)),
        html_page.picture(lambda width: draw("", scored, width)),
        *(
            html_page.listing(
                escape(each.name),
                (f"<code>{f.code}</code> {escape(f.message)}" for f in each.score.findings),
                "No findings.",
            )
            for each in scored
        ),
        "<h2>Errors</h2>",
        html_page.table(_COLUMNS, [(_cells(each), each.score.passed) for each in scored]),
        html_page.paragraph(
            "Errors as defined by BROAD (Data 6(7):72, 2021); RMS and 95 % of the total error, degrees."
        ),
    ]
    return html_page.document(title, parts, with_figures=False)
