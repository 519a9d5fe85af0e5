"""Scalar coefficient functions of the exponential of SO(3) and its Jacobians, with their small-angle series.

The functions of the rotation angle θ ≥ 0 are accurate to a few units in the last place on all of [0, 2π). Where the
textbook form of `dexp_quadratic` or `dexpinv_quadratic` cancels, a power series in θ² with exactly rounded coefficients
replaces it below ``SERIES_LIMIT``. One series is entire, the other has radius 2π, so the limit can lie far from 0,
where the closed form is already well conditioned.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array

SERIES_LIMIT: Final = 2.0
"""Angle in rad below which the power series are used."""


def _bernoulli(count: int) -> list[Fraction]:
    """The Bernoulli numbers B₀ … B_{count−1} by their defining recurrence Σ C(n+1, k) Bₖ = 0."""
    numbers: list[Fraction] = [Fraction(1)]
    for n in range(1, count):
        partial = sum((math.comb(n + 1, k) * numbers[k] for k in range(n) if numbers[k]), Fraction(0))
        numbers.append(-partial / (n + 1))
    return numbers


# (θ − sin θ)/θ³ = Σ (−1)ᵏ θ²ᵏ/(2k+3)!
_DEXP_QUADRATIC: Final = tuple((-1.0) ** k / math.factorial(2 * k + 3) for k in range(14))

# (1 − (θ/2) cot(θ/2))/θ² = Σ |B₂ₖ₊₂| θ²ᵏ/(2k+2)!; at θ = 2 the terms fall like (1/π)²ᵏ
DEXPINV_QUADRATIC: Final = tuple(float(abs(b) / math.factorial(2 * k + 2)) for k, b in enumerate(_bernoulli(40)[2::2]))


def half_angle_sine_ratio(theta: Array) -> Array:
    """The ratio sin(θ/2)/θ, with its limit ½ at 0."""
    return 0.5 * sine_ratio(0.5 * theta)


def sine_ratio(theta: Array) -> Array:
    """The ratio sin θ/θ, with its limit 1 at 0."""
    safe = np.where(theta == 0.0, 1.0, theta)
    return np.where(theta == 0.0, 1.0, np.sin(safe) / safe)


def dexp_linear(theta: Array) -> Array:
    """The coefficient (1 − cos θ)/θ² = 2 (sin(θ/2)/θ)², with its limit ½ at 0."""
    ratio = half_angle_sine_ratio(theta)
    return 2.0 * ratio * ratio


def dexp_quadratic(theta: Array) -> Array:
    """The coefficient (θ − sin θ)/θ³, with its limit 1/6 at 0."""
    return _by_series_below_limit(theta, _DEXP_QUADRATIC, lambda x: (x - np.sin(x)) / x**3)


def dexpinv_quadratic(theta: Array) -> Array:
    """The coefficient (1 − (θ/2) cot(θ/2))/θ², with its limit 1/12 at 0."""
    return _by_series_below_limit(
        theta, DEXPINV_QUADRATIC, lambda x: (1.0 - 0.5 * x * np.cos(0.5 * x) / np.sin(0.5 * x)) / x**2
    )


def _by_series_below_limit(theta: Array, coefficients: tuple[float, ...], closed: Callable[[Array], Array]) -> Array:
    """A function of θ by its power series in θ² below `SERIES_LIMIT`, from there on by its closed form."""
    small = theta < SERIES_LIMIT
    series = np.polyval(coefficients[::-1], np.where(small, theta, 0.0) ** 2)
    return np.where(small, series, closed(np.where(small, SERIES_LIMIT, theta)))
