"""A diagnosis as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from lie_rigid_body.diagnosis import FilterDiagnosis
from lie_rigid_body.diagnosis.result import degrees
from lie_rigid_body.evaluation.score import wrapped
from lie_rigid_body.wording import counted

_MISTAKES: Final = "{:<20} {:<18} {:>10} {:>10}  {}"
_PROBES: Final = "{:<20} {:<8} {:>10}  "


def as_text(found: FilterDiagnosis) -> str:
    """The sentences, the mistakes, the probes and the notes, without a final newline."""
    return "\n".join(_lines(found))


def _lines(found: FilterDiagnosis) -> Iterator[str]:
    for sentence in found.sentences:
        yield from wrapped(sentence)
    if found.mistakes:
        yield from ("", _MISTAKES.format("mistake", "repair", "before", "after", "does as well"))
    for m in found.mistakes:
        numbers = degrees(m.rms_deg_before), degrees(m.rms_deg_after)
        yield _MISTAKES.format(m.code, m.repair[:18], *numbers, ", ".join(m.or_else)).rstrip()
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
