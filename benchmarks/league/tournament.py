"""Every filter over every case, at its defaults and at the best of its grid."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from tqdm import tqdm

from league.contender import DEFAULTS, Filter, Setting, filters
from lie_rigid_body import Run
from lie_rigid_body.league.cases import CASES, REAL, SEED, SETTLED_S, Case, run_of
from lie_rigid_body.league.playing import play_case
from lie_rigid_body.league.table import CaseResult
from lie_rigid_body.sensors import PERFECT

TUNING: Final = ("slow_tumble", "fast_tumble", "spin_z", "flips")
"""Motions on which settings are chosen."""
TUNED_AS: Final = {"perfect": "navigation"}
"""Perfect sensors are read with the settings of the best real ones."""
TUNING_SEEDS: Final = (1001, 1002)
"""Noise of the runs on which settings are chosen: others than those that are scored."""


@dataclass(frozen=True)
class Result:
    """What a filter made of a case.

    Attributes
    ----------
    filter : str
    case : Case
    setting : mapping of str to float
    errors : CaseResult
    cost : float
        CPU time of an update, µs.
    trouble : str
        The exception that it ended with, or the codes of findings about conventions, looked for with perfect sensors.
    """

    filter: str
    case: Case
    setting: Setting
    errors: CaseResult
    cost: float = np.nan
    trouble: str = ""

    @property
    def total(self) -> float:
        """RMS of the total error, degrees."""
        return self.errors.total_deg


def score(number: int, case: Case, setting: Setting, seed: int = SEED) -> Result:
    """Run one filter on one case."""
    contender, answers, costs = filters()[number], [], []

    def estimate(run: Run) -> Any:
        begin = time.process_time()
        answers.append(contender.of_run(run, **setting))
        costs.append(1e6 * (time.process_time() - begin) / len(answers[0][0]))
        return answers[0]

    errors, trouble = play_case(estimate, case, seed), ""
    if case.grade == PERFECT and not errors.failure:
        t_ns, attitude = answers[0]
        trouble = " ".join(each.code for each in run_of(case, seed).score(attitude, t_ns, after_s=SETTLED_S).findings)
    return Result(contender.full_name, case, setting, errors, costs[0] if costs else np.nan, errors.failure or trouble)


def bound(case: Case) -> float | None:
    """The Cramér–Rao bound of a case, degrees."""
    found = run_of(case).cramer_rao_bound()
    if found is None:
        return None
    late = found.stamps_ns - found.stamps_ns[0] >= SETTLED_S * 1e9
    return float(np.degrees(found.rms(found.filtered[late])))


def play(workers: int, *, progress: bool | None = None) -> tuple[list[Result], list[Result], dict[str, float]]:
    """All results at the defaults and at the chosen settings, in the order of filters and cases, and the bounds.

    Parameters
    ----------
    workers : int
        Processes.
    progress : bool, optional
        Whether to show a bar; by default on a terminal.
    """
    everyone = filters()
    with ProcessPoolExecutor(workers) as pool:
        bounds = {str(case): found for case, found in zip(CASES, pool.map(bound, CASES), strict=True) if found}
        trials = [
            (n, Case(motion, grade), setting, seed)
            for grade in REAL
            for motion in TUNING
            for seed in TUNING_SEEDS
            for n, each in enumerate(everyone)
            for setting in each.settings()
            if each.grid
        ]
        chosen = _chosen(_scored(pool, trials, "settings", progress))
        jobs = [(n, case, DEFAULTS, SEED) for case in CASES for n in range(len(everyone))]
        defaults = _scored(pool, jobs, "defaults", progress)
        settings = [
            (n, case, chosen.get((everyone[n].full_name, TUNED_AS.get(case.grade, case.grade)), DEFAULTS), SEED)
            for n, case, _, _ in jobs
        ]
        changed = [job for job in settings if job[2]]
        tuned = {(result.filter, result.case): result for result in _scored(pool, changed, "tuned", progress)}
    best = [tuned.get((result.filter, result.case), result) for result in defaults]
    return defaults, best, bounds


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
