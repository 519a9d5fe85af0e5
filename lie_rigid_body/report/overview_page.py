"""Many certificates as one HTML page: a table of the bags or runs, and how often each size of residual occurs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from lie_rigid_body.report import html_page, residual_figures
from lie_rigid_body.report.certificate_text import of_limit
from lie_rigid_body.report.overview import Verdict, kind_of, uncovered

MOST_LINES: Final = 500
"""Largest number of lines of the table; of more the worst are shown."""
MOST_MESSAGES: Final = 100
"""Largest number of broken laws that are told in words."""


@dataclass(frozen=True)
class Line:
    """One of many bags, or of the runs of a campaign.

    Parameters
    ----------
    cells : tuple of str
        What it is: its name or number first.
    certified : bool
    accuracy : float
        Bound of the error of its attitudes, rad.
    residuals : mapping of str to (float, float)
        `Certificate.residuals`.
    """

    cells: tuple[str, ...]
    certified: bool
    accuracy: float
    residuals: Mapping[str, Sequence[float]]

    @property
    def worst(self) -> tuple[str, str]:
        """Law that came nearest to its limit, or went farthest beyond, and its residual as a share of the limit."""
        if not self.residuals:
            return "", ""
        name, (worst, limit) = max(self.residuals.items(), key=lambda item: _share(*item[1]))
        return name, of_limit(worst, limit)

    @property
    def rank(self) -> tuple[bool, float]:
        """Key of order, smaller for what is worse."""
        return self.certified, -math.inf if math.isnan(self.accuracy) else -self.accuracy

    @property
    def row(self) -> tuple[tuple[str, ...], bool]:
        """Cells of the table, and whether it is certified: only then its attitudes are worth a bound."""
        accuracy, verdict = (f"{self.accuracy:.2g}", "certified") if self.certified else ("", "NOT CERTIFIED")
        name, *others = self.cells  # the verdict beside it: a wide table is cut off at the right
        return (name, verdict, *others, *self.worst, accuracy), self.certified


def _share(worst: float, limit: float) -> tuple[bool, float]:
    """Key of order, larger for what goes farther beyond its limit; NaN does by any."""
    return not worst <= limit, 0.0 if worst == 0.0 else math.inf if limit == 0.0 or math.isnan(worst) else worst / limit


def verdicts_page(title: str, verdicts: Sequence[Verdict]) -> bytes:
    """Make the page of several bags, or of several bodies, of which at least one has a certificate.

    Parameters
    ----------
    title : str
    verdicts : sequence of Verdict

    Returns
    -------
    bytes
        HTML.
    """
    judged = [(verdict.name, verdict.certificate) for verdict in verdicts if verdict.certificate is not None]
    unusable = [verdict.reason for verdict in verdicts if verdict.certificate is None]
    broken = [f"{name}: {message}" for name, certificate in judged for message in certificate.messages]
    if len(broken) > MOST_MESSAGES:
        broken[MOST_MESSAGES:] = [f"and {len(broken) - MOST_MESSAGES} more"]
    more = [
        html_page.listing("Broken laws", map(escape, broken)),
        html_page.listing("Not certified, besides what is not of any bag", map(escape, uncovered(verdicts))),
        html_page.listing("Not judged", map(escape, unusable)),
    ]
    lines = [Line((name,), each.passed, each.attitude_accuracy, each.residuals) for name, each in judged]
    return page(title, kind_of(verdicts), ("bag",), lines, more, len(unusable))


def page(
    title: str, what: str, headings: Sequence[str], lines: Sequence[Line], more: Sequence[str] = (), unusable: int = 0
) -> bytes:
    """Make the page of lines.

    Parameters
    ----------
    title : str
    what : str
        Noun in the plural for what the lines are.
    headings : sequence of str
        Of their own cells.
    lines : sequence of Line
        At least one.
    more : sequence of str, optional
        HTML at the end.
    unusable : int, optional
        How many others could not be judged.

    Returns
    -------
    bytes
        HTML.
    """
    count = len(lines) + unusable
    certified = sum(line.certified for line in lines)
    parts = [
        html_page.badge(f"{certified} of {count} {what} CERTIFIED", passed=certified == count),
        *_accuracy(what, lines, everything=certified == count),
        *_distributions(what, lines),
        *_table(what, headings, lines),
        *more,
    ]
    return html_page.document(title, parts, with_figures=True)


def _accuracy(what: str, lines: Sequence[Line], *, everything: bool) -> Iterator[str]:
    """Paragraph on the accuracy of those that are certified."""
    accuracies = [line.accuracy for line in lines if line.certified]
    if accuracies:
        whose = "Attitudes" if everything else f"The attitudes of the {what} that are certified"
        yield html_page.paragraph(f"{whose} are within {max(accuracies):.2g} rad of the exact motion.")


def _distributions(what: str, lines: Sequence[Line]) -> Iterator[str]:
    names = dict.fromkeys(name for line in lines for name in line.residuals)
    laws = [(name, [line.residuals[name] for line in lines if name in line.residuals]) for name in names]
    if panels := list(residual_figures.distributions(laws, what)):
        yield "<h2>Residuals</h2>"
        yield html_page.paragraph(f"How many {what} have a worst residual of each size, beside the limits.")
        yield html_page.grid(panels)


def _table(what: str, headings: Sequence[str], lines: Sequence[Line]) -> Iterator[str]:
    yield f"<h2>{what.capitalize()}</h2>"
    if len(lines) > MOST_LINES:
        shown = {id(line) for line in sorted(lines, key=lambda line: line.rank)[:MOST_LINES]}
        yield html_page.paragraph(f"Of {len(lines)} {what} these {MOST_LINES} are the worst.")
        lines = [line for line in lines if id(line) in shown]
    yield html_page.table(
        (*headings[:1], "", *headings[1:], "worst law", "of limit", "attitude, rad"), [line.row for line in lines]
    )
