"""Consistency of a covariance with the errors of many runs, and what is wrong where it is not consistent.

Errors of a filter are correlated in time, so the samples of one run are not independent; runs are, where the seeds of
their sensors differ. So whole runs are the samples here. Of each run the NEES is averaged over time. Where the
covariance is right, its mean over runs is the number of degrees of freedom, whatever the correlation. Its distribution
is close to a gamma distribution of unknown shape, by whose likelihood ratio the mean is tested. A band of the mean NEES
over time that holds for all times at once comes from resampling whole runs (bootstrap-t: B. Efron, R. Tibshirani, An
Introduction to the Bootstrap, 1993, chapter 12, with the largest deviation over time). What is wrong is named by
repair: of the covariances that are repaired, the likelier ones without an inconsistency name it.

Measured (benchmarks/covariances.py): of right covariances 3 to 6 % are called inconsistent, with 12, 30 or 100 runs.
Their errors are constant over a run, grow like a random walk, or are stationary. Of covariances that are wrong by the
factor that so many runs are said to show, 47 to 66 % are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import numbers
from lie_rigid_body.evaluation.consistency import errors_and_covariances, nees_and_logarithm, require_axes
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.lie import quaternion

LEVEL: Final = 0.05
"""Probability that a right covariance is called inconsistent."""
_HALF: Final = LEVEL / 2.0
"""Level of each of the two tests, of the mean and of the band."""
NOT_SHOWN: Final = "no inconsistency shown"
"""Verdict on a covariance that the errors do not contradict; other ones may be as likely."""
MIN_RUNS: Final = 10
"""Least number of runs whose spread is known well enough."""
COVERAGES: Final = (0.68, 0.95, 0.997)


@dataclass(frozen=True)
class Interval:
    """A time in which the mean NEES leaves its band.

    Attributes
    ----------
    begin_s, end_s : float
        First and last time outside, s.
    verdict : str
        ``overconfident`` or ``conservative``.
    """

    begin_s: float
    end_s: float
    verdict: str


@short_dataclass
class EnsembleConsistency:
    """Verdict on a covariance over many runs.

    Attributes
    ----------
    runs, dimension : int
    nees_mean : float
        Mean over runs and times; `dimension` is expected.
    verdict : str
        ``no inconsistency shown``, ``overconfident`` (errors larger than the covariance says), ``conservative``, or
        ``changing``, where the mean over all times is right and that of some times is not.
    outside : tuple of Interval
        Times in which the mean NEES over the runs is outside of a band that holds for all times together.
    coverage : dict of float to float
        Share of errors inside the ellipsoid of each probability in `COVERAGES`.
    cause : str
        ``axes``, ``standard_deviation``, ``degrees``, ``cross_covariances`` or ``factor``; '' if none explains it.
    factor : float
        What the covariance is to be multiplied by to have the right mean NEES.
    factor_bounds : tuple of float
        Interval of `factor` at 97.5 %, the level of the test of the mean.
    over_time : tuple of (float, float)
        Times, s, and the mean NEES over the runs at each.
    """

    runs: int
    dimension: int
    nees_mean: float
    verdict: str
    outside: tuple[Interval, ...]
    coverage: dict[float, float]
    cause: str
    factor: float
    factor_bounds: tuple[float, float]
    over_time: tuple[tuple[float, float], ...]

    @property
    def passed(self) -> bool:
        """Whether no inconsistency is shown."""
        return self.verdict == NOT_SHOWN

    @property
    def factor_shown(self) -> float:
        """Factor of a wrong covariance that so many runs would show: half of the interval's width, as a ratio."""
        low, high = self.factor_bounds
        return math.sqrt(high / low)

    @property
    def message(self) -> str:
        """The verdict in one sentence."""
        said = _REPAIRS[self.cause][1].format(self.factor, *self.factor_bounds) if self.cause else ""
        times = "; ".join(
            f"{i.verdict} at {i.begin_s:.4g} s"
            if i.begin_s == i.end_s
            else f"{i.verdict} from {i.begin_s:.4g} s to {i.end_s:.4g} s"
            for i in self.outside
        )
        mean = f"mean NEES {self.nees_mean:.3g} over {self.runs} runs, expected {self.dimension}"
        if self.passed:
            low, high = self.factor_bounds
            found = f"{self.factor:.3g} ({low:.3g} to {high:.3g})"
            shown = f"with these {self.runs} runs a factor of {self.factor_shown:.3g} would be"
            return f"No inconsistency shown ({mean}, factor {found}); {shown}"
        if self.verdict == "changing":
            return f"The covariance is wrong at some times ({mean}): {'; '.join(filter(None, (times, said)))}"
        return f"The covariance is {self.verdict} ({mean}): {said or times}"

    @property
    def covered(self) -> str:
        """Shares of errors inside the ellipsoids, in one sentence."""
        named, found = (
            listed([f"{100.0 * share:.3g}" for share in shares]) for shares in (self.coverage, self.coverage.values())
        )
        return f"Inside of its {named} % ellipsoids are {found} % of the errors"


