"""Answer about a certificate, and what is proved beside it; and JSON for programs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np

from lie_rigid_body.certificate import Certificate, LawResult, SegmentCertificate
from lie_rigid_body.certificate.proved import Proof
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.report import answer, figures, html_page
from lie_rigid_body.report.answer import Conclusion, Details, Part, Parts, Picture, Sentences, Table
from lie_rigid_body.report.recorded_motion import Pieces, ResidualsOverTime, in_words
from lie_rigid_body.scenario.facts import facts

_HEADINGS: Final = ("law", "worst", "limit", "", "sample", "time, s", "")
MAX_TABLES: Final = 30
"""Largest number of segments whose laws are told: the first ones, those that break a law before the others."""


def as_table(bag: str, certificate: Certificate, proof: Proof | None = None) -> str:
    """Answer for a terminal, with the name of the bag as the user gave it."""
    return answer.as_text(parts(certificate, proof), bag)


@np.errstate(all="ignore")  # recorded numbers may be anything
def page(
    bag: str,
    certificate: Certificate,
    residuals: ResidualsOverTime,
    pieces: Pieces,
    proof: Proof | None = None,
) -> bytes:
    """Answer as a page.

    Parameters
    ----------
    bag : str
        Name of the bag, as the user gave it.
    certificate : Certificate
    residuals : ResidualsOverTime
        Told while the certificate was made.
    pieces : sequence of RecordedSegment
        The bag's samples, or none.
    proof : Proof, optional
    """
    drawn = [piece for piece in pieces if len(piece.samples)]
    conclusion, verdict, *others = parts(certificate, proof)
    motion = Picture(lambda: "".join(figures.sections(drawn) if drawn else ()))
    curves = Picture(lambda: _residuals(certificate, residuals, drawn) if drawn else "")
    segments = [each.segment for each in certificate.segments[:MAX_TABLES]]
    scenarios = [Details(f"Scenario from {segment.start_ns} ns on", segment.to_json()) for segment in segments]
    return answer.as_page(
        f"Certificate of {bag}", [conclusion, verdict, motion, *others, curves, *scenarios], with_film=True
    )


def parts(certificate: Certificate, proof: Proof | None = None) -> Parts:
    """Answer about a certificate: to what accuracy it holds or what is broken, the laws, and what it leaves out."""
    first, *others = _verdict(certificate)
    return [
        Conclusion([first], certificate.passed),
        Sentences([*others, *([_proved(proof)] if proof else [])]),
        *_laws(certificate),
        Sentences([each.removeprefix("and ") for each in certificate.not_certified], "Not certified"),
    ]


def _verdict(certificate: Certificate) -> Iterator[str]:
    """Sentences that say to what accuracy a bag is certified, or which laws it breaks."""
    if not certificate.passed:
        yield "NOT CERTIFIED"
        yield from certificate.messages
        if any(segment.segment.scenario.kicks for segment in certificate.segments):
            yield from _worst(certificate, _accuracy(certificate)["attitude_worst"])
        return
    told = _accuracy(certificate)
    certified = f"CERTIFIED: attitude within {told['attitude_rad']:.2g} rad of the"
    limit = f"(limit {told['attitude_limit_rad']:.2g})"
    if certificate.is_prescribed:
        yield f"{certified} prescribed path {limit}. No law of mechanics was judged."
    else:
        yield (
            f"{certified} exact motion {limit}, kinetic energy to {told['kinetic_energy_relative']:.2g}, "
            f"world momentum to {told['world_momentum_relative']:.2g} (relative)."
        )
    yield from _worst(certificate, told["attitude_worst"])
    if certificate.to_the_bit is not None:
        yield f"It is {'' if certificate.to_the_bit else 'not '}equal to the bit to what is computed here."
    if certificate.sensors:
        yield f"Every reading is what its scenario determines: {', '.join(certificate.sensors)}."


def _worst(certificate: Certificate, worst: dict[str, Any]) -> Iterator[str]:
    """Sentence that says where the attitude is worst, unless it is exact everywhere."""
    if worst["sample"] is None or certificate.accuracy("attitude") == 0.0:
        return
    where = f" of segment {worst['segment']}" if len(certificate.segments) > 1 else ""
    arc = f", in arc {worst['arc']}, which begins at {worst['arc_begin_s']:.7g} s" if "arc" in worst else ""
    yield f"Attitude is worst at sample {worst['sample']}{where}, {worst['time_s']:.7g} s after the start{arc}."


def _proved(proof: Proof) -> str:
    """Sentence that says what is proved."""
    worst = proof.worst
    count = len(proof.samples)
    if worst is None:
        return "proved: nothing, as there is no sample with a motion to hold it against"
    where = f"sample {worst.sample} of segment {worst.segment}, {worst.time_s:.7g} s after the start"
    if broken := sum(not sample.holds for sample in proof.samples):
        return (
            f"proved: {broken} of {count} samples are beyond their limit; the attitude is at least "
            f"{worst.attitude_at_least_rad:.2g} rad off the true one (limit {worst.attitude_limit_rad:.2g}) at {where}"
        )
    return f"proved: within {worst.attitude_at_most_rad:.2g} rad at {counted(count, 'sample')}, worst at {where}"


def _laws(certificate: Certificate) -> Iterator[Part]:
    """Laws of each segment, and of the bag as a whole."""
    count = len(certificate.segments)
    numbered = sorted(enumerate(certificate.segments, 1), key=lambda item: item[1].passed)[:MAX_TABLES]
    for number, segment in sorted(numbered, key=lambda item: item[0]):
        yield Sentences([_facts(number, count, segment)])
        yield _table((law, segment.time_s(law)) for law in segment.laws)
        yield Sentences([f"Note: {note}." for note in segment.notes])
    if count > MAX_TABLES:
        yield Sentences([f"{count - MAX_TABLES} other segments are not listed."])
    if certificate.whole:
        yield _table(((law, None) for law in certificate.whole), "The bag as a whole")


def _table(laws: Iterable[tuple[LawResult, float | None]], heading: str = "") -> Table:
    """Table of laws, each with the time of its worst sample since the segment's start, s."""
    told = [*laws]
    return Table(_HEADINGS, [law_cells(*each) for each in told], heading, [not law.holds for law, _ in told])


