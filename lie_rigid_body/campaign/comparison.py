"""Estimators over the runs of a campaign: errors, which is better, best points of grids, consistency of covariances."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np

from lie_rigid_body.campaign.definition import Campaign, EstimatorSpec
from lie_rigid_body.campaign.run import CURVE, MORE_SCORES, SCORES, SERIES, Row, RunScore, errors_of
from lie_rigid_body.evaluation.cramer_rao_bound import mean_square
from lie_rigid_body.evaluation.differences import Difference, best_point, geometric_mean, of_pairs
from lie_rigid_body.evaluation.ensemble_consistency import MIN_RUNS, EnsembleConsistency, ensemble_consistency
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.runs import simulate

MAX_SERIES: Final = 1000
"""Largest number of runs, the first ones, whose errors over time and covariances are judged."""
_COLUMNS: Final = (*SCORES, *MORE_SCORES)
_TOTAL: Final = SCORES[0]
_READING: Final = "reading_s"
_SEED: Final = "sensor_seed"


@short_dataclass
class Point:
    """One point of a grid, on the runs of even number.

    Attributes
    ----------
    parameters : dict of str to object
    mean_deg : float
        Geometric mean of the RMS of the total error, degrees; NaN if it failed in all.
    failures : int
    reason : str
        What it failed of in the first run of these; '' if it did in none.
    difference : Difference or None
        Ratio of the error of the best point to that of this one; None of the best.
    """

    parameters: Mapping[str, Any]
    mean_deg: float
    failures: int
    reason: str
    difference: Difference | None = None


@short_dataclass(eq=False)
class EstimatorSummary:
    """An estimator over the runs in which it is scored: all, or with a grid those of odd number.

    Attributes
    ----------
    entry : EstimatorSpec
        With the parameters of the best point of its grid.
    runs : ndarray of int, shape (R,)
        Numbers of the runs.
    scores : dict of str to ndarray, shape (R,)
        By column, NaN where there is none, also where the estimator failed. Of ``converged_s`` it is infinite where an
        estimate does not converge.
    failed : ndarray of bool, shape (R,)
    reason : str
        What it failed of in the first run of these; '' if it did in none.
    reading_s : float
        Median time of a run by the number of its attitudes, s; NaN if it failed in all.
    curve_deg : ndarray, shape (K, `CURVE`)
        Total error, degrees, over time in at most `MAX_SERIES` runs; NaN where there is no estimate.
    covariance, gyro_bias : EnsembleConsistency or None
        Verdict on the covariance of the attitude, and of the gyro's bias, where there are enough runs that have one.
    points : tuple of Point
        Those of its grid.
    bias_claimed_exact : int
        Number of the kept runs in which the covariance of the gyro's bias is 0 beside an error.
    """

    entry: EstimatorSpec
    runs: Integers
    scores: Mapping[str, Array]
    failed: Any
    reason: str
    reading_s: float
    curve_deg: Array
    covariance: EnsembleConsistency | None
    gyro_bias: EnsembleConsistency | None
    points: tuple[Point, ...]
    bias_claimed_exact: int

    @property
    def name(self) -> str:
        """Name of the estimator."""
        return self.entry.name

    def quantile(self, column: str, share: float) -> float:
        """Quantile of a score over the runs that have it, some of which may be infinite; NaN if none has."""
        values = np.sort(self.scores[column][~np.isnan(self.scores[column])])
        if not len(values):
            return np.nan
        place = share * len(values)
        return float(0.5 * values[math.ceil(place) - 1] + 0.5 * values[min(int(place), len(values) - 1)])

    def worst(self, count: int) -> list[int]:
        """Numbers of the runs of the largest errors, first those in which it failed."""
        key = np.where(self.failed, np.inf, self.scores[_TOTAL])
        return [int(run) for run in self.runs[np.argsort(-key, kind="stable")[:count]]]


class Bound(NamedTuple):
    """Cramér–Rao bound of a run, for filters that do not know the dynamics.

    Attributes
    ----------
    run : int
    rms_deg : float
        Bound of the RMS of the total error, degrees.
    curve_deg : ndarray, shape (`CURVE`,)
        Bound of the total error over time, degrees.
    """

    run: int
    rms_deg: float
    curve_deg: Array


@short_dataclass(eq=False)
class Comparison:
    """Estimators of a campaign.

    Attributes
    ----------
    summaries : tuple of EstimatorSummary
        In the order of the campaign.
    differences : tuple of (EstimatorSummary, EstimatorSummary, Difference)
        Of each pair: ratio of the RMS of the total error over the runs in which both are scored.
    t_s : ndarray, shape (`CURVE`,)
        Times of the curves, s.
    bound : Bound or None
        That of the first run in which every estimator is scored, but those that fail in all.
    independent : bool
        Whether no two runs have the same noise, without which nothing is said of covariances.
    has_covariances : bool
        Whether any estimate has one.
    """

    summaries: tuple[EstimatorSummary, ...]
    differences: tuple[tuple[EstimatorSummary, EstimatorSummary, Difference], ...]
    t_s: Array
    bound: Bound | None
    independent: bool
    has_covariances: bool

    @property
    def worst_first(self) -> list[EstimatorSummary]:
        """Estimators in the order of the share of runs in which they failed, and then of their median total error."""
        return sorted(self.summaries, key=lambda one: (-np.mean(one.failed), -one.quantile(_TOTAL, 0.5)))


def compare(campaign: Campaign, rows: Iterable[Row]) -> Comparison:
    """Compare the estimators of a campaign.

    Parameters
    ----------
    campaign : Campaign
    rows : iterable of Row
        Those of the finished runs, at least one, in the order of their numbers.
    """
    entries = [_EntryScores(entry) for entry in campaign.entries]
    seeds: list[object] = []
    for row in rows:
        seeds.append(row.parameters.get(_SEED))
        for one, run_score in zip(entries, row.run_scores, strict=True):
            one.add(row.run, RunScore(**run_score))
    duration = float(campaign.exact_duration)
    independent = _SEED in campaign.vary and len({*seeds}) == len(seeds)
    chosen = [_best([one for one in entries if one.entry.name == name]) for name in campaign.estimator_specs]
    summaries = tuple(one.summary(points, duration if independent else None) for one, points in chosen)
    pairs = [*combinations(summaries, 2)]
    differences = of_pairs([_in_common(*pair) for pair in pairs])
    return Comparison(
        summaries,
        tuple((*pair, difference) for pair, difference in zip(pairs, differences, strict=True)),
        np.linspace(0.0, duration, CURVE),
        _bound(campaign, summaries),
        independent,
        any(each.covariance for one, _ in chosen for each in one.kept),
    )


class _EntryScores:
    """Scores of an entry in all runs.

    Attributes
    ----------
    entry : EstimatorSpec
    kept : list of RunScore
        Those of the first runs in which it is scored, at most `MAX_SERIES`.
    reasons : dict of int to str
        What it failed of first: of a grid in the runs with a remainder of a division by 2, else in all, for 1.
    """

    def __init__(self, entry: EstimatorSpec) -> None:
        self.entry = entry
        self.kept: list[RunScore] = []
        self.reasons: dict[int, str] = {}
        self._runs: list[int] = []
        self._numbers: list[list[float]] = []

    def add(self, run: int, run_score: RunScore) -> None:
        """Take what the entry is worth in a run."""
        self._runs.append(run)
        self._numbers.append(_numbers(run_score))
        if run_score.error:
            self.reasons.setdefault(run % 2 if self.entry.grid else 1, run_score.error)
        if self.entry.grid and run % 2 == 0:
            return  # the best point of a grid is chosen in it, and scored in others
        if len(self.kept) < MAX_SERIES:
            self.kept.append(run_score)

    def scored(self, *remainders: int) -> tuple[Integers, dict[str, Array]]:
        """Numbers of the runs with these remainders of a division by 2, and by column the scores in them."""
        runs = np.array(self._runs)
        some = np.isin(runs % 2, remainders)
        return runs[some], dict(zip((*_COLUMNS, _READING), np.array(self._numbers)[some].T, strict=True))

    def summary(self, points: tuple[Point, ...], duration_s: float | None) -> EstimatorSummary:
        """The entry over the runs in which it is scored; verdicts on covariances need the duration of a run."""
        runs, scores = self.scored(1) if points else self.scored(0, 1)
        failed = np.isnan(scores[_TOTAL])
        reading_s = scores.pop(_READING)
        right = [each for each in self.kept if each.error is None]
        return EstimatorSummary(
            self.entry,
            runs,
            scores,
            failed,
            self.reasons.get(1, ""),
            reading_s=float(np.nanmedian(reading_s)) if not failed.all() else np.nan,
            curve_deg=np.array([each.curve_deg for each in right], dtype=float).reshape(-1, CURVE),
            covariance=_verdict(duration_s, right, of_bias=False),
            gyro_bias=_verdict(duration_s, right, of_bias=True),
            points=points,
            bias_claimed_exact=sum(each.bias_claimed_exact for each in right),
        )


def _numbers(run_score: RunScore) -> list[float]:
    """Scores by column, and the time of a reading; NaN where there is none."""
    scores = {**run_score.scores, _READING: run_score.reading_s}
    if run_score.error is None and scores["converged_s"] is None:
        scores["converged_s"] = np.inf
    return [np.nan if value is None else float(value) for value in map(scores.get, (*_COLUMNS, _READING))]


def _best(entries: Sequence[_EntryScores]) -> tuple[_EntryScores, tuple[Point, ...]]:
    """The entry of an estimator, with a grid that of the best point, and all points."""
    if not entries[0].entry.grid:
        return entries[0], ()
    totals = [one.scored(0)[1][_TOTAL] for one in entries]
    best, differences = best_point(totals)
    points = [
        Point(each.entry.parameters, geometric_mean(total), int(np.isnan(total).sum()), each.reasons.get(0, ""), ratio)
        for each, total, ratio in zip(entries, totals, differences, strict=True)
    ]
    return entries[best], tuple(points)


def _in_common(first: EstimatorSummary, second: EstimatorSummary) -> tuple[Array, Array]:
    """Errors of two estimators in the runs in which both are scored, degrees; NaN where one failed."""
    _, left, right = np.intersect1d(first.runs, second.runs, return_indices=True)
    return first.scores[_TOTAL][left], second.scores[_TOTAL][right]


def _bound(campaign: Campaign, summaries: Sequence[EstimatorSummary]) -> Bound | None:
    """The bound in the first run in which every estimator is scored that is in any; None if there is none."""
    scored = [{*one.runs[~one.failed].tolist()} for one in summaries if not one.failed.all()]
    runs = set.intersection(*scored) if scored else None
    if not runs:
        return None
    number = min(runs)
    run = simulate(campaign.scenario_of(number), duration=campaign.duration)
    bound = run.cramer_rao_bound()
    if bound is None or bound.unobserved:
        return None
    t_s = (bound.stamps_ns - run.t_ns[0]) / 1e9
    squares = np.interp(np.linspace(0.0, float(campaign.exact_duration), CURVE), t_s, mean_square(bound.filtered))
    return Bound(number, math.degrees(bound.rms(bound.filtered)), np.degrees(np.sqrt(squares)))


def _verdict(duration_s: float | None, run_scores: list[RunScore], *, of_bias: bool) -> EnsembleConsistency | None:
    """Verdict on the covariance of the attitude, or of the gyro's bias, of enough runs of a duration that have one."""
    axes = {each.axes for each in run_scores if each.covariance}
    series = [each.gyro_bias if of_bias else each.covariance for each in run_scores]
    told = [rows for rows in series if rows]
    if duration_s is None or len(told) < MIN_RUNS or len(axes) > 1:
        return None
    t_s = np.linspace(0.0, duration_s, SERIES)
    errors, P, attitude_xyzw = errors_of(told)
    return (
        ensemble_consistency(t_s, errors, P)
        if of_bias
        else ensemble_consistency(t_s, errors, P, attitude_xyzw, axes.pop())
    )