_REPAIRS: Final[dict[str, tuple[Callable[[Array, Array, float], Array], str]]] = {
    "axes": (
        lambda P, R, factor: R @ P @ np.swapaxes(R, -1, -2),
        "it is consistent about the other axes, of world and body: give covariance_axes",
    ),
    "standard_deviation": (
        lambda P, R, factor: P @ P,
        "it is consistent when it is squared: give variances, not standard deviations",
    ),
    "degrees": (
        lambda P, R, factor: P * np.radians(1.0) ** 2,
        "it is consistent when degrees become radians: give rad²",
    ),
    "cross_covariances": (
        lambda P, R, factor: P * (2.0 * np.eye(P.shape[-1]) - 1.0),
        "it is consistent with cross-covariances of the other sign",
    ),
    "factor": (lambda P, R, factor: factor * P, "multiply it by {:.3g} ({:.3g} to {:.3g})"),
}
"""Repairs of covariances by cause: a function of covariances P, turns R to the other axes and a factor, and what is
said.
"""


def ensemble_consistency(
    t_s: ArrayLike,
    errors: ArrayLike,
    covariance: ArrayLike,
    attitude_xyzw: ArrayLike | None = None,
    axes: str = "world",
) -> EnsembleConsistency:
    """Judge the covariance of an estimate over many independent runs.

    Parameters
    ----------
    t_s : array_like, shape (T,)
        Times that the runs have in common, s.
    errors : array_like, shape (R, T, d)
        Errors: of an attitude small rotations, rad, about the axes of the covariance.
    covariance : array_like, shape (R, T, d, d) or (d, d)
        Covariances that the filter gave, in the squared unit of the errors.
    attitude_xyzw : array_like, shape (R, T, 4), optional
        Attitudes world-from-body, scalar last; with them a covariance about the wrong axes is named.
    axes : str
        ``world`` or ``body``: the axes of the covariance.

    Raises
    ------
    InputError
        If a shape is wrong, a number not finite, or there are too few runs. Also if a covariance is not symmetric and
        positive definite.
    """
    require_axes(axes)
    e, P = errors_and_covariances(errors, covariance, "R", "T", "d")
    runs, count, dimension = e.shape
    if runs < MIN_RUNS:
        raise InputError(f"the covariances of {runs} runs: their spread tells too little: give {MIN_RUNS} or more")
    times = numbers("t_s", t_s, count, whole=True)
    R = np.eye(dimension)
    if attitude_xyzw is not None:
        q = numbers("attitude_xyzw", attitude_xyzw, runs, count, 4, whole=True)
        R = quaternion.to_matrix(q if axes == "world" else quaternion.conjugate(q))
    values, scores = _nees_and_score(e, P)
    means = values.mean(axis=1)
    low, high = mean_bounds(means, _HALF)
    factor = float(means.mean()) / dimension
    verdict, outside = _verdict(times, values, dimension)
    return EnsembleConsistency(
        runs,
        dimension,
        float(means.mean()),
        verdict,
        outside,
        {share: float(np.mean(values <= scipy.stats.chi2.ppf(share, dimension))) for share in COVERAGES},
        "" if verdict == NOT_SHOWN else _cause(times, e, P, scores, R, factor),
        factor,
        (low / dimension, high / dimension),
        tuple(zip(times.tolist(), values.mean(axis=0).tolist(), strict=True)),
    )


def _nees_and_score(errors: Array, covariance: Array) -> tuple[Array, Array]:
    """NEES of every sample, shape (R, T), and minus the mean logarithm of the likelihood of each run, shape (R,)."""
    values, logarithm = nees_and_logarithm(errors, covariance)
    values = np.maximum(values, 1e-100)  # the logarithm of which is taken
    return values, (0.5 * values + logarithm).mean(axis=1)


