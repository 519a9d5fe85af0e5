"""Estimators over the runs of a campaign: errors, which one is better, best points of grids, honesty of covariances."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.campaign.estimators import Contender, Entry
from lie_rigid_body.campaign.judging import CURVE, MORE_SCORES, SCORES, SERIES, Judgement, errors_of
from lie_rigid_body.campaign.run import Row
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.differences import Difference, of_runs
from lie_rigid_body.evaluation.honesty import FEWEST_RUNS, Honesty, honesty
from lie_rigid_body.runs import simulate
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.wording import short_repr

MOST_SERIES: Final = 1000
"""Number of runs, the first ones, of which errors over time are looked at, with their covariances."""
_COLUMNS: Final = (*SCORES, *MORE_SCORES)
_TOTAL: Final = SCORES[0]
_SEED: Final = "sensor_seed"
_CONSTANTS: Final = ("_scale_factor", "_misalignment", "_hard_iron", "_soft_iron")
"""Ends of the names of parameters of errors that stay, and that no filter knows."""


@dataclass(frozen=True)
class Point:
    """One point of a grid, on the runs of even number.

    Attributes
    ----------
    parameters : dict of str to object
    mean_deg : float
        Mean RMS of the total error, degrees; NaN if it failed in all.
    failures : int
    """

    parameters: Mapping[str, Any]
    mean_deg: float
    failures: int

    __repr__ = short_repr


@dataclass(frozen=True)
class Standing:
    """An estimator over the runs in which it is scored: all, or with a grid those of odd number.

    Attributes
    ----------
    entry : Entry
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
        Total error, degrees, over time in at most `MOST_SERIES` runs; NaN where there is no estimate.
    covariance, gyro_bias : Honesty or None
        Verdict on the covariance of the attitude, and of the gyro's bias, where there are enough runs that have one.
    points : tuple of Point
        Those of its grid.
    """

    entry: Entry
    runs: Integers
    scores: Mapping[str, Array]
    failed: Any
    reason: str
    reading_s: float
    curve_deg: Array
    covariance: Honesty | None
    gyro_bias: Honesty | None
    points: tuple[Point, ...]

    __repr__ = short_repr

    @property
    def name(self) -> str:
        """Name of the estimator."""
        return self.entry.contender.name

    def quantile(self, column: str, share: float) -> float:
        """Quantile of a score over the runs that have it, some of which may be infinite; NaN if none has."""
        values = np.sort(self.scores[column][~np.isnan(self.scores[column])])
        if not len(values):
            return np.nan
        place = share * len(values)
        low, high = values[math.ceil(place) - 1], values[min(int(place), len(values) - 1)]
        return float(low if low == high else 0.5 * (low + high))

    def worst(self, count: int) -> list[int]:
        """Numbers of the runs of the largest errors, first those in which it failed."""
        key = np.where(self.failed, np.inf, self.scores[_TOTAL])
        return [int(run) for run in self.runs[np.argsort(-key, kind="stable")[:count]]]


@dataclass(frozen=True)
class Best:
    """What the sensors of a run leave at best.

    Attributes
    ----------
    run : int
    rms_deg : float
        RMS of the total error of the best filter, degrees.
    """

    run: int
    rms_deg: float

    __repr__ = short_repr


@dataclass(frozen=True)
class Comparison:
    """Estimators of a campaign.

    Attributes
    ----------
    standings : tuple of Standing
        In the order of the campaign.
    differences : tuple of (Standing, Standing, Difference)
        Of each pair: difference of the RMS of the total error, degrees, over the runs in which both are scored.
    t_s : ndarray, shape (`CURVE`,)
        Times of the curves, s.
    best : Best or None
        What the sensors leave at best, in the first run in which every estimator is scored.
    independent : bool
        Whether the noise differs from run to run, without which nothing is said of covariances.
    has_covariances : bool
        Whether any estimate has one.
    fixed_constants : tuple of str
        Parameters of errors that no filter knows, such as the scale of the gyro, and that are the same in every run.
    """

    standings: tuple[Standing, ...]
    differences: tuple[tuple[Standing, Standing, Difference], ...]
    t_s: Array
    best: Best | None
    independent: bool
    has_covariances: bool
    fixed_constants: tuple[str, ...]

    __repr__ = short_repr


def compare(campaign: Campaign, rows: Callable[[], Iterable[Row]]) -> Comparison:
    """Compare the estimators of a campaign.

    Parameters
    ----------
    campaign : Campaign
    rows : callable
        Gives the rows of the finished runs in the order of their numbers. They are read twice, as they may be many.
    """
    entries, duration = campaign.entries, float(campaign.exact_duration)
    tables = _Tables(entries, rows())
    chosen = {name: _best(one, entries, tables) for name, one in campaign.contenders.items()}
    kept: dict[str, list[Judgement]] = {name: [] for name in chosen}
    for row in rows():
        for name, (place, _) in chosen.items():
            if _counts(campaign.contenders[name], row.run) and len(kept[name]) < MOST_SERIES:
                kept[name].append(Judgement(**row.judgements[place]))
    independent = _SEED in campaign.vary
    standings = tuple(
        tables.standing(entries[place], place, points, kept[name], duration if independent else None)
        for name, (place, points) in chosen.items()
    )
    return Comparison(
        standings,
        tuple((first, second, _difference(first, second)) for first, second in combinations(standings, 2)),
        np.linspace(0.0, duration, CURVE),
        _best_possible(campaign, standings),
        independent,
        any(each.covariance for some in kept.values() for each in some),
        tuple(_fixed_constants(campaign)),
    )


def _fixed_constants(campaign: Campaign) -> Iterator[str]:
    scenario = campaign.scenario_of(0)
    for name, value in scenario.sensor_parameters:
        sensor = "magnetometer" if name.startswith("magnetometer") else "imu"
        is_fixed = sensor in scenario.sensors.on and name not in campaign.vary
        if is_fixed and name.endswith(_CONSTANTS) and value != BY_NAME[name].default:
            yield name


def _counts(contender: Contender, run: int) -> bool:
    """Whether an estimator is scored in a run: the best point of a grid is chosen on those of even number."""
    return not contender.grid or run % 2 == 1


class _Tables:
    """The scores of all entries in all runs, and why those failed that did."""

    def __init__(self, entries: tuple[Entry, ...], rows: Iterable[Row]) -> None:
        runs: list[int] = []
        scores: list[list[list[float]]] = []
        self._first: list[dict[int, str]] = [{} for _ in entries]
        for row in rows:
            runs.append(row.run)
            read = [Judgement(**judgement) for judgement in row.judgements]  # the journal has looked at them
            scores.append([_numbers(judgement) for judgement in read])
            for first, judgement in zip(self._first, read, strict=True):
                if judgement.error is not None:
                    first.setdefault(row.run % 2, judgement.error)
        self.runs = np.array(runs, dtype=np.int64)
        self._scores = np.array(scores)

    def of(self, place: int, rows: Any) -> tuple[dict[str, Array], Any, Array]:
        """Scores of an entry by column in some rows, whether it failed there, and times of a reading, s."""
        *columns, reading_s = self._scores[rows, place].T
        found = dict(zip(_COLUMNS, columns, strict=True))
        return found, np.isnan(found[_TOTAL]), reading_s

    def standing(
        self, entry: Entry, place: int, points: tuple[Point, ...], kept: list[Judgement], duration_s: float | None
    ) -> Standing:
        rows = np.array([_counts(entry.contender, run) for run in self.runs], dtype=bool)
        scores, failed, reading_s = self.of(place, rows)
        reasons = self._first[place]
        reason = reasons.get(1, "") if points else reasons[min(reasons)] if reasons else ""
        right = [each for each in kept if each.error is None]
        attitude, bias = (
            None if duration_s is None else _verdict(duration_s, right, of_bias) for of_bias in (False, True)
        )
        curves = np.array([each.curve_deg for each in right], dtype=float).reshape(-1, CURVE)
        median = float(np.nanmedian(reading_s)) if not failed.all() else np.nan
        return Standing(entry, self.runs[rows], scores, failed, reason, median, curves, attitude, bias, points)


def _numbers(judgement: Judgement) -> list[float]:
    """Scores by column, and the time of a reading; NaN where there is none."""
    numbers = [np.nan if value is None else float(value) for value in map(judgement.scores.get, _COLUMNS)]
    if judgement.error is None and judgement.scores["converged_s"] is None:
        numbers[_COLUMNS.index("converged_s")] = np.inf
    return [*numbers, np.nan if judgement.reading_s is None else judgement.reading_s]


def _best(contender: Contender, entries: tuple[Entry, ...], tables: _Tables) -> tuple[int, tuple[Point, ...]]:
    """Place of an estimator's entry, with a grid that of the best point, and all points."""
    places = [place for place, entry in enumerate(entries) if entry.contender.name == contender.name]
    if not contender.grid:
        return places[0], ()
    points = []
    for place in places:
        scores, failed, _ = tables.of(place, tables.runs % 2 == 0)
        mean = float(np.mean(scores[_TOTAL][~failed])) if not failed.all() else np.nan
        points.append(Point(entries[place].parameters, mean, int(np.sum(failed))))
    best = min(range(len(points)), key=lambda at: (points[at].failures, np.nan_to_num(points[at].mean_deg, nan=np.inf)))
    return places[best], tuple(points)


