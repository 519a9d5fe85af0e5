"""Many certificates as one HTML page: a table of the bags or runs, and how often each size of residual occurs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.cli import residual_figures
from lie_rigid_body.report import html_page

MOST_LINES: Final = 500
"""Lines of the table; of more the worst are shown."""


@dataclass(frozen=True)
class Line:
    """One of many bags.

    Parameters
    ----------
    cells : tuple of str
        What it is.
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

    @classmethod
    def of(cls, bag: str, certificate: Certificate) -> Line:
        """The line of a bag."""
        return cls((bag,), certificate.passed, certificate.attitude_accuracy, certificate.residuals)

    @property
    def _rank(self) -> tuple[bool, float]:
        """Smaller for what is worse."""
        return self.certified, -math.inf if math.isnan(self.accuracy) else -self.accuracy


def certificates_page(
    title: str,
    certificates: Sequence[tuple[str, Certificate]],
    unusable: Sequence[str] = (),
    uncovered: Sequence[str] = (),
) -> bytes:
    """The page of several bags.

    Parameters
    ----------
    title : str
    certificates : sequence of (str, Certificate)
        Each with the name of its bag.
    unusable : sequence of str, optional
        Why other bags could not be judged.
    uncovered : sequence of str, optional
        What no law speaks of in some of them.

    Returns
    -------
    bytes
        HTML.
    """
    more = [
        html_page.listing("Not certified, besides what is not of any bag", map(escape, uncovered)),
        html_page.listing("Not judged", map(escape, unusable)),
    ]
    return page(title, "bags", ("bag",), [Line.of(*named) for named in certificates], more, len(unusable))


def page(
    title: str, what: str, headings: Sequence[str], lines: Sequence[Line], more: Sequence[str] = (), unusable: int = 0
) -> bytes:
    """The page of lines.

    Parameters
    ----------
    title : str
    what : str
        What each line is, in the plural.
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
    worst = max(line.accuracy for line in lines)
    parts = [
        html_page.badge(f"{certified} of {count} {what} CERTIFIED", passed=certified == count),
        html_page.paragraph(f"Attitudes are within {worst:.2g} rad of the exact motion."),
        *_distributions(what, lines),
        *_table(what, headings, lines),
        *more,
    ]
    return html_page.document(title, parts, with_figures=True)


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
        shown = {id(line) for line in sorted(lines, key=lambda line: line._rank)[:MOST_LINES]}
        yield html_page.paragraph(f"Of {len(lines)} {what} these {MOST_LINES} are the worst.")
        lines = [line for line in lines if id(line) in shown]
    rows = [
        ((*line.cells, f"{line.accuracy:.2g}", "certified" if line.certified else "NOT CERTIFIED"), line.certified)
        for line in lines
    ]
    yield html_page.table((*headings, "attitude, rad", ""), rows)
