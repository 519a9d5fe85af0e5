"""Another clock of an estimate's stamps: far lags, and other rates, as by a mistaken unit or the time of day."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.attitudes import sizes
from lie_rigid_body.evaluation.causes import BY_CODE, Part, Track, fit, undone
from lie_rigid_body.evaluation.naming import FEWEST, NEGLIGIBLE, SHARE, UNLIKE, spread
from lie_rigid_body.evaluation.truth import Truth

LARGEST_LEFT: Final = float(np.radians(5.0))
"""Largest root mean square of the error that is left by a clock, rad: any clock fits a little."""
LEAST_COVERED: Final = {True: 0.25, False: 0.9}
"""Least share of the samples within the truth's times by another lag, and by another rate."""
MOST_STRAY: Final = 0.05
"""Largest share of the samples at either end that may be stamped far from all others, and are then left out."""
GRID_TURN: Final = 0.2
"""Turn of the body from one clock that is tried to the next, rad."""
MOST_CLOCKS: Final = 5000
"""Largest number of clocks that are tried of one kind; more are not."""
LEAST_TURN: Final = 0.1
"""Least turn of the body in the whole run that tells a clock, rad."""
GRID_SAMPLES: Final = 60
FIT_SAMPLES: Final = 300
"""Largest number of samples by which clocks are tried, and fitted."""
MOST_REFINED: Final = 5
SPIN: Final = 0.9
"""Squared length of the mean axis of rotation above which a body turns about one axis: so an error of a gyro does."""
FAR: Final = 1.5
"""Ratio of two rates above which no error of a gyro feigns it."""
MOSTLY_SPANNED: Final = 0.8
"""Least share of the truth's times that stamps by another rate fill, where the body turns about one axis."""

Clock = list[Part]
"""A rate, and a lag, by which stamps are those of the truth; of a lag alone only that."""


def other_clock(track: Track) -> tuple[Clock, Track] | None:
    """Search for another clock by which an estimate follows the truth.

    Parameters
    ----------
    track : Track
        All samples, also those outside of the truth's times.

    Returns
    -------
    tuple of Clock and Track, or None
        The clock, and the samples that it puts within the truth's times.
    """
    truth, track = track.truth, _without_strays(track)
    some = np.linspace(truth.first_ns, truth.last_ns, 200).round().astype(np.int64)
    rate = truth.states(some[truth.covers(some)])[1]
    fastest, duration = float(sizes(rate).max(initial=0.0)), (truth.last_ns - truth.first_ns) / 1e9
    if fastest * duration < LEAST_TURN or len(track.stamps_ns) < FEWEST:
        return None
    best, least = None, np.inf
    for rates, lags in _grids(track, GRID_TURN / fastest):
        for k in _lowest(_costs(track, rates, lags), rates[0] == 1.0):
            lag = (BY_CODE["lagging"], np.array([lags[k]]))
            clock = [lag] if rates[k] == 1.0 else [(BY_CODE["clock_rate"], np.array([rates[k]])), lag]
            found = _refined(track, clock)
            if found is not None and found[1] * (1 + len(clock)) < least:
                best, least = found[0], found[1] * (1 + len(clock))
    return None if best is None else (best, undone(track, best).known())


def rate_of(clock: Clock) -> float:
    """Seconds of the truth in a second of the stamps."""
    return float(clock[0][1][0]) if len(clock) > 1 else 1.0


def _without_strays(track: Track) -> Track:
    """The track without the few samples that are farther from all others than these span, as by one wrong stamp."""
    stamps, few = track.stamps_ns, round(MOST_STRAY * len(track.stamps_ns))
    first, last = int(stamps[few]), int(stamps[-1 - few])
    return track.part(np.flatnonzero((stamps >= 2 * first - last) & (stamps <= 2 * last - first)))


def _grids(track: Track, step_s: float) -> Iterator[tuple[Array, Array]]:
    """Rates and lags, s, that are tried: all lags, then all rates by which the last sample is within the truth."""
    truth: Truth = track.truth
    first, last = int(track.stamps_ns[0]), int(track.stamps_ns[-1])
    begin, end = (first - truth.last_ns) / 1e9, (last - truth.first_ns) / 1e9
    if end - begin <= MOST_CLOCKS * step_s:
        lags = np.arange(begin, end, step_s)
        yield np.ones(len(lags)), lags
    for anchor in {first, truth.first_ns, 0}:
        span = (truth.last_ns - anchor) / 1e9
        if truth.first_ns <= anchor < last and step_s <= span <= MOST_CLOCKS * step_s:
            rates = np.arange(step_s, span + step_s, step_s) * 1e9 / (last - anchor)
            yield rates, (anchor - first) / 1e9 * (rates - 1.0)


