"""Diagnoses: tables for a terminal, and a page that needs no other file and no network."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.diagnosis.result import degrees
from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.report import html_page
from lie_rigid_body.wording import counted

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MISTAKES: Final = "{:<20} {:<18.18} {:>10} {:>10}  {}"
_PROBES: Final = "{:<20} {:<8} {:>10}  "
_SMALLEST_DEG: Final = 1e-4
"""Smallest error that is drawn, degrees."""
_COLOURS: Final = ("#D55E00", "#0072B2", "#009E73", "#333333")
"""Distinct in every kind of colour vision."""


def lines(found: FilterDiagnosis) -> Iterator[str]:
    """Lines of the sentences, the mistakes, the probes and the notes for a terminal."""
    for sentence in found.sentences:
        yield from wrapped(sentence)
    if found.mistakes:
        yield from ("", _MISTAKES.format("mistake", "repair", "before", "after", "does as well"))
        yield from (_MISTAKES.format(*cells).rstrip() for cells in _cells(found))
    if found.probes:
        yield from ("", _PROBES.format("probe", "", "value").rstrip())
    for p in found.probes:
        value = "" if p.value is None else f"{p.value:.3g}"
        yield from wrapped(p.message, _PROBES.format(p.code, "passed" if p.passed else "FAILED", value))
    yield ""
    for note in found.notes:
        yield from wrapped(note.message, f"note: {note.code}: ")
    yield from found.remarks  # each on one line, as it may be a command
    yield f"{counted(found.filter_runs, 'run')} of the filter."


def _cells(found: FilterDiagnosis) -> list[tuple[str, ...]]:
    """Code, repair, error before and after, and what does as well of each mistake."""
    return [
        (m.code, m.repair, degrees(m.rms_deg_before), degrees(m.rms_deg_after), ", ".join(m.or_else))
        for m in found.mistakes
    ]


def page(name: str, found: FilterDiagnosis) -> bytes:
    """The page of the filter that is called so, as HTML."""
    probes = [
        f"<strong>{'passed' if p.passed else 'FAILED'}</strong> <code>{p.code}</code> {escape(p.message)}"
        for p in sorted(found.probes, key=lambda probe: probe.passed)
    ]
    notes = [f"<code>{note.code}</code> {escape(note.message)}" for note in found.notes]
    parts = [
        *(html_page.badge(sentence, passed=found.passed) for sentence in found.sentences),
        html_page.picture(lambda width: _draw(found, width)) if found.errors else "",
        f"<h2>Mistakes</h2>{mistakes(found)}" if found.mistakes else "",
        html_page.listing("Probes", probes),
        html_page.listing("Notes", notes),
        *map(html_page.paragraph, found.remarks),
        html_page.paragraph(
            f"{found.filter_runs} runs of the filter, with perfect sensors but where a probe says otherwise. Nothing "
            f"is looked for below {found.floor_deg:.2g}°, a tenth of the turn between two readings."
        ),
    ]
    return html_page.document(f"Diagnosis of {name}", filter(None, parts))


def mistakes(found: FilterDiagnosis) -> str:
    """Table of the mistakes as HTML."""
    headings = ("mistake", "repair", "error before", "error after", "does as well")
    return html_page.table(headings, [(cells, True) for cells in _cells(found)])


def _draw(found: FilterDiagnosis, width: float) -> Figure:
    """The total error before and after each named repair."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, 3.8), layout="constrained")
    axes = figure.subplots()
    for number, each in enumerate(found.errors):
        errors = np.maximum(each.error_deg, _SMALLEST_DEG)  # those of a right filter may be 0
        label = f"{each.code} repaired" if each.code else "as it is"
        axes.plot(each.t_s, errors, color=_COLOURS[number % len(_COLOURS)], label=label)
    axes.axhline(found.floor_deg, color="#888888", linestyle=":", label="floor")
    axes.set(xlabel="time, s", ylabel="total error, °", yscale="log")
    axes.margins(x=0.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4 if width > 5.0 else 2, frameon=False)
    return figure
