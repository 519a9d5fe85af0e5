"""Another clock: stamps of an estimate that run faster or slower than those of the truth, or are off by far.

The true time of a sample is anchor + rate · (stamp − anchor) − lag. One grid has all lags at the rate 1, others all
rates with the clocks alike at the first estimate, the first truth, or 0, as where a unit is mistaken. The best point
is refined by the lags of both halves. Conventions and misalignments are none: with them, another motion would do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.evaluation.alignment import LAG, Misalignment, RunComparison, fit, lag_standard_error
from lie_rigid_body.evaluation.attitudes import from_mean, sizes
from lie_rigid_body.evaluation.estimate import FARTHEST_NS
from lie_rigid_body.evaluation.explanation import NEGLIGIBLE
from lie_rigid_body.evaluation.gyro_errors import left_by_gyro_errors
from lie_rigid_body.evaluation.lag import LAG_SAMPLES
from lie_rigid_body.evaluation.search import spread
from lie_rigid_body.evaluation.statistics import FEWEST_SAMPLES, worst_quarter
from lie_rigid_body.evaluation.truth import Truth
from lie_rigid_body.wording import short_repr

LARGEST_LEFT: Final = float(np.radians(5.0))
"""Largest median angle that is left by a clock that is named, rad."""
LARGEST_SHARE: Final = 0.25
"""Largest median angle that is left by a clock that is named, as a share of the error and of `from_mean`."""
AS_GOOD: Final = 1.25
"""Ratio of the median angles left by errors of a gyro and by another rate, up to which the gyro is taken."""
LEAST_COVERED: Final = 0.25
"""Least share of the samples that a clock of rate 1 puts within the truth's times."""
MOSTLY_COVERED: Final = 0.9
"""Least share of the samples that a clock of another rate puts within the truth's times."""
MOST_STRAY: Final = 0.05
"""Largest share of the samples at either end that may be stamped far from all others, and are then left out."""
UNEVEN: Final = 3.0
"""Largest ratio of the median angle in a quarter of the run, from the second on, to that of the whole run."""

TABLE_TURN: Final = 0.1
"""Turn of the body between points of the table of the truth, rad."""
GRID_STEP: Final = 2.0
"""Distance between neighbouring points of a grid, in points of the table."""
MOST_POINTS: Final = 20_000
"""Largest number of points of the table of the truth; of a longer run the first part tells the clock."""
MOST_CLOCKS: Final = 50_000
"""Largest number of points of a grid; a larger grid is not searched."""
LEAST_TURN: Final = 0.1
"""Least turn of the body in the whole run that tells a clock, rad."""
MOST_REFINED: Final = 5
"""Largest number of points of a grid that are refined."""
GRID_SAMPLES: Final = 80
"""Number of samples by which a point of a grid is judged."""
FIT_SAMPLES: Final = 200
"""Largest number of samples by which a clock is refined."""
ROUNDS: Final = 12
"""Largest number of rounds of a refinement."""
SPIN: Final = 0.98
"""Squared length of the mean axis of rotation above which a body counts as turning about one axis."""
FAR: Final = 1.5
"""Ratio of two clock rates above which no error of a gyro feigns it."""
MOSTLY_SPANNED: Final = 0.8
"""Least share of the truth's times that samples span which are said to fill them."""
ONLY_LAG: Final = frozenset({LAG})
FINE: Final = 1e-8
"""Lag below which a refinement ends, s."""


