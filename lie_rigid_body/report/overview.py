"""The verdicts on several bags, or on several bodies, as one table for people and as JSON for programs."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from lie_rigid_body import console
from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.report import certificate_text
from lie_rigid_body.wording import counted, printable, short_repr, shortened

_VERDICTS: Final = {console.SUCCESS: "certified", console.BROKEN: "BROKEN", console.UNUSABLE: "unusable"}
_COLUMNS: Final = "{:<9} {:>9} {:>8} {:<34} {:>7}  {}"
_MOST_TOLD: Final = 10
"""Number of broken bags of which the table is followed by what is broken, and of things that are not certified."""
_NUMBERS: Final = re.compile(r" \(\d+ messages\)|: \d+$")
"""Numbers of messages, which may differ from bag to bag where the same thing is not certified."""


@dataclass(frozen=True)
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

    __repr__ = short_repr

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
    left_out = [_item(line) for line in uncovered(verdicts)]
    remark = ["Not certified, besides what is not of any bag:"] if left_out else []
    return "\n".join([head, *map(_row, verdicts), "", _summary(verdicts), *_faults(verdicts), *remark, *left_out])


def as_json(verdicts: Sequence[Verdict]) -> dict[str, object]:
    """JSON-serialisable data: numbers of the verdicts, and for each bag or body what it has alone."""
    counts = Counter(verdict.status for verdict in verdicts)
    return {
        "passed": all(verdict.status == console.SUCCESS for verdict in verdicts),
        "certified": counts[console.SUCCESS],
        "broken": counts[console.BROKEN],
        "unusable": counts[console.UNUSABLE],
        "bags": [_json(verdict) for verdict in verdicts],
    }


def _json(verdict: Verdict) -> dict[str, object]:
    if verdict.certificate is None:
        return {"bag": verdict.bag, "body": verdict.body, "passed": None, "error": verdict.reason}
    return certificate_text.as_json(verdict.bag, verdict.certificate) | {"body": verdict.body}


def _row(verdict: Verdict) -> str:
    certificate, cells = verdict.certificate, ("", "", "", "")
    if certificate is not None:
        samples, worst = sum(segment.samples for segment in certificate.segments), _worst_law(certificate)
        accuracy = f"{certificate.attitude_accuracy:.2g}" if certificate.passed else ""
        cells = str(samples), accuracy, worst.name, certificate_text.of_limit(worst.worst, worst.limit)
    return _COLUMNS.format(_VERDICTS[verdict.status], *cells, printable(verdict.name)).rstrip()


def _worst_law(certificate: Certificate) -> LawResult:
    """Law that came nearest to its limit, or went farthest beyond."""
    return max(certificate.laws, key=lambda law: (not law.holds, law.share))


def _summary(verdicts: Sequence[Verdict]) -> str:
    counts = Counter(verdict.status for verdict in verdicts)
    number = counted(len(verdicts), "bag") if kind_of(verdicts) == "bags" else f"{len(verdicts)} bodies"
    if counts[console.SUCCESS] < len(verdicts):
        return (
            f"NOT CERTIFIED: of {number} {counts[console.SUCCESS]} are certified, "
            f"{counts[console.BROKEN]} broken, {counts[console.UNUSABLE]} unusable."
        )
    worst = max(verdict.certificate.attitude_accuracy for verdict in verdicts if verdict.certificate is not None)
    return f"CERTIFIED: {'all ' * (len(verdicts) > 1)}{number}, attitude within {worst:.2g} rad of the exact motion."


def kind_of(verdicts: Sequence[Verdict]) -> str:
    """Noun in the plural for what the verdicts are on."""
    return "bodies" if any(verdict.body is not None for verdict in verdicts) else "bags"


def _faults(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Lines about what is broken worst in each bag, of not too many."""
    broken = [(v.name, v.certificate) for v in verdicts if v.certificate is not None and not v.certificate.passed]
    for name, certificate in broken[:_MOST_TOLD]:
        others = len(certificate.messages) - 1
        more = f" ({others} more)" if others else ""
        yield _item(f"{shortened(printable(name))}: {_worst_law(certificate).message}{more}")
    if len(broken) > _MOST_TOLD:
        yield f"  - and {len(broken) - _MOST_TOLD} more"


def uncovered(verdicts: Sequence[Verdict]) -> list[str]:
    """Sentences about what no law speaks of in some bags, each once, with the name of its bag or how many have it."""
    found: dict[str, list[tuple[Verdict, str]]] = {}
    for verdict in verdicts:
        for text in verdict.certificate.uncovered if verdict.certificate else ():
            found.setdefault(_NUMBERS.sub("", text), []).append((verdict, text))
    count, lines = len({verdict.bag for verdict in verdicts}), []
    for what, places in found.items():
        texts, bags = {text for _, text in places}, {verdict.bag for verdict, _ in places}
        first = places[0][0].name if len(places) == 1 else places[0][0].bag
        where = shortened(printable(first)) if len(bags) == 1 else f"{len(bags)} of {count} bags"
        lines.append(f"{texts.pop() if len(texts) == 1 else what} ({where})")
    more = len(lines) - _MOST_TOLD
    return lines if more <= 0 else [*lines[:_MOST_TOLD], f"and {counted(more, 'other thing')}, which --json tells"]


def _item(text: str) -> str:
    """Point of a list, in lines that leave paths whole."""
    return textwrap.fill(
        text, 80, initial_indent="  - ", subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
