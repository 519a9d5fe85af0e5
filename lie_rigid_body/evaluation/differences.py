"""Difference of the RMS errors of two estimates, with its interval: which one is better, and whether that is luck.

Errors of one run are correlated in time. So the variance of their mean follows from its autocovariances, as far as the
errors remember. The window and its width are those of D. N. Politis, H. White, Econometric Reviews 23:53 (2004). Runs
are independent. Both intervals are Student's; the difference of two RMS errors is linearised.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import numbers, real_numbers
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.short_dataclass import short_dataclass

PROBABILITY: Final = 0.95
"""Probability of the intervals."""
FEWEST_SAMPLES: Final = 10
"""Least number of samples or runs whose difference has an interval."""
LONGEST_MEMORY: Final = 0.2
"""Largest share of a run that errors may remember."""


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
        """What may be said of two estimates of these names."""
        if not np.isfinite(self.low):
            few = "few common samples" if self.runs == 1 else f"few common runs ({self.runs})"
            return f"{first} and {second}: too {few} to tell a difference"
        among = "" if self.runs == 1 else f" that {self.runs} runs could show"
        if not self.is_sure:
            return f"{first} and {second}: no difference{among} ({self.low:+.2g}{unit} to {self.high:+.2g}{unit})"
        best, worst, wins = (
            (first, second, self.better) if self.value < 0.0 else (second, first, self.runs - self.better)
        )
        half = 0.5 * (self.high - self.low)
        runs = "" if self.runs == 1 else f", in {wins} of {self.runs} runs"
        return f"{best} is better than {worst} by {abs(self.value):.2g}{unit} ± {half:.2g}{unit}{runs}"


def _both(first: ArrayLike, second: ArrayLike) -> Array:
    """Read two rows of as many numbers, shape (2, N)."""
    one, other = real_numbers("first", first, "(N,)"), real_numbers("second", second, "(N,)")
    if one.ndim != 1 or one.shape != other.shape:
        raise InputError(f"second: shape {other.shape} beside {one.shape}: give two flat lists that are as long")
    return np.stack([one, other])


def of_run(first: ArrayLike, second: ArrayLike) -> Difference:
    """Difference of the RMS of two errors of one run.

    Parameters
    ----------
    first, second : array_like, shape (N,)
        Errors at the same stamps, which are about even.

    Raises
    ------
    InputError
        If they are not two flat lists of as many finite numbers.
    """
    both = _both(first, second)
    errors = numbers("errors", both.T, 2).T if both.size else both
    (one, other), count, variance, freedom = map(rms, errors), errors.shape[1], np.inf, 1.0
    if count >= FEWEST_SAMPLES:
        # the difference of the roots, linearised, is a mean
        slopes = np.array([0.5, -0.5]) / np.maximum([one, other], np.finfo(float).tiny)
        long_run, memory = long_run_variance(errors.T**2 @ slopes)
        variance, freedom = long_run / count, max(1.0, count / memory - 1.0)
    return _with_interval(one - other, variance, freedom, int(one < other), 1)


def of_runs(first: ArrayLike, second: ArrayLike) -> Difference:
    """Mean difference of the RMS errors of two estimates over runs.

    Parameters
    ----------
    first, second : array_like, shape (R,)
        RMS errors of the same runs; NaN where the estimate failed.

    Raises
    ------
    InputError
        If they are not two flat lists of as many numbers.
    """
    errors = _both(first, second)
    both = np.isfinite(errors).all(axis=0)
    differences = (errors[0] - errors[1])[both]
    runs, better = len(differences), int(np.sum(differences < 0.0))
    value = float(differences.mean()) if runs else np.nan
    variance = float(differences.var(ddof=1)) / runs if runs >= FEWEST_SAMPLES else np.inf
    return _with_interval(value, variance, max(1, runs - 1), better, runs, int(np.sum(~both)))


def _with_interval(
    value: float, variance: float, freedom: float, better: int, runs: int, left_out: int = 0
) -> Difference:
    """The difference of a variance that was estimated with some degrees of freedom."""
    half = float(scipy.stats.t.isf(0.5 * (1.0 - PROBABILITY), freedom) * np.sqrt(variance))
    return Difference(value, value - half, value + half, better, runs, left_out)


def long_run_variance(values: Array) -> tuple[float, int]:
    """Variance of a mean times the number of samples, and the width of the window, by the autocovariances of samples.

    Parameters
    ----------
    values : ndarray, shape (N,)
        Samples of a stationary process.

    Returns
    -------
    float
        At least the variance of a sample.
    int
        Number of samples after which nothing is remembered.
    """
    n = len(values)
    # autocovariances by the spectrum of the padded values
    spectrum = np.fft.rfft(values - values.mean(), 2 * n)
    covariances = np.fft.irfft(np.abs(spectrum) ** 2)[:n] / n
    quiet = max(5, int(np.ceil(np.sqrt(np.log10(n)))))
    longest = int(LONGEST_MEMORY * n) + quiet
    loud = np.abs(covariances[1 : longest + 1]) >= 2.0 * np.sqrt(np.log10(n) / n) * covariances[0]
    # the last lag before so many quiet ones in a row
    runs = np.convolve(~loud, np.ones(quiet), mode="valid") == quiet
    last = max(1, int(np.argmax(runs)) if runs.any() else longest - quiet)
    lags = np.arange(1, min(2 * last, n - 1) + 1)
    window = np.clip(2.0 - lags / last, 0.0, 1.0)
    variance = covariances[0] + 2.0 * float(np.sum(window * covariances[lags]))
    return max(variance, float(covariances[0])), 2 * last