def _likelihood(values: Array, mean: float) -> float:
    """Twice the largest log-likelihood of gamma variates of a given mean, over all shapes k: ln k − ψ(k) = excess."""
    logarithm = np.log(values).mean()
    ratio = values.mean() / mean
    excess = max(np.log(mean) - logarithm + ratio - 1.0, 1e-12)
    # 1 / 2k < ln k − ψ(k) < 1 / k
    k = scipy.optimize.brentq(
        lambda shape: np.log(shape) - scipy.special.psi(shape) - excess, 0.4 / excess, 1.1 / excess
    )
    return (
        2.0 * len(values) * float(k * np.log(k / mean) - scipy.special.gammaln(k) + (k - 1.0) * logarithm - k * ratio)
    )


def mean_bounds(values: Array, level: float) -> tuple[float, float]:
    """Interval of the mean of gamma variates of unknown shape, by the likelihood ratio.

    Parameters
    ----------
    values : ndarray, shape (R,)
        Positive numbers.
    level : float
        Probability that the mean lies outside.
    """
    mean = float(values.mean())
    most = float(scipy.stats.f.isf(level, 1, len(values) - 1))
    best = _likelihood(values, mean)

    low, high = (
        scipy.optimize.brentq(lambda factor: best - _likelihood(values, mean * factor) - most, *ends)
        for ends in ((1e-9, 1.0), (1.0, 1e9))
    )
    return mean * float(low), mean * float(high)


def _verdict(t_s: Array, values: Array, dimension: int) -> tuple[str, tuple[Interval, ...]]:
    """Verdict by the mean of all runs and times and, where that is right, by times that are outside of the band."""
    (low, high) = mean_bounds(values.mean(axis=1), _HALF)
    outside = _outside(t_s, values, dimension)
    if low <= dimension <= high:
        return ("changing" if outside else NOT_SHOWN), outside
    return ("overconfident" if low > dimension else "conservative"), outside


def _outside(t_s: Array, values: Array, dimension: int) -> tuple[Interval, ...]:
    """Times in which the mean over runs is outside of its band, neighbours joined."""
    runs = len(values)
    draws = np.random.default_rng(0)
    mean = values.mean(axis=0)
    error = values.std(axis=0, ddof=1) / np.sqrt(runs)
    # each resampling counts how often every run is drawn
    weights = draws.multinomial(runs, np.full(runs, 1.0 / runs), size=2000) / runs
    means = weights @ values
    variance = (weights @ values**2 - means**2) * runs / (runs - 1)
    deviation = (means - mean) / np.sqrt(np.maximum(variance / runs, 1e-300))
    least = np.quantile(deviation.min(axis=1), _HALF / 2.0)
    most = np.quantile(deviation.max(axis=1), 1.0 - _HALF / 2.0)
    sides = np.where(mean - most * error > dimension, 1, np.where(mean - least * error < dimension, -1, 0))
    return tuple(
        Interval(float(t_s[part[0]]), float(t_s[part[-1]]), "overconfident" if sides[part[0]] > 0 else "conservative")
        for part in np.split(np.arange(len(t_s)), np.flatnonzero(np.diff(sides)) + 1)
        if sides[part[0]]
    )


@np.errstate(over="ignore")  # what is repaired may leave double precision, and is then no cause
def _cause(t_s: Array, errors: Array, covariance: Array, scores: Array, R: Array, factor: float) -> str:
    """Cause whose repair makes errors likelier and the covariance consistent: the likeliest, a factor if no other."""
    runs = len(errors)
    dimension = errors.shape[-1]
    found: dict[str, tuple[bool, float]] = {}
    for code, (repair, _) in _REPAIRS.items():
        try:
            values, repaired = _nees_and_score(errors, repair(covariance, R, factor))
        except InputError:  # the repaired one is none
            continue
        gain = scores - repaired
        sure = code == "factor" or gain.mean() > scipy.stats.t.isf(LEVEL, runs - 1) * gain.std(ddof=1) / np.sqrt(runs)
        if sure and _verdict(t_s, values, dimension)[0] == NOT_SHOWN:
            found[code] = code == "factor", float(repaired.mean())
    return min(found, key=lambda code: found[code], default="")
