"""The certificates of several bags, or of several bodies, as one table for people and as JSON for programs."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from lie_rigid_body import console
from lie_rigid_body.certificate import Certificate, LawResult
from lie_rigid_body.cli import certificate_text
from lie_rigid_body.cli.judgement import Judgement
from lie_rigid_body.wording import counted, printable, shortened

_VERDICTS: Final = {console.SUCCESS: "certified", console.BROKEN: "BROKEN", console.UNUSABLE: "unusable"}
_COLUMNS: Final = "{verdict:<9} {samples:>9} {accuracy:>8} {law:<34} {used:>7}  {bag}"
_MOST_TOLD: Final = 10
"""Number of broken bags of which the table is followed by what is broken, and of things that are not certified."""
_NUMBERS: Final = re.compile(r" \(\d+ messages\)|: \d+$")
"""How many of a thing there are, which may differ from bag to bag."""


def as_table(judgements: Sequence[Judgement]) -> str:
    """The certificates in lines for a terminal: a row for each, a count of the verdicts, what is broken or left out."""
    head = {"verdict": "verdict", "samples": "samples", "accuracy": "rad", "law": "worst law", "used": "of limit"}
    lines = [_COLUMNS.format(**head, bag="bag"), *map(_row, judgements)]
    return "\n".join([*lines, "", _summary(judgements), *_faults(judgements), *_uncovered(judgements)])


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
        law, used = worst.name, certificate_text.of_limit(worst.worst, worst.limit)
        if certificate.passed:
            accuracy = f"{certificate.attitude_accuracy:.2g}"
    return _COLUMNS.format(
        verdict=_VERDICTS[judgement.status],
        samples=samples,
        accuracy=accuracy,
        law=law,
        used=used,
        bag=printable(judgement.name),
    ).rstrip()


def _worst_law(certificate: Certificate) -> LawResult:
    """The law that came nearest to its limit, or went farthest beyond."""
    laws = [law for segment in certificate.segments for law in segment.laws] + list(certificate.whole)
    return max(laws, key=lambda law: (not law.holds, law.share))


def _summary(judgements: Sequence[Judgement]) -> str:
    counts = Counter(judgement.status for judgement in judgements)
    number = counted(len(judgements), "bag") if kind_of(judgements) == "bags" else f"{len(judgements)} bodies"
    if not counts[console.BROKEN] and not counts[console.UNUSABLE]:
        certificates = [judgement.certificate for judgement in judgements if judgement.certificate is not None]
        worst = max(certificate.attitude_accuracy for certificate in certificates)
        return (
            f"CERTIFIED: {'all ' * (len(judgements) > 1)}{number}, attitude within {worst:.2g} rad of the exact motion."
        )
    return (
        f"NOT CERTIFIED: of {number} {counts[console.SUCCESS]} are certified, "
        f"{counts[console.BROKEN]} broken, {counts[console.UNUSABLE]} unusable."
    )


def kind_of(judgements: Sequence[Judgement]) -> str:
    """What each of them is of, in the plural."""
    return "bodies" if any(judgement.body is not None for judgement in judgements) else "bags"


def _faults(judgements: Sequence[Judgement]) -> Iterator[str]:
    """What is broken worst in each bag, of not too many."""
    broken = [judgement for judgement in judgements if judgement.status == console.BROKEN]
    for judgement in broken[:_MOST_TOLD]:
        assert judgement.certificate is not None
        others = len(judgement.certificate.messages) - 1
        more = f" ({others} more)" if others else ""
        text = f"{shortened(printable(judgement.name))}: {_worst_law(judgement.certificate).message}{more}"
        yield _item(text)
    if len(broken) > _MOST_TOLD:
        yield f"  - and {len(broken) - _MOST_TOLD} more"


def uncovered(judgements: Sequence[Judgement]) -> list[str]:
    """What no law speaks of in some of the bags, each thing once, with the name of its bag or how many have it."""
    found: dict[str, list[tuple[Judgement, str]]] = {}
    for judgement in judgements:
        for text in judgement.certificate.uncovered if judgement.certificate else ():
            found.setdefault(_NUMBERS.sub("", text), []).append((judgement, text))
    count, lines = len({judgement.bag for judgement in judgements}), []
    for what, places in found.items():
        texts, bags = {text for _, text in places}, {judgement.bag for judgement, _ in places}
        first = places[0][0].name if len(places) == 1 else places[0][0].bag
        where = shortened(printable(first)) if len(bags) == 1 else f"{len(bags)} of {count} bags"
        lines.append(f"{texts.pop() if len(texts) == 1 else what} ({where})")
    more = len(lines) - _MOST_TOLD
    return lines if more <= 0 else [*lines[:_MOST_TOLD], f"and {counted(more, 'other thing')}, which --json tells"]


def _uncovered(judgements: Sequence[Judgement]) -> Iterator[str]:
    if lines := uncovered(judgements):
        yield "Not certified, besides what is not of any bag:"
        for line in lines:
            yield _item(line)


def _item(text: str) -> str:
    """A point of a list, in lines that leave paths whole."""
    return textwrap.fill(
        text, 80, initial_indent="  - ", subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
