"""Scores of one estimate or of several: a table, JSON, a picture, and a page that needs no network."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain, combinations
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
from lie_rigid_body.evaluation.attitudes import GAP_PERIODS
from lie_rigid_body.evaluation.consistency import Consistency
from lie_rigid_body.evaluation.differences import Difference, of_run
from lie_rigid_body.evaluation.score import (
    HEADINGS,
    BiasEstimate,
    Score,
    angles,
    facts,
    findings,
    numbers,
    table,
    verdict,
    wrapped,
)
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import counted, printable, shortened
from lie_rigid_body.report import html_page
from lie_rigid_body.report.drawing import BLACK, BLUE, COLOURS, GREEN, ORANGE, PINK, RED, png
from lie_rigid_body.report.html_page import escaped
from lie_rigid_body.report.recorded_motion import curve_style, extremes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Scored: TypeAlias = Sequence[tuple[RecordedEstimate, Score]]
"""Estimates with their scores."""
Panel: TypeAlias = "tuple[Callable[[Axes], None], str, int]"
"""Panel of a figure: what draws it, the label of its axis, and the number of columns of its legend."""

_HEADINGS: Final = (
    "estimate",
    "total",
    "heading",
    "inclination",
    "95 %",
    "converges",
    "lag",
    "NEES",
    "gyro bias",
    "findings",
)
_WIDTHS: Final = "{:<22} {:>8} {:>8} {:>11} {:>8} {:>9} {:>10} {:>6} {:>12}  {}"
_SOURCE: Final = "Errors as defined by BROAD (Data 6(7):72, 2021)"

SCORE_COLUMNS: Final = 2000
"""Number of intervals of time of a long curve, so that no peak is lost."""
_LONGEST_LINE: Final = 110
"""Number of characters of a line of the title that the figure has room for."""
_WIDE_SPAN: Final = 30.0
"""Ratio of the largest error to the median above which the axis is logarithmic, and of a limit that is far beyond."""
_NARROW: Final = 5.0
"""Width, inches, up to which a figure is for the screen of a phone."""


def as_table(title: str, read: RecordedEstimate, score: Score) -> str:
    """Lines of a score for a terminal, without a final newline."""
    notes = (line for note in read.notes for line in wrapped(note, "note: "))
    sentences = chain(findings(score), *map(wrapped, verdict(score)))
    return "\n".join([printable(title), *wrapped(extent(read, score)), "", *table(score), "", *notes, *sentences])


def table_of_several(title: str, scored: Scored) -> str:
    """Lines of several scores for a terminal, without a final newline."""
    rows = [_WIDTHS.format(*cells) for cells in (_HEADINGS, *(_cells(*each) for each in scored))]
    return "\n".join([printable(title), "", *rows, "", *chain.from_iterable(map(wrapped, _sentences(scored)))])


def _cells(read: RecordedEstimate, score: Score) -> list[str]:
    """Cells of a score under `_HEADINGS`."""
    converged, lag = score.time_to_converge_s, score.lag_s
    return [
        printable(read.track.topic),
        *(f"{angle.rms:.4g}°" for angle in (score.total_deg, score.heading_deg, score.inclination_deg)),
        f"{score.total_deg.p95:.4g}°",
        "never" if converged is None else f"{converged:.3g} s",
        "" if lag is None else f"{lag:+.2g} s",
        "" if score.consistency is None else f"{score.consistency.mean:.3g}",
        "" if score.gyro_bias_rad_s is None else f"{score.gyro_bias_rad_s.rms:.2g} rad/s",
        " ".join(finding.code for finding in score.findings),
    ]


def _sentences(scored: Scored) -> Iterator[str]:
    """What is said of several scores: the difference of each pair, and the limits that are broken."""
    yield from (f"{difference.sentence(*names)}." for names, difference in differences(scored))
    for read, score in scored:
        yield from (f"{read.track.topic}: {sentence}" for sentence in verdict(score) if not score.passed)


def differences(scored: Scored) -> Iterator[tuple[tuple[str, str], Difference]]:
    """Differences of the RMS of the total error, degrees, of every pair at the stamps that both have, by the topics."""
    for (first, left), (second, right) in combinations(scored, 2):
        _, of_left, of_right = np.intersect1d(left.stamps_ns, right.stamps_ns, return_indices=True)
        difference = of_run(np.degrees(left.error.total[of_left]), np.degrees(right.error.total[of_right]))
        yield (first.track.topic, second.track.topic), difference


def as_json(bag: str | None, read: RecordedEstimate, score: Score, *, series: bool) -> dict[str, object]:
    """JSON-serialisable data of a score, with its source."""
    return {
        "bag": bag,
        "topic": read.track.topic,
        "type": read.track.message_type,
        "truth": read.motion.source,
        **score.to_dict(series=series),
        "notes": list(read.notes),
    }


def json_of_several(bag: str, scored: Scored, *, series: bool) -> dict[str, object]:
    """Data of several scores and of the differences of each pair, for JSON; an interval may be infinite."""
    return {
        "estimates": [as_json(bag, *each, series=series) for each in scored],
        "differences": [
            {
                "first": first,
                "second": second,
                "value_deg": difference.value,
                "low_deg": difference.low,
                "high_deg": difference.high,
                "sentence": difference.sentence("the first", "the second"),
            }
            for (first, second), difference in differences(scored)
        ],
        "passed": all(score.passed for _, score in scored),
    }


def extent(read: RecordedEstimate | None, score: Score) -> str:
    """Sentence that says what was compared with what; without an estimate that was read for one in arrays."""
    kind = "" if read is None else f" of type {read.track.message_type.replace('/msg/', '/')}"
    source = "" if read is None else f" ({read.motion.source})"
    first, last = (int(score.stamps_ns[i]) / 1e9 for i in (0, -1))  # times of day to milliseconds
    left_out = f"; {score.outside} more are outside of the truth's times" if score.outside else ""
    return (
        f"{score.samples} attitudes{kind}, stamped {first:.13g} s to {last:.13g} s, against the truth{source} at "
        f"these stamps{left_out}"
    )


def summary(score: Score) -> str:
    """Sentence that tells the size of the error."""
    heading, inclination = (f"{angle.rms:.3g}°" for angle in (score.heading_deg, score.inclination_deg))
    best = "" if score.best is None or score.best.filtered is None else score.best.filtered.rms
    least = f"; the noise of the sensors leaves {best:.3g}° to the best filter" if best else ""
    return f"The attitude error is {score.total_deg.rms:.3g}° rms: heading {heading}, inclination {inclination}{least}."


def tables(score: Score) -> list[str]:
    """Statistics of the errors, and what else the score tells, as tables of HTML."""
    return [
        html_page.table(("error, deg", *HEADINGS), [((name, *numbers(found)), True) for name, found in angles(score)]),
        html_page.table(("", ""), [((name, value), True) for name, value in facts(score)]),
    ]


def page(title: str, read: RecordedEstimate | None, score: Score) -> bytes:
    """Make the page of a score.

    Parameters
    ----------
    title : str
    read : RecordedEstimate or None
        None of an estimate in arrays.
    score : Score

    Returns
    -------
    bytes
        HTML.
    """
    parts = [
        *(html_page.badge(sentence, passed=score.passed) for sentence in verdict(score)),
        html_page.paragraph(summary(score)),
        html_page.picture(lambda width: draw("", score, width)),
        _findings("Findings", score, "None."),
        html_page.listing("Notes", map(escaped, read.notes if read else ())),
        "<h2>Errors</h2>",
        *tables(score),
        html_page.paragraph(f"{extent(read, score)}."),
        *map(html_page.scenario, read.motion.segments if read else ()),
        html_page.paragraph(f"{_SOURCE}."),
    ]
    return html_page.document(title, parts)


def page_of_several(title: str, scored: Scored) -> bytes:
    """Make the page of several scores."""
    parts = [
        *map(html_page.paragraph, _sentences(scored)),
        html_page.picture(lambda width: curves("", scored, width)),
        *(_findings(escaped(read.track.topic), score, "No findings.") for read, score in scored),
        "<h2>Errors</h2>",
        html_page.table(_HEADINGS, [(_cells(*each), each[1].passed) for each in scored]),
        html_page.paragraph(f"{_SOURCE}; RMS and 95 % of the total error, degrees."),
    ]
    return html_page.document(title, parts)


def _findings(heading: str, score: Score, none: str) -> str:
    return html_page.listing(heading, (f"<code>{f.code}</code> {escaped(f.message)}" for f in score.findings), none)


def draw(title: str, score: Score, width: float = 10.0) -> Figure:
    """Figure of a score: the errors over time, with the limits, the NEES with its bounds, and the gyro's bias.

    Parameters
    ----------
    title : str
        It may hold anything; without one nothing is above the panels.
    score : Score
    width : float, optional
        Width, inches; a narrow one is for the screen of a phone.
    """
    columns = 5 if width > _NARROW else 2
    nees, bias = score.consistency, score.gyro_bias
    panels: list[Panel] = [
        (partial(_draw_total, score=score), "error [deg]", columns),
        (partial(_draw_parts, score=score), "error [deg]", columns),
        *([(partial(_draw_nees, t_s=score.t_s, found=nees), "NEES", columns)] if nees else []),
        *([(partial(_draw_bias, first_ns=score.stamps_ns[0], bias=bias), "gyro bias [rad/s]", 3)] if bias else []),
    ]
    height = 1.0 * bool(title) + 1.2 + (2.0 if width > _NARROW else 1.7) * len(panels)
    rms = f"attitude error {score.total_deg.rms:.4g}° rms, {counted(score.samples, 'sample')}"
    return _figure([title, rms], (width, height), panels)


def curves(title: str, scored: Scored, width: float = 10.0) -> Figure:
    """Figure of the total errors of several estimates, under their topics; see `draw`."""
    columns = 2 if width > _NARROW else 1
    size = (width, 3.4 + 0.25 * len(scored) / columns)
    return _figure([title], size, [(partial(_draw_several, scored=scored), "total error [deg]", columns)], "left")


def _figure(titles: Sequence[str], size: tuple[float, float], panels: Sequence[Panel], side: str = "right") -> Figure:
    """Panels one above the other, and titles above them."""
    from matplotlib.figure import Figure

    figure, place = Figure(figsize=size, dpi=120, layout="constrained"), float(side == "right")
    figure._repr_png_ = partial(png, lambda: figure)  # type: ignore[attr-defined]  # by which a notebook shows it
    for (draw_panel, label, columns), axes in zip(
        panels, np.ravel(figure.subplots(len(panels), sharex=True)), strict=True
    ):
        draw_panel(axes)
        axes.margins(x=0.0)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3, lw=0.6)
        axes.legend(loc=f"lower {side}", bbox_to_anchor=(place, 1.0), ncols=columns, frameon=False, borderaxespad=0.1)
    axes.set_xlabel("time since the first estimate [s]")
    if titles[0]:
        # the names of a file and a topic may hold anything, and ``$`` is no formula
        above = [shortened(printable(title), _LONGEST_LINE) for title in titles]
        figure.suptitle("\n".join(above), fontsize=11, parse_math=False)
    return figure


def _plot(axes: Axes, t_s: Array, values: Array, label: str, colour: str, width: float = 1.1, style: str = "-") -> None:
    """Plot some thousand points of a curve, the smallest and the largest of their neighbours, and none in a gap."""
    steps = np.diff(t_s)
    behind = np.flatnonzero(steps > GAP_PERIODS * np.median(steps)) + 1 if steps.size else np.empty(0, dtype=np.int64)
    kept = np.union1d(extremes(t_s, values, SCORE_COLUMNS), behind)
    points = [np.insert(array[kept], np.searchsorted(kept, behind), np.nan) for array in (t_s, values)]
    axes.plot(*points, color=colour, ls=style, label=label, **curve_style(len(values), width))


def _draw_several(axes: Axes, scored: Scored) -> None:
    """Draw the total error of each estimate."""
    first_ns = min(int(score.stamps_ns[0]) for _, score in scored)
    for number, (read, score) in enumerate(scored):
        label = f"{shortened(printable(read.track.topic), 30)}, {score.total_deg.rms:.4g}° rms".replace("$", r"\$")
        _plot(axes, (score.stamps_ns - first_ns) / 1e9, np.degrees(score.error.total), label, f"C{number % 10}", 1.0)
    _scale(axes, [np.degrees(score.error.total) for _, score in scored])


def _draw_total(axes: Axes, score: Score) -> None:
    """Draw the total error, the best by noise and the limits, on a logarithmic axis where one of these is shown."""
    total, end = np.degrees(score.error.total), float(score.t_s[-1])
    axes.set_xlim(0.0, end or 1.0)
    drawn = [total]
    _plot(axes, score.t_s, total, "total", BLACK)
    if score.best is not None and not score.best.unobserved:
        drawn.append(score.best.filtered_deg)
        _plot(axes, score.t_s, score.best.filtered_deg, "best by noise", PINK)
    rms = score.limits.max_rms_deg
    limits = [] if rms is None else [(0.0, rms, ":", f"limit {rms:g}° rms")]
    limits += [(start, limit, "-", f"limit {limit:g}° from {start:g} s") for start, limit in score.limits.max_after]
    low, high = _scale(axes, drawn, [limit for _, limit, _, _ in limits])
    for start, limit, style, name in limits:
        where = ", far above" if limit > high else ", far below" if limit < low else ""
        axes.plot([min(start, end), end], [limit] * 2, color=RED, lw=1.3, ls=style, label=f"{name}{where}")
    if score.time_to_converge_s:
        axes.axvline(score.time_to_converge_s, color=GREEN, lw=1.0, ls="--", label="converged")


def _draw_parts(axes: Axes, score: Score) -> None:
    """Draw the heading and the inclination error."""
    heading, inclination = np.degrees(score.error.heading), np.degrees(score.error.inclination)
    _plot(axes, score.t_s, heading, "heading", BLUE)
    _plot(axes, score.t_s, inclination, "inclination", ORANGE)
    _scale(axes, [np.maximum(heading, inclination)])


def _draw_nees(axes: Axes, t_s: Array, found: Consistency) -> None:
    _plot(axes, t_s, found.nees, "NEES", BLACK, 0.9)
    axes.axhspan(*found.bounds, color=GREEN, alpha=0.2, lw=0.0, label=f"{found.probability:.0%} bounds")
    axes.set_yscale("log")


def _draw_bias(axes: Axes, first_ns: int, bias: BiasEstimate) -> None:
    """Draw the estimated biases of the gyro, each beside the true one."""
    t_s = (bias.stamps_ns - first_ns) / 1e9
    for name, colour, estimate, truth in zip("xyz", COLOURS, bias.estimate.T, bias.truth.T, strict=True):
        _plot(axes, t_s, estimate, f"estimated {name}", colour)
        _plot(axes, t_s, truth, f"true {name}", colour, style="--")


def _scale(axes: Axes, curves: Sequence[Array], limits: Sequence[float] = ()) -> tuple[float, float]:
    """Choose the scale and the range of an axis of errors, and return its ends.

    Several curves, or one and limits, may be of any sizes: they have a logarithmic axis. The range is that of the
    curves, so that no limit flattens them: the legend alone tells of one that is far beyond.
    """
    top = max(float(curve.max()) for curve in curves)
    positive = [curve[curve > 0.0] for curve in curves if (curve > 0.0).any()]
    wide = top > _WIDE_SPAN * float(np.median(curves[0])) > 0.0
    if not positive or not (wide or limits or len(curves) > 1):
        high = 1.05 * top or 1.0
        axes.set_ylim(0.0, high)
        return 0.0, high
    bottom = max(min(float(np.percentile(curve, 1.0)) for curve in positive), 1e-6 * top)
    near = [limit for limit in limits if bottom / _WIDE_SPAN <= limit <= _WIDE_SPAN * top]
    low, high = min([bottom, *near]) / 1.5, max([top, *near]) * 1.5
    axes.set(yscale="log", ylim=(low, high))
    return low, high
