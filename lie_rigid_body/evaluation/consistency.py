"""Whether errors are as large as an estimator says: the normalised estimation error squared (NEES).

For an error e of dimension d and its covariance P the NEES is eᵀ P⁻¹ e. If the error is Gaussian with that covariance
it has a χ² distribution with d degrees of freedom (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with
Applications to Tracking and Navigation, 2001, section 5.4.2). Errors of one run are correlated in time, over an unknown
time, so its mean NEES has no test. Only a mean that is wrong by a factor of `FAR` is remarked on. Many runs have a
test, `ensemble_consistency`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation.arguments import numbers, real_numbers
from lie_rigid_body.evaluation.attitudes import error_vectors
from lie_rigid_body.foundation.arrays import Array, Booleans
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown

OTHER_AXES: Final = {"world": "body", "body": "world"}
"""Names of the axes that a covariance may be about, each with the name of the others."""
PROBABILITY: Final = 0.95
"""Probability that a single NEES of a right covariance lies within its bounds, two-sided."""
FAR: Final = 10.0
"""Ratio of mean and expected NEES, or its inverse, from which on a run alone has a remark.

Measured (benchmarks/run_consistency.py) in runs of 60 s: where errors are correlated over 0.01 to 10 s, fewer than
0.1 % of right covariances have one. Where the error is constant 4 % have.
"""
BETTER: Final = 0.25
"""Largest ratio of the logarithm of the relative NEES about the other axes to that about the given ones, for the others
to be named. The ratio is not 0, as errors are correlated in time."""

MIN_VARIANCE: Final = 1e-200
"""Least variance, in the squared unit of the errors; a NEES by a smaller one overflows."""
ASYMMETRY: Final = 1e-6
"""Largest difference between a covariance and its transpose, relative to the standard deviations, that counts as
round-off."""


@short_dataclass(eq=False)
class Consistency:
    """NEES of a run; one run gives no verdict on a covariance.

    Attributes
    ----------
    nees : ndarray, shape (N,)
        One number a sample.
    dimension : int
        Degrees of freedom d of one sample; the expected NEES.
    mean : float
    bounds : tuple of float
        Between which a single NEES lies with the probability `PROBABILITY`.
    share_inside : float
        Share of samples between `bounds`.
    remark : str
        Where the mean is wrong by a factor of `FAR` or more: a sentence with the factor. Where the covariance fits
        about the other axes, of world and body, it names them. Else empty.
    """

    nees: Array
    dimension: int
    mean: float
    bounds: tuple[float, float]
    share_inside: float
    remark: str

    @property
    def sentence(self) -> str:
        """Mean, expected mean and share inside, without a full stop."""
        inside = f"{100.0 * self.share_inside:.3g} % of the samples within their {100.0 * PROBABILITY:g} % bounds"
        return f"{self.mean:.4g} on average, expected {self.dimension}; {inside}"

    def to_json(self) -> dict[str, float | str]:
        """JSON-serialisable data: mean, expected mean, share inside the bounds, and remark."""
        return {
            "mean": self.mean,
            "expected": float(self.dimension),
            "inside": self.share_inside,
            "remark": self.remark,
        }


def nees(errors: Array, covariance: Array) -> Consistency:
    """NEES of errors, shape (N, d), and covariances on the same axes, shape (N, d, d), or (d, d) of all.

    Raises
    ------
    InputError
        If a covariance is not symmetric and positive definite.
    """
    values, _ = nees_and_logarithm(errors, covariance)
    d = errors.shape[1]
    tail = 0.5 * (1.0 - PROBABILITY)
    low = float(scipy.stats.chi2.ppf(tail, d))
    high = float(scipy.stats.chi2.isf(tail, d))
    inside = float(np.mean((values >= low) & (values <= high)))
    mean = float(np.mean(values))
    remark = ""
    if not 1.0 / FAR < mean / d < FAR:
        remark = f"the squared errors are {mean / d:.3g} times what the covariance says"
    return Consistency(values, d, mean, (low, high), inside, remark)


def attitude_nees(estimate_xyzw: Array, truth_xyzw: Array, covariance: Array, axes: str = "world") -> Consistency:
    """NEES of attitude estimates, with a remark where their covariances fit the other axes.

    Parameters
    ----------
    estimate_xyzw, truth_xyzw : ndarray, shape (N, 4)
        World-from-body, scalar last, of unit norm.
    covariance : ndarray, shape (N, 3, 3) or (3, 3)
        Of small rotations about x, y, z, rad².
    axes : str
        ``"world"``: about the axes of the header's frame, as geometry_msgs/PoseWithCovariance says; ``"body"``: about
        the axes of the body, as most error-state filters have it.

    Raises
    ------
    InputError
        See `nees`.
    """
    found = nees(error_vectors(estimate_xyzw, truth_xyzw, axes), covariance)
    if not found.remark or not found.mean:
        return found
    other = OTHER_AXES[axes]
    mean = nees(error_vectors(estimate_xyzw, truth_xyzw, other), covariance).mean
    if abs(np.log(mean / found.dimension)) > BETTER * abs(np.log(found.mean / found.dimension)):
        return found
    remedy = (
        f"about the {other}'s axes the mean NEES would be {mean:.4g}: if it is about them, give covariance_axes {other}"
    )
    return replace(found, remark=f"{found.remark}; {remedy}")


def require_axes(axes: str) -> None:
    """Refuse axes that no covariance is about.

    Raises
    ------
    InputError
    """
    if not isinstance(axes, str) or axes not in OTHER_AXES:
        raise InputError(f"axes {shown(axes)} are unknown: give 'world' or 'body'")


def unknown_covariances(covariance: Array) -> Booleans:
    """Mask of the covariances, shape (N, 3, 3), that an estimator does not know: −1, or all 0."""
    return np.asarray((covariance[:, 0, 0] == -1.0) | ~covariance.any(axis=(-2, -1)))


def covariance_fault(covariance: Array) -> str:
    """Reason in one line why those of some covariances, shape (N, 3, 3), that are known are none; empty if they are."""
    known = covariance[~unknown_covariances(covariance)]
    try:
        factor_of(numbers("covariance", known, 3, 3) if len(known) else np.eye(3))
    except InputError as error:
        return str(error)
    return ""


def rotation_block(covariance: ArrayLike) -> Array:
    """Covariance of the rotation, 3 × 3, in a covariance of a rotation or of a pose."""
    P = real_numbers("covariance", covariance, "(..., 3, 3)")
    P = numbers("covariance", P[..., 3:, 3:] if P.shape[-2:] == (6, 6) else P, 3, 3)
    if np.any(P[..., 0, 0] == -1.0) or not P.any(axis=(-2, -1)).all():
        raise InputError("covariance: -1 or all 0 says that the estimator does not know it: leave it out")
    return P


def errors_and_covariances(errors: ArrayLike, covariance: ArrayLike, *axes: str) -> tuple[Array, Array]:
    """Read errors, whose axes have these names, and the covariance of each, or one of all.

    Raises
    ------
    InputError
        If a shape is wrong or a number not finite.
    """
    wanted = f"({', '.join(axes)})"
    e = real_numbers("errors", errors, wanted)
    if e.ndim != len(axes):
        raise InputError(f"errors: shape {e.shape} is not {wanted}: give a row for each error")
    d = e.shape[-1]
    e = numbers("errors", e, d)
    P = numbers("covariance", covariance, d, d)
    if P.shape not in {(d, d), (*e.shape, d)}:
        raise InputError(f"covariance: shape {P.shape} is not {(d, d)} or {(*e.shape, d)}: give one, or one an error")
    return e, P


def nees_and_logarithm(errors: Array, covariance: Array) -> tuple[Array, Array]:
    """NEES of errors, shape (..., d), and half of the logarithms of the determinants of covariances (..., d, d).

    Raises
    ------
    InputError
        As `factor_of`.
    """
    factor = factor_of(covariance)
    values = np.sum(np.linalg.solve(factor, errors[..., np.newaxis])[..., 0] ** 2, axis=-1)
    return values, np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1)


def factor_of(P: Array, name: str = "covariance") -> Array:
    """Lower Cholesky factor of covariances, by their symmetric part, on axes scaled to unit variance to lose no digits.

    Raises
    ------
    InputError
        If one is not symmetric and positive definite.
    """
    variances = np.diagonal(P, axis1=-2, axis2=-1)
    if not np.all(variances >= MIN_VARIANCE):
        raise InputError(
            f"{name}: {variances.min():.3g} on its diagonal: give positive variances, {MIN_VARIANCE:g} at least"
        )
    scale = np.sqrt(variances)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is no covariance, and refused
        scaled = P / scale[..., :, np.newaxis] / scale[..., np.newaxis, :]
        transposed = np.swapaxes(scaled, -1, -2)
        # beside the variances: what is round-off of R P Rᵀ may be all that there is of a correlation
        if not np.all(np.abs(scaled - transposed) <= ASYMMETRY):
            raise InputError(f"{name}: not symmetric: give its symmetric part, (P + Pᵀ)/2")
    try:
        return scale[..., :, np.newaxis] * np.linalg.cholesky(0.5 * scaled + 0.5 * transposed)
    except np.linalg.LinAlgError:
        raise InputError(f"{name}: not positive definite: give one that has an inverse") from None
