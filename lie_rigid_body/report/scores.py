"""Scores of one estimate or of several: an answer for people, JSON, and a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
from lie_rigid_body.evaluation.clock import SIGNIFICANT
from lie_rigid_body.evaluation.consistency import PROBABILITY, Consistency
from lie_rigid_body.evaluation.score import BiasEstimate, Score
from lie_rigid_body.evaluation.statistics import MAX_SETTLED_DEG, MIN_LIMIT, Limits, Statistics
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import counted, in_degrees, printable, shortened
from lie_rigid_body.report import answer, html_page
from lie_rigid_body.report.answer import Conclusion, Parts, Picture, Sentences, Table
from lie_rigid_body.report.drawing import BLACK, BLUE, COLOURS, GREEN, ORANGE, PINK, RED, draw_curve, finish, label, png

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Scored: TypeAlias = Sequence[tuple[RecordedEstimate, Score]]
"""Estimates with their scores."""
Panel: TypeAlias = "tuple[Callable[[Axes], None], str]"
"""Panel of a figure: what draws it, and the label of its axis."""

_HEADINGS: Final = (
    "estimate",
    "total",
    "heading",
    "inclination",
    "95 %",
    "settles",
    "lag",
    "NEES",
    "gyro bias",
    "findings",
)
WITHOUT_DYNAMICS: Final = "Cramér–Rao bound of filters that do not know the dynamics"
_SOURCE: Final = "Errors as defined by BROAD (Data 6(7):72, 2021)"

_MAX_LINE: Final = 110
"""Number of characters of a line of the title that the figure has room for."""
_WIDE_SPAN: Final = 30.0
"""Ratio of the largest error to the median above which the axis is logarithmic."""


def as_text(score: Score) -> str:
    """Lines of a score in arrays, for a terminal."""
    notes = Sentences([note.message for note in score.notes], "Notes")
    return answer.as_text([Sentences(score.remarks), _verdict(score), *tables(score), _findings(score), notes])


def parts(read: RecordedEstimate | None, score: Score) -> Parts:
    """Answer about the score of an estimate that was read, or of one in arrays."""
    return [
        Sentences(score.remarks),
        _verdict(score),
        Sentences([summary(score)]),
        Picture(lambda: html_page.picture(partial(draw, "", score))),
        *tables(score),
        _findings(score),
        Sentences([*(note.message for note in score.notes), *(read.notes if read else ())], "Notes"),
        Sentences([f"{extent(read, score)}.", f"{_SOURCE}."]),
    ]


def parts_of_several(scored: Scored) -> Parts:
    """Answer about the scores of several estimates."""
    return [
        Sentences([*dict.fromkeys(sentence for _, score in scored for sentence in score.remarks)]),
        *(_verdict(score, f"{read.track.topic}: ") for read, score in scored if not score.passed),
        Table(
            _HEADINGS,
            [_cells(*each) for each in scored],
            marked=[not score.passed for _, score in scored],
        ),
        Picture(lambda: html_page.picture(partial(curves, "", scored))),
        Sentences([f"{_SOURCE}; RMS and 95 % of the total error, degrees."]),
        *(_findings(score, f"Findings of {read.track.topic}") for read, score in scored if score.findings),
    ]


def _cells(read: RecordedEstimate, score: Score) -> list[str]:
    """Cells of a score under `_HEADINGS`."""
    converged = score.time_to_converge_s
    lag = score.lag_s
    return [
        read.track.topic,
        *(in_degrees(angle.rms) for angle in (score.total_deg, score.heading_deg, score.inclination_deg)),
        in_degrees(score.total_deg.p95),
        "never" if converged is None else f"{converged:.3g} s",
        "" if lag is None else f"{round(lag, 9):+.2g} s",
        "" if score.consistency is None else f"{score.consistency.mean:.3g}",
        "" if score.gyro_bias_rad_s is None else f"{score.gyro_bias_rad_s.rms:.2g} rad/s",
        " ".join(finding.code for finding in score.findings),
    ]


def _verdict(score: Score, name: str = "") -> Conclusion:
    """Sentences about whether limits are kept; none if none were given."""
    kept = [] if score.limits == Limits() else ["PASSED: every limit is kept."]
    return Conclusion([f"BROKEN: {name}{sentence}." for sentence in score.broken] or kept, score.passed)


def _findings(score: Score, heading: str = "Findings") -> Sentences:
    """Findings under their codes; if there is none, a sentence that says so, with a warning of large errors."""
    is_late = score.lag_s is not None and abs(score.lag_s) > SIGNIFICANT * (score.lag_standard_error_s or 0.0)
    large = score.total_deg.median > MAX_SETTLED_DEG and not is_late and not score.remarks
    hint = ": no known mistake in the output explains errors this large; diagnose tests what the filter reads"
    found = [f"{finding.code}: {finding.message}" for finding in score.findings]
    return Sentences(found, heading) if found else Sentences([f"No findings{hint * large}."])


def tables(score: Score) -> list[Table]:
    """Statistics of the errors and of the bounds, and what else the score tells."""
    names = ("rms", "median", "95 %", "largest", "final")
    rows = [
        (name, *(in_degrees(value).removesuffix("°") for value in asdict(found).values()))
        for name, found in _angles(score)
    ]
    return [Table(("error, deg", *names), rows), Table((), [*_facts(score)])]


def _angles(score: Score) -> Iterator[tuple[str, Statistics]]:
    """Statistics of the three errors by name, and of the Cramér–Rao bounds of the total error, where they are known."""
    yield "total", score.total_deg
    yield "heading", score.heading_deg
    yield "inclination", score.inclination_deg
    best = score.best
    bounds = {"": best, "calibrated ": best and best.calibrated, "dynamic ": best and best.dynamic}
    for name, bound in bounds.items():
        if bound and bound.filtered and bound.smoothed:
            yield f"bound, {name}filter", bound.filtered
            yield f"bound, {name}smoother", bound.smoothed


def _facts(score: Score) -> Iterator[tuple[str, str]]:
    """Other facts of a score, each a name and a sentence."""
    converged = score.time_to_converge_s
    limit = f"{score.converged_deg:.4g}°"
    if converged is None:
        yield "converged", f"never: the last error is above {limit}"
    elif score.settled_deg is None:
        yield "converged", f"{converged:.4g} s after the first, to below {limit}"
    else:
        yield "settles", f"to {in_degrees(score.settled_deg, 3)} or less, {converged:.4g} s after the first"
    if score.lag_s is None:
        yield "lag", "cannot be determined from this run"
    else:
        # stamps are whole nanoseconds
        yield "lag", f"{round(score.lag_s, 9) + 0.0:+.4g} s ± {score.lag_standard_error_s:.2g} s; positive is late"
    if score.of_sensors_deg is not None:
        yield (
            "sensors",
            f"a constant error of up to {score.of_sensors_deg:.2g}° is normal for a right filter with these",
        )
    if score.gyro_at_limit:
        share = f"{100.0 * score.gyro_at_limit:.3g} %"
        yield "gyro", f"at the limit of its range in {share} of the readings: the body turns faster"
    if score.truth_uncertainty_deg > MIN_LIMIT:
        yield "truth", f"uncertain by up to {score.truth_uncertainty_deg:.2g}° between its samples"
    if score.consistency:
        yield "NEES", score.consistency.sentence
        if score.consistency.remark:
            yield "remark", score.consistency.remark
    if bias := score.gyro_bias_rad_s:
        yield "gyro bias", f"off by {bias.rms:.4g} rad/s rms, {bias.final:.4g} rad/s at the end"
    if score.gyro_bias and (exact := score.gyro_bias.claimed_exact):
        count = f"{exact} of {counted(len(score.gyro_bias.stamps_ns), 'estimate')}"
        yield "remark", f"the covariance of the gyro's bias is 0 in {count} that are not exact: give its variance"
    if score.best and score.best.unobserved:
        yield "bound", f"not known: no sensor tells {score.best.unobserved}"
    elif score.best:
        dynamic = "; dynamic: of those that know the inertia and Euler's equations" if score.best.dynamic else ""
        yield "bound", f"{WITHOUT_DYNAMICS}{dynamic}"
        if score.best.carried:
            yield "bound", "that of the same run without acceleration, which counts as known along the body's axes"
    if score.best and score.best.beaten:
        yield (
            "remark",
            "the error is smaller than the noise leaves to filters that know the dynamics: the estimate has seen the "
            "truth, or the noise is not as declared",
        )


def as_json(bag: str | None, read: RecordedEstimate, score: Score, *, series: bool) -> dict[str, object]:
    """JSON-serialisable data of a score, with its source."""
    return {
        "bag": bag,
        "topic": read.track.topic,
        "type": read.track.message_type,
        "truth": read.motion.source,
        **score.to_dict(series=series),
        "remarks": [*score.remarks, *read.notes],
    }


def json_of_several(bag: str, scored: Scored, *, series: bool) -> dict[str, object]:
    """Data of several scores, for JSON."""
    return {
        "estimates": [as_json(bag, *each, series=series) for each in scored],
        "passed": all(score.passed for _, score in scored),
    }


def extent(read: RecordedEstimate | None, score: Score) -> str:
    """Sentence that says what was compared with what; without an estimate that was read for one in arrays."""
    kind = (
        ""
        if read is None or not read.track.message_type
        else f" of type {read.track.message_type.replace('/msg/', '/')}"
    )
    source = "" if read is None else f" ({read.motion.source})"
    first, last = (int(score.stamps_ns[i]) / 1e9 for i in (0, -1))  # times of day to milliseconds
    left_out = f"; {score.outside} more are outside of the truth's times" if score.outside else ""
    return (
        f"{score.samples} attitudes{kind}, stamped {first:.13g} s to {last:.13g} s, against the truth{source} at "
        f"these stamps{left_out}"
    )


def summary(score: Score) -> str:
    """Sentence that tells the size of the error."""
    total, heading, inclination = (
        in_degrees(error.rms, 3) for error in (score.total_deg, score.heading_deg, score.inclination_deg)
    )
    best = "" if score.best is None or score.best.filtered is None else score.best.filtered.rms
    least = f"; the {WITHOUT_DYNAMICS} is {best:.3g}°" if best else ""
    return f"The attitude error is {total} rms: heading {heading}, inclination {inclination}{least}."


def draw(title: str, score: Score) -> Figure:
    """Figure of a score: the errors over time, with the limits, the NEES with its bounds, and the gyro's bias.

    Parameters
    ----------
    title : str
        It may hold anything; without one nothing is above the panels.
    score : Score
    """
    nees = score.consistency
    bias = score.gyro_bias
    panels = [
        (partial(_draw_total, score=score), "error [deg]"),
        (partial(_draw_parts, score=score), "error [deg]"),
        *([(partial(_draw_nees, t_s=score.t_s, found=nees), "NEES")] if nees else []),
        *([(partial(_draw_bias, first_ns=score.stamps_ns[0], bias=bias), "gyro bias [rad/s]")] if bias else []),
    ]
    height = 1.0 * bool(title) + 1.2 + 2.0 * len(panels)
    rms = f"attitude error {in_degrees(score.total_deg.rms)} rms, {counted(score.samples, 'sample')}"
    return _figure([title, rms], height, panels)


def curves(title: str, scored: Scored) -> Figure:
    """Figure of the total errors of several estimates, under their topics; see `draw`."""
    panel = (partial(_draw_several, scored=scored), "total error [deg]")
    return _figure([title], 3.4 + 0.06 * len(scored), [panel])


def _figure(titles: Sequence[str], height: float, panels: Sequence[Panel]) -> Figure:
    """Panels one above the other, and titles above them."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, height), dpi=120, layout="constrained")
    figure._repr_png_ = partial(png, lambda: figure)  # type: ignore[attr-defined]  # by which a notebook shows it
    for (draw_panel, name), axes in zip(panels, np.ravel(figure.subplots(len(panels), sharex=True)), strict=True):
        draw_panel(axes)
        axes.margins(x=0.0)
        axes.set_ylabel(name)
        finish(axes, 4)
    axes.set_xlabel("time since the first estimate [s]")
    if titles[0]:
        # the names of a file and a topic may hold anything, and ``$`` is no formula
        above = [shortened(printable(title), _MAX_LINE) for title in titles]
        figure.suptitle("\n".join(above), fontsize=11, parse_math=False)
    return figure


