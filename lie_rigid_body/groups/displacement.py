"""Chasles' theorem: every displacement of a rigid body is a rotation and a translation; here both from points.

The theorem and its proof are eqs. (1) to (6) of A. Lucas, arXiv 1111.1275, whose numbers are used below. Eq. (2) alone
does not make the rotation the same for all points, as x ↦ R(|x|)x obeys it; eq. (1) does.

References
----------
S. Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE Transactions on
Pattern Analysis and Machine Intelligence 13 (1991) 376-380, eqs. 38-43, with the scale held at 1.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics.array_input import real_array, require_share

_ROUND_OFF: Final = 8.0 * float(np.finfo(np.float64).eps)
"""Rounding error of a coordinate, relative to the largest."""
_THIN: Final = 1e-2
"""Squared ratio of a body's width to its length below which the width is compared with the noise of the measured
points."""


@short_dataclass(frozen=True, eq=False)
class Displacement:
    """A displacement x ↦ A x + t of a rigid body in n dimensions: eq. (3), with the translation.

    Parameters
    ----------
    rotation : ndarray, shape (n, n)
        A in SO(n): takes body vectors to world vectors.
    translation : ndarray, shape (n,)
        t, the world position of the body's origin, m.
    residual : float
        Root mean square distance of the displaced points from where the displacement puts them, m. Round-off for exact
        data, and about the noise for noisy data; large when the points were reflected or the body was not rigid.
    determinacy : float
        How well the points determine the rotation, above 0 and at most 2: (σₙ₋₁ ± σₙ)/σ₁ of the singular values of
        the cross covariance, minus if its determinant is negative. A relative error ε of the data changes the rotation
        by at most about ε/determinacy, rad.
    """

    rotation: Array
    translation: Array
    residual: float
    determinacy: float

    def apply(self, points: ArrayLike) -> Array:
        """The positions of displaced points of the body, whose distances are unchanged: eqs. (1) and (2).

        Parameters
        ----------
        points : array_like, shape (..., n)
            Body frame, m.

        Returns
        -------
        ndarray, shape (..., n)
            World frame, m.
        """
        x = real_array("points", points, f"(…, {len(self.translation)})", empty=True)
        return np.asarray(x @ self.rotation.T + self.translation)


def chasles(points: ArrayLike, displaced: ArrayLike, weights: ArrayLike | None = None) -> Displacement:
    """The rotation and the translation that best fit points of a body before and after a displacement, eq. (1).

    They minimise Σ wᵢ |yᵢ − A xᵢ − t|² over A in SO(n) and t. The determinant of A is 1 also when the points lie in one
    hyperplane, and when the data are a mirror image, which no rotation fits: see the residual.

    Parameters
    ----------
    points : array_like, shape (N, n)
        Points xᵢ in the body frame, m. At least n of them, n ≥ 2.
    displaced : array_like, shape (N, n)
        The same points yᵢ in the world frame, in the same order, exact or noisy, m.
    weights : array_like, shape (N,), optional
        Not negative, in any unit; equal if left out. For independent noise, the inverse of its variance.

    Returns
    -------
    Displacement

    Raises
    ------
    InputError
        If shapes do not match, numbers are not finite, weights are negative or all 0, or the rotation is not
        determined. It is not determined if the points span fewer than n−1 dimensions about their centre, or if they are
        reflected and the direction of the mirror is not unique. Both are within round-off of squared lengths, so that a
        body thinner than about 1e-7 of its length counts as a line. Nor is it determined if the width of a thin body
        may be noise. That is a width of less than a tenth of its length, and less than the misfit of the best
        orthogonal map.
    """
    x, y = _point_pairs(points, displaced)
    w = _fractions(weights, len(x))
    x_centre, y_centre = w @ x, w @ y
    body, world = _unit_spread(x, x_centre, w), _unit_spread(y, y_centre, w)
    rotation, determinacy = _closest_rotation(body, world, x.shape[1])
    translation = y_centre - rotation @ x_centre
    # of centred points, so that a far origin adds no round-off
    residual = _root_mean_square((y - y_centre) - (x - x_centre) @ rotation.T, w)
    rotation.setflags(write=False)
    translation.setflags(write=False)
    return Displacement(rotation, translation, residual, determinacy)


def _root_mean_square(misses: Array, fractions: Array) -> float:
    scale = float(np.abs(misses).max()) or 1.0
    return scale * float(np.sqrt(fractions @ np.sum((misses / scale) ** 2, axis=1)))


def _point_pairs(points: ArrayLike, displaced: ArrayLike) -> tuple[Array, Array]:
    x = real_array("points", points, "(N, n)")
    y = real_array("displaced", displaced, f"({len(x)}, {x.shape[1]})")
    if x.shape[1] < 2:
        raise ParameterError("points", "1 coordinate has no rotations: give at least 2 coordinates a point")
    return x, y


def _fractions(weights: ArrayLike | None, count: int) -> Array:
    if weights is None:
        return np.full(count, 1.0 / count)
    w = real_array("weights", weights, f"({count},)")
    require_share("weights", w, "")
    w /= w.max()
    return w / w.sum()


def _unit_spread(points: Array, centre: Array, fractions: Array) -> tuple[Array, float]:
    """Weighted points about their centre, scaled to unit size, and their rounding error at that size."""
    centred = (points - centre) * np.sqrt(fractions)[:, None]
    size = float(np.abs(centred).max())
    if size == 0.0:
        return centred, _ROUND_OFF
    return centred / size, _ROUND_OFF * max(1.0, float(np.abs(points).max()) / size)


def _closest_rotation(body: tuple[Array, float], world: tuple[Array, float], n: int) -> tuple[Array, float]:
    """The A in SO(n) that maximises tr(Aᵀ H), with the cross covariance H (Umeyama 1991, eqs. 38-40, 43); determinacy.

    Umeyama's condition is rank H ≥ n−1. It admits mirror images with σₙ₋₁ = σₙ, whose best rotation is not unique. The
    rotation is unique exactly if σₙ₋₁ + sign(det H) σₙ > 0.
    """
    (x, x_error), (y, y_error) = body, world
    left, sigma, right = np.linalg.svd(y.T @ x)
    sign = float(np.sign(np.linalg.det(left) * np.linalg.det(right)))
    limit = float(np.linalg.norm(x) * np.linalg.norm(y)) * (x_error + y_error)
    rank = int(np.sum(sigma > limit))
    if rank < n - 1:
        raise InputError(
            f"the rotation is not determined: about their centre the points and their images span rank {rank} in "
            f"{n} dimensions, and at least {n - 1} is needed: add points off their common subspace"
        )
    if sigma[-2] < _THIN * sigma[0]:
        _require_width(x, y, left @ right, float(sigma[-2]))
    gap = float(sigma[-2] + sign * sigma[-1])
    if not gap > limit:
        raise InputError(
            f"not determined for a mirror image: the smallest singular values {sigma[-2]:.6g} and {sigma[-1]:.6g} "
            f"(largest {sigma[0]:.6g}) must differ: undo the reflection, or add points that break the symmetry"
        )
    left[:, -1] *= sign
    return left @ right, gap / float(sigma[0])


def _require_width(x: Array, y: Array, orthogonal: Array, variance: float) -> None:
    """Refuse points whose second least width is below the misfit of the best orthogonal map: it may be noise."""
    # each set was scaled to unit size by itself; a common scale lets them be compared
    scale = float(np.linalg.norm(y) / np.linalg.norm(x))
    noise = float(np.linalg.norm(y - scale * x @ orthogonal.T)) / math.sqrt(scale)
    width = math.sqrt(variance)
    if noise > max(width, _ROUND_OFF):
        raise InputError(
            f"the rotation is not determined: the images miss the points by {noise / width:.3g} times the width of the "
            "body, which may be noise alone: add points off their common subspace, or measure them better"
        )
