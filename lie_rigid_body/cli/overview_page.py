"""Many certificates as one HTML page: a table of the bags or runs, and how often each size of residual occurs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.cli import certificate_text, residual_figures
from lie_rigid_body.report import html_page

MOST_LINES: Final = 500
"""Lines of the table; of more the worst are shown."""
MOST_MESSAGES: Final = 100
"""Broken laws that are told in words."""


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
    def worst(self) -> tuple[str, str]:
        """The law that came nearest to its limit, or went farthest beyond, and its share of that."""
        if not self.residuals:
            return "", ""
        name, (worst, limit) = max(self.residuals.items(), key=lambda item: _share(*item[1]))
        return name, certificate_text.of_limit(worst, limit)

    @property
    def _rank(self) -> tuple[bool, float]:
        """Smaller for what is worse."""
        return self.certified, -math.inf if math.isnan(self.accuracy) else -self.accuracy


def _share(worst: float, limit: float) -> tuple[bool, float]:
    """A key that is larger for what goes farther beyond its limit; NaN does by any."""
    return not worst <= limit, 0.0 if worst == 0.0 else math.inf if limit == 0.0 or math.isnan(worst) else worst / limit


def certificates_page(
    title: str,
    certificates: Sequence[tuple[str, Certificate]],
    unusable: Sequence[str] = (),
    uncovered: Sequence[str] = (),
    what: str = "bags",
) -> bytes:
    """The page of several bags, or of several bodies.

    Parameters
    ----------
    title : str
    certificates : sequence of (str, Certificate)
        Each with the name of its bag.
    unusable : sequence of str, optional
        Why other bags could not be judged.
    uncovered : sequence of str, optional
        What no law speaks of in some of them.
    what : str, optional
        What each certificate is of, in the plural.

    Returns
    -------
    bytes
        HTML.
    """
    broken = [f"{name}: {message}" for name, certificate in certificates for message in certificate.messages]
    if len(broken) > MOST_MESSAGES:
        broken[MOST_MESSAGES:] = [f"and {len(broken) - MOST_MESSAGES} more"]
    more = [
        html_page.listing("Broken laws", map(escape, broken)),
        html_page.listing("Not certified, besides what is not of any bag", map(escape, uncovered)),
        html_page.listing("Not judged", map(escape, unusable)),
    ]
    return page(title, what, ("bag",), [Line.of(*named) for named in certificates], more, len(unusable))


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
    parts = [
        html_page.badge(f"{certified} of {count} {what} CERTIFIED", passed=certified == count),
        *_accuracy(what, lines, everything=certified == count),
        *_distributions(what, lines),
        *_table(what, headings, lines),
        *more,
    ]
    return html_page.document(title, parts, with_figures=True)


def _accuracy(what: str, lines: Sequence[Line], *, everything: bool) -> Iterator[str]:
    """To what accuracy those are certified that are."""
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
        shown = {id(line) for line in sorted(lines, key=lambda line: line._rank)[:MOST_LINES]}
        yield html_page.paragraph(f"Of {len(lines)} {what} these {MOST_LINES} are the worst.")
        lines = [line for line in lines if id(line) in shown]
    yield html_page.table(
        (*headings[:1], "", *headings[1:], "worst law", "of limit", "attitude, rad"), map(_row, lines)
    )


def _row(line: Line) -> tuple[tuple[str, ...], bool]:
    """The cells of a line, and whether it is certified: only then its attitudes are worth a bound."""
    accuracy, verdict = (f"{line.accuracy:.2g}", "certified") if line.certified else ("", "NOT CERTIFIED")
    name, *others = line.cells  # the verdict beside it: a wide table is cut off at the right
    return (name, verdict, *others, *line.worst, accuracy), line.certified
