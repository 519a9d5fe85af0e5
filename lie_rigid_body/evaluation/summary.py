"""A score in words and columns, for terminals, pages and the messages of tests."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Final

from lie_rigid_body.evaluation.limits import Limits
from lie_rigid_body.evaluation.scoring import LARGEST_SETTLED_DEG, Score
from lie_rigid_body.evaluation.statistics import SMALLEST_LIMIT, Statistics

WIDTH: Final = 88
"""Characters of a line of sentences."""
HEADINGS: Final = ("rms", "median", "95 %", "largest", "final")
"""Of the columns of statistics."""


def table(score: Score) -> list[str]:
    """Statistics of the errors and of the best possible, and below what else the score tells, in aligned columns."""
    return [
        f"{'error, deg':<14}" + "".join(f"{heading:>11}" for heading in HEADINGS),
        *(f"{name:<14}" + "".join(f"{n:>11}" for n in numbers(statistics)) for name, statistics in angles(score)),
        "",
        *(f"{name:<14}{value}" for name, value in facts(score)),
    ]


def findings(score: Score) -> list[str]:
    """Each finding under its code, wrapped; that there is none is said with a warning where it errs by much."""
    found = [line for finding in score.findings for line in wrapped(finding.message, f"{finding.code}: ")]
    large = score.total_deg.median > LARGEST_SETTLED_DEG
    return found or [f"no findings{': no mistake that is known explains errors as large' if large else ''}"]


def angles(score: Score) -> Iterator[tuple[str, Statistics]]:
    """The three errors by name, and the total at best, by the noise of the sensors, where it is known."""
    yield "total", score.total_deg
    yield "heading", score.heading_deg
    yield "inclination", score.inclination_deg
    if score.best is not None and score.best.filtered and score.best.smoothed:
        yield "best filter", score.best.filtered
        yield "best smoother", score.best.smoothed


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
        yield "lag", "not told by this motion and these errors"
    else:
        yield "lag", f"{score.lag_s:+.4g} s ± {score.lag_standard_error_s:.2g} s; positive is late"
    if score.truth_uncertainty_deg > SMALLEST_LIMIT:
        yield "truth", f"uncertain by up to {score.truth_uncertainty_deg:.2g}° between its samples"
    consistency = score.consistency
    if consistency is not None:
        low, high = consistency.mean_bounds
        yield (
            "NEES",
            f"{consistency.mean:.4g} on average, expected {consistency.dimension} "
            f"({low:.3g} to {high:.3g} if errors were independent): {consistency.verdict}",
        )
        if consistency.remark:
            yield "remark", consistency.remark
    if score.best is not None and score.best.unobserved:
        yield "best filter", f"not known: no sensor tells {score.best.unobserved}"
    if score.best is not None and score.best.beaten:
        yield "remark", "nearer than noise allows: it has seen the truth, or the noise is not as declared"


def verdict(score: Score) -> list[str]:
    """Whether limits are kept, in sentences; none if none were given."""
    broken = [f"BROKEN: {sentence}." for sentence in score.broken]
    return broken or ([] if score.limits == Limits() else ["PASSED: every limit is kept."])


def wrapped(sentence: str, mark: str = "") -> list[str]:
    """A sentence in lines for a terminal, the first after a mark."""
    return textwrap.wrap(sentence, WIDTH, initial_indent=mark, subsequent_indent="  ")
