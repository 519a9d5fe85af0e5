"""Answer about the estimators of a campaign."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import cycle
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.comparison import Comparison, EstimatorSummary
from lie_rigid_body.evaluation.differences import Difference, fewest_runs
from lie_rigid_body.evaluation.ensemble_consistency import MIN_RUNS, EnsembleConsistency
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.report import answer
from lie_rigid_body.report.answer import Parts, Picture, Sentences, Table
from lie_rigid_body.report.drawing import BLACK, DISTINCT, label
from lie_rigid_body.report.html_page import grid, plane
from lie_rigid_body.report.scores import WITHOUT_DYNAMICS
from lie_rigid_body.scenario.parameter_file import recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLUMNS: Final = (
    "estimator",
    "total",
    "heading",
    "inclination",
    "settles",
    "NEES",
    "gyro bias",
    "no answer",
    "time per reading",
)
_HEAD: Final = "Medians over the runs; 95 % of the runs are below the number in brackets."
_PAIRS: Final = {"total_rms_deg": "°", "heading_rms_deg": "°", "inclination_rms_deg": "°", "converged_s": " s"}
"""Scores of which the median and a larger one are told, and their units."""

_WIDE_SPAN: Final = 30.0
"""Ratio of the largest value to the smallest above which an axis is logarithmic."""

Shown = Sequence[tuple[EstimatorSummary, str]]
"""Estimators and their colours."""
Varied = Mapping[int, Mapping[str, Any]]
"""The parameters that vary, by the numbers of the runs."""


def as_text(comparison: Comparison) -> str:
    """Answer for a terminal: the estimators, each two of them, and sentences on grids, covariances and failures."""
    return answer.as_text([*_table(comparison), *_pairs(comparison), Sentences([*_sentences(comparison)])])


def parts(campaign: Campaign, comparison: Comparison, varied: Varied) -> Parts:
    """Answer for a page, with figures and the commands of the worst runs."""
    shown = [*zip(comparison.summaries, cycle(DISTINCT), strict=False)]
    return [
        *_table(comparison),
        Picture(lambda: grid(_errors_over_time(comparison, shown))),
        *_pairs(comparison),
        Picture(lambda: grid(_nees_over_time(shown))),
        Sentences([*_sentences(comparison)]),
        Picture(lambda: grid(_figures(shown, varied))),
        _worst_runs(campaign, comparison),
    ]


def _table(comparison: Comparison) -> Parts:
    summaries = comparison.summaries
    failed = [bool(one.failed.any()) for one in summaries]
    return [Table(_COLUMNS, [_cells(one) for one in summaries], "Estimators", failed), Sentences([_HEAD])]


def _pairs(comparison: Comparison) -> Parts:
    """Ratios of the errors of each two estimators: a sentence of two estimators, a matrix of more."""
    found = comparison.differences
    if len(found) <= 1:
        return [Sentences([f"{pair.sentence(first.name, second.name)}." for first, second, pair in found])]
    cells = {(first.name, second.name): _ratio(pair) for first, second, pair in found}
    names = [one.name for one in comparison.summaries]
    runs = sorted({pair.runs for _, _, pair in found})
    many = counted(len(found), "pair")
    few = f", {runs[0]} where one has a grid" if len(runs) > 1 else ""
    lost = " A run without an answer counts as 180°." * any(one.failed.any() for one in comparison.summaries)
    least = fewest_runs(len(found))
    short = f" At least {least} runs are needed for {many}." if runs[0] < least else ""
    return [
        Table(
            ("", *names[1:]),
            [(row, *(cells.get((row, column), "") for column in names[1:])) for row in names[:-1]],
            "Errors of the row divided by those of the column",
        ),
        Sentences(
            [
                f"By pairs over {runs[-1]} runs{few}, with intervals that hold together at 95 % for {many} (signed "
                f"ranks, Holm). not shown (f): so many runs would show a factor of f.{lost}{short}"
            ]
        ),
    ]


def _ratio(pair: Difference) -> str:
    """Cell of a pair in the matrix."""
    if pair.is_shown:
        return f"{pair.ratio:.3g}" + (f" ({pair.low:.3g} to {pair.high:.3g})" if pair.low else "")
    return f"not shown ({pair.factor:.3g})" if pair.low else "not shown"


def _cells(one: EstimatorSummary) -> list[str]:
    unit, size = ("µs", 1e-6) if one.reading_s < 1e-3 else ("ms", 1e-3)
    bias = one.quantile("gyro_bias_rms_rad_s", 0.5)
    return [
        one.name,
        *(
            _two(*(_number(one.quantile(column, share), unit) for share in (0.5, 0.95)))
            for column, unit in _PAIRS.items()
        ),
        _number(one.quantile("nees_mean", 0.5)),
        "" if np.isnan(bias) else f"{bias:.2g} rad/s",
        f"{np.sum(one.failed)}/{len(one.runs)}",
        _number(one.reading_s / size, f" {unit}"),
    ]


def _two(median: str, larger: str) -> str:
    """Median and 95 % of a score in one cell."""
    return f"{median} ({larger})" if median and median != larger else median


def _number(value: float, unit: str = "") -> str:
    return "" if np.isnan(value) else "never" if np.isinf(value) else f"{value:.3g}{unit}"


def _sentences(comparison: Comparison) -> Iterator[str]:
    for one in comparison.summaries:
        if one.points:
            yield from _of_grid(one)
        if one.reason:
            yield f"{one.name} failed in {np.sum(one.failed)} of {counted(len(one.runs), 'run')}, first: {one.reason}"
        if one.bias_claimed_exact:
            runs = counted(one.bias_claimed_exact, "run")
            yield f"{one.name}: the covariance of the gyro's bias is 0 beside an error in {runs}: give its variance."
        verdicts = {"": one.covariance, " (gyro bias)": one.gyro_bias}
        yield from (f"{one.name}{what}: {v.message}. {v.covered}." for what, v in verdicts.items() if v)
    if bound := comparison.bound:
        known = [one for one in comparison.summaries if not one.failed.all()]
        errors = [(one.name, one.scores["total_rms_deg"][one.runs == bound.run][0]) for one in known]
        larger = ", ".join(f"{name} {_number(error / bound.rms_deg)}" for name, error in errors)
        yield (
            f"Run {bound.run}: the {WITHOUT_DYNAMICS} is {_number(bound.rms_deg)}° on average over such runs. "
            f"Errors relative to it: {larger}."
        )
    if comparison.has_covariances and not comparison.independent:
        yield "Covariances are not judged: some runs have the same noise; draw sensor_seed by run."
    elif comparison.has_covariances and any(one.covariance for one in comparison.summaries):
        yield (
            "Verdicts on covariances hold for these sensors only: vary scale, mounting, hard and soft iron where a "
            "filter counts them as unknown."
        )
    elif comparison.has_covariances:
        yield f"Covariances are not judged: {MIN_RUNS} runs that have one are needed, outside of grids."


def _of_grid(one: EstimatorSummary) -> Iterator[str]:
    """Sentences on the points of a grid: which is best, whether that is shown, and which failed."""
    points = counted(len(one.points), "point")
    others = [point.difference for point in one.points if point.difference]
    if not all(np.isnan(each.mean_deg) for each in one.points):
        shown = sum(each.is_shown for each in others)
        best = f"{json.dumps(one.entry.parameters)} has the least geometric mean of errors of {points} in even runs"
        than = f"shown to be better than {shown} of the others" if shown else "no point is shown to be better"
        yield f"{one.name}: {best}; {than}; it is scored on odd ones."
        yield from _at_the_edge(one)
    if lost := [each for each in one.points if each.failures]:
        yield f"{one.name}: {len(lost)} of {points} failed in runs of even number, first: {lost[0].reason}"


def _at_the_edge(one: EstimatorSummary) -> Iterator[str]:
    """A hint for each parameter whose best value is the first or the last, and shown to be better than the next."""
    best = one.entry.parameters
    for name, values in one.entry.grid.items():
        if not _are_numbers(values):
            continue
        ranked = sorted(set(values))
        for end, following, further in ((ranked[0], ranked[1:2], "smaller"), (ranked[-1], ranked[-2:-1], "larger")):
            inward = {**best, name: following[0]} if following else None
            next_one = next((point.difference for point in one.points if point.parameters == inward), None)
            if best[name] == end and next_one and next_one.is_shown:
                yield f"{one.name}: {name} is best at the end of its grid: try {further} ones than {end:g}."


def _errors_over_time(comparison: Comparison, shown: Shown) -> Iterator[str]:
    known = [(one, colour) for one, colour in shown if len(one.curve_deg)]
    if known:
        caption = "Median over the runs, and the band that has 90 % of them."
        if bound := comparison.bound:
            caption += f" Dashed: the {WITHOUT_DYNAMICS}, of run {bound.run}."
        yield plane("Error over time", partial(_draw_errors, comparison=comparison, shown=known), caption)


def _draw_errors(axes: Axes, comparison: Comparison, shown: Shown) -> None:
    """Draw the median, and the band from the 5th to the 95th percentile, of the error of each estimator."""
    for one, colour in shown:
        known = ~np.isnan(one.curve_deg).all(axis=0)
        low, middle, high = np.nanquantile(one.curve_deg[:, known], (0.05, 0.5, 0.95), axis=0)
        axes.plot(comparison.t_s[known], middle, color=colour, label=label(one.name))
        axes.fill_between(comparison.t_s[known], low, high, color=colour, alpha=0.15, lw=0.0)
    if bound := comparison.bound:
        axes.plot(comparison.t_s, bound.curve_deg, "--", color=BLACK, label=f"bound, run {bound.run}")
    axes.set(xlabel="time, s", ylabel="total error, °")
    _scale(axes)


def _nees_over_time(shown: Shown) -> Iterator[str]:
    judged = [(one.name, colour, one.covariance) for one, colour in shown if one.covariance]
    if judged:
        caption = "Mean NEES over the runs; above the dashed line errors are larger than the covariance says."
        yield plane("Covariance over time", partial(_draw_nees, judged=judged), caption)


def _draw_nees(axes: Axes, judged: Sequence[tuple[str, str, EnsembleConsistency]]) -> None:
    for name, colour, found in judged:
        axes.plot(*np.transpose(found.over_time), color=colour, label=label(name))
    axes.axhline(judged[0][2].dimension, color=BLACK, ls="--", label="expected")
    axes.set(xlabel="time, s", ylabel="NEES", yscale="log")


def _worst_runs(campaign: Campaign, comparison: Comparison) -> Table:
    """The worst runs of every estimator, each once, with the errors of all and the command that makes it again."""
    runs = sorted({run for one in comparison.summaries if not one.failed.all() for run in one.worst(3)})
    totals = [dict(zip(one.runs.tolist(), one.scores["total_rms_deg"], strict=True)) for one in comparison.summaries]
    rows = [
        (
            str(run),
            *("" if run not in total else _number(total[run], "°") or "no answer" for total in totals),
            _command(campaign, run),
        )
        for run in runs
    ]
    return Table(("run", *(one.name for one in comparison.summaries), "command"), rows, "Worst runs")


def _figures(shown: Shown, varied: Varied) -> Iterator[str]:
    yield from (_grid(one) for one, _ in shown if one.points)
    for name in next(iter(varied.values()), {}):
        values = {run: parameters[name] for run, parameters in varied.items()}
        if name != "sensor_seed" and _are_numbers(values.values()):
            yield _over(name, values, shown)
        elif all(isinstance(value, list) and len(value) == 3 for value in values.values()):
            yield _over(
                f"the norm of {name}", {run: float(np.linalg.norm(value)) for run, value in values.items()}, shown
            )


def _are_numbers(values: Iterable[object]) -> bool:
    return all(type(value) in (int, float) for value in values)


def _scale(axes: Axes) -> None:
    """Make axes logarithmic where the largest value is more than 30 times the smallest."""
    box = axes.dataLim
    if box.y1 > _WIDE_SPAN * box.minposy:
        axes.set_yscale("log")
    elif box.y1 > 0.0:
        axes.set_ylim(0.0, 1.05 * box.y1)
    if box.x0 > 0.0 and box.x1 > _WIDE_SPAN * box.x0:
        axes.set_xscale("log")


def _grid(one: EstimatorSummary) -> str:
    """Geometric mean error of each point of a grid over its first parameter, a line for each choice of the others."""
    best = json.dumps(one.entry.parameters)
    caption = f"RMS of the total error on the runs of even number. The best point: {best}."
    return plane(f"Grid of {one.name}", partial(_draw_grid, one=one), caption)


def _draw_grid(axes: Axes, one: EstimatorSummary) -> None:
    name, *others = one.entry.grid
    are_numbers = _are_numbers(point.parameters[name] for point in one.points)
    lines: dict[str, list[tuple[Any, float]]] = {}
    for point in one.points:
        value = point.parameters[name]
        key = ", ".join(f"{other} {json.dumps(point.parameters[other])}" for other in others)
        lines.setdefault(key, []).append((value if are_numbers else json.dumps(value), point.mean_deg))
    for (key, means), colour in zip(lines.items(), cycle(DISTINCT), strict=False):
        values, errors = zip(*means, strict=True)
        axes.plot(values, errors, "o-" if are_numbers else "o", color=colour, label=label(key or one.name))
    axes.set(xlabel=label(name), ylabel="geometric mean of errors, °")
    _scale(axes)


def _over(name: str, values: Mapping[int, float], shown: Shown) -> str:
    """Error of every run over a parameter that varies."""
    return plane(f"Error over {name}", partial(_draw_over, name=name, values=values, shown=shown))


def _draw_over(axes: Axes, name: str, values: Mapping[int, float], shown: Shown) -> None:
    for one, colour in shown:
        known = ~one.failed
        errors = one.scores["total_rms_deg"][known]
        at = [values[int(run)] for run in one.runs[known]]
        axes.plot(at, errors, "o", color=colour, ms=4, alpha=0.7, label=label(one.name))
    axes.set(xlabel=name, ylabel="total error, °")
    _scale(axes)


def _command(campaign: Campaign, run: int) -> str:
    """The command that makes a run again."""
    parameters = {**campaign.parameters, **campaign.varied(campaign.scenario_of(run))}
    return recording(f"{run:06d}.mcap", campaign.duration, parameters, campaign.scenario)
