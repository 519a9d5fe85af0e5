"""The clock of an estimate's stamps: its lag with a standard error, a far lag, or another rate.

A lag is told where it is one and not what slow errors feign. Another clock, as by a mistaken unit or by the time of day
beside a replay, is looked for where nothing else explains a large error.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.attitudes import sizes
from lie_rigid_body.evaluation.causes import BY_CODE, UP, Part, derivative, fit, late, undone, weights
from lie_rigid_body.evaluation.evidence import BOTH, FULL, LEAD, LEAST_LATE, SHARE, UNLIKE
from lie_rigid_body.evaluation.explanations import LARGEST_LEFT, NEGLIGIBLE, Explanation
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.track import FEWEST, SPIN, Track, quarters, spins, still
from lie_rigid_body.lie import quaternion

SIGNIFICANT: Final = 3.0
"""Largest lag, in standard errors, that counts as none."""
SURE: Final = 8.0
"""Least lag, in standard errors, that is told and named also where other errors are larger."""
UNSTEADY: Final = 0.25
"""Largest relative difference between the lag of each half of a run and that of the whole; a drift makes a half."""
LARGEST_INFLATION: Final = 10.0
"""Largest variance inflation factor at which a lag counts as told apart from turns."""
SLOWEST_RATE: Final = 1e-6
"""Least body rate that tells something about time, rad/s."""
LEFT_BY_CLOCK: Final = float(np.radians(5.0))
"""Largest error, root mean square in a quarter, that is left by another clock, rad: any clock fits a little."""
LEAST_COVERED: Final = {True: 0.25, False: 0.9}
"""Least share of the samples within the truth's times by another lag, and by another rate."""
MOST_STRAY: Final = 0.05
"""Largest share of the samples at either end that may be stamped far from all others, and are then left out."""
GRID_TURN: Final = 0.2
"""Turn of the body from one clock that is tried to the next, rad."""
MOST_CLOCKS: Final = 5000
"""Largest number of clocks that are tried of one kind; where it would take more, none is."""
LEAST_TURN: Final = 0.1
"""Least turn of the body in the whole run that tells a clock, rad."""
EVEN_SPIN: Final = 0.98
"""Squared length of the mean axis of rotation above which a lag is that of a turn earlier as well."""
FAR: Final = 1.5
"""Ratio of two rates above which no error of a gyro feigns it."""
LEAST_OFF: Final = 2e-3
"""Least difference of a rate from 1: a lag with a little of a rate is a lag, as that of a right filter."""
MOSTLY_SPANNED: Final = 0.8
"""Least share of the truth's times that stamps by another rate fill, where the body turns about one axis."""

Clock = list[Part]
"""A rate, and a lag, by which stamps are those of the truth; of a lag alone only that."""


class Lag(NamedTuple):
    """A lag that is told.

    Attributes
    ----------
    lag_s, standard_error_s : float or None
        None where the motion and the errors do not tell it.
    sure : bool
        Whether it is a cause beside errors as large.
    """

    lag_s: float | None = None
    standard_error_s: float | None = None
    sure: bool = False