@dataclass(frozen=True)
class StampClock:
    """Clock of an estimate's stamps, relative to that of the truth.

    Attributes
    ----------
    rate : float
        Seconds of the truth in a second of the estimate's stamps.
    anchor_ns : int
    lag_s : float
        The true time of a stamp is anchor + rate · (stamp − anchor) − lag.
    median : float
        Of the angles that are left, rad; infinite if it is not known, or the clock explains nothing.
    """

    rate: float
    anchor_ns: int
    lag_s: float = 0.0
    median: float = np.inf

    __repr__ = short_repr

    def true_stamps(self, stamps_ns: Integers) -> Integers:
        """True times of stamps, ns."""
        since = self.rate * (stamps_ns - self.anchor_ns) - 1e9 * self.lag_s
        return np.asarray(self.anchor_ns + np.clip(np.round(since), -FARTHEST_NS, FARTHEST_NS).astype(np.int64))

    @property
    def cost(self) -> float:
        """Cost as `Explanation.cost`: one cause, less simple than a heading; another rate beside a lag is two."""
        return 1.06 + 1.0 * (self.rate != 1.0) + float(np.log2(self.median))

    def moved(self, early: tuple[float, float], late: tuple[float, float]) -> StampClock:
        """Clock without the lags, s, that it has at two true times, s after the anchor."""
        (t, lag), (later, other) = early, late
        drift = (other - lag) / (later - t) if later != t else 0.0
        return StampClock(self.rate * (1.0 - drift), self.anchor_ns, self.lag_s * (1.0 - drift) + lag - drift * t)


def other_clock(comparison: RunComparison, error: float) -> StampClock | None:
    """Search for another clock by which an estimate follows the truth.

    Parameters
    ----------
    comparison : RunComparison
        Of all samples, also those outside of the truth's times.
    error : float
        Median error by the stamps as they are, rad.

    Returns
    -------
    StampClock or None
    """
    table, comparison = _Table.of(comparison.truth), _without_strays(comparison)
    if table is None or len(comparison.stamps_ns) < FEWEST_SAMPLES:
        return None
    found = []
    for grid in _grids(comparison, table):
        for k in _lowest(table.costs(grid, comparison)):
            clock = _refined(grid.clock(k), comparison, table.step_ns / 1e9)
            found.append(replace(clock, median=_left(clock, comparison)))
    best = min(found, key=lambda clock: clock.cost, default=None)
    if best is None or best.median > min(LARGEST_LEFT, LARGEST_SHARE * error) or _is_of_a_gyro(best, comparison):
        return None
    return best


def _without_strays(comparison: RunComparison) -> RunComparison:
    """Comparison without the few samples that are farther from all others than these span, as by one wrong stamp."""
    stamps, few = comparison.stamps_ns, round(MOST_STRAY * len(comparison.stamps_ns))
    first, last = int(stamps[few]), int(stamps[-1 - few])
    span = last - first
    return comparison.part(np.flatnonzero((stamps >= first - span) & (stamps <= last + span)))


def _is_of_a_gyro(clock: StampClock, comparison: RunComparison) -> bool:
    """Whether errors of a gyro explain as much as another clock rate that does not fill the truth's times."""
    known = comparison.part(np.flatnonzero(comparison.truth.covers(comparison.stamps_ns)))
    if clock.rate == 1.0 or len(known.stamps_ns) < FEWEST_SAMPLES or _spans(clock, by_clock(comparison, clock)):
        return False
    return left_by_gyro_errors(known) <= AS_GOOD * clock.median


def _lowest(costs: Array) -> list[int]:
    """Indices of the minima that are as low as the grid can tell, the lowest first."""
    padded = np.concatenate([[np.inf], costs, [np.inf]])
    minima = np.flatnonzero(np.isfinite(costs) & (costs <= padded[:-2]) & (costs <= padded[2:]))
    near = minima[costs[minima] <= costs[minima].min(initial=np.inf) + TABLE_TURN / 2.0]
    return [int(k) for k in near[np.argsort(costs[near])][:MOST_REFINED]]


def by_clock(comparison: RunComparison, clock: StampClock) -> RunComparison:
    """Comparison of the samples that a clock puts within the truth's times, at their true times."""
    true = clock.true_stamps(comparison.stamps_ns)
    return replace(comparison, stamps_ns=true).part(np.flatnonzero(comparison.truth.covers(true)))


def clock_lag(comparison: RunComparison, clock: StampClock) -> tuple[float, float] | tuple[None, None]:
    """Lag of a clock and its standard error, s; none of a clock of another rate."""
    if clock.rate != 1.0:
        return None, None
    true = by_clock(comparison, clock)
    some = true.part(spread(len(true.stamps_ns), LAG_SAMPLES))
    return clock.lag_s, lag_standard_error(some, ONLY_LAG, Misalignment())


