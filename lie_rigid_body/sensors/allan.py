"""Noise densities of readings at rest, by the overlapping Allan deviation, with standard errors.

The Allan variance of white noise of density N and a random walk of density K is N²/τ + K²τ/3 (IEEE Std 952-1997, annex
C). Its equivalent degrees of freedom are those of white noise over many readings (D. A. Howe, D. W. Allan, J. A.
Barnes, "Properties of signal sources and measurement methods", 1981, table 2).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from lie_rigid_body.foundation.arrays import Array

MIN_ALLAN_S: Final = 0.1
"""Shortest averaging time of the Allan deviation, s: filters of sensors are faster."""
MIN_ALLAN_CYCLES: Final = 5.0
"""Least duration over the longest averaging time."""
OCTAVES_SHARED: Final = 2.0
"""Factor of the variances of fitted densities, as octaves share readings: errors are 1.4 to 1.5 times those without."""
SIGMAS: Final = 4.0
"""Number of standard errors that the square of a random walk must exceed."""
LEAST_WALK: Final = 1e-6
"""Least variance of a walk at the longest averaging time, over that of white noise: less is not fitted."""


class Allan(NamedTuple):
    """Overlapping Allan variance of the mean of K axes.

    Attributes
    ----------
    tau_s, variance : ndarray, shape (M,)
        Averaging times, s, and variances, (unit of the readings)².
    freedom : ndarray, shape (M,)
        Equivalent degrees of freedom.
    """

    tau_s: Array
    variance: Array
    freedom: Array


class Density(NamedTuple):
    """Densities of noise with their standard errors.

    Attributes
    ----------
    white, white_sigma : float
        Of white noise, unit/√Hz.
    walk, walk_sigma : float
        Of the random walk, unit/s/√Hz; 0 where it is not told.
    """

    white: float
    white_sigma: float
    walk: float
    walk_sigma: float


def allan(readings: Array, step_s: float) -> Allan:
    """Compute the Allan variance at averaging times of powers of two steps.

    Parameters
    ----------
    readings : ndarray, shape (N, K)
    step_s : float
        Time between readings, s.
    """
    count, axes = readings.shape
    sums = np.cumsum(np.pad(readings - readings.mean(axis=0), ((1, 0), (0, 0))), axis=0)
    shortest = max(MIN_ALLAN_S / step_s, 1.0)
    powers = 2.0 ** np.arange(np.ceil(np.log2(shortest)), np.log2(count / MIN_ALLAN_CYCLES))
    squares = [
        np.mean((sums[2 * size :] - 2.0 * sums[size:-size] + sums[: -2 * size]) ** 2)
        for size in powers.astype(np.int64)
    ]
    return Allan(powers * step_s, np.array(squares) / (2.0 * powers**2), axes * (1.5 * count / powers - 2.0))


def density(found: Allan) -> Density:
    """Fit white noise and a random walk, if it is told, to the logarithm of an Allan variance.

    White noise is that beside a walk, told or not. The unknowns are logarithms, of a walk down to `LEAST_WALK`.
    """

    def model(tau_s: Array, white: float, walk: float) -> Array:
        return np.logaddexp(white - np.log(tau_s), walk + np.log(tau_s / 3.0))

    white = np.log(found.variance[0] * found.tau_s[0])
    walk = white - 2.0 * np.log(found.tau_s[-1])
    squares, covariance = curve_fit(
        model,
        found.tau_s,
        np.log(found.variance),
        p0=(white, walk),
        sigma=np.sqrt(2.0 * OCTAVES_SHARED / found.freedom),
        absolute_sigma=True,
        bounds=((-np.inf, walk + np.log(LEAST_WALK)), np.inf),
    )
    errors = np.sqrt(np.diag(covariance))
    sizes = np.exp(0.5 * squares)
    numbers = np.stack([sizes, 0.5 * errors * sizes], axis=1).ravel().tolist()
    return Density(*(numbers if errors[1] < 1.0 / SIGMAS else [*numbers[:2], 0.0, 0.0]))