def lag_of(track: Track, named: Explanation, longest_lag_s: float, period_s: float, most: int = 4000) -> Lag:
    """Tell the lag beside a turn of the world and one of the body where the motion tells them apart.

    Where it does not, the lag is fitted beside a heading and a mounting, else beside the turns that are named. Then a
    tilt of the world, which sensors leave as well, may be told as a lag. So the standard error of a named one is at
    least by how much another it is beside a tilt. A lag is told where it is named, where it is sure, and where it is
    none. The latter is to an error that is small beside a lag that would turn the body by what is left. It is fitted to
    `most` samples.
    """
    parts = [part for part in named.parts if part[0].code in BOTH]
    track = undone(track.few(most), [part for part in named.parts if part[0].maps and part[0].code not in BOTH])
    lag, known = late(named.lag_s or 0.0), {cause.code: fitted for cause, fitted in parts}
    up, mounting = known.get("heading_offset", np.zeros(1)), known.get("body_mounting", np.zeros(3))
    body = BY_CODE["body_mounting"], mounting
    tilted, level = [(BY_CODE["world_turned"], up * UP), body], [(BY_CODE["heading_offset"], up), body]
    for turned in (tilted, level, parts):
        if _separable(track, [*turned, lag]) or (named.lag_s is not None and turned is parts):
            fitted = fit([track], [*turned, lag])
            lag_s = float(fitted[-1][1][0])
            if abs(lag_s) > FULL * longest_lag_s:
                return Lag()
            if named.lag_s is not None:
                beside_tilt = float(fit([track], [*tilted, lag])[-1][1][0])
                return Lag(lag_s, max(standard_error(track, fitted), abs(lag_s - beside_tilt)))
            instead = fitted if turned is tilted else fit([track], tilted)
            found = _unnamed(track, fitted, [*fit([track], turned), lag], instead, period_s)
            return found if turned is not parts else found._replace(sure=False)
    return Lag()


def _unnamed(
    track: Track, fitted: Sequence[Part], without: Sequence[Part], instead: Sequence[Part], period_s: float
) -> Lag:
    """The lag of fitted constants, or none of others: told where it is sure, or small and sure to be.

    A lag leaves no more than what is fitted instead of it, a turn of the world and one of the body. The lead of a right
    filter may leave more.
    """
    lag_s, error = float(fitted[-1][1][0]), standard_error(track, fitted)
    left, before, other, raw = (
        float(np.median(undone(track, parts).error().total)) for parts in (fitted, without, instead, ())
    )
    turn = rms(sizes(track.truth.states(track.stamps_ns)[1]))
    if left > LARGEST_LEFT:  # what follows the truth so little tells no lag
        return Lag()
    clear = abs(lag_s) >= SURE * error or (abs(lag_s) >= SIGNIFICANT * error and before >= 2.0 * left)
    # each half of a run alone tells about the same lag; what drifts feign hardly does
    halves = [track.part(half) for half in np.array_split(np.arange(len(track.stamps_ns)), 2)]
    alone = (float(fit([half], fitted)[-1][1][0]) for half in halves)
    lead = -LEAD * period_s <= lag_s <= 0.0
    clear &= abs(lag_s) * turn <= min(2.0 * raw, 0.5 * np.pi) and (lead or left <= other)
    if clear and all(abs(of_half - lag_s) <= UNSTEADY * abs(lag_s) for of_half in alone):
        return Lag(lag_s, error, abs(lag_s) >= max(SURE * error, LEAST_LATE * period_s) and not lead)
    error = max(standard_error(track, without), 1e-9)  # stamps are whole nanoseconds
    told = abs(lag_s) <= SIGNIFICANT * error and 4.0 * error * turn <= max(before, NEGLIGIBLE)
    return Lag(lag_s, error) if told else Lag()


def _separable(track: Track, parts: Sequence[Part]) -> bool:
    """Whether the motion tells the lag, the last of some constants, from the others, and turns at all.

    The variance of a lag that is fitted alone grows by a factor when others are fitted with it.
    """
    J = derivative(track, parts)[0]
    normal = np.einsum("nia,nib->ab", J, J)
    alone = float(normal[-1, -1])
    shared = normal[-1, :-1] @ np.linalg.lstsq(normal[:-1, :-1], normal[:-1, -1], rcond=1e-10)[0]
    return bool(alone > SLOWEST_RATE**2 * len(J) and alone <= LARGEST_INFLATION * (alone - shared))


