"""Every filter over every case, at its defaults and at the best of its grid."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np

from league.contender import DEFAULTS, Filter, Setting, filters
from league.kept import each, key_of
from lie_rigid_body import Run
from lie_rigid_body.evaluation.differences import Difference, best_point, of_runs
from lie_rigid_body.league.cases import CASES, GRADES, RANKED, SEEDS, SETTLED_S, WIRING, Case, readings_hash, run_of
from lie_rigid_body.league.playing import play_case
from lie_rigid_body.league.table import CaseResult

TUNING_SEED: Final = 1001
"""Seed of the cases on which settings are chosen."""
TUNED_ON: Final = (("slow", False), ("fast", True))
"""Speeds, and whether there are rests, of the cases on which settings are chosen."""
TUNING: Final = tuple(
    replace(case, seed=TUNING_SEED) for case in RANKED if case.seed == SEEDS[0] and (case.speed, case.rests) in TUNED_ON
)
UNSEEN: Final = tuple(case for case in RANKED if (case.speed, case.rests) not in TUNED_ON)
"""Cases in which a chosen setting is compared with the defaults: other motions and other seeds."""


class Job(NamedTuple):
    """A filter, by its number, with a setting in a case."""

    number: int
    case: Case
    setting: Setting


@dataclass(frozen=True)
class Result:
    """What a filter made of a case.

    Attributes
    ----------
    errors : CaseResult
    cost : float
        CPU time of an update, µs; NaN where it failed.
    """

    errors: CaseResult
    cost: float


@dataclass(frozen=True)
class Advice:
    """A setting that is shown to be better than the defaults with sensors of a grade, and by how much."""

    setting: Setting
    difference: Difference


@dataclass(frozen=True)
class Entry:
    """A filter over all cases.

    Attributes
    ----------
    filter : Filter
    defaults : mapping of Case to Result
        At the defaults of its library.
    advice : mapping of str to Advice
        By the grades of sensors for which there is one.
    tuned : mapping of Case to Result
        With the settings that are advised, and else at the defaults.
    """

    filter: Filter
    defaults: Mapping[Case, Result]
    advice: Mapping[str, Advice]
    tuned: Mapping[Case, Result]


def score(job: Job) -> dict[str, Any]:
    """Run one filter on one case; the fields of its result."""
    contender, costs = filters()[job.number], [np.nan]

    def estimate(run: Run) -> Any:
        begin = time.process_time()
        answer = contender.of_run(run, **job.setting)
        costs.append(1e6 * (time.process_time() - begin) / len(answer[0]))
        return answer

    errors, _ = play_case(estimate, job.case)
    return asdict(Result(errors, costs[-1]))


def bound(case: Case) -> float | None:
    """The Cramér–Rao bound of a case, degrees."""
    found = run_of(case).cramer_rao_bound()
    if found is None:
        return None
    late = found.stamps_ns - found.stamps_ns[0] >= SETTLED_S * 1e9
    return float(np.degrees(found.rms(found.filtered[late])))


def hash_of(case: Case) -> str:
    """Hash of the readings of a case."""
    return readings_hash(run_of(case))


def play(workers: int) -> tuple[list[Entry], dict[Case, str], dict[str, float]]:
    """Results at the defaults and at the settings that are advised, hashes of the readings, and the bounds."""
    everyone = range(len(filters()))
    tunable = [number for number in everyone if filters()[number].grid]
    with ProcessPoolExecutor(workers) as pool:
        hashes = hashes_of(pool, (*CASES, *TUNING))
        keys = [f"bound {hashes[case]}" for case in CASES]
        least = zip(CASES, each(pool, bound, CASES, keys, "bounds"), strict=True)
        bounds = {str(case): degrees for case, degrees in least if degrees}
        defaults = results(pool, [Job(n, case, DEFAULTS) for case in CASES for n in everyone], hashes, "defaults")
        points = [Job(n, case, point) for case in TUNING for n in tunable for point in filters()[n].settings()]
        tried = results(pool, points, hashes, "settings")
        chosen = {(n, grade): best_setting(n, grade, tried) for n in tunable for grade in GRADES}
        chosen = {key: setting for key, setting in chosen.items() if setting}
        found = defaults
        for own in (True, False):  # few are better with sensors of their own grade
            jobs = [Job(n, case, setting) for (n, grade), setting in chosen.items() for case in judging(grade, own=own)]
            found |= results(pool, jobs, hashes, "chosen settings")
            chosen = improved(chosen, found, own=own)
        jobs = [
            Job(n, case, setting)
            for (n, grade), setting in chosen.items()
            for case in CASES
            if setting_for(case) == grade
        ]
        found |= results(pool, jobs, hashes, "advised settings")
    entries = [entry(n, {grade: chosen[n, grade] for grade in GRADES if (n, grade) in chosen}, found) for n in everyone]
    return entries, hashes, bounds


def hashes_of(pool: Executor, cases: Sequence[Case]) -> dict[Case, str]:
    """Hashes of the readings of some cases."""
    return dict(zip(cases, pool.map(hash_of, cases), strict=True))


Results = Mapping[tuple[int, Case, tuple[tuple[str, float], ...]], Result]
"""Results by the number of the filter, the case and the setting."""
Settings = Mapping[tuple[int, str], Setting]
"""Settings by the number of the filter and the grade of the sensors."""


def results(pool: Executor, jobs: Sequence[Job], hashes: Mapping[Case, str], name: str) -> dict[Any, Result]:
    """Results of some jobs, of which those that are kept are not made again."""
    keys = [key_of(filters()[job.number], job.setting, hashes[job.case]) for job in jobs]
    return {
        (job.number, job.case, tuple(job.setting.items())): Result(CaseResult(**found["errors"]), found["cost"])
        for job, found in zip(jobs, each(pool, score, jobs, keys, name), strict=True)
    }


def totals(number: int, cases: Sequence[Case], setting: Setting, found: Results) -> np.ndarray:
    """Errors of a filter with a setting in some cases, degrees; NaN where it failed."""
    errors = [found[number, case, tuple(setting.items())].errors for case in cases]
    return np.array([np.nan if each.failure else each.total_deg for each in errors])


def setting_for(case: Case) -> str:
    """Grade whose setting is taken in a case: the nearest one for perfect sensors."""
    return "tactical" if case == WIRING else case.grade


def best_setting(number: int, grade: str, tried: Results) -> Setting:
    """The best point of a grid with sensors of a grade."""
    points = [*filters()[number].settings()]
    cases = [case for case in TUNING if case.grade == grade]
    best, _ = best_point([totals(number, cases, point, tried) for point in points])
    return points[best]


def judging(grade: str, *, own: bool) -> list[Case]:
    """The cases in which a setting for sensors of a grade is judged: with sensors of that grade, or of the other."""
    return [case for case in UNSEEN if (case.grade == grade) is own]


def improved(chosen: Settings, found: Results, *, own: bool) -> dict[tuple[int, str], Setting]:
    """The settings that are shown to be better than the defaults with sensors of their own grade, or of the other."""
    ratios = {(n, grade): ratio(n, judging(grade, own=own), setting, found) for (n, grade), setting in chosen.items()}
    return {key: chosen[key] for key, each in ratios.items() if each.is_shown and each.ratio < 1.0}


def ratio(number: int, cases: Sequence[Case], setting: Setting, found: Results) -> Difference:
    """Error of a filter with a setting beside that at the defaults."""
    return of_runs(*(totals(number, cases, point, found) for point in (setting, DEFAULTS)))


def entry(number: int, advised: Mapping[str, Setting], found: Results) -> Entry:
    """A filter at the defaults, and with the settings that are advised for grades.

    One is advised where it is shown to be better with sensors of each grade: real sensors lie between.
    """
    advice = {
        grade: Advice(setting, ratio(number, judging(grade, own=True), setting, found))
        for grade, setting in advised.items()
    }
    settings = {grade: tuple(setting.items()) for grade, setting in advised.items()}
    tuned = {case: found[number, case, settings.get(setting_for(case), ())] for case in CASES}
    return Entry(filters()[number], {case: found[number, case, ()] for case in CASES}, advice, tuned)
