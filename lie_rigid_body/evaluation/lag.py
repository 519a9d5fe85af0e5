"""The time lag of an estimate: whether the motion tells it, and whether it is one or what drifts feign."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.alignment import (
    LAG,
    Convention,
    Misalignment,
    RunComparison,
    fit,
    lag_standard_error,
    separable,
)
from lie_rigid_body.evaluation.attitudes import angles_between, sizes
from lie_rigid_body.evaluation.explanation import (
    ALL_CONSTANTS,
    FEWEST_FITTED,
    NEGLIGIBLE,
    TIE_FACTOR,
    Explanation,
    median_left,
)
from lie_rigid_body.evaluation.search import LAG_TURN, spread, written
from lie_rigid_body.evaluation.statistics import later_quarters, rms

LAG_SAMPLES: Final = 20_000
"""Largest number of samples that the lag is fitted to."""

AT_LIMIT: Final = 0.999
"""Share of the longest lag above which a fitted lag counts as at the limit."""

SIGNIFICANT: Final = 3.0
"""Least lag, in standard errors, that is told from none."""

SURE: Final = 8.0
"""Least lag, in standard errors, that is told and named also where other errors are larger."""

UNSTEADY: Final = 0.25
"""Largest relative difference between the lag of each half of a run and that of the whole.

A lag that grows in proportion to time, as a drift feigns it, differs by half: this is in the middle."""

LOST: Final = float(np.radians(20.0))
"""Median angle that is left above which an estimate follows the truth too little to tell a lag, rad."""

FAR: Final = 1.0 - float(np.log2(TIE_FACTOR))
"""Further cost of a far lag: alone it is not named if a near lag with a mounting leaves clearly less.

Where both leave the same the far lag is named: an even top makes of it a near lag with a mounting."""

MOST_OTHER_LAGS: Final = 1000
"""Largest number of other lags, either way, that a far one is held against."""


def told_lag(comparison: RunComparison, explanation: Explanation) -> tuple[float, float] | tuple[None, None]:
    """Tell the lag and its standard error, s, beside heading and mounting where the motion tells them apart.

    Where it does not, the lag is fitted beside what was found. A lag is told in three cases: it is named as a cause; it
    is about the same in each half of the run and is sure, eight times its standard error, or halves the error and is
    three times that; or it is none of these, and its standard error is small beside a lag that would turn the body by
    the error that is left. Between them is what slow errors may feign. A lag that is not named is not told either where
    the error that is left is above `LOST`.
    """
    ours = written(comparison, explanation.convention)
    ours = ours.part(spread(len(ours.stamps_ns), LAG_SAMPLES))
    if len(ours.stamps_ns) < FEWEST_FITTED:
        return None, None
    for free in (ALL_CONSTANTS, explanation.free | {LAG}):
        if separable(ours, free, explanation.misalignment) or free == explanation.free:
            return _told(ours, free, explanation)
    return None, None


def _is_the_same_in_halves(comparison: RunComparison, fitted: Misalignment) -> bool:
    """Whether each half of a run alone tells about the same lag; what drifts feign hardly does."""
    for half in np.array_split(np.arange(len(comparison.stamps_ns)), 2):
        alone = fit(comparison.part(half), ALL_CONSTANTS, fitted)
        if abs(alone.lag_s - fitted.lag_s) > UNSTEADY * abs(fitted.lag_s):
            return False
    return True


def is_far(comparison: RunComparison, misalignment: Misalignment) -> bool:
    """Whether the body turns by more than half a turn in a lag."""
    return abs(misalignment.lag_s) * comparison.fastest() > np.pi


def is_nearest(comparison: RunComparison, explanation: Explanation, tried: Iterable[Explanation]) -> bool:
    """Whether a lag is near, or every explanation tried without a far lag costs clearly more.

    One of the causes of the latter would take the place of the far lag.
    """
    if not is_far(comparison, explanation.misalignment):
        return True
    near = (e.cost for e in tried if e.causes and not is_far(comparison, e.misalignment))
    return explanation.cost + FAR < min(near, default=np.inf)


def is_for_all_quarters(comparison: RunComparison, explanation: Explanation) -> bool:
    """Whether no other lag leaves half of what a far lag leaves in any quarter of the run, from the second on.

    Of a motion that nearly repeats there are many far ones that fit better than none beside errors that drift, each for
    a while. Others are looked for within a quarter of the run.
    """
    ours, found = written(comparison, explanation.convention), explanation.misalignment
    if not is_far(ours, found):
        return True
    fastest = ours.fastest()
    longest_s = max(ours.longest_lag_s, float(ours.stamps_ns[-1] - ours.stamps_ns[0]) / 4e9)
    most = min(int(longest_s * fastest / LAG_TURN), MOST_OTHER_LAGS)
    lags = np.arange(-most, most + 1) * (LAG_TURN / fastest)
    tried = [found.lag_s, *lags[np.abs(lags - found.lag_s) * fastest > np.pi].tolist()]
    quarters = (_medians(ours.part(quarter), found, tried) for quarter in later_quarters(len(ours.stamps_ns)))
    return all(medians[0] <= 2.0 * max(medians.min(), NEGLIGIBLE) for medians in quarters)


def _medians(comparison: RunComparison, misalignment: Misalignment, lags_s: list[float]) -> Array:
    """Medians of the angles that some lags leave, rad; infinite where less than half of the samples have a truth."""
    stamps = np.stack([comparison.true_stamps(lag_s) for lag_s in lags_s])
    known = comparison.truth.covers(stamps)
    truth = comparison.truth.at(np.clip(stamps, comparison.truth.first_ns, comparison.truth.last_ns))
    angles = np.where(known, angles_between(misalignment.predict(truth), comparison.estimate_xyzw), np.inf)
    return np.asarray(np.median(angles, axis=-1))


def _told(
    comparison: RunComparison, free: frozenset[str], explanation: Explanation
) -> tuple[float, float] | tuple[None, None]:
    fitted = fit(comparison, free, explanation.misalignment)
    without = fit(comparison, free - {LAG}, replace(fitted, lag_s=0.0))
    before, left = (median_left(comparison, Convention(), m) for m in (without, fitted))
    named, lag_s = LAG in explanation.free, abs(fitted.lag_s)
    error = lag_standard_error(comparison, free, fitted)
    large = free == ALL_CONSTANTS and (lag_s >= SURE * error or before >= 2.0 * left)
    if left >= LOST and not named:
        return None, None
    explains = named or (large and _is_the_same_in_halves(comparison, fitted))
    if not explains:
        error = lag_standard_error(comparison, free, without)
    rate = rms(sizes(comparison.true_states(0.0)[1]))
    if explains:
        raw = median_left(comparison, Convention(), Misalignment())
        told = named or (SIGNIFICANT * error <= lag_s and lag_s * rate <= 2.0 * raw)
    else:
        told = lag_s <= SIGNIFICANT * error and 4.0 * error * rate <= before
    return (fitted.lag_s, error) if told and lag_s < AT_LIMIT * comparison.longest_lag_s else (None, None)
