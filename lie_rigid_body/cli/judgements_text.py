"""The certificates of several bags, or of several bodies, as one table for people and as JSON for programs."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from lie_rigid_body import console
from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.cli import certificate_text
from lie_rigid_body.cli.judgement import Judgement
from lie_rigid_body.wording import shortened

_VERDICTS: Final = {console.SUCCESS: "certified", console.BROKEN: "BROKEN", console.UNUSABLE: "unusable"}
_COLUMNS: Final = "{verdict:<9}{samples:>10}{accuracy:>9} {law:<34}{used:>8}  {bag}"
_MOST_TOLD: Final = 10
"""Number of broken bags of which the table is followed by what is broken."""


def as_table(judgements: Sequence[Judgement]) -> str:
    """The certificates in lines for a terminal: a row for each, a count of the verdicts, and what is broken."""
    head = {"verdict": "verdict", "samples": "samples", "accuracy": "rad", "law": "worst law", "used": "of limit"}
    lines = [_COLUMNS.format(**head, bag="bag"), *map(_row, judgements)]
    return "\n".join([*lines, "", _summary(judgements), *_faults(judgements)])


def as_json(judgements: Sequence[Judgement]) -> dict[str, object]:
    """The certificates as JSON-serialisable data: counts, and of each bag or body what it has alone."""
    counts = Counter(judgement.status for judgement in judgements)
    return {
        "passed": all(judgement.status == console.SUCCESS for judgement in judgements),
        "certified": counts[console.SUCCESS],
        "broken": counts[console.BROKEN],
        "unusable": counts[console.UNUSABLE],
        "bags": [_json(judgement) for judgement in judgements],
    }


def _json(judgement: Judgement) -> dict[str, object]:
    if judgement.certificate is None:
        return {"bag": judgement.bag, "body": judgement.body, "passed": None, "error": judgement.reason}
    return certificate_text.as_json(judgement.bag, judgement.certificate) | {"body": judgement.body}


def _row(judgement: Judgement) -> str:
    certificate = judgement.certificate
    samples = accuracy = law = used = ""
    if certificate is not None:
        samples = str(sum(segment.samples for segment in certificate.segments))
        worst = _worst_law(certificate)
        law, used = worst.name, f"{worst.share:.2g}"
        if certificate.passed:
            accuracy = f"{certificate.attitude_accuracy:.2g}"
    return _COLUMNS.format(
        verdict=_VERDICTS[judgement.status], samples=samples, accuracy=accuracy, law=law, used=used, bag=judgement.name
    ).rstrip()


def _worst_law(certificate: Certificate) -> LawResult:
    """The law that came nearest to its limit, or went farthest beyond."""
    laws = [law for segment in certificate.segments for law in segment.laws] + list(certificate.whole)
    return max(laws, key=lambda law: (not law.holds, law.share))


def _summary(judgements: Sequence[Judgement]) -> str:
    counts = Counter(judgement.status for judgement in judgements)
    kind = "bodies" if any(judgement.body is not None for judgement in judgements) else "bags"
    if not counts[console.BROKEN] and not counts[console.UNUSABLE]:
        certificates = [judgement.certificate for judgement in judgements if judgement.certificate is not None]
        worst = max(certificate.attitude_accuracy for certificate in certificates)
        return f"CERTIFIED: all {len(judgements)} {kind}, attitude within {worst:.2g} rad of the exact motion."
    return (
        f"NOT CERTIFIED: of {len(judgements)} {kind} {counts[console.SUCCESS]} are certified, "
        f"{counts[console.BROKEN]} broken, {counts[console.UNUSABLE]} unusable."
    )


def _faults(judgements: Sequence[Judgement]) -> Iterator[str]:
    """What is broken worst in each bag, of not too many."""
    broken = [judgement for judgement in judgements if judgement.status == console.BROKEN]
    for judgement in broken[:_MOST_TOLD]:
        assert judgement.certificate is not None
        others = len(judgement.certificate.messages) - 1
        more = f" ({others} more)" if others else ""
        text = f"{shortened(judgement.name)}: {_worst_law(judgement.certificate).message}{more}"
        yield textwrap.fill(text, 80, initial_indent="  - ", subsequent_indent="    ")
    if len(broken) > _MOST_TOLD:
        yield f"  - and {len(broken) - _MOST_TOLD} more"
