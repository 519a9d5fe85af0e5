"""A score as a table for people and as JSON for programs."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Final

from lie_rigid_body.evaluation import Limits, Score, Statistics
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate

_WIDTH: Final = 88
"""Characters of a line of sentences."""
HEADINGS: Final = ("rms", "median", "95 %", "largest", "final")
"""Of the columns of statistics."""


def as_table(title: str, read: RecordedEstimate, score: Score, limits: Limits) -> str:
    """The score in lines for a terminal, without a final newline."""
    lines = [title, *_wrapped(extent(read, score)), ""]
    lines.append(f"{'error, deg':<14}" + "".join(f"{heading:>11}" for heading in HEADINGS))
    for name, statistics in angles(score):
        lines.append(f"{name:<14}" + "".join(f"{number:>11}" for number in numbers(statistics)))
    lines += ["", *(f"{name:<14}{value}" for name, value in facts(score))]
    for note in read.notes:
        lines += _wrapped(note, "note: ")
    lines.append("")
    lines += _findings(score)
    lines += [line for sentence in verdict(score, limits) for line in _wrapped(sentence)]
    return "\n".join(lines)


def as_json(bag: str, read: RecordedEstimate, score: Score, *, series: bool) -> dict[str, object]:
    """The score as JSON-serialisable data, with where it is from."""
    return {
        "bag": bag,
        "topic": read.track.topic,
        "type": read.track.message_type,
        "truth": read.source,
        **score.to_json(series=series),
        "notes": list(read.notes),
    }


def extent(read: RecordedEstimate, score: Score) -> str:
    """What was compared with what, in a sentence."""
    kind = read.track.message_type.replace("/msg/", "/")
    first, last = (int(score.stamps_ns[i]) / 1e9 for i in (0, -1))
    left_out = f"; {score.outside} more are outside of the truth's times" if score.outside else ""
    return (
        f"{score.samples} of {kind}, stamped {first:.9g} s to {last:.9g} s, against the truth ({read.source}) at "
        f"these stamps{left_out}"
    )


def angles(score: Score) -> Iterator[tuple[str, Statistics]]:
    """The three errors by name."""
    yield "total", score.total_deg
    yield "heading", score.heading_deg
    yield "inclination", score.inclination_deg


def numbers(statistics: Statistics) -> list[str]:
    """The statistics as text, in the order of `HEADINGS`."""
    return [f"{value:.4g}" for value in statistics.to_json().values()]


def facts(score: Score) -> Iterator[tuple[str, str]]:
    """What else the score tells, by name."""
    if score.time_to_converge_s is None:
        yield "converged", f"never: the last error is above {score.converged_deg:.4g}°"
    else:
        yield "converged", f"{score.time_to_converge_s:.4g} s after the first, to below {score.converged_deg:.4g}°"
    if score.lag_s is None:
        yield "lag", "not told by this motion"
    else:
        yield "lag", f"{score.lag_s:+.4g} s ± {score.lag_standard_error_s:.2g} s; positive is late"
    consistency = score.consistency
    if consistency is not None:
        low, high = consistency.mean_bounds
        yield (
            "NEES",
            f"{consistency.mean:.4g} on average, expected {consistency.dimension} "
            f"({low:.3g} to {high:.3g} if errors were independent): {consistency.verdict}",
        )


def verdict(score: Score, limits: Limits) -> list[str]:
    """Whether limits are kept, in sentences; none if none were given."""
    broken = [f"BROKEN: {sentence}." for sentence in score.broken]
    return broken or ([] if limits == Limits() else ["PASSED: every limit is kept."])


def _findings(score: Score) -> Iterator[str]:
    for finding in score.findings:
        yield from _wrapped(finding.message, f"{finding.code}: ")
    if not score.findings:
        yield "no findings"


def _wrapped(sentence: str, mark: str = "") -> list[str]:
    return textwrap.wrap(sentence, _WIDTH, initial_indent=mark, subsequent_indent="  ")
