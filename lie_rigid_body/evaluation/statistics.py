"""Statistics of an error over a run, limits to it, and whether one estimate is better than another, or was lucky.

Limits are written on a command line as ``1deg``, or ``10s:2deg`` from a time on.

The difference of the RMS errors of two estimates has an interval. Errors of one run are correlated in time, so moving
blocks of samples are drawn again, as long as the errors remember: D. N. Politis, H. White, Econometric Reviews 23:53
(2004), with the correction by A. Patton et al., ibid. 28:372 (2009), for circular blocks. Over many runs, which are
independent, whole runs are drawn again.
"""

from __future__ import annotations

import re
from dataclasses import asdict
from typing import Any, Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import numbers, quantity, real_numbers
from lie_rigid_body.lie import vectors
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.wording import shown

SMALLEST_LIMIT: Final = 1e-3
"""Least default limit of convergence, degrees."""
Largest = tuple[float, float] | None
"""Time, s, and size, degrees, of the largest of some errors; None of no samples."""
UNITS: Final = {
    "an angle such as 1deg": {"deg": 1.0, "°": 1.0, "rad": 180.0 / np.pi, "mrad": 0.18 / np.pi},
    "a time such as 10s": {"ms": 1e-3, "s": 1.0, "min": 60.0},
}
"""Units of what a limit is of, in degrees and in seconds."""
LEAST_SHARE: Final = 0.5
"""Least share of the given estimates, and of the time in which they are due, that must be compared to keep a limit."""
PROBABILITY: Final = 0.95
"""Probability of the intervals."""
RESAMPLED: Final = 1000
"""Number of resamplings."""
MOST_SAMPLES: Final = 20_000
"""Largest number of samples that are drawn again one by one; of more, means of neighbours are."""
FEWEST_SAMPLES: Final = 10
"""Least number of samples or runs whose difference has an interval."""
FEWEST_BLOCKS: Final = 5
"""Least number of blocks of a run."""
MOST_BLOCKS: Final = 500
"""Largest number of blocks of a run: more tell hardly more of the spread."""
_NUMBER: Final = re.compile(r"\s*(\+?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D*?)\s*", re.ASCII)


@short_dataclass(frozen=True)
class Statistics:
    """Statistics of a non-negative error, in the unit of the error.

    Attributes
    ----------
    rms, median, p95, max, final : float
        Root mean square, median, 95th percentile (linear between samples), largest and last value.
    """

    rms: float
    median: float
    p95: float
    max: float
    final: float

    @classmethod
    def of(cls, errors: Array) -> Statistics:
        """Compute the statistics of errors in order of time, shape (N,) with N ≥ 1, all finite."""
        median, p95 = np.percentile(errors, [50.0, 95.0])
        return cls(rms(errors), float(median), float(p95), float(errors.max()), float(errors[-1]))

    def to_json(self) -> dict[str, float]:
        """JSON-serialisable data: the five numbers."""
        return asdict(self)


def rms(errors: Array) -> float:
    """Root mean square; scaled by the largest value, so that tiny errors do not underflow."""
    largest = float(np.abs(errors).max(initial=0.0))
    return largest * float(np.sqrt(np.mean((errors / largest) ** 2))) if largest else 0.0


def bias_error(estimate: ArrayLike, truth: ArrayLike) -> Statistics:
    """Statistics of the norm of a bias estimate's error.

    Parameters
    ----------
    estimate, truth : array_like, shape (N, 3)
        Bias estimates and true biases of the same instants, in the same unit: rad/s of a gyro, m/s² of an
        accelerometer.

    Returns
    -------
    Statistics
        In that unit.

    Raises
    ------
    InputError
        If a shape is wrong or a number is not finite.
    """
    given, true = numbers("estimate", estimate, 3), numbers("truth", truth, 3)
    if given.shape != true.shape:
        raise InputError(f"truth: shape {true.shape} is not {given.shape}: give the true bias of each estimate")
    return Statistics.of(vectors.norm(given - true).reshape(-1))