def _difference(first: Standing, second: Standing) -> Difference:
    """Difference over the runs in which both are scored."""
    _, left, right = np.intersect1d(first.runs, second.runs, return_indices=True)
    return of_runs(first.scores[_TOTAL][left], second.scores[_TOTAL][right])


def _best_possible(campaign: Campaign, standings: Sequence[Standing]) -> Best | None:
    """The bound in the first run in which every estimator is scored; None if there is none."""
    runs = set.intersection(*({*one.runs[~one.failed].tolist()} for one in standings))
    if not runs:
        return None
    run = min(runs)
    bound = simulate(campaign.scenario_of(run), duration=campaign.duration).unavoidable_error()
    if bound is None or bound.unobserved:
        return None
    return Best(run, float(np.degrees(bound.rms(bound.filtered))))


def _verdict(duration_s: float, judgements: list[Judgement], of_bias: bool) -> Honesty | None:
    """Verdict on the covariance of the attitude, or of the gyro's bias, of enough runs that have one."""
    axes = {each.axes for each in judgements if each.covariance}
    series = [each.gyro_bias if of_bias else each.covariance for each in judgements]
    told = [rows for rows in series if rows]
    if len(told) < FEWEST_RUNS or len(axes) > 1:
        return None
    t_s, (errors, P, attitude_xyzw) = np.linspace(0.0, duration_s, SERIES), errors_of(told)
    try:
        return honesty(t_s, errors, P) if of_bias else honesty(t_s, errors, P, attitude_xyzw, axes.pop())
    except InputError:  # the digits that are kept of a covariance have no inverse
        return None
