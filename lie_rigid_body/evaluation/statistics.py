"""Statistics of errors: their size, and when an estimate has converged."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import numbers, quantity, real_numbers
from lie_rigid_body.lie import vectors
from lie_rigid_body.short_dataclass import short_dataclass

SMALLEST_LIMIT: Final = 1e-3
"""Least default limit of convergence, degrees."""


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


def time_to_converge(t_s: ArrayLike, errors: ArrayLike, limit: float) -> float | None:
    """Time from the first sample to the first one from which on the error never exceeds a limit.

    Parameters
    ----------
    t_s, errors : array_like, shape (N,)
        Times in s, increasing, and errors. One that is NaN counts as above the limit.
    limit : float
        In the unit of the errors.

    Returns
    -------
    float or None
        Seconds; None if the last error is above the limit, or there is none.

    Raises
    ------
    InputError
        If there is not an error for each time, times decrease, or the limit is no finite number from 0 on.
    """
    times, sizes = real_numbers("t_s", t_s, "(N,)"), real_numbers("errors", errors, "(N,)")
    if times.ndim != 1 or times.shape != sizes.shape or not (np.diff(times) >= 0.0).all():
        raise InputError(
            f"errors: shape {sizes.shape} for times of shape {times.shape}: give rising times, an error for each"
        )
    above = np.flatnonzero(~(sizes <= quantity("limit", limit, "units of the errors", "1.0", or_zero=True)))
    first = int(above[-1]) + 1 if above.size else 0
    return float(times[first] - times[0]) if first < len(sizes) else None