def settling_limit(t_s: Array, errors: Array) -> float:
    """Default limit of `time_to_converge`: one and a half times the largest error of the second half of the run.

    Steady noise hardly ever exceeds it, so the time tells when the error came down to what it is later.

    Parameters
    ----------
    t_s, errors : ndarray, shape (N,)
        Times in s and errors in degrees.

    Returns
    -------
    float
        Degrees, at least `SMALLEST_LIMIT`.
    """
    return max(1.5 * float(errors[t_s >= 0.5 * (t_s[0] + t_s[-1])].max()), SMALLEST_LIMIT)


def time_to_converge(t_s: Array, errors: Array, limit: float) -> float | None:
    """Time from the first sample to the first one from which on the error never exceeds a limit.

    Parameters
    ----------
    t_s, errors : ndarray, shape (N,)
        Times in s, increasing, and errors.
    limit : float
        In the unit of the errors.

    Returns
    -------
    float or None
        Seconds; None if the last error is above the limit.
    """
    above = np.flatnonzero(errors > limit)
    first = int(above[-1]) + 1 if above.size else 0
    return float(t_s[first] - t_s[0]) if first < len(errors) else None


@short_dataclass(frozen=True)
class Limits:
    """Limits to the total error.

    Attributes
    ----------
    max_rms_deg : float or None
        Largest RMS over the whole run, degrees, above 0.
    max_after : tuple of (float, float)
        Pairs of a time in s since the first sample, and the largest error from then on, degrees, above 0.

    Raises
    ------
    InputError
        If a limit is not finite or not above 0, or a time is not finite or below 0: no error would break it, or every
        one.
    """

    max_rms_deg: float | None = None
    max_after: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if self.max_rms_deg is not None:
            quantity("max_rms_deg", self.max_rms_deg, "degrees", "max_rms_deg=1.0")
        try:
            pairs = tuple((start, limit) for start, limit in self.max_after)
        except (TypeError, ValueError):
            given = shown(self.max_after)
            raise InputError(
                f"max_after: {given} is not pairs of s and degrees: give for example ((10.0, 2.0),)"
            ) from None
        for start, limit in pairs:
            quantity("max_after: time", start, "seconds", "((10.0, 2.0),)", or_zero=True)
            quantity("max_after: limit", limit, "degrees", "((10.0, 2.0),)")

    @classmethod
    def parse(cls, max_rms: str | None = None, max_after: str | tuple[str, ...] = ()) -> Limits:
        """Read limits from texts: ``max_rms="1deg"``, ``max_after="10s:2deg"`` or several of them.

        Raises
        ------
        InputError
            If a text is not an angle, or not a time, a colon and an angle.
        """
        pairs = max_after if isinstance(max_after, list | tuple) else (max_after,)
        return cls(
            None if max_rms is None else _read(max_rms, "an angle such as 1deg"), tuple(_after(pair) for pair in pairs)
        )


def largest(start_s: float, t_s: Array, total_deg: Array, before: Largest = None) -> Largest:
    """The time, s, and size of the first of the largest errors from a time on, `before` the samples or among them."""
    late = np.flatnonzero(t_s >= start_s)
    k = late[np.argmax(total_deg[late])] if late.size else 0
    if not late.size or (before is not None and before[1] >= total_deg[k]):
        return before
    return float(t_s[k]), float(total_deg[k])


def _after(text: str) -> tuple[float, float]:
    time, colon, angle = text.partition(":") if isinstance(text, str) else (text, "", "")
    if not colon:
        raise InputError(f"{shown(text)} is not a time and an angle: give for example 10s:2deg")
    return _read(time, "a time such as 10s"), _read(angle, "an angle such as 1deg")