@dataclass(frozen=True)
class _ClockGrid:
    """Grid of clocks with one anchor."""

    anchor_ns: int
    rates: Array
    lags_s: Array

    def clock(self, k: int) -> StampClock:
        return StampClock(float(self.rates[k]), self.anchor_ns, float(self.lags_s[k]))

    @property
    def least_covered(self) -> float:
        return LEAST_COVERED if np.all(self.rates == 1.0) else MOSTLY_COVERED


def _grids(comparison: RunComparison, table: _Table) -> Iterator[_ClockGrid]:
    """Grids of all lags, and of all rates by which the last sample is within the truth's times."""
    truth, step = comparison.truth, GRID_STEP * table.step_ns
    first, last = int(comparison.stamps_ns[0]), int(comparison.stamps_ns[-1])
    begin, end = ceil((first - table.last_ns) / step), ceil((last - truth.first_ns) / step)
    if end - begin <= MOST_CLOCKS:
        lags = np.arange(begin, end, dtype=np.float64) * step / 1e9
        yield _ClockGrid(first, np.ones(len(lags)), lags)
    for anchor in {first, truth.first_ns, 0}:
        count = int((truth.last_ns - anchor) / step) + 1
        if truth.first_ns <= anchor < last and 0 < count <= MOST_CLOCKS:
            rates = np.arange(1, count + 1) * step / (last - anchor)
            yield _ClockGrid(anchor, rates, np.zeros(count))