def _draw_several(axes: Axes, scored: Scored) -> None:
    """Draw the total error of each estimate."""
    first_ns = min(score.stamps_ns[0] for _, score in scored)
    for number, (read, score) in enumerate(scored):
        name = label(f"{shortened(printable(read.track.topic), 30)}, {in_degrees(score.total_deg.rms)} rms")
        t_s = (score.stamps_ns - first_ns) / 1e9
        draw_curve(axes, t_s, np.degrees(score.error.total), f"C{number % 10}", name, 1.0)
    _scale(axes, [np.degrees(score.error.total) for _, score in scored])


def _draw_total(axes: Axes, score: Score) -> None:
    """Draw the total error, the Cramér–Rao bound and the limits, on a logarithmic axis where one of these is shown."""
    total = np.degrees(score.error.total)
    end = score.t_s[-1]
    axes.set_xlim(0.0, end or 1.0)
    drawn = [total]
    draw_curve(axes, score.t_s, total, BLACK, "total")
    if score.best is not None and not score.best.unobserved:
        drawn.append(score.best.filtered_deg)
        draw_curve(axes, score.t_s, score.best.filtered_deg, PINK, "Cramér–Rao bound")
    rms = score.limits.max_rms_deg
    limits = [] if rms is None else [(0.0, rms, ":", f"limit {rms:g}° rms")]
    limits += [(start, limit, "-", f"limit {limit:g}° from {start:g} s") for start, limit in score.limits.max_after]
    for start, limit, style, name in limits:
        axes.plot([min(start, end), end], [limit] * 2, color=RED, lw=1.3, ls=style, label=name)
    _scale(axes, [*drawn, *(np.array([limit]) for _, limit, _, _ in limits)])
    if score.time_to_converge_s:
        axes.axvline(score.time_to_converge_s, color=GREEN, lw=1.0, ls="--", label="settled")


