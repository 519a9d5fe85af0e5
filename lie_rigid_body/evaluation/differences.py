"""Difference of the RMS errors of two estimates, with its interval: which one is better, and whether that is luck.

Errors of one run are correlated in time, so moving blocks of samples are drawn again, as long as the errors remember:
D. N. Politis, H. White, Econometric Reviews 23:53 (2004), with the correction by A. Patton et al., ibid. 28:372 (2009),
for circular blocks. Over many runs, which are independent, whole runs are drawn again.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import numbers, real_numbers
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.arrays import Array, whole_number
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass

PROBABILITY: Final = 0.95
"""Probability of the intervals."""
RESAMPLED: Final = 1000
"""Number of resamplings."""
MAX_SAMPLES: Final = 20_000
"""Largest number of samples that are drawn again one by one; of more, means of neighbours are."""
MIN_COMPARED: Final = 10
"""Least number of samples or runs whose difference has an interval."""
MIN_BLOCKS: Final = 5
"""Least number of blocks of a run."""
MAX_BLOCKS: Final = 500
"""Largest number of blocks of a run: more tell hardly more of the spread."""


@short_dataclass(frozen=True)
class Difference:
    """Difference of the RMS errors of two estimates: below 0 where the first is better.

    Attributes
    ----------
    value, low, high : float
        The difference and its interval of 95 %, in the unit of the errors.
    better : int
        Number of runs in which the first is better; of one run 0 or 1.
    runs : int
        Number of runs that both have.
    left_out : int
        Number of runs in which either failed.
    """

    value: float
    low: float
    high: float
    better: int
    runs: int
    left_out: int = 0

    @property
    def is_sure(self) -> bool:
        """Whether the interval has one sign."""
        return self.low > 0.0 or self.high < 0.0

    def sentence(self, first: str, second: str, unit: str = "°") -> str:
        """Sentence about the difference of two estimates of these names."""
        if not np.isfinite(self.low):
            few = "few common samples" if self.runs == 1 else f"few common runs ({self.runs})"
            return f"{first} and {second}: too {few} to tell a difference"
        among = "" if self.runs == 1 else f" that {self.runs} runs could show"
        if not self.is_sure:
            low, high = (f"{round(end, 12) + 0.0:+.2g}{unit}" for end in (self.low, self.high))
            return f"{first} and {second}: no difference{among} ({low} to {high})"
        best, worst, wins = (
            (first, second, self.better) if self.value < 0.0 else (second, first, self.runs - self.better)
        )
        runs = "" if self.runs == 1 else f", in {wins} of {self.runs} runs"
        by = f"{abs(self.value):.2g}{unit} ± {0.5 * (self.high - self.low):.2g}{unit}"
        return f"{best} is better than {worst} by {by}{runs}"


def _both(first: ArrayLike, second: ArrayLike) -> Array:
    """Read two rows of as many numbers, shape (2, N)."""
    one = real_numbers("first", first, "(N,)")
    other = real_numbers("second", second, "(N,)")
    if one.ndim != 1 or one.shape != other.shape:
        raise InputError(f"second: shape {other.shape} beside {one.shape}: give two flat lists that are as long")
    both = np.stack([one, other])
    with np.errstate(over="ignore"):
        squares = np.sum(np.square(both[np.isfinite(both)]))
    if not np.isfinite(squares):
        raise InputError("first, second: their squares are beyond double precision, 1.8e308: give smaller errors")
    return both


def of_run(first: ArrayLike, second: ArrayLike, seed: int = 0) -> Difference:
    """Difference of the RMS of two errors of one run, by moving blocks.

    Parameters
    ----------
    first, second : array_like, shape (N,)
        Errors at the same stamps, which are about even.
    seed : int
        Seed of the resampling.

    Raises
    ------
    InputError
        If they are not two flat lists of as many finite numbers, or the seed is no whole number from 0 on.
    """
    both = _both(first, second)
    seed = whole_number("seed", seed, 0)
    errors = numbers("errors", both.T, 2).T if both.size else both
    value = rms(errors[0]) - rms(errors[1])
    squares = errors**2
    given = errors.shape[1]
    if given > MAX_SAMPLES:
        group = -(-given // MAX_SAMPLES)
        squares = squares[:, : given // group * group].reshape(2, -1, group).mean(axis=2)
    count = squares.shape[1]
    if count < MIN_COMPARED:
        return Difference(value, -np.inf, np.inf, int(value < 0.0), 1)
    # the difference of the roots, linearised, is a mean, of which the blocks are to keep the variance
    slopes = 0.5 / np.maximum(np.sqrt(squares.mean(axis=1)), np.finfo(float).tiny)
    length, wider = blocks_of(slopes[0] * squares[0] - slopes[1] * squares[1])
    sums = np.concatenate(
        [np.zeros((2, 1)), np.cumsum(np.concatenate([squares, squares[:, :length]], axis=1), axis=1)], axis=1
    )
    draws = np.random.default_rng(seed)
    blocks = max(1, round(count / length))
    begins = draws.integers(0, count, size=(RESAMPLED, blocks))
    means = (sums[:, begins + length] - sums[:, begins]).sum(axis=2) / (blocks * length)
    resampled = value + wider * (np.sqrt(means[0]) - np.sqrt(means[1]) - value)
    return _with_interval(value, resampled, int(value < 0.0), 1, freedom=blocks - 1)


def of_runs(first: ArrayLike, second: ArrayLike, seed: int = 0) -> Difference:
    """Mean difference of the RMS errors of two estimates over runs, by bootstrap of runs.

    Parameters
    ----------
    first, second : array_like, shape (R,)
        RMS errors of the same runs; NaN where the estimate failed.
    seed : int
        Seed of the resampling.

    Raises
    ------
    InputError
        If they are not two flat lists of as many numbers, or the seed is no whole number from 0 on.
    """
    errors = _both(first, second)
    seed = whole_number("seed", seed, 0)
    both = np.isfinite(errors).all(axis=0)
    differences = (errors[0] - errors[1])[both]
    left_out = int(np.sum(~both))
    runs = len(differences)
    better = int(np.sum(differences < 0.0))
    value = float(differences.mean()) if runs else np.nan
    if runs < MIN_COMPARED:
        return Difference(value, -np.inf, np.inf, better, runs, left_out)
    draws = np.random.default_rng(seed)
    resampled = np.concatenate(
        [differences[draws.integers(0, runs, (100, runs))].mean(axis=1) for _ in range(RESAMPLED // 100)]
    )
    return _with_interval(value, resampled, better, runs, left_out, freedom=runs - 1)


def _with_interval(
    value: float, resampled: Array, better: int, runs: int, left_out: int = 0, *, freedom: int
) -> Difference:
    """Quantiles of what was drawn again, farther out by Student's quantile for so many independent parts.

    Means of n parts that are drawn again from n vary less by the factor n − 1 of n than those of new ones.
    """
    tail = 0.5 * (1.0 - PROBABILITY)
    freedom = max(1, freedom)
    wider = scipy.stats.t.isf(tail, freedom) / scipy.stats.norm.isf(tail) * np.sqrt((freedom + 1) / freedom)
    low, high = (np.quantile(resampled, [tail, 1.0 - tail]) - value) * wider
    return Difference(value, value + float(low), value + float(high), better, runs, left_out)


def blocks_of(values: Array) -> tuple[int, float]:
    """Length of the circular blocks that estimate the variance of a mean best, and how much it is to be widened.

    Parameters
    ----------
    values : ndarray, shape (N,)
        Samples of a stationary process.

    Returns
    -------
    int
        Samples.
    float
        What deviations are multiplied by, at least 1. Blocks of length L miss correlations across their ends, which are
        a share g / (L v) of the variance v, where g = Σ |k| R(k).
    """
    n = len(values)
    # autocovariances by the spectrum of the padded values
    covariances = np.fft.irfft(np.abs(np.fft.rfft(values - values.mean(), 2 * n)) ** 2)[:n] / n
    if covariances[0] <= 0.0:
        return 1, 1.0
    quiet = max(5, int(np.ceil(np.sqrt(np.log10(n)))))
    longest = n // MIN_BLOCKS + quiet
    loud = np.abs(covariances[1 : longest + 1] / covariances[0]) >= 2.0 * np.sqrt(np.log10(n) / n)
    # the last lag before so many quiet ones in a row
    runs = np.convolve(~loud, np.ones(quiet), mode="valid") == quiet
    last = int(np.argmax(runs)) if runs.any() else longest - quiet
    lags = np.arange(1, min(2 * max(last, 1), n - 1) + 1)
    window = np.clip(2.0 * (1.0 - lags / (2.0 * max(last, 1))), 0.0, 1.0)
    variance = covariances[0] + 2.0 * float(np.sum(window * covariances[lags]))
    slope = 2.0 * float(np.sum(window * lags * covariances[lags]))
    if variance <= 0.0:
        return 1, 1.0
    length = (1.5 * (slope / variance) ** 2 * n) ** (1.0 / 3.0)
    chosen = int(np.clip(np.ceil(length), max(1, n // MAX_BLOCKS), max(1, n // MIN_BLOCKS)))
    return chosen, float(np.sqrt(1.0 / (1.0 - min(max(slope / (variance * chosen), 0.0), 0.5))))
