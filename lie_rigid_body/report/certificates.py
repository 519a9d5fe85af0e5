"""A certificate, and what is proved beside it: a table for people, JSON for programs, and a page with figures."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from lie_rigid_body.certificate import Certificate, LawResult, SegmentCertificate
from lie_rigid_body.certificate.proved import Proof
from lie_rigid_body.foundation.wording import counted, numerals, printable
from lie_rigid_body.report import figures, html_page
from lie_rigid_body.report.html_page import escaped
from lie_rigid_body.report.recorded_motion import RecordedSegment, ResidualsOverTime

LAW_HEADINGS: Final = ("law", "worst", "limit", "", "sample", "time, s", "")
"""Headings of the columns of `law_cells`."""
LAW_ROW: Final = " {:<34} {:>7} {:>7} {:<3} {:>7} {:>9} {}"
_UNIT: Final = 3
"""Width of the column of units, characters; a longer unit stands behind the name."""
_TIME: Final = 9
"""Width of the column of times, characters."""
_COUNTS: Final = (99.0, 1e7)
"""Limits between which a whole number is a count, shown with all digits; a larger one does not fit."""
_WIDTH: Final = 80
"""Width of the table, and of the sentences, characters."""
MOST_TABLES: Final = 30
"""Largest number of segments whose laws are on a page: the first ones, those that break a law before the others."""


def as_table(bag: str, certificate: Certificate, proof: Proof | None = None) -> str:
    """Lines of a certificate for a terminal.

    Parameters
    ----------
    bag : str
        Name of the bag, as the user gave it.
    certificate : Certificate
    proof : Proof, optional

    Returns
    -------
    str
        Without a final newline.
    """
    lines = [printable(bag)]
    for i, segment in enumerate(certificate.segments, 1):
        first, *others = segment_facts(i, len(certificate.segments), segment)
        lines += ["", first, *(f"  {fact}" for fact in others), "", LAW_ROW.format(*LAW_HEADINGS).rstrip()]
        lines += [LAW_ROW.format(*law_cells(law, segment.time_s(law))).rstrip() for law in segment.laws]
        lines += [wrapped(note, " note: ") for note in segment.notes]
    lines += [*(LAW_ROW.format(*law_cells(law, None)).rstrip() for law in certificate.whole), "", verdict(certificate)]
    if certificate.not_certified:
        lines.append(wrapped("; ".join(certificate.not_certified) + ".", "Not certified: "))
    if proof is not None:
        lines.append(proved(proof))
    return "\n".join(lines)


def verdict(certificate: Certificate) -> str:
    """Sentences that say to what accuracy a bag is certified, or which laws it breaks."""
    if not certificate.passed:
        return "\n".join(["NOT CERTIFIED", *(wrapped(message, "  - ") for message in certificate.messages)])
    told = _accuracy(certificate)
    worst = told["attitude_worst"]
    lines = [
        f"CERTIFIED: attitude within {told['attitude_rad']:.2g} rad of the exact motion "
        f"(limit {told['attitude_limit_rad']:.2g}),",
        f"  kinetic energy to {told['kinetic_energy_relative']:.2g}, "
        f"world momentum to {told['world_momentum_relative']:.2g} (relative).",
    ]
    if worst["sample"] is not None and certificate.accuracy("attitude") != 0.0:
        where = f" of segment {worst['segment']}" if len(certificate.segments) > 1 else ""
        lines.append(
            f"  Attitude is worst at sample {worst['sample']}{where}, {worst['time_s']:.7g} s after the start."
        )
    if certificate.to_the_bit is not None:
        lines.append(f"  It is {'' if certificate.to_the_bit else 'not '}equal to the bit to what is computed here.")
    if certificate.sensors:
        lines.append(wrapped(f"Every reading is what its scenario determines: {', '.join(certificate.sensors)}.", "  "))
    return "\n".join(lines)


def proved(proof: Proof) -> str:
    """Sentence that says what is proved, in lines for a terminal."""
    worst, count = proof.worst, len(proof.samples)
    if worst is None:
        return "proved: nothing, as there is no sample with a motion to hold it against"
    where = f"sample {worst.sample} of segment {worst.segment}, {worst.time_s:.7g} s after the start"
    broken = sum(not sample.holds for sample in proof.samples)
    said = (
        f"proved: {broken} of {count} samples are beyond their limit; the attitude is at least "
        f"{worst.at_least:.2g} rad off the true one (limit {worst.limit:.2g}) at {where}"
        if broken
        else f"proved: within {worst.at_most:.2g} rad at {counted(count, 'sample')}, worst at {where}"
    )
    return textwrap.fill(said, _WIDTH, subsequent_indent="  ")


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
                "attitude_rad": max((sample.at_most for sample in proof.samples), default=math.nan),
                "samples": [
                    {
                        "segment": sample.segment,
                        "sample": sample.sample,
                        "stamp_ns": sample.stamp_ns,
                        "time_s": sample.time_s,
                        "attitude_at_least_rad": sample.at_least,
                        "attitude_at_most_rad": sample.at_most,
                        "attitude_limit_rad": sample.limit,
                        "body_rate_at_most_rad_s": sample.rate_at_most,
                        "holds": sample.holds,
                    }
                    for sample in proof.samples
                ],
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
        "kinetic_energy_relative": certificate.accuracy("kinetic energy"),
        "world_momentum_relative": certificate.accuracy("world momentum"),
        "attitude_worst": {
            "segment": number,
            "sample": law.sample,
            "stamp_ns": law.stamp_ns,
            "time_s": segment.time_s(law),
        },
        "to_the_bit": certificate.to_the_bit,
    }


def _law_json(law: LawResult, time_s: float | None) -> dict[str, object]:
    return {
        "name": law.name,
        "unit": law.unit,
        "holds": law.holds,
        "worst": law.worst,
        "limit": law.limit,
        "sample": law.sample,
        "stamp_ns": law.stamp_ns,
        "time_s": time_s,
        "broken": law.broken,
        "checked": law.checked,
        "message": law.message,
    }


def segment_facts(number: int, count: int, certificate: SegmentCertificate) -> tuple[str, ...]:
    """Facts about a segment: its number of so many, samples, inertia, start and motion."""
    scenario = certificate.segment.scenario
    steps = f"moving_chart {scenario.method}, steps of at most {scenario.max_step:g} s"
    return (
        f"segment {number} of {count}: {counted(certificate.samples, 'sample')} at {scenario.rate:g} Hz "
        f"from {certificate.segment.start_ns} ns",
        f"inertia [{numerals(scenario.inertia)}] kg m²",
        f"initial body rate [{numerals(scenario.initial_body_rate)}] rad/s",
        steps if scenario.motion == "moving_chart" else scenario.motion,
    )


def law_cells(law: LawResult, time_s: float | None) -> tuple[str, ...]:
    """Cells of a law's line in the table, under `LAW_HEADINGS`.

    Parameters
    ----------
    law : LawResult
    time_s : float or None
        Time of its worst sample since the segment's start, s.
    """
    sample, time = "", ""
    if law.sample is not None and time_s is not None:
        # seven digits, or as many as there is room for: such as of a small time that does not end
        times = (f"{time_s:.{digits}g}" for digits in range(7, 0, -1))
        fitting = next(text for text in times if len(text) <= _TIME)
        sample, time = ("all", "") if law.worst == 0.0 else (str(law.sample), fitting)
    is_long, is_count = len(law.unit) > _UNIT, _COUNTS[0] < law.worst < _COUNTS[1] and law.worst.is_integer()
    name, unit = (f"{law.name}, {law.unit}", "") if is_long else (law.name, law.unit)
    worst = f"{law.worst:.0f}" if is_count else f"{law.worst:.2g}"
    if not law.is_judged:
        return name, worst, "", unit, sample, time, ""
    return name, worst, f"{law.limit:.2g}", unit, sample, time, "holds" if law.holds else "BROKEN"


def of_limit(worst: float, limit: float) -> str:
    """Residual as a share of its limit; the residual itself where the limit is 0."""
    return f"{worst / limit:.2g}" if limit > 0.0 else f"{worst:.2g} of 0" if worst != 0.0 else "0"


def wrapped(sentence: str, mark: str) -> str:
    """Lines of a sentence for a terminal, the first after a mark; paths stay whole."""
    return textwrap.fill(
        sentence,
        _WIDTH,
        initial_indent=mark,
        subsequent_indent=" " * min(len(mark), 7),
        break_long_words=False,
        break_on_hyphens=False,
    )


@np.errstate(all="ignore")  # recorded numbers may be anything
def page(
    bag: str,
    certificate: Certificate,
    residuals: ResidualsOverTime,
    pieces: Sequence[RecordedSegment],
    proof: Proof | None = None,
) -> bytes:
    """Make the page.

    Parameters
    ----------
    bag : str
        Name of the bag, as the user gave it.
    certificate : Certificate
    residuals : ResidualsOverTime
        Told while the certificate was made.
    pieces : sequence of RecordedSegment
        The bag's samples, thinned, or none.
    proof : Proof, optional

    Returns
    -------
    bytes
        HTML.
    """
    parts = _parts(certificate, residuals, [piece for piece in pieces if len(piece.samples)], proof)
    return html_page.document(f"Certificate of {bag}", parts, with_figures=True)


def _parts(
    certificate: Certificate, residuals: ResidualsOverTime, pieces: Sequence[RecordedSegment], proof: Proof | None
) -> Iterator[str]:
    """HTML of the verdict, the motion, the laws, their residuals, what is not certified, and the scenarios."""
    yield html_page.badge("CERTIFIED" if certificate.passed else "NOT CERTIFIED", passed=certificate.passed)
    if certificate.passed:
        said = " ".join(verdict(certificate).split()).removeprefix("CERTIFIED: ")
        yield html_page.paragraph(said[:1].upper() + said[1:])
    else:
        yield f"<ul>{''.join(f'<li>{escaped(message)}</li>' for message in certificate.messages)}</ul>"
    if proof is not None:
        yield html_page.paragraph(proved(proof))
    if pieces:
        yield from figures.sections(pieces)
    yield from _laws(certificate)
    if pieces and (panels := list(figures.residuals_over_time(certificate, residuals, pieces))):
        yield "<h2>Residuals over time</h2>"
        yield html_page.paragraph(
            "The largest residual of each law in each of some hundred intervals of time, beside its limit. "
            "A circle marks the worst sample or reading; what is beyond its limit is red. Residuals of 0 are left out, "
            "and so are laws that have no other: the tables have all."
        )
        yield html_page.grid(panels)
    yield html_page.listing("Not certified", map(escaped, certificate.not_certified))
    yield from (
        html_page.details(*html_page.scenario(segment.segment)) for segment in certificate.segments[:MOST_TABLES]
    )


def _laws(certificate: Certificate) -> Iterator[str]:
    yield "<h2>Laws</h2>"
    count = len(certificate.segments)
    numbered = sorted(enumerate(certificate.segments, 1), key=lambda item: item[1].passed)[:MOST_TABLES]
    for number, segment in sorted(numbered, key=lambda item: item[0]):
        facts = ", ".join(segment_facts(number, count, segment))
        yield html_page.paragraph(f"{facts[:1].upper()}{facts[1:]}.")
        yield law_table((law, segment.time_s(law)) for law in segment.laws)
        yield from (html_page.paragraph(f"Note: {note}.") for note in segment.notes)
    if count > MOST_TABLES:
        yield html_page.paragraph(f"{count - MOST_TABLES} other segments are not listed.")
    if certificate.whole:
        yield html_page.paragraph("The bag as a whole.")
        yield law_table((law, None) for law in certificate.whole)


def law_table(laws: Iterable[tuple[LawResult, float | None]]) -> str:
    """Table of laws as HTML, each with the time of its worst sample; see `law_cells`."""
    return html_page.table(LAW_HEADINGS, [(law_cells(law, time_s), law.holds) for law, time_s in laws])
