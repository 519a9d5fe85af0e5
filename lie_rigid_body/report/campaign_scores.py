"""Answer about the estimators of a campaign."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import cycle
from typing import Any, Final

import numpy as np

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.comparison import Comparison, EstimatorSummary
from lie_rigid_body.evaluation.ensemble_consistency import MIN_RUNS
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.wording import counted, listed
from lie_rigid_body.report import answer
from lie_rigid_body.report.answer import Part, Sentences, Table
from lie_rigid_body.report.drawing import DISTINCT
from lie_rigid_body.report.html_page import (
    axis,
    drawn,
    escaped,
    figure,
    grid,
    line,
    listing,
    logarithmic,
)
from lie_rigid_body.scenario.parameter_file import recording

_COLUMNS: Final = (
    "estimator",
    "total",
    "heading",
    "inclination",
    "converges",
    "NEES",
    "gyro bias",
    "failed",
    "a reading",
)
_HEAD: Final = "Medians over the runs; of errors and times 95 % of the runs are below the second number."
_PAIRS: Final = {"total_rms_deg": "°", "heading_rms_deg": "°", "inclination_rms_deg": "°", "converged_s": " s"}
"""Scores of which the median and a larger one are told, and their units."""

Varied = Mapping[int, Mapping[str, Any]]
"""The parameters that vary, by the numbers of the runs."""


def as_text(comparison: Comparison) -> str:
    """Answer for a terminal."""
    return answer.as_text(_parts(comparison))


def sections(campaign: Campaign, comparison: Comparison, varied: Varied) -> list[str]:
    """HTML of the answer, with figures and the commands of the worst runs."""
    shown = [*zip(comparison.summaries, cycle(DISTINCT), strict=False)]
    commands = [
        f"{escaped(one.name)}: <code>{escaped(_command(campaign, run))}</code>"
        for one in comparison.summaries
        for run in one.worst(3)
    ]
    return [
        *answer.as_html(_parts(comparison)),
        grid(_figures(comparison, shown, varied), wide=True),
        listing("Worst runs", commands),
    ]


def _parts(comparison: Comparison) -> list[Part]:
    """Table of the estimators, and sentences on pairs, grids, covariances and failures."""
    summaries = comparison.summaries
    failed = {number for number, one in enumerate(summaries) if one.failed.any()}
    return [
        Table(_COLUMNS, [_cells(one) for one in summaries], "Estimators", failed),
        Sentences([_HEAD]),
        Sentences([*_sentences(comparison)]),
    ]


def _cells(one: EstimatorSummary) -> list[str]:
    unit, size = ("µs", 1e-6) if one.reading_s < 1e-3 else ("ms", 1e-3)
    bias = one.quantile("gyro_bias_rms_rad_s", 0.5)
    return [
        one.name,
        *(
            " ".join(_number(one.quantile(column, share), unit) for share in (0.5, 0.95)).strip()
            for column, unit in _PAIRS.items()
        ),
        _number(one.quantile("nees_mean", 0.5)),
        "" if np.isnan(bias) else f"{bias:.2g} rad/s",
        f"{np.sum(one.failed)}/{len(one.runs)}",
        _number(one.reading_s / size, f" {unit}"),
    ]


def _number(value: float, unit: str = "") -> str:
    return "" if np.isnan(value) else "never" if np.isinf(value) else f"{value:.3g}{unit}"


def _sentences(comparison: Comparison) -> Iterator[str]:
    for first, second, difference in comparison.differences:
        left_out = (
            f"; {counted(difference.left_out, 'run')} left out, in which one failed" if difference.left_out else ""
        )
        yield f"{difference.sentence(first.name, second.name)}{left_out}."
    for one in comparison.summaries:
        if one.points:
            point = json.dumps(one.entry.parameters)
            points = counted(len(one.points), "point")
            if not all(np.isnan(each.mean_deg) for each in one.points):
                yield f"{one.name}: of {points} the best on runs of even number is {point}; scored on the odd ones."
                yield from _at_the_edge(one)
            if lost := [each for each in one.points if each.failures]:
                yield f"{one.name}: {len(lost)} of {points} failed in runs of even number, first: {lost[0].reason}"
        if one.reason:
            yield f"{one.name} failed in {np.sum(one.failed)} of {counted(len(one.runs), 'run')}, first: {one.reason}"
        verdicts = {"": one.covariance, " (gyro bias)": one.gyro_bias}
        yield from (f"{one.name}{what}: {v.message}. {v.covered}." for what, v in verdicts.items() if v)
    if best := comparison.best:
        left = f"The sensors of run {best.run} leave a filter {_number(best.rms_deg)}° at best, over many such runs"
        errors = [(one.name, one.scores["total_rms_deg"][one.runs == best.run][0]) for one in comparison.summaries]
        larger = ", ".join(f"{name} {_number(error / best.rms_deg)}" for name, error in errors)
        yield f"{left}. In that run the errors are so many times as large: {larger}."
    if comparison.has_covariances and not comparison.independent:
        yield "Nothing is said of the covariances: runs have the same noise; draw sensor_seed by run."
    elif comparison.has_covariances and any(one.covariance for one in comparison.summaries):
        if names := comparison.fixed_constants:
            what = f"{listed(names)} {'is' if len(names) == 1 else 'are'} the same in every run"
            remedy = "vary what a filter counts as unknown"
            yield f"The verdicts on covariances hold for these very sensors: {what}; {remedy}."
    elif comparison.has_covariances:
        yield f"Nothing is said of the covariances: {MIN_RUNS} runs that have one are needed, outside of grids."


def _at_the_edge(one: EstimatorSummary) -> Iterator[str]:
    """A hint for each parameter whose best value is the smallest or the largest that was tried."""
    for name, values in one.entry.grid.items():
        best = one.entry.parameters[name]
        if len({*map(str, values)}) > 1 and _are_numbers(values):
            for end, further in ((min(values), "smaller"), (max(values), "larger")):
                if best == end:
                    yield f"{one.name}: {name} is best at the end of its grid: try {further} ones than {best:g}."


def _figures(comparison: Comparison, shown: Sequence[tuple[EstimatorSummary, str]], varied: Varied) -> Iterator[str]:
    curves = [trace for one, colour in shown if len(one.curve_deg) for trace in _band(comparison.t_s, one, colour)]
    if curves:
        errors = np.concatenate([trace["y"] for trace in curves])
        content = drawn(curves, xaxis=axis("time, s"), yaxis=_scale("total error, °", errors))
        yield figure("Error over time", content, "Median over the runs; between the thin lines are 90 % of the runs.")
    yield from (_grid(one, colour) for one, colour in shown if one.points)
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


def _band(t_s: Array, one: EstimatorSummary, colour: str) -> Iterator[dict[str, Any]]:
    """Lines of the median and of the 5th and 95th percentile of the error."""
    known = ~np.isnan(one.curve_deg).all(axis=0)
    for share, width in ((0.05, 0.6), (0.95, 0.6), (0.5, 2.2)):
        points = np.column_stack([t_s[known], np.nanquantile(one.curve_deg[:, known], share, axis=0)])
        yield line(points, one.name, colour, width, legendgroup=one.name, showlegend=share == 0.5)


def _scale(title: str, values: Array) -> dict[str, Any]:
    """Axis of errors, logarithmic where the largest is more than 30 times the smallest."""
    positive = values[np.isfinite(values) & (values > 0.0)]
    if len(positive) and positive.max() > 30.0 * positive.min():
        return logarithmic(title, np.maximum(positive, 1e-6 * positive.max()))
    return axis(title, rangemode="tozero")


def _grid(one: EstimatorSummary, colour: str) -> str:
    """Mean error of each point of a grid over its first parameter, a line for each choice of the others."""
    name, *others = one.entry.grid
    ranked = [point.parameters[name] for point in one.points]
    are_numbers = _are_numbers(ranked)
    lines: dict[str, list[tuple[Any, float]]] = {}
    for point, value in zip(one.points, ranked if are_numbers else map(json.dumps, ranked), strict=True):
        key = ", ".join(f"{other} {json.dumps(point.parameters[other])}" for other in others)
        lines.setdefault(key, []).append((value, point.mean_deg))
    traces = [
        {
            "type": "scatter",
            "x": [value for value, _ in means],
            "y": [mean for _, mean in means],
            "name": key or one.name,
            "mode": "lines+markers" if are_numbers else "markers",
            "line": {"color": colour if len(lines) == 1 else own},
        }
        for (key, means), own in zip(lines.items(), cycle(DISTINCT), strict=False)
    ]
    xaxis = _scale(name, np.array(ranked, dtype=float)) if are_numbers else axis(name, type="category")
    yaxis = _scale("mean total error, °", np.array([point.mean_deg for point in one.points]))
    caption = f"RMS of the total error on the runs of even number. The best point: {json.dumps(one.entry.parameters)}."
    return figure(f"Grid of {one.name}", drawn(traces, xaxis=xaxis, yaxis=yaxis), caption)


def _over(name: str, values: Mapping[int, float], shown: Sequence[tuple[EstimatorSummary, str]]) -> str:
    """Error of every run over a parameter that varies."""
    traces = [
        line(
            np.column_stack([[values[int(run)] for run in one.runs], one.scores["total_rms_deg"]])[~one.failed],
            one.name,
            colour,
            1,
            mode="markers",
            marker={"color": colour, "size": 5, "opacity": 0.7},
        )
        for one, colour in shown
    ]
    errors = np.concatenate([one.scores["total_rms_deg"] for one, _ in shown])
    xaxis = _scale(name, np.array([*values.values()], dtype=float))
    yaxis = _scale("total error, °", errors)
    return figure(f"Error over {name}", drawn(traces, xaxis=xaxis, yaxis=yaxis))


def _command(campaign: Campaign, run: int) -> str:
    """The command that makes a run again."""
    parameters = {**campaign.parameters, **campaign.varied(campaign.scenario_of(run))}
    return recording(f"{run:06d}.mcap", campaign.duration, parameters, campaign.scenario)