def standard_error(track: Track, parts: Sequence[Part]) -> float:
    """Standard error of the lag, the last of fitted constants, s.

    The fit takes the lag as a weighted sum of the errors, G · ψ. The same sum with the errors moved along the run, in a
    circle, is what errors of that spectrum make of a lag where there is none. Its root mean square over all shifts
    counts white errors as independent, and drifts as the few that they are. Errors keep to the axes of the world, as
    those of a heading, or to those of the body, as biases do. Of a body that turns evenly the shifts are all alike and
    tell nothing: errors that are independent are counted as well. The largest value counts.
    """
    J, error, truth = derivative(track, parts)
    weight = weights(sizes(error))[:, np.newaxis]
    normal = np.einsum("nia,nib->ab", J * weight[..., np.newaxis], J)
    G, psi = J @ np.linalg.pinv(normal, rcond=1e-10)[:, -1], weight * error
    independent = float(np.sqrt(np.sum(G**2) * np.mean(psi**2)))
    both = np.stack([(G, psi), (quaternion.rotate(truth, G), quaternion.rotate(truth, psi))])
    of_weights, of_errors = np.moveaxis(np.fft.rfft(both, axis=2), 1, 0)
    shifted = np.fft.irfft((np.conj(of_weights) * of_errors).sum(axis=2), n=len(G))
    return max(rms(shifted[0]), rms(shifted[1]), independent)


def other_clock(track: Track, beyond_s: float = 0.0) -> tuple[Clock, Track] | None:
    """Search for another clock by which an estimate follows the truth.

    Parameters
    ----------
    track : Track
        All samples, also those outside of the truth's times.
    beyond_s : float
        Lags up to this were judged before, s.

    Returns
    -------
    tuple of Clock and Track, or None
        The clock, and the samples that it puts within the truth's times.
    """
    truth, track = track.truth, _without_strays(track)
    some = np.linspace(truth.first_ns, truth.last_ns, 200).round().astype(np.int64)
    fastest = float(sizes(truth.states(some[truth.covers(some)])[1]).max(initial=0.0))
    if fastest * (truth.last_ns - truth.first_ns) < 1e9 * LEAST_TURN or len(track.stamps_ns) < FEWEST:
        return None
    found = []
    for rates, lags in _grids(track, GRID_TURN / fastest):
        for k in _lowest(_costs(track, rates, lags)):
            rate = [] if rates[k] == 1.0 else [(BY_CODE["clock_rate"], np.array([rates[k]]))]
            clock = [*rate, late(float(lags[k]))]
            found += [one for one in _refined(track, clock) if len(clock) > 1 or abs(one[0][0][1][0]) > beyond_s]
    # as good as each other: one constant before two
    return min(found, key=lambda clock: len(clock[0]) * (NEGLIGIBLE + rms(clock[1].error().total)), default=None)


def rate_of(clock: Clock) -> float:
    """Seconds of the truth in a second of the stamps."""
    return float(clock[0][1][0]) if len(clock) > 1 else 1.0


def clock_lag(clock: Clock, track: Track) -> Lag:
    """Lag of a clock and its standard error by the samples that it covers; none of a clock of another rate."""
    (cause, lag_s), *rate = clock[::-1]
    return Lag() if rate else Lag(float(lag_s[0]), standard_error(track, [(cause, np.zeros(1))]))


def _without_strays(track: Track) -> Track:
    """The track without the few samples that are farther from all others than these span, as by one wrong stamp."""
    stamps, few = track.stamps_ns, round(MOST_STRAY * len(track.stamps_ns))
    first, last = int(stamps[few]), int(stamps[-1 - few])
    kept = np.flatnonzero((stamps >= 2 * first - last) & (stamps <= 2 * last - first))
    return replace(track.part(kept), origin_ns=None)  # a rate is about the first of these


def _grids(track: Track, step_s: float) -> Iterator[tuple[Array, Array]]:
    """Rates and lags, s, that are tried: all lags, then all rates by which the last sample is within the truth."""
    truth, first, last = track.truth, int(track.stamps_ns[0]), int(track.stamps_ns[-1])
    begin, end = (first - truth.last_ns) / 1e9, (last - truth.first_ns) / 1e9
    if end - begin <= MOST_CLOCKS * step_s:
        lags = np.arange(begin, end, step_s)
        yield np.ones(len(lags)), lags
    for anchor in {first, truth.first_ns, 0}:
        span = (truth.last_ns - anchor) / 1e9
        if truth.first_ns <= anchor < last and step_s <= span <= MOST_CLOCKS * step_s:
            rates = np.arange(step_s, span + step_s, step_s) * 1e9 / (last - anchor)
            yield rates, (anchor - first) / 1e9 * (rates - 1.0)


