"""Every filter over every case, at its defaults and at the best of its grid."""

from __future__ import annotations

import io
import time
import warnings
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from dataclasses import dataclass
from typing import Final

import numpy as np
from tqdm import tqdm

from league.cases import GRADES, SEED, SETTLED, TUNING_SEEDS, Case, cases, run_of
from league.contender import DEFAULTS, Filter, Setting, filters
from lie_rigid_body import attitude_error
from lie_rigid_body.evaluation.statistics import settling_limit, time_to_converge

TUNING: Final = ("slow_tumble", "fast_tumble", "spin_z", "flips")
"""Motions on which settings are chosen."""
TUNED_AS: Final = {"perfect": "navigation"}
"""Perfect sensors are read with the settings of the best real ones."""
LOST: Final = 180.0
"""What a filter that fails is given, degrees."""


@dataclass(frozen=True)
class Result:
    """What a filter made of a case.

    Attributes
    ----------
    filter : str
    case : Case
    setting : mapping of str to float
    total, heading, inclination : float
        RMS of the errors from `SETTLED` on, degrees.
    converged : float
        Time from which the total error stays below one and a half times the largest of the second half, s.
    cost : float
        CPU time of an update, µs.
    trouble : str
        The exception that it ended with, or the codes of findings about conventions, looked for with perfect sensors.
    """

    filter: str
    case: Case
    setting: Setting
    total: float
    heading: float
    inclination: float
    converged: float
    cost: float
    trouble: str = ""


def score(number: int, case: Case, setting: Setting, seed: int = SEED) -> Result:
    """Run one filter on one case."""
    contender = filters()[number]
    run, given = run_of(case, seed)
    np.random.seed(seed)  # noqa: NPY002 - what filters draw from
    begin = time.process_time()
    try:
        with redirect_stdout(io.StringIO()), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            estimate = contender.estimate(given, **setting).as_quat()
    except Exception as failure:  # of another's code anything may come
        return Result(contender.full_name, case, setting, LOST, LOST, LOST, np.inf, np.nan, repr(failure)[:80])
    cost = 1e6 * (time.process_time() - begin) / len(estimate)
    t_s = (given.t_ns - given.t_ns[0]) / 1e9
    error = attitude_error(estimate, run.attitude().at(given.t_ns))
    rms, heading, inclination = (float(np.degrees(np.sqrt(np.mean(angle[t_s >= SETTLED] ** 2)))) for angle in error)
    total = np.degrees(error.total)
    found = time_to_converge(t_s, total, settling_limit(t_s, total))
    converged = np.inf if found is None else found
    trouble = ""
    if case.grade == "perfect":
        trouble = " ".join(each.code for each in run.score(estimate, given.t_ns, after_s=SETTLED).findings)
    return Result(contender.full_name, case, setting, rms, heading, inclination, converged, cost, trouble)


def bound(case: Case) -> Result | None:
    """The unavoidable error of a case, as a result."""
    found = run_of(case, SEED)[0].unavoidable_error()
    if found is None:
        return None
    late = found.stamps_ns - found.stamps_ns[0] >= SETTLED * 1e9
    rms = [float(np.degrees(found.rms(covariance[late]))) for covariance in (found.filtered, found.smoothed)]
    return Result("unavoidable", case, DEFAULTS, rms[0], np.nan, np.nan, np.nan, np.nan, f"smoothed {rms[1]:.3g}")


def play(workers: int, *, progress: bool | None = None) -> tuple[list[Result], list[Result]]:
    """All results at the defaults and at the chosen settings, each in the order of filters and cases.

    Parameters
    ----------
    workers : int
        Processes.
    progress : bool, optional
        Whether to show a bar; by default on a terminal.
    """
    every, everyone = cases(), filters()
    with ProcessPoolExecutor(workers) as pool:
        bounds = [found for found in pool.map(bound, every) if found is not None]
        trials = [
            (n, Case(motion, grade), setting, seed)
            for grade in GRADES[1:]
            for motion in TUNING
            for seed in TUNING_SEEDS
            for n, each in enumerate(everyone)
            for setting in each.settings()
            if each.grid
        ]
        chosen = _chosen(_scored(pool, trials, "settings", progress))
        jobs = [(n, case, DEFAULTS, SEED) for case in every for n in range(len(everyone))]
        defaults = _scored(pool, jobs, "defaults", progress)
        settings = [
            (n, case, chosen.get((everyone[n].full_name, TUNED_AS.get(case.grade, case.grade)), DEFAULTS), SEED)
            for n, case, _, _ in jobs
        ]
        changed = [job for job in settings if job[2]]
        tuned = {(result.filter, result.case): result for result in _scored(pool, changed, "tuned", progress)}
    best = [tuned.get((result.filter, result.case), result) for result in defaults]
    return defaults + bounds, best + bounds


def _scored(
    pool: ProcessPoolExecutor, jobs: Sequence[tuple[int, Case, Setting, int]], name: str, progress: bool | None
) -> list[Result]:
    results = pool.map(score, *zip(*jobs, strict=True), chunksize=4)
    return list(tqdm(results, desc=name, total=len(jobs), disable=None if progress is None else not progress))


def _chosen(trials: Iterable[Result]) -> dict[tuple[str, str], Setting]:
    """By filter and grade the setting of the least geometric mean of errors; the defaults if none is better."""
    errors: dict[tuple[str, str], dict[tuple[tuple[str, float], ...], float]] = {}
    for result in trials:
        sums = errors.setdefault((result.filter, result.case.grade), {})
        key = tuple(result.setting.items())
        sums[key] = sums.get(key, 0.0) + float(np.log(max(result.total, 1e-9)))
    return {owner: dict(min(sums.items(), key=lambda item: item[1])[0]) for owner, sums in errors.items()}


def by_filter(results: Iterable[Result]) -> Iterator[tuple[Filter, list[Result]]]:
    """Each filter with its results."""
    kept: dict[str, list[Result]] = {}
    for result in results:
        kept.setdefault(result.filter, []).append(result)
    for each in filters():
        yield each, kept[each.full_name]
