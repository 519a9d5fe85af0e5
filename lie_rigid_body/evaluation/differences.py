"""Ratios of the errors of estimators over runs that they have in common, and whether a difference is shown or luck.

Each run is a pair, as both estimators have the same motion and the same noise. The logarithms of the ratios of the RMS
errors are compared with 0 by the signed-rank test of F. Wilcoxon (Biometrics Bulletin 1:80, 1945), so a run that
diverges counts by its rank alone. The values p of several pairs are adjusted after S. Holm (Scandinavian Journal of
Statistics 6:65, 1979). The ratio and its interval are those of J. L. Hodges and E. L. Lehmann (Annals of Mathematical
Statistics 34:598, 1963), by the means of all two logarithms. The intervals of all pairs hold together (Bonferroni).

One run has no such interval: its samples are correlated, and an error that is constant in it differs in the next one.

Measured (benchmarks/paired_runs.py): of equally good filters a difference is shown in 4 to 6 % of campaigns, of six in
3 to 4 %. Where 5 % of the runs diverge, 25 runs show a ratio of 0.85 in 41 % of campaigns; Student's t of the
differences in degrees does in 4 %. Intervals hold the true ratio in 94 to 96 %.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from math import comb
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import real_numbers
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted

LEVEL: Final = 0.05
"""Probability that a difference is shown in any pair of equally good estimators, and that any interval misses."""
NO_ANSWER_DEG: Final = 180.0
"""Error of a run without an answer, degrees."""
MIN_ERROR_DEG: Final = 1e-9
"""Smallest error of which a ratio is taken, degrees."""
ROUND_OFF: Final = 1e-9
"""Largest logarithm of a ratio that counts as 0."""
MAX_EXACT: Final = 50
"""Largest number of runs of which the distribution of the ranks is exact; that of more is normal."""
MAX_MEANS: Final = 1000
"""Largest number of logarithms whose means are made; more are replaced by so many of their quantiles."""


@short_dataclass
class Difference:
    """Ratio of the errors of two estimators: below 1 where that of the first is smaller.

    Attributes
    ----------
    ratio, low, high : float
        The ratio and its interval at the level 1 − 0.05 / `pairs`; from 0 to infinity where there are too few runs.
    p : float
        Value p of the signed-rank test, adjusted for all pairs; it decides.
    runs : int
        Number of runs that both have.
    without_answer : tuple of int
        Number of runs in which the first and the second gave no answer, which count as an error of 180°.
    pairs : int
        Number of pairs that are compared together.
    """

    ratio: float
    low: float
    high: float
    p: float
    runs: int
    without_answer: tuple[int, int]
    pairs: int

    @property
    def is_shown(self) -> bool:
        """Whether one error is shown to be smaller than the other."""
        return self.p <= LEVEL

    @property
    def factor(self) -> float:
        """Factor between two errors that so many runs would show: half of the interval's width, as a ratio."""
        return math.sqrt(self.high / self.low) if self.low else np.inf

    def sentence(self, first: str, second: str) -> str:
        """Sentence about the errors of two estimators of these names, without a full stop."""
        if self.is_shown:
            interval = f" ({self.low:.3g} to {self.high:.3g})" if self.low else ""
            said = f"{first}'s error is {self.ratio:.3g} of {second}'s{interval}"
        else:
            said = f"{first} and {second}: a difference is not shown with {counted(self.runs, 'run')}; {self._limit()}"
        failed = [
            f"{name} gave no answer in {counted(count, 'run')}, counted as 180°"
            for name, count in zip((first, second), self.without_answer, strict=True)
            if count
        ]
        return "; ".join([said, *failed])

    def _limit(self) -> str:
        if self.low:
            return f"they would show a factor of {self.factor:.3g}"
        return f"at least {fewest_runs(self.pairs)} are needed for {counted(self.pairs, 'pair')}"


def fewest_runs(pairs: int) -> int:
    """Smallest number n of runs that can show anything in so many pairs: 2 · 2⁻ⁿ ≤ 0.05 / pairs."""
    return math.ceil(math.log2(2.0 * pairs / LEVEL))


def of_runs(first: ArrayLike, second: ArrayLike) -> Difference:
    """Ratio of the errors of two estimators over the same runs.

    Parameters
    ----------
    first, second : array_like, shape (R,)
        RMS errors, degrees; NaN where there is no answer.

    Raises
    ------
    InputError
        As `of_pairs`.
    """
    return of_pairs([(first, second)])[0]


