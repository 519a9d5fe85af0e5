"""A score as a table for people and as JSON for programs."""

from __future__ import annotations

from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.score import findings, table, verdict, wrapped
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate
from lie_rigid_body.wording import printable


def as_table(title: str, read: RecordedEstimate, score: Score) -> str:
    """Lines of a score for a terminal, without a final newline."""
    lines = [printable(title), *wrapped(extent(read, score)), ""]
    lines += [*table(score), ""]
    for note in read.notes:
        lines += wrapped(note, "note: ")
    lines += findings(score)
    lines += [line for sentence in verdict(score) for line in wrapped(sentence)]
    return "\n".join(lines)


def as_json(bag: str | None, read: RecordedEstimate, score: Score, *, series: bool) -> dict[str, object]:
    """JSON-serialisable data of a score, with its source."""
    return {
        "bag": bag,
        "topic": read.track.topic,
        "type": read.track.message_type,
        "truth": read.source,
        **score.to_json(series=series),
        "notes": list(read.notes),
    }


def extent(read: RecordedEstimate | None, score: Score) -> str:
    """Sentence that says what was compared with what; without an estimate that was read for one in arrays."""
    kind = "attitudes" if read is None else read.track.message_type.replace("/msg/", "/")
    source = "" if read is None else f" ({read.source})"
    first, last = (int(score.stamps_ns[i]) / 1e9 for i in (0, -1))  # times of day to milliseconds
    left_out = f"; {score.outside} more are outside of the truth's times" if score.outside else ""
    return (
        f"{score.samples} of {kind}, stamped {first:.13g} s to {last:.13g} s, against the truth{source} at "
        f"these stamps{left_out}"
    )
