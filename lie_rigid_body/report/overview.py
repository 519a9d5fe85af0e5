"""Answer about many bags."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import Final

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, printable
from lie_rigid_body.report import answer, certificates
from lie_rigid_body.report.answer import Conclusion, Parts, Sentences, Table
from lie_rigid_body.system import console

_VERDICTS: Final = {console.SUCCESS: "certified", console.BROKEN: "BROKEN", console.UNUSABLE: "unusable"}


@short_dataclass
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


Verdicts = Sequence[Verdict]
"""Verdicts in the order in which the bags were given."""


def as_table(verdicts: Verdicts) -> str:
    """Answer for a terminal."""
    return answer.as_text(_parts(verdicts))


def page_of_verdicts(title: str, verdicts: Verdicts) -> bytes:
    """Answer as a page, of at least one bag or body that has a certificate."""
    return answer.as_page(title, _parts(verdicts))


def _parts(verdicts: Verdicts) -> Parts:
    """Answer about many bags: how many there are of each verdict, a row for each, what is broken or left out."""
    judged = [(verdict.name, verdict.certificate) for verdict in verdicts if verdict.certificate is not None]
    broken = [f"{name}: {message}" for name, certificate in judged for message in certificate.messages]
    return [
        Conclusion([_summary(verdicts)], not any(verdict.status for verdict in verdicts)),
        Table(
            ("verdict", "samples", "attitude, rad", "worst law", "of limit", "bag"),
            [_cells(verdict) for verdict in verdicts],
            marked=[bool(verdict.status) for verdict in verdicts],
        ),
        Sentences(broken, "Broken laws"),
        Sentences(uncovered(verdicts), "Not certified, besides what is not of any bag"),
        Sentences([verdict.reason for verdict in verdicts if verdict.certificate is None], "Not judged"),
    ]


def as_json(verdicts: Verdicts) -> dict[str, object]:
    """Data for JSON: numbers of the verdicts, and for each bag or body what it has alone."""
    counts = Counter(verdict.status for verdict in verdicts)
    return {
        "passed": not any(verdict.status for verdict in verdicts),
        **{name.lower(): counts[status] for status, name in _VERDICTS.items()},
        "bags": [
            {"bag": verdict.bag, "body": verdict.body, "passed": None, "error": verdict.reason}
            if verdict.certificate is None
            else certificates.as_json(verdict.bag, verdict.certificate) | {"body": verdict.body}
            for verdict in verdicts
        ],
    }


def _cells(verdict: Verdict) -> tuple[str, ...]:
    certificate = verdict.certificate
    if certificate is None:
        return _VERDICTS[verdict.status], "", "", "", "", verdict.name
    samples = sum(segment.samples for segment in certificate.segments)
    # that came nearest to its limit, or went farthest beyond
    worst = max(certificate.laws, key=lambda law: (not law.holds, law.share))
    share = f"{worst.share:.2g}" if worst.limit or worst.holds else f"{worst.worst:.2g} of 0"
    accuracy = f"{certificate.attitude_accuracy:.2g}" if certificate.passed else ""
    return _VERDICTS[verdict.status], str(samples), accuracy, worst.name, share, verdict.name


def _summary(verdicts: Verdicts) -> str:
    are_bodies = any(verdict.body is not None for verdict in verdicts)
    number = f"{len(verdicts)} bodies" if are_bodies else counted(len(verdicts), "bag")
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


def uncovered(verdicts: Verdicts) -> list[str]:
    """Sentences about what no law speaks of in some bags, each once, with the name of its bag or how many have it."""
    found: dict[str, list[Verdict]] = {}
    for verdict in verdicts:
        for text in verdict.certificate.uncovered if verdict.certificate else ():
            # numbers of messages may differ from bag to bag where the same thing is not certified
            found.setdefault(re.sub(r" \(\d+ messages\)|: \d+$", "", text), []).append(verdict)
    lines = []
    for text, (first, *others) in found.items():
        bags = {verdict.bag for verdict in (first, *others)}
        where = f"{len(bags)} of {len({verdict.bag for verdict in verdicts})} bags"
        if len(bags) == 1:
            where = printable(first.bag if others else first.name)
        lines.append(f"{text} ({where})")
    return lines