def _draw_parts(axes: Axes, score: Score) -> None:
    """Draw the heading and the inclination error."""
    heading = np.degrees(score.error.heading)
    inclination = np.degrees(score.error.inclination)
    draw_curve(axes, score.t_s, heading, BLUE, "heading")
    draw_curve(axes, score.t_s, inclination, ORANGE, "inclination")
    _scale(axes, [np.maximum(heading, inclination)])


def _draw_nees(axes: Axes, t_s: Array, found: Consistency) -> None:
    draw_curve(axes, t_s, found.nees, BLACK, "NEES", 0.9)
    axes.axhspan(*found.bounds, color=GREEN, alpha=0.2, lw=0.0, label=f"{PROBABILITY:.0%} bounds")
    axes.set_yscale("log")


def _draw_bias(axes: Axes, first_ns: int, bias: BiasEstimate) -> None:
    """Draw the estimated biases of the gyro, each beside the true one."""
    t_s = (bias.stamps_ns - first_ns) / 1e9
    for name, colour, estimate, truth in zip("xyz", COLOURS, bias.estimate.T, bias.truth.T, strict=True):
        draw_curve(axes, t_s, estimate, colour, f"estimated {name}")
        draw_curve(axes, t_s, truth, colour, f"true {name}", ls="--")


def _scale(axes: Axes, curves: Sequence[Array]) -> None:
    """Choose the scale and the range of an axis of errors: several curves or limits may be of any sizes."""
    top = max(curve.max() for curve in curves)
    positive = [curve[curve > 0.0] for curve in curves if (curve > 0.0).any()]
    wide = top > _WIDE_SPAN * np.median(curves[0]) > 0.0
    if positive and (wide or len(curves) > 1):
        bottom = max(min(np.percentile(curve, 1.0) for curve in positive), 1e-6 * curves[0].max())
        axes.set(yscale="log", ylim=(bottom / 1.5, 1.5 * top))
    else:
        axes.set_ylim(0.0, 1.05 * top or 1.0)