@dataclass(frozen=True)
class _Table:
    """Table of the truth at even times, the share of the run that they span, and where the truth is known."""

    first_ns: int
    step_ns: float
    share: float
    attitude_xyzw: Array
    known: Booleans

    @classmethod
    def of(cls, truth: Truth) -> _Table | None:
        """Tabulate the truth as finely as the motion asks for; None if the body hardly turns."""
        some = np.linspace(truth.first_ns, truth.last_ns, 200).round().astype(np.int64)
        some = some[truth.covers(some)]
        rate = truth.states(some)[1] if some.size else np.zeros((1, 3))
        fastest = float(sizes(rate).max())
        duration = truth.last_ns - truth.first_ns
        if fastest * duration < 1e9 * LEAST_TURN:
            return None
        step = 1e9 * TABLE_TURN / fastest
        count = min(int(duration / step) + 1, MOST_POINTS)
        stamps = truth.first_ns + np.round(step * np.arange(count)).astype(np.int64)
        return cls(truth.first_ns, step, step * (count - 1) / duration, truth.at(stamps), truth.covers(stamps))

    @property
    def last_ns(self) -> int:
        return self.first_ns + round(self.step_ns * (len(self.known) - 1))

    def costs(self, grid: _ClockGrid, comparison: RunComparison) -> Array:
        """Mean sine of half of the angles by each clock; infinite where it leaves too few samples within the table."""
        stamps, estimate = comparison.stamps_ns, comparison.estimate_xyzw
        fewest = max(FEWEST_SAMPLES, grid.least_covered * self.share * len(stamps))
        since = (stamps - grid.anchor_ns).astype(np.float64)
        found = []
        for part in np.array_split(np.arange(len(grid.rates)), len(grid.rates) // 1000 + 1):
            rate, lag = grid.rates[part], 1e9 * grid.lags_s[part]
            begin = np.searchsorted(since, (self.first_ns - grid.anchor_ns + lag) / rate)
            end = np.searchsorted(since, (self.last_ns - grid.anchor_ns + lag) / rate, side="right")
            fraction = np.linspace(0.0, 1.0, GRID_SAMPLES)
            chosen = begin[:, np.newaxis] + (np.maximum(end - begin - 1, 0)[:, np.newaxis] * fraction).astype(np.int64)
            chosen = np.minimum(chosen, len(stamps) - 1)
            true = rate[:, np.newaxis] * since[chosen] - lag[:, np.newaxis] + (grid.anchor_ns - self.first_ns)
            place = np.clip(np.round(true / self.step_ns), 0, len(self.known) - 1).astype(np.int64)
            cosine = np.einsum("ijk,ijk->ij", self.attitude_xyzw[place], estimate[chosen])
            sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
            cost = np.sum(sine, axis=1, where=self.known[place]) / np.maximum(np.sum(self.known[place], axis=1), 1)
            found.append(np.where(end - begin >= fewest, cost, np.inf))
        return np.concatenate(found)


def _refined(clock: StampClock, comparison: RunComparison, step_s: float) -> StampClock:
    """Refine the lag of a clock, and its rate if that is not 1, until the estimate follows the truth best."""
    for _ in range(ROUNDS):
        true = by_clock(comparison, clock)
        if len(true.stamps_ns) < FEWEST_SAMPLES:
            return clock
        few = replace(true, longest_lag_s=5.0 * step_s).part(spread(len(true.stamps_ns), FIT_SAMPLES))
        whole = np.arange(len(few.stamps_ns))
        parts = [few.part(part) for part in np.array_split(whole, 1 if clock.rate == 1.0 else 2)]
        lags = [(float(np.mean(part.stamps_ns - clock.anchor_ns)) / 1e9, _lag(part)) for part in parts]
        clock = clock.moved(lags[0], lags[-1])
        if max(abs(lag) for _, lag in lags) < FINE:
            break
    return clock


def _lag(comparison: RunComparison) -> float:
    return fit(comparison, ONLY_LAG, Misalignment(), steps=3, smallest_step=FINE).lag_s


def _left(clock: StampClock, comparison: RunComparison) -> float:
    """Median angle that a clock leaves, rad; infinite if the estimate does not follow the body all along by it."""
    true = by_clock(comparison, clock)
    share = LEAST_COVERED if clock.rate == 1.0 else MOSTLY_COVERED
    if len(true.stamps_ns) < max(FEWEST_SAMPLES, share * len(comparison.stamps_ns)):
        return np.inf
    angles, few = true.angles(Misalignment()), true.part(spread(len(true.stamps_ns), FIT_SAMPLES))
    left, (attitude, rate) = max(float(np.median(angles)), NEGLIGIBLE), few.true_states(0.0)
    uneven = worst_quarter(angles) > UNEVEN * left
    unlike = left > LARGEST_SHARE * min(from_mean(attitude), _as_stamped(clock, comparison))
    feigned = _is_spin(rate) and not (_spans(clock, true) if clock.rate != 1.0 else _is_within_half_a_turn(clock, rate))
    return np.inf if uneven or unlike or feigned else left


def _as_stamped(clock: StampClock, comparison: RunComparison) -> float:
    """Median angle by the stamps as they are, rad, of the samples that a clock puts within the truth's times.

    Only these are compared: else a lag would win by leaving the samples that err without a truth.
    """
    compared = comparison.truth.covers(clock.true_stamps(comparison.stamps_ns))
    angles = comparison.part(np.flatnonzero(compared)).angles(Misalignment())
    return float(np.median(angles)) if len(angles) >= FEWEST_SAMPLES else np.inf


def _is_spin(rate: Array) -> bool:
    """Whether a body turns about one axis, so that an error of the gyro's scale or bias turns the estimate alike."""
    axes = rate / np.maximum(sizes(rate), 1e-300)[:, np.newaxis]
    return bool(np.sum(np.mean(axes, axis=0) ** 2) > SPIN)


def _is_within_half_a_turn(clock: StampClock, rate: Array) -> bool:
    """Whether a lag is so short that the attitude is not that of a turn earlier or later as well."""
    return abs(clock.lag_s) * float(sizes(rate).max()) < np.pi


def _spans(clock: StampClock, true: RunComparison) -> bool:
    """Whether a clock of a far other rate makes an estimate fill the truth's times, as no error of a gyro does."""
    truth = true.truth
    span = float(true.stamps_ns[-1] - true.stamps_ns[0])
    return max(clock.rate, 1.0 / clock.rate) > FAR and span > MOSTLY_SPANNED * (truth.last_ns - truth.first_ns)