def _costs(track: Track, rates: Array, lags_s: Array) -> Array:
    """Mean sine of half of the error by each clock; infinite where it leaves too few samples within the truth."""
    few, truth = track.part(spread(len(track.stamps_ns), GRID_SAMPLES)), track.truth
    since = (few.stamps_ns - track.stamps_ns[0]) / 1e9
    found = []
    for part in np.array_split(np.arange(len(rates)), len(rates) // 500 + 1):
        true_s = rates[part, np.newaxis] * since - lags_s[part, np.newaxis]
        stamps = track.stamps_ns[0] + np.round(1e9 * true_s).astype(np.int64)
        known = truth.covers(stamps)
        at = truth.at(np.clip(stamps, truth.first_ns, truth.last_ns))
        sine = np.sqrt(np.maximum(1.0 - np.einsum("gni,ni->gn", at, few.attitude_xyzw) ** 2, 0.0))
        cost = np.sum(sine, axis=1, where=known) / np.maximum(known.sum(axis=1), 1)
        enough = known.mean(axis=1) >= LEAST_COVERED[bool(np.all(rates == 1.0))]
        found.append(np.where(enough, cost, np.inf))
    return np.concatenate(found)


def _lowest(costs: Array, is_lag: bool) -> list[int]:
    """Numbers of the minima that are as low as a grid can tell, the lowest first."""
    around = np.concatenate([[np.inf], costs, [np.inf]])
    minima = np.flatnonzero(np.isfinite(costs) & (costs <= around[:-2]) & (costs <= around[2:]))
    near = minima[costs[minima] <= costs[minima].min(initial=np.inf) + 0.25 * GRID_TURN]
    return [int(k) for k in near[np.argsort(costs[near])][:MOST_REFINED]]


def _refined(track: Track, clock: Clock) -> tuple[Clock, float] | None:
    """The clock fitted to the samples that it covers, and the error that it leaves, rad; None where it explains little.

    It must leave little in every quarter of the run but the first, beside the error by the stamps as they are and
    beside the turn of the body.
    """
    for _ in range(3):
        covered = np.flatnonzero(track.truth.covers(undone(track, clock).stamps_ns))
        if len(covered) < max(FEWEST, LEAST_COVERED[len(clock) == 1] * len(track.stamps_ns)):
            return None
        few = track.part(np.r_[0, covered[spread(len(covered), FIT_SAMPLES)]])  # a rate is about the first stamp
        clock = fit([few], clock, steps=4)
    moved = undone(few, clock).known()
    truth, rate = moved.truth.states(moved.stamps_ns)
    left = _quarters(moved)
    own = few.known()
    before = _quarters(own) if len(own.stamps_ns) >= FEWEST else np.ones(3)
    outer = np.mean(truth[:, :, np.newaxis] * truth[:, np.newaxis], axis=0)
    still = 1.0 - float(np.linalg.eigvalsh(outer)[-1])
    most = np.minimum(SHARE**2 * before, min((0.5 * UNLIKE) ** 2 * still, np.sin(0.5 * LARGEST_LEFT) ** 2))
    if np.any(left > np.maximum(most, np.sin(0.5 * NEGLIGIBLE) ** 2)):
        return None
    axes = rate / np.maximum(sizes(rate), 1e-300)[:, np.newaxis]
    if np.sum(np.mean(axes, axis=0) ** 2) > SPIN:
        span, whole = moved.stamps_ns[-1] - moved.stamps_ns[0], track.truth.last_ns - track.truth.first_ns
        times = max(rate_of(clock), 1.0 / rate_of(clock))
        near = abs(float(clock[-1][1][0])) * float(sizes(rate).max()) < np.pi
        if not (near if len(clock) == 1 else times > FAR and span > MOSTLY_SPANNED * whole):
            return None
    return clock, float(2.0 * np.arcsin(np.sqrt(left.mean()))) + NEGLIGIBLE


def _quarters(track: Track) -> Array:
    """Mean of sin² of half of the error in each quarter but the first."""
    return np.array([np.mean(np.sin(0.5 * errors) ** 2) for errors in np.array_split(track.errors(), 4)[1:]])