def of_pairs(pairs: Sequence[tuple[ArrayLike, ArrayLike]], among: int = 0) -> list[Difference]:
    """Ratios of the errors of several pairs of estimators, which are judged together.

    Parameters
    ----------
    pairs : sequence of (array_like, array_like), shape (R,) each
        RMS errors of two estimators in the same runs, degrees; NaN where there is no answer. R may differ by the pair.
    among : int, optional
        Number of pairs among which these were chosen, where there are more.

    Raises
    ------
    InputError
        If errors are not two flat lists of as many numbers from 0 on.
    """
    among = max(among, len(pairs))
    read = [_both(*pair) for pair in pairs]
    logarithms = [_logarithms(errors) for errors in read]
    values = np.array([_value(each) for each in logarithms])
    order = np.argsort(values, kind="stable")
    adjusted = np.empty(len(pairs))
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate(values[order] * (among - np.arange(len(pairs)))))
    found = list[Difference]()
    for each, errors, p in zip(logarithms, read, adjusted, strict=True):
        ratio, low, high = np.exp(_interval(each, LEVEL / among)).tolist()
        lost = np.isnan(errors).sum(axis=1).tolist()
        found.append(Difference(ratio, low, high, float(p), len(each), (lost[0], lost[1]), among))
    return found


def best_point(errors: Sequence[Array]) -> tuple[int, list[Difference | None]]:
    """Index of the best point of a grid, and the ratio of its error to that of each other one; None for itself.

    The best one fails in the fewest runs, and then has the least geometric mean of the RMS errors. Chosen after a look
    at all errors, it is judged among all pairs of points.

    Parameters
    ----------
    errors : sequence of ndarray, shape (R,) each
        RMS errors of the points in the same runs, degrees; NaN where there is no answer.
    """
    means = np.nan_to_num([geometric_mean(each) for each in errors], nan=np.inf)
    best = min(range(len(errors)), key=lambda at: (np.isnan(errors[at]).sum(), means[at]))
    others = [at for at in range(len(errors)) if at != best]
    found = of_pairs([(errors[best], errors[at]) for at in others], comb(len(errors), 2))
    return best, [None if at == best else found[others.index(at)] for at in range(len(errors))]


def geometric_mean(errors: Array) -> float:
    """Geometric mean of RMS errors, degrees, over the runs that have an answer; NaN where none has."""
    right = errors[~np.isnan(errors)]
    return float(np.exp(np.mean(np.log(np.maximum(right, MIN_ERROR_DEG))))) if len(right) else np.nan


def _both(first: ArrayLike, second: ArrayLike) -> Array:
    """Read two lists of as many errors, shape (2, R)."""
    one = real_numbers("first", first, "(R,)")
    other = real_numbers("second", second, "(R,)")
    if one.ndim != 1 or one.shape != other.shape:
        raise InputError(f"second: shape {other.shape} beside {one.shape}: give two flat lists that are as long")
    both = np.stack([one, other])
    wrong = both[(both < 0.0) | np.isinf(both)]
    if wrong.size:
        raise InputError(f"first, second: {wrong[0]:g} is no error: give numbers from 0 on, NaN where there is none")
    return both


def _logarithms(errors: Array) -> Array:
    """Logarithms of the ratios of two rows of errors; 0 where they differ by round-off."""
    first, second = np.log(np.maximum(np.where(np.isnan(errors), NO_ANSWER_DEG, errors), MIN_ERROR_DEG))
    difference = first - second
    return np.where(np.abs(difference) > ROUND_OFF, difference, 0.0)


def _value(logarithms: Array) -> float:
    """Value p of the signed-rank test; 1 where there is no difference in any run."""
    different = logarithms[logarithms != 0.0]
    return float(scipy.stats.wilcoxon(different).pvalue) if len(different) else 1.0


def _interval(logarithms: Array, level: float) -> tuple[float, float, float]:
    """Median of the means of all two logarithms, and their interval, which misses the true one at this level."""
    runs = len(logarithms)
    if not runs:
        return np.nan, -np.inf, np.inf
    below = _below(runs, 0.5 * level) / (0.5 * runs * (runs + 1))
    few = logarithms
    if runs > MAX_MEANS:
        few = np.quantile(logarithms, (np.arange(MAX_MEANS) + 0.5) / MAX_MEANS)
    i, j = np.triu_indices(len(few))
    means = np.sort(0.5 * (few[i] + few[j]))
    out = round(below * len(means))
    low, high = (float(means[out - 1]), float(means[-out])) if out else (-np.inf, np.inf)
    return float(np.median(means)), low, high


@lru_cache
def _below(runs: int, tail: float) -> int:
    """Number of means below the interval: the largest k with P(T < k) at most the tail; T is the sum of the ranks."""
    if runs > MAX_EXACT:
        deviation = np.sqrt(runs * (runs + 1) * (2 * runs + 1) / 24.0)
        return int(0.25 * runs * (runs + 1) - scipy.stats.norm.isf(tail) * deviation)
    counts = np.ones(1)
    for rank in range(1, runs + 1):
        counts = np.convolve(counts, [1.0, *[0.0] * (rank - 1), 1.0])
    return int(np.searchsorted(np.cumsum(counts) / 2.0**runs, tail, side="right"))
