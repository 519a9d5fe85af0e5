"""Verdicts on many bags or runs: a table for people, JSON for programs, and a page of residuals."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, printable
from lie_rigid_body.report import certificates, figures, html_page
from lie_rigid_body.report.html_page import escaped
from lie_rigid_body.system import console

_VERDICTS: Final = {console.SUCCESS: "certified", console.BROKEN: "BROKEN", console.UNUSABLE: "unusable"}
_COLUMNS: Final = "{:<9} {:>9} {:>8} {:<34} {:>7}  {}"
_MOST_TOLD: Final = 10
"""Number of broken bags of which the table is followed by what is broken, and of things that are not certified."""
MOST_LINES: Final = 500
"""Largest number of lines of the table; of more the worst are shown."""
MOST_MESSAGES: Final = 100
"""Largest number of broken laws that are told in words."""


@short_dataclass(frozen=True)
class Verdict:
    """Certificate of one body of a bag, or the reason why there is none.

    Parameters
    ----------
    bag : str
        As the user gave it.
    body : str or None
        Its namespace, where the bag has several bodies.
    certificate : Certificate or None
    reason : str
        Why it cannot be judged, in one line that begins with the bag.
    """

    bag: str
    body: str | None
    certificate: Certificate | None
    reason: str = ""

    @property
    def name(self) -> str:
        """Name of the bag, and of the body where there are several."""
        return self.bag if self.body is None else f"{self.bag} {self.body}"

    @property
    def status(self) -> int:
        """Exit status that the body alone would have."""
        if self.certificate is None:
            return console.UNUSABLE
        return console.SUCCESS if self.certificate.passed else console.BROKEN


def as_table(verdicts: Sequence[Verdict]) -> str:
    """Lines for a terminal: a row for each verdict, how many there are of each, what is broken or left out."""
    head = _COLUMNS.format("verdict", "samples", "rad", "worst law", "of limit", "bag")
    left_out = [certificates.wrapped(line, "  - ") for line in uncovered(verdicts)]
    remark = ["Not certified, besides what is not of any bag:"] if left_out else []
    return "\n".join([head, *map(_row, verdicts), "", _summary(verdicts), *_faults(verdicts), *remark, *left_out])


def as_json(verdicts: Sequence[Verdict]) -> dict[str, object]:
    """Data for JSON: numbers of the verdicts, and for each bag or body what it has alone."""
    counts = Counter(verdict.status for verdict in verdicts)
    return {
        "passed": all(verdict.status == console.SUCCESS for verdict in verdicts),
        **{name.lower(): counts[status] for status, name in _VERDICTS.items()},
        "bags": [
            {"bag": verdict.bag, "body": verdict.body, "passed": None, "error": verdict.reason}
            if verdict.certificate is None
            else certificates.as_json(verdict.bag, verdict.certificate) | {"body": verdict.body}
            for verdict in verdicts
        ],
    }


def _row(verdict: Verdict) -> str:
    certificate, cells = verdict.certificate, ("", "", "", "")
    if certificate is not None:
        samples, worst = sum(segment.samples for segment in certificate.segments), _worst_law(certificate)
        accuracy = f"{certificate.attitude_accuracy:.2g}" if certificate.passed else ""
        cells = str(samples), accuracy, worst.name, certificates.of_limit(worst.worst, worst.limit)
    return _COLUMNS.format(_VERDICTS[verdict.status], *cells, printable(verdict.name)).rstrip()


def _worst_law(certificate: Certificate) -> LawResult:
    """Law that came nearest to its limit, or went farthest beyond."""
    return max(certificate.laws, key=lambda law: (not law.holds, law.share))


def _summary(verdicts: Sequence[Verdict]) -> str:
    number = counted(len(verdicts), "bag") if kind_of(verdicts) == "bags" else f"{len(verdicts)} bodies"
    right = [
        verdict.certificate.attitude_accuracy for verdict in verdicts if verdict.certificate and not verdict.status
    ]
    if len(right) == len(verdicts):
        return (
            f"CERTIFIED: {'all ' * (len(right) > 1)}{number}, attitude within {max(right):.2g} rad of the exact motion."
        )
    counts = Counter(verdict.status for verdict in verdicts)
    return (
        f"NOT CERTIFIED: of {number} {len(right)} are certified, "
        f"{counts[console.BROKEN]} broken, {counts[console.UNUSABLE]} unusable."
    )


def kind_of(verdicts: Sequence[Verdict]) -> str:
    """Noun in the plural for what the verdicts are on."""
    return "bodies" if any(verdict.body is not None for verdict in verdicts) else "bags"


def _faults(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Lines about what is broken worst in each bag, of not too many."""
    broken = [(v.name, v.certificate) for v in verdicts if v.certificate is not None and not v.certificate.passed]
    for name, certificate in broken[:_MOST_TOLD]:
        more = f" ({len(certificate.messages) - 1} more)" if len(certificate.messages) > 1 else ""
        yield certificates.wrapped(f"{printable(name)}: {_worst_law(certificate).message}{more}", "  - ")
    if len(broken) > _MOST_TOLD:
        yield f"  - and {len(broken) - _MOST_TOLD} more"


