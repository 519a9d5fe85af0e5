"""A certificate as one HTML page, with the motion and the residuals of its bag as figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import Final

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.certificate.law_result import ResidualsOverTime
from lie_rigid_body.certificate.proved import Proof
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.report import certificate_text, html_page, motion_figures, residual_figures
from lie_rigid_body.report.html_page import figure, grid

MOST_TABLES: Final = 30
"""Largest number of segments whose laws are listed: the first ones, those that break a law before the others."""


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
    pieces = [piece for piece in pieces if len(piece.samples)]
    parts = [
        *_verdict(certificate, proof),
        *(_motion(pieces) if pieces else ()),
        *_laws(certificate),
        *(_residuals(certificate, residuals, pieces) if pieces else ()),
        html_page.listing("Not certified", map(escape, certificate.not_certified)),
        *(html_page.scenario(segment.segment) for segment in certificate.segments[:MOST_TABLES]),
    ]
    return html_page.document(f"Certificate of {bag}", parts, with_figures=True)


def _verdict(certificate: Certificate, proof: Proof | None) -> Iterator[str]:
    yield html_page.badge("CERTIFIED" if certificate.passed else "NOT CERTIFIED", passed=certificate.passed)
    if certificate.passed:
        said = " ".join(certificate_text.verdict(certificate).split()).removeprefix("CERTIFIED: ")
        yield html_page.paragraph(said[:1].upper() + said[1:])
    else:
        yield f"<ul>{''.join(f'<li>{escape(message)}</li>' for message in certificate.messages)}</ul>"
    if proof is not None:
        yield html_page.paragraph(certificate_text.proved(proof))


def _laws(certificate: Certificate) -> Iterator[str]:
    yield "<h2>Laws</h2>"
    count = len(certificate.segments)
    numbered = sorted(enumerate(certificate.segments, 1), key=lambda item: item[1].passed)[:MOST_TABLES]
    for number, segment in sorted(numbered, key=lambda item: item[0]):
        facts = ", ".join(certificate_text.segment_facts(number, count, segment))
        yield html_page.paragraph(f"{facts[:1].upper()}{facts[1:]}.")
        rows = [(certificate_text.law_cells(law, segment.time_s(law)), law.holds) for law in segment.laws]
        yield html_page.table(certificate_text.HEADINGS, rows)
        for note in segment.notes:
            yield html_page.paragraph(f"Note: {note}.")
    if count > MOST_TABLES:
        yield html_page.paragraph(f"{count - MOST_TABLES} other segments are not listed.")
    if certificate.whole:
        yield html_page.paragraph("The bag as a whole.")
        rows = [(certificate_text.law_cells(law, None), law.holds) for law in certificate.whole]
        yield html_page.table(certificate_text.HEADINGS, rows)


def _residuals(
    certificate: Certificate, residuals: ResidualsOverTime, pieces: Sequence[RecordedSegment]
) -> Iterator[str]:
    shapes = motion_figures.resets(pieces)
    panels = list(residual_figures.figures_over_time(certificate, residuals, int(pieces[0].stamps_ns[0]), shapes))
    if panels:
        yield "<h2>Residuals over time</h2>"
        yield html_page.paragraph(
            "The largest residual of each law in each of some hundred intervals of time, beside its limit. "
            "A circle marks the worst sample or reading; what is beyond its limit is red. Residuals of 0 are left out, "
            "and so are laws that have no other: the tables have all."
        )
        yield grid(panels)


def _motion(pieces: Sequence[RecordedSegment]) -> Iterator[str]:
    first = pieces[0]
    whose = " of the first segment" if len(pieces) > 1 else ""
    if film := motion_figures.body(first):
        yield figure(f"The body{whose}", *film, kind="body")
    yield figure("Body rate", motion_figures.rate(pieces), "Angular velocity in the frame of the body.")
    paths = (
        (
            motion_figures.polhode(first),
            "Polhode",
            "ω [rad/s] in the principal frame, on the ellipsoid of the kinetic energy.",
        ),
        (motion_figures.herpolhode(first), "Herpolhode", "ω in the world, seen along the angular momentum (cross)."),
    )
    drawn = [figure(f"{name}{whose}", content, text, kind="tall") for content, name, text in paths if content]
    yield grid(drawn, wide=True) if drawn else html_page.paragraph("The body is at rest: no polhode, no herpolhode.")
