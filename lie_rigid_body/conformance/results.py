"""Results of an engine in a case at three steps, and what follows from them: order, limit at step 0, precision.

With results at steps h, h/r and h/r² and an order p, errors fall by R = rᵖ from one to the next. Richardson's
extrapolation adds 1/(R − 1) of the last difference to the last result. What remains at step 0 is known to about the
difference of two such extrapolations (L. F. Richardson, Phil. Trans. R. Soc. A 226 (1927) 299).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from math import inf
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.conformance.cases import EngineCase, MotionArrays, exact_motion
from lie_rigid_body.foundation.arrays import Array, shaped
from lie_rigid_body.foundation.errors import InputError, ParameterError, describe
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.lie import quaternion

Simulate: TypeAlias = Callable[[EngineCase, float], tuple[ArrayLike, ArrayLike, ArrayLike]]
"""An engine: a case and a step, s, to times, s, attitudes and body rates after every step."""

STEPS: Final = (20, 40, 80)
"""Steps in a period, if no others are given."""
DOUBLE: Final = 2.0**-53
"""Unit round-off of a double: results are not more precise."""
MAX_DIFFERENCE: Final = 0.2
"""Largest difference between results at two steps, and largest effect of round-off, up to which results are judged:
rad, or share of the rate. Beyond, angles do not add up like vectors."""
MAX_REMAINS: Final = 3.0
"""Largest distance at step 0 from the exact motion of a right engine, in units of how well it is known. That of right
and wrong engines is measured by benchmarks/conformance.py."""
MIN_INSTANTS: Final = 4
"""Smallest number of instants that are judged, for a case to count."""
MAX_OFF: Final = 0.01
"""Largest distance of a returned time from a multiple of the step, in steps."""
MAX_GROWTH: Final = 1e3
"""Largest rate, as a multiple of that at the start; beyond, an engine has diverged."""
MAX_PRECISION: Final = 1e-3
"""Noise of results of which nothing is judged."""
_MEDIAN: Final = 0.6745
"""Median of the absolute values of normal noise of variance 1."""
_LINE: Final = (0.48, 0.6, 0.64)
"""Unit vector in the body, along none of its axes."""
_MAX_LEVEL: Final = 24
"""Highest difference by which noise is looked for."""


class Track(NamedTuple):
    """Results at one step, from the start on.

    Attributes
    ----------
    step : float
        s.
    attitude_xyzw : ndarray, shape (N + 1, 4)
        Of unit norm.
    body_rate : ndarray, shape (N + 1, 3)
        rad/s; NaN from where an engine diverges, in attitude or rate.
    """

    step: float
    attitude_xyzw: Array
    body_rate: Array


def tracked(simulate: Simulate, case: EngineCase, count: int) -> Track:
    """Run an engine with a number of steps.

    Raises
    ------
    InputError
        If it raises an error, or does not return a time, an attitude and a rate for every step.
    """
    step = case.duration / count
    try:
        given, attitudes, rates = simulate(case, step)
        t_s = shaped("times", given, ("N",))
        first = len(t_s) - count  # 1 where the start is returned as well
        if first not in (0, 1) or not np.allclose(t_s, step * np.arange(1 - first, count + 1), 0.0, MAX_OFF * step):
            raise ParameterError("times", f"{shown(t_s)} are not those of the steps")
        attitude = shaped("attitudes", attitudes, (len(t_s), 4))
        rate = shaped("rates", rates, (len(t_s), 3))
    except Exception as error:
        raise InputError(
            f"{case.name}, {count} steps of {step:.6g} s: {describe(error)}. An engine returns times, attitudes and "
            "body rates after every step"
        ) from error
    with np.errstate(all="ignore"):  # an engine that diverges
        attitude = quaternion.normalize(np.vstack([case.attitude_xyzw, attitude[first:]]))
        rate = np.vstack([case.body_rate, rate[first:]])
        growth = np.linalg.norm(rate, axis=1) * np.linalg.norm(attitude, axis=1) / np.linalg.norm(case.body_rate)
    rate[np.maximum.accumulate(~(growth <= MAX_GROWTH))] = np.nan
    return Track(step, attitude, rate)


def noise(values: Array) -> float:
    """Noise of a smooth series, by its differences: that of float32 is found in results that are given as doubles.

    The k-th difference of noise of variance s² has the variance (2k)!/(k!)² s², and that of a smooth series vanishes as
    k grows: J. J. Moré, S. M. Wild, SIAM J. Sci. Comput. 33 (2011) 1292. The least over all k is taken.

    Parameters
    ----------
    values : ndarray, shape (N, M)
    """
    found = inf
    for k in range(1, min(_MAX_LEVEL, len(values) // 2) + 1):
        values = np.diff(values, axis=0)
        median = float(np.median(np.abs(values), axis=0).max())
        found = min(found, median / (_MEDIAN * math.sqrt(math.comb(2 * k, k))))
    return found


def difference(one: MotionArrays, other: MotionArrays, speed: float) -> Array:
    """Rotation from one attitude to another, rad, and difference of the rates as a share of a speed: shape (N, 6)."""
    between = quaternion.multiply(quaternion.conjugate(one[0]), other[0])
    return np.concatenate([quaternion.log(between), (other[1] - one[1]) / speed], axis=1)


class CaseResults:
    """Results of an engine in a case at three steps.

    Parameters
    ----------
    simulate : callable
    case : EngineCase
    steps, ratio : int
        Number of the largest steps in a period, and quotient of two steps, r.

    Attributes
    ----------
    tracks : list of Track
        The largest step first.
    speed : float
        Norm of the rate at the start, rad/s.
    t_s : ndarray, shape (N,)
        Multiples of the largest step, s: results are compared at these times.
    common : list of tuple
        Attitudes and rates at these times, by steps.
    """

    def __init__(self, simulate: Simulate, case: EngineCase, steps: int, ratio: int) -> None:
        self.case = case
        self.ratio = ratio
        self.speed = float(np.linalg.norm(case.body_rate))
        count = math.ceil(steps * case.duration / case.period)
        strides = (1, ratio, ratio**2)
        self.tracks = [tracked(simulate, case, count * stride) for stride in strides]
        self.t_s = self.tracks[0].step * np.arange(count + 1.0)
        self.common = [
            (attitude[::stride], rate[::stride])
            for (_, attitude, rate), stride in zip(self.tracks, strides, strict=True)
        ]

    @cached_property
    def truth(self) -> MotionArrays:
        """The exact attitudes and rates."""
        return exact_motion(self.case.inertia, self.case.attitude_xyzw, self.case.body_rate, self.t_s)

    @cached_property
    def precision(self) -> float:
        """Noise at the smallest step of a line of the body in the world, or of the rate as a share of its norm."""
        _, attitude, rate = self.tracks[-1]
        values = np.hstack([quaternion.rotate(attitude, np.array(_LINE)), rate / self.speed])
        return float(np.clip(noise(values[np.isfinite(values).all(axis=1)]), DOUBLE, MAX_PRECISION))

    @cached_property
    def floor(self) -> Array:
        """Effect of round-off at each time, by exact motions whose rate at the start or inertia differ by it.

        Each step rounds in units of the precision, and roundings of N steps add up to their √N-fold.
        """
        case = self.case
        size = self.precision * math.sqrt(12.0 * len(self.tracks[-1].body_rate))
        parted = np.full(len(self.t_s), size)
        for axis in np.eye(3):
            for inertia, rate in (
                (case.inertia, case.body_rate + size * self.speed * axis),
                (case.inertia + size * case.principal_moments[2] * np.diag(1.0 - axis), case.body_rate),
            ):
                near = exact_motion(inertia, case.attitude_xyzw, rate, self.t_s)
                parted = np.maximum(parted, np.linalg.norm(difference(self.truth, near, self.speed), axis=1))
        return np.maximum.accumulate(parted)

    @cached_property
    def differences(self) -> MotionArrays:
        """From the second to the first result, and from the third to the second."""
        first, second, third = self.common
        return difference(second, first, self.speed), difference(third, second, self.speed)

    @cached_property
    def judged(self) -> int:
        """Number of instants from the start on that are judged; 0 where they are too few."""
        sizes = [np.abs(each).max(axis=1) for each in self.differences]
        count = int(np.cumprod(np.maximum.reduce([*sizes, self.floor]) < MAX_DIFFERENCE).sum())
        return count if count >= MIN_INSTANTS else 0

    @cached_property
    def orders(self) -> tuple[float, float]:
        """Orders of the attitude and of the rate: medians of the logᵣ of ratios of differences.

        Infinite where most differences are those of round-off.
        """
        return self._order(slice(3)), self._order(slice(3, 6))

    def _order(self, part: slice) -> float:
        coarse, fine = (np.linalg.norm(each[1 : self.judged, part], axis=1) for each in self.differences)
        clear = np.minimum(coarse, fine) > MAX_REMAINS * self.floor[1 : self.judged]
        if not self.judged or clear.mean() <= 0.5:
            return inf
        return float(np.median(np.log(coarse[clear] / fine[clear]))) / math.log(self.ratio)

    @property
    def order(self) -> float:
        """The lower order of attitude and rate; infinite where it is not judged."""
        return min(self.orders)

    def at_step_0(self, coarse: Array, fine: Array) -> MotionArrays:
        """Addition to the result at the smallest step, and how well it is known, from two differences.

        The order is taken as the nearest whole one, from 1 on.
        """
        R = float(self.ratio ** max(1, round(self.order if self.order < inf else 1.0)))
        return -fine / (R - 1.0), (R * fine - coarse) / (R - 1.0)

    def remains(self, motion: MotionArrays) -> float:
        """Distance at step 0 from a motion, in units of how well that is known: the median over time.

        Infinite where the case is not judged, or the engine diverges.
        """
        if not self.judged or np.isnan(self.common[-1][1]).any():
            return inf
        added, unknown = self.at_step_0(*self.differences)
        left = difference(motion, self.common[-1], self.speed) + added
        known_to = np.linalg.norm(unknown, axis=1) + self.floor
        return float(np.median((np.linalg.norm(left, axis=1) / known_to)[1 : self.judged]))

    @cached_property
    def energy(self) -> Array:
        """Change of the kinetic energy as a share of that at the start, by steps: shape (3, N)."""
        energies = np.array([np.sum(rate * (rate @ self.case.inertia), axis=1) for _, rate in self.common])
        return np.asarray(energies / energies[0, 0] - 1.0)

    @cached_property
    def momentum(self) -> Array:
        """Momentum in the world's axes at the smallest step, in units of its norm at the start: shape (N, 3)."""
        attitude, rate = self.common[-1]
        momentum = quaternion.rotate(attitude, rate @ self.case.inertia)
        return np.asarray(momentum / np.linalg.norm(momentum[0]))