def _costs(track: Track, rates: Array, lags_s: Array, most: int = 60) -> Array:
    """Mean sine of half of the error of some samples by each clock; infinite where too few are within the truth."""
    few, truth = track.few(most), track.truth
    since = (few.stamps_ns - track.stamps_ns[0]) / 1e9
    found = []
    for part in np.array_split(np.arange(len(rates)), len(rates) // 500 + 1):
        true_s = rates[part, np.newaxis] * since - lags_s[part, np.newaxis]
        stamps = track.stamps_ns[0] + np.round(1e9 * true_s).astype(np.int64)
        known, at = truth.covers(stamps), truth.at(np.clip(stamps, truth.first_ns, truth.last_ns))
        sine = np.sqrt(np.maximum(1.0 - np.einsum("gni,ni->gn", at, few.attitude_xyzw) ** 2, 0.0))
        cost = np.sum(sine, axis=1, where=known) / np.maximum(known.sum(axis=1), 1)
        found.append(np.where(known.mean(axis=1) >= LEAST_COVERED[bool(np.all(rates == 1.0))], cost, np.inf))
    return np.concatenate(found)


def _lowest(costs: Array, most: int = 5) -> list[int]:
    """Numbers of some minima that are as low as a grid can tell, the lowest first."""
    around = np.concatenate([[np.inf], costs, [np.inf]])
    minima = np.flatnonzero(np.isfinite(costs) & (costs <= around[:-2]) & (costs <= around[2:]))
    near = minima[costs[minima] <= costs[minima].min(initial=np.inf) + 0.25 * GRID_TURN]
    return [int(k) for k in near[np.argsort(costs[near])][:most]]


def _refined(track: Track, clock: Clock, most: int = 300) -> list[tuple[Clock, Track]]:
    """The clock fitted to some of the samples that it covers, and these; none where it explains little.

    It must leave little in every quarter of the run but the first, beside the error by the stamps as they are and
    beside the turn of the body.
    """
    is_lag = len(clock) == 1
    for _ in range(3):
        covered = track.part(track.truth.covers(undone(track, clock).stamps_ns))
        if len(covered.stamps_ns) < max(FEWEST, LEAST_COVERED[is_lag] * len(track.stamps_ns)):
            return []
        few = covered.few(most)
        clock = fit([few], clock, steps=4)
    moved, own = undone(few, clock).known(), few.known()
    if len(moved.stamps_ns) < FEWEST:  # the last fit leaves the truth's times
        return []
    truth, rate = moved.truth.states(moved.stamps_ns)
    before = quarters(own) if len(own.stamps_ns) >= FEWEST else np.ones(3)
    allowed = np.minimum(SHARE**2 * before, min((0.5 * UNLIKE) ** 2 * still(truth), np.sin(0.5 * LEFT_BY_CLOCK) ** 2))
    is_of_rate_1 = not is_lag and abs(rate_of(clock) - 1.0) < LEAST_OFF
    if is_of_rate_1 or np.any(quarters(moved) > np.maximum(allowed, np.sin(0.5 * NEGLIGIBLE) ** 2)):
        return []
    if spins(rate, EVEN_SPIN if is_lag else SPIN):
        span, whole = moved.stamps_ns[-1] - moved.stamps_ns[0], track.truth.last_ns - track.truth.first_ns
        times = max(rate_of(clock), 1.0 / rate_of(clock))
        near = abs(float(clock[-1][1][0])) * float(sizes(rate).max()) < np.pi
        if not (near if is_lag else times > FAR and span > MOSTLY_SPANNED * whole):
            return []
    return [(clock, undone(track, clock).known())]