def _read(text: str, wanted: str) -> float:
    """Read a number with one of the units of what is wanted."""
    match, units = _NUMBER.fullmatch(text) if isinstance(text, str) else None, UNITS[wanted]
    if not match or match[2] not in units or np.isinf(float(match[1])):
        raise InputError(f"{shown(text)} is not {wanted}: give a number and one of {', '.join(units)}")
    return float(match[1]) * units[match[2]]


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
        among = "" if self.runs == 1 else f" that {self.runs} runs could show"
        if not self.is_sure:
            return f"{first} and {second}: no difference{among} ({self.low:+.2g}{unit} to {self.high:+.2g}{unit})"
        best, worst, wins = (
            (first, second, self.better) if self.value < 0.0 else (second, first, self.runs - self.better)
        )
        half = 0.5 * (self.high - self.low)
        runs = "" if self.runs == 1 else f", in {wins} of {self.runs} runs"
        return f"{best} is better than {worst} by {abs(self.value):.2g}{unit} ± {half:.2g}{unit}{runs}"

    def to_dict(self) -> dict[str, Any]:
        """The numbers as JSON-serialisable data."""
        return asdict(self)


def _side_by_side(*errors: ArrayLike) -> list[Array]:
    """Errors of two estimates, read as rows of one length."""
    read = [real_numbers(name, row, "(N,)") for name, row in zip(("first", "second"), errors, strict=True)]
    if read[0].ndim != 1 or read[0].shape != read[1].shape:
        raise InputError(
            f"first and second: shapes {read[0].shape} and {read[1].shape} are not (N,) of one N: give as many errors "
            "of each, of the same stamps or runs"
        )
    return read


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
        If they are no numbers, or not as many of both.
    """
    first, second = _side_by_side(first, second)
    value = rms(first) - rms(second)
    squares = np.stack([first**2, second**2])
    if len(first) > MOST_SAMPLES:
        group = -(-len(first) // MOST_SAMPLES)
        squares = squares[:, : len(first) // group * group].reshape(2, -1, group).mean(axis=2)
    count = squares.shape[1]
    if count < FEWEST_SAMPLES:
        return Difference(value, -np.inf, np.inf, int(value < 0.0), 1)
    # the difference of the roots, linearised, is a mean, of which the blocks are to keep the variance
    slopes = 0.5 / np.maximum(np.sqrt(squares.mean(axis=1)), np.finfo(float).tiny)
    length, wider = blocks_of(slopes[0] * squares[0] - slopes[1] * squares[1])
    sums = np.concatenate(
        [np.zeros((2, 1)), np.cumsum(np.concatenate([squares, squares[:, :length]], axis=1), axis=1)], axis=1
    )
    draws, blocks = np.random.default_rng(seed), max(1, round(count / length))
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
        If they are no numbers, or not as many of both.
    """
    first, second = _side_by_side(first, second)
    both = np.isfinite(first) & np.isfinite(second)
    differences, left_out = (first - second)[both], int(np.sum(~both))
    runs, better = len(differences), int(np.sum(differences < 0.0))
    value = float(differences.mean()) if runs else np.nan
    if runs < FEWEST_SAMPLES:
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
    tail, freedom = 0.5 * (1.0 - PROBABILITY), max(1, freedom)
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
    centred = values - values.mean()
    # autocovariances by the spectrum of the padded values
    spectrum = np.fft.rfft(centred, 2 * n)
    covariances = np.fft.irfft(np.abs(spectrum) ** 2)[:n] / n
    if covariances[0] <= 0.0:
        return 1, 1.0
    quiet = max(5, int(np.ceil(np.sqrt(np.log10(n)))))
    longest = n // FEWEST_BLOCKS + quiet
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
    chosen = int(np.clip(np.ceil(length), max(1, n // MOST_BLOCKS), max(1, n // FEWEST_BLOCKS)))
    return chosen, float(np.sqrt(1.0 / (1.0 - min(max(slope / (variance * chosen), 0.0), 0.5))))