def _facts(number: int, count: int, certificate: SegmentCertificate) -> str:
    """Sentence about a segment: its number of so many, samples, inertia, start and motion."""
    scenario = certificate.segment.scenario
    others = "".join(f"; {name}: {phrase}" for name, phrase in facts(scenario).items())
    return (
        f"Segment {number} of {count}: {counted(certificate.samples, 'sample')} at {scenario.rate:g} Hz "
        f"from {certificate.segment.start_ns} ns, {in_words(scenario)}{others}."
    )


def law_cells(law: LawResult, time_s: float | None) -> tuple[str, ...]:
    """Cells of a law: name, worst residual, limit, unit, sample, time of that, s, and whether it holds."""
    sample = ""
    time = ""
    if law.sample is not None and time_s is not None:
        sample = "all" if law.worst == 0.0 else str(law.sample)
        time = "" if law.worst == 0.0 else f"{time_s:.7g}"
    worst = f"{law.worst:.7g}" if law.worst.is_integer() else f"{law.worst:.2g}"  # counts have all digits
    if not law.is_judged:
        return law.name, worst, "", law.unit, sample, time, ""
    return law.name, worst, f"{law.limit:.2g}", law.unit, sample, time, "holds" if law.holds else "BROKEN"


def _residuals(certificate: Certificate, residuals: ResidualsOverTime, pieces: Pieces) -> str:
    """HTML of the residuals over time."""
    panels = list(figures.residuals_over_time(certificate, residuals, pieces))
    what = html_page.paragraph(
        "The largest residual of each law in each of some hundred intervals of time, beside its limit. "
        "What is beyond its limit is red. Residuals of 0 are left out, "
        "and so are laws that have no other: the tables have all."
    )
    return f"<h2>Residuals over time</h2>{what}{html_page.grid(panels)}" if panels else ""


def as_json(bag: str, certificate: Certificate, proof: Proof | None = None) -> dict[str, object]:
    """Data of a certificate for JSON; its numbers may be infinite or NaN."""
    return {
        "bag": bag,
        "passed": certificate.passed,
        "certified": _accuracy(certificate) if certificate.passed else None,
        "certified_sensors": list(certificate.sensors) if certificate.passed else [],
        "not_certified": list(certificate.not_certified),
        "messages": list(certificate.messages),
        "segments": [
            {
                "start_ns": segment.segment.start_ns,
                "first_sample": segment.segment.first_sample,
                "samples": segment.samples,
                "passed": segment.passed,
                "scenario": segment.segment.scenario.parameters(),
                "laws": [_law_json(law, segment.time_s(law)) for law in segment.laws],
                "notes": list(segment.notes),
            }
            for segment in certificate.segments
        ],
        "laws": [_law_json(law, None) for law in certificate.whole],
    } | (
        {}
        if proof is None
        else {
            "proved": {
                "passed": proof.passed,
                "attitude_rad": max((sample.attitude_at_most_rad for sample in proof.samples), default=math.nan),
                "samples": [{**vars(sample), "holds": sample.holds} for sample in proof.samples],
            }
        }
    )


def _accuracy(certificate: Certificate) -> dict[str, Any]:
    """How exact a certified bag is, and where it is so least."""
    number, segment = certificate.farthest
    law = segment.law("attitude")
    return {
        "attitude_rad": certificate.attitude_accuracy,
        "attitude_limit_rad": max(each.law("attitude").limit for each in certificate.segments),
        "body_rate_relative": certificate.accuracy("body rate"),
        "kinetic_energy_relative": None if certificate.is_prescribed else certificate.accuracy("kinetic energy"),
        "world_momentum_relative": None if certificate.is_prescribed else certificate.accuracy("world momentum"),
        "attitude_worst": {
            "segment": number,
            "sample": law.sample,
            "stamp_ns": law.stamp_ns,
            "time_s": segment.time_s(law),
            **_arc(segment, law),
        },
        "to_the_bit": certificate.to_the_bit,
    }


def _arc(certificate: SegmentCertificate, law: LawResult) -> dict[str, Any]:
    """Number and begin of the arc of a law's worst sample, where there are kicks."""
    kicks = certificate.segment.scenario.kick_schedule()
    if not len(kicks) or law.stamp_ns is None:
        return {}
    arc = kicks.arc(law.stamp_ns - certificate.segment.start_ns)
    return {"arc": arc, "arc_begin_s": kicks.begin_ns(arc) / NS}


def _law_json(law: LawResult, time_s: float | None) -> dict[str, object]:
    names = ("name", "unit", "holds", "worst", "limit", "sample", "stamp_ns", "broken", "checked", "message")
    return {name: getattr(law, name) for name in names} | {"time_s": time_s}
