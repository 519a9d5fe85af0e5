"""A filter over the cases of the league."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from functools import partial

import numpy as np

from lie_rigid_body.estimates.estimators import Estimator, Source, Workers, called
from lie_rigid_body.evaluation import attitude_error, bias_error
from lie_rigid_body.evaluation.statistics import (
    MIN_SHARE,
    largest_of_second_half,
    rms,
    settling_limit,
    time_to_converge,
)
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.league.cases import CASES, SEED, SETTLED_S, Case, readings_hash, run_of
from lie_rigid_body.league.table import LOST_DEG, CaseResult, FilterRow, reference
from lie_rigid_body.runs.ensemble import BlindRun


def play(name: str, source: Source, *, workers: int, timeout_s: float, progress: Callable[[], object]) -> FilterRow:
    """Run a filter over all cases, in processes.

    Parameters
    ----------
    name : str
        Name of the row.
    source : Source
        Where the processes find the filter.
    workers : int
        Number of processes.
    timeout_s : float
        Longest time of a case, s.
    progress : callable
        Called after each case.

    Raises
    ------
    InputError
        If the filter fails in every case, with what it failed of in the first.
    """
    results: dict[str, CaseResult] = {}
    other: list[str] = []
    with closing(Workers(source, workers, timeout_s)) as pool:
        for case, answer in zip(CASES, pool.each([partial(_play_here, case=case) for case in CASES]), strict=True):
            result, digest = (lost(answer), "") if isinstance(answer, InputError) else answer
            results[str(case)] = result
            if digest and digest != reference().readings[str(case)]:
                other.append(str(case))
            progress()
    if all(result.failure for result in results.values()):
        raise InputError(f"{name} gave no estimate in any case: {results[str(CASES[0])].failure}")
    return FilterRow(name, results, other_readings=tuple(other))


def _play_here(estimate: Estimator, case: Case) -> tuple[CaseResult, str]:
    return play_case(estimate, case), readings_hash(run_of(case))


def play_case(estimate: Estimator, case: Case, seed: int = SEED) -> CaseResult:
    """Score a filter in one case; it is given the readings, and nothing of the truth."""
    run = run_of(case, seed)
    begin_ns = run.t_ns[0]
    due_ns = run.sensors["imu"].t_ns
    try:
        found = called(estimate, BlindRun.without_truth(run), SETTLED_S)
        error = attitude_error(found.attitude_xyzw, run.attitude().at(found.t_ns))
        t_s = (found.t_ns - begin_ns) / 1e9
        settled = t_s >= SETTLED_S
        count = int(np.sum(settled))
        due = int(np.sum(due_ns - begin_ns >= SETTLED_S * 1e9))
        if count < MIN_SHARE * due:
            raise InputError(
                f"{count} attitudes after {SETTLED_S:g} s, for {due} readings of the IMU: give half at least"
            )
    except InputError as failure:
        return lost(failure)
    off = None
    if found.gyro_bias is not None:
        with suppress(InputError):  # one that is not finite costs no attitude
            off = bias_error(found.gyro_bias[settled], run.gyro_bias_at(found.t_ns[settled])).rms
    total = np.degrees(error.total)
    of_axis = [float(np.degrees(rms(angle[settled]))) for angle in (error.total, error.heading, error.inclination)]
    return CaseResult(
        of_axis[0],
        of_axis[1],
        of_axis[2],
        converged_s=time_to_converge(t_s, total, settling_limit(largest_of_second_half(t_s, total))),
        gyro_bias_rms_rad_s=off,
    )


def lost(failure: InputError) -> CaseResult:
    """The result of a filter that failed."""
    return CaseResult(LOST_DEG, LOST_DEG, LOST_DEG, None, str(failure))
