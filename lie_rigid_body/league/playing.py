"""A filter over the cases of the league."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import replace
from functools import partial
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.estimates.buffers import usable
from lie_rigid_body.estimates.estimators import Estimator, Source, Workers, called
from lie_rigid_body.evaluation import bias_error
from lie_rigid_body.evaluation.attitudes import period_ns
from lie_rigid_body.evaluation.causes import BY_CODE
from lie_rigid_body.evaluation.matched import Matched, error_of
from lie_rigid_body.evaluation.statistics import largest_of_second_half, rms, settling_limit, time_to_converge
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.league.cases import CASES, SETTLED_S, WIRING, Case, readings_hash, run_of
from lie_rigid_body.league.table import LOST_DEG, MOST, CaseResult, FilterRow, reference
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.ensemble import BlindRun

MIN_SHARE: Final = 0.9
"""Smallest share of the readings of the IMU, from `SETTLED_S` on, that have an answer in a case that is not lost."""
CONSTANTS: Final = ("heading_offset", "body_mounting", "lagging", "leading")
"""Codes of the causes with one constant that may explain most of a row's error."""


class Constant(NamedTuple):
    """A cause with its constant, which one process tells another.

    Attributes
    ----------
    code : str
        One of `CONSTANTS`.
    values : tuple of float
        In the unit of the cause.
    """

    code: str
    values: tuple[float, ...]

    @property
    def message(self) -> str:
        """Sentence about what is wrong, without a full stop."""
        return BY_CODE[self.code].fact(np.array(self.values))

    def left_deg(self, track: Matched) -> float:
        """RMS of the total error of a track without the constant, degrees."""
        return float(np.degrees(BY_CODE[self.code].left([track], np.array(self.values))))


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
    constant: Constant | None = None
    with closing(Workers(source, workers, timeout_s)) as pool:
        for cases in (CASES[:1], CASES[1:]):  # the first one has the constant
            answers = pool.each([partial(_play_here, case=case, constant=constant) for case in cases])
            for case, answer in zip(cases, answers, strict=True):
                if isinstance(answer, InputError):
                    results[str(case)] = lost(answer)
                else:
                    results[str(case)], constant, digest = answer
                    other += [str(case)] * (digest != reference().readings[str(case)])
                progress()
    if all(result.failure for result in results.values()):
        raise InputError(f"{name} gave no estimate in any case: {results[str(CASES[0])].failure}")
    row = FilterRow(name, results, constant=constant.message if constant else "", other_readings=tuple(other))
    return row if row.explained else replace(row, constant="")


def _play_here(estimate: Estimator, case: Case, constant: Constant | None) -> tuple[CaseResult, Constant | None, str]:
    return *play_case(estimate, case, constant), readings_hash(run_of(case))


def play_case(estimate: Estimator, case: Case, constant: Constant | None = None) -> tuple[CaseResult, Constant | None]:
    """Score a filter in one case; it is given the readings, and nothing of the truth.

    Parameters
    ----------
    estimate : callable
    case : Case
    constant : Constant, optional
        What explains most of its error in the case `WIRING`, without which it is scored as well.

    Returns
    -------
    result : CaseResult
    constant : Constant or None
        What was given; of the case `WIRING` what was found.
    """
    run = run_of(case)
    begin_ns = run.t_ns[0]
    due_ns = run.sensors["imu"].t_ns
    try:
        found = called(estimate, BlindRun.without_truth(run), SETTLED_S)
        found = found[usable(found)]
        late_ns = due_ns[due_ns - begin_ns >= SETTLED_S * 1e9]
        half_ns = period_ns(due_ns) // 2
        ends = np.searchsorted(found.t_ns, late_ns + half_ns, side="right")
        share = float(np.mean(ends > np.searchsorted(found.t_ns, late_ns - half_ns)))
        if share < MIN_SHARE:
            raise InputError(
                f"attitudes at {share:.0%} of the readings of the IMU after {SETTLED_S:g} s: give nine tenths at least"
            )
    except InputError as failure:
        return lost(failure), constant
    track = Matched(found.t_ns, quaternion.normalize(found.attitude_xyzw), run.attitude())
    error = track.error()
    t_s = (found.t_ns - begin_ns) / 1e9
    settled = t_s >= SETTLED_S
    off = None
    if found.gyro_bias is not None:
        with suppress(InputError):  # one that is not finite costs no attitude
            off = bias_error(found.gyro_bias[settled], run.gyro_bias_at(found.t_ns[settled])).rms
    total = np.degrees(error.total)
    of_axis = [float(np.degrees(rms(angle[settled]))) for angle in (error.total, error.heading, error.inclination)]
    if case == WIRING:
        constant = _constant(track[settled])
    result = CaseResult(
        of_axis[0],
        of_axis[1],
        of_axis[2],
        converged_s=time_to_converge(t_s, total, settling_limit(largest_of_second_half(t_s, total))),
        gyro_bias_rms_rad_s=off,
        without_constant_deg=constant.left_deg(track[settled]) if constant else None,
    )
    return result, constant


def _constant(track: Matched) -> Constant | None:
    """The one constant that explains most of an error; None where none does."""
    fits = {code: BY_CODE[code].fitted([track]) for code in CONSTANTS}
    code, (values, left) = min(fits.items(), key=lambda fit: fit[1][1])
    return Constant(code, tuple(values.tolist())) if left < MOST * error_of([track]) else None


def lost(failure: InputError) -> CaseResult:
    """The result of a filter that failed."""
    return CaseResult(LOST_DEG, LOST_DEG, LOST_DEG, None, str(failure))