def uncovered(verdicts: Sequence[Verdict]) -> list[str]:
    """Sentences about what no law speaks of in some bags, each once, with the name of its bag or how many have it."""
    found: dict[str, list[tuple[Verdict, str]]] = {}
    for verdict in verdicts:
        for text in verdict.certificate.uncovered if verdict.certificate else ():
            # numbers of messages may differ from bag to bag where the same thing is not certified
            found.setdefault(re.sub(r" \(\d+ messages\)|: \d+$", "", text), []).append((verdict, text))
    lines, count = [], len({verdict.bag for verdict in verdicts})
    for what, places in found.items():
        (first, text), *others = places
        bags = {verdict.bag for verdict, _ in places}
        where = f"{len(bags)} of {count} bags" if len(bags) > 1 else printable(first.bag if others else first.name)
        lines.append(f"{text if all(other == text for _, other in others) else what} ({where})")
    more = len(lines) - _MOST_TOLD
    return lines if more <= 0 else [*lines[:_MOST_TOLD], f"and {counted(more, 'other thing')}, which --json tells"]


@short_dataclass(frozen=True)
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
        name, (worst, limit) = max(self.residuals.items(), key=lambda law: _share(*law[1]), default=("", (0.0, 0.0)))
        return name, certificates.of_limit(worst, limit) if name else ""

    @property
    def rank(self) -> tuple[bool, float]:
        """Key of order, smaller for what is worse."""
        return self.certified, -math.inf if math.isnan(self.accuracy) else -self.accuracy

    @property
    def row(self) -> tuple[tuple[str, ...], bool]:
        """Cells of the table, and whether it is certified: only then its attitudes are worth a bound."""
        accuracy, verdict = (f"{self.accuracy:.2g}", "certified") if self.certified else ("", "NOT CERTIFIED")
        # the verdict is beside the name: a wide table is cut off at the right
        return (self.cells[0], verdict, *self.cells[1:], *self.worst, accuracy), self.certified


def _share(worst: float, limit: float) -> tuple[bool, float]:
    """Key of order, larger for what goes farther beyond its limit; NaN does by any."""
    return not worst <= limit, 0.0 if worst == 0.0 else math.inf if limit == 0.0 or math.isnan(worst) else worst / limit


def page_of_verdicts(title: str, verdicts: Sequence[Verdict]) -> bytes:
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
    broken = [f"{name}: {message}" for name, certificate in judged for message in certificate.messages]
    if len(broken) > MOST_MESSAGES:
        broken[MOST_MESSAGES:] = [f"and {len(broken) - MOST_MESSAGES} more"]
    unusable = [verdict.reason for verdict in verdicts if verdict.certificate is None]
    told = {
        "Broken laws": broken,
        "Not certified, besides what is not of any bag": uncovered(verdicts),
        "Not judged": unusable,
    }
    more = [html_page.listing(heading, map(escaped, sentences)) for heading, sentences in told.items()]
    lines = [Line((name,), each.passed, each.attitude_accuracy, each.residuals) for name, each in judged]
    return page(title, kind_of(verdicts), ("bag",), lines, more, len(unusable))


def page(
    title: str,
    what: str,
    headings: Sequence[str],
    lines: Sequence[Line],
    more: Sequence[str] = (),
    unusable: int = 0,
    first: Sequence[str] = (),
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
    first : sequence of str, optional
        HTML before the residuals.

    Returns
    -------
    bytes
        HTML.
    """
    count, accuracies = len(lines) + unusable, [line.accuracy for line in lines if line.certified]
    whose = "Attitudes" if len(accuracies) == count else f"The attitudes of the {what} that are certified"
    within = f"{whose} are within {max(accuracies, default=0.0):.2g} rad of the exact motion."
    parts = [
        html_page.badge(f"{len(accuracies)} of {count} {what} CERTIFIED", passed=len(accuracies) == count),
        *([html_page.paragraph(within)] if accuracies else []),
        *first,
        *_distributions(what, lines),
        *more,
        *_table(what, headings, lines),
    ]
    return html_page.document(title, parts, with_figures=True)


def _distributions(what: str, lines: Sequence[Line]) -> Iterator[str]:
    laws: dict[str, list[Sequence[float]]] = {}
    for line in lines:
        for name, pair in line.residuals.items():
            laws.setdefault(name, []).append(pair)
    if panels := list(figures.distributions(laws, what)):
        yield "<h2>Residuals</h2>"
        yield html_page.paragraph(f"How many {what} have a worst residual of each size, beside the limits.")
        yield html_page.grid(panels)


def _table(what: str, headings: Sequence[str], lines: Sequence[Line]) -> Iterator[str]:
    yield f"<h2>{what.capitalize()}</h2>"
    if len(lines) > MOST_LINES:
        shown = {id(line) for line in sorted(lines, key=lambda line: line.rank)[:MOST_LINES]}
        yield html_page.paragraph(f"Of {len(lines)} {what} these {MOST_LINES} are the worst.")
        lines = [line for line in lines if id(line) in shown]
    head = (headings[0], "", *headings[1:], "worst law", "of limit", "attitude, rad")
    yield html_page.table(head, [line.row for line in lines])
