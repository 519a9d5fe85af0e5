"""Chasles' theorem: every displacement of a rigid body is a rotation and a translation; here both from points.

The theorem and its proof are eqs. (1) to (6) of A. Lucas, arXiv 1111.1275, whose numbers are used below. Eq. (2) alone
does not make the rotation the same for all points, as x ↦ R(|x|)x obeys it; eq. (1) does.

References
----------
W. Kabsch, Acta Crystallographica A 32 (1976) 922; S. Umeyama, "Least-squares estimation of transformation parameters
between two point patterns", IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (1991) 376-380, eqs.
38-43, with the scale held at 1. Umeyama's condition, rank n−1 of the cross covariance, admits mirror images whose best
rotation is not unique; the one here does not.
"""

from __future__ import annotations

import sys
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics.array_input import require_share

_ROUND_OFF: Final = 8.0 * sys.float_info.epsilon
"""Rounding error of a coordinate, relative to the largest."""


@short_dataclass(eq=False)
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
        x = real_array("points", points, (..., len(self.translation)), empty=True)
        return x @ self.rotation.T + self.translation


@np.errstate(invalid="ignore", divide="ignore")  # of points that are all the same
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
        body thinner than about 1e-7 of its length counts as a line.
    """
    x = real_array("points", points, ("N", "n"))
    y = real_array("displaced", displaced, x.shape)
    if x.shape[1] < 2:
        raise ParameterError("points", "1 coordinate has no rotations: give at least 2 coordinates a point")
    w = real_array("weights", np.ones(len(x)) if weights is None else weights, (len(x),))
    require_share("weights", w, "")
    w /= w.sum()
    x_centre = w @ x
    y_centre = w @ y
    body = x - x_centre
    world = y - y_centre
    left, sigma, right = np.linalg.svd((w[:, None] * world).T @ body)
    sign = np.sign(np.linalg.det(left @ right))
    gap = sigma[-2] + sign * sigma[-1]
    # lengths are known to the round-off of the coordinates
    round_off = _ROUND_OFF * sum((np.abs(p).max() / np.abs(q).max()) for p, q in ((x, body), (y, world)))
    if not gap > round_off * sigma[0]:
        raise InputError(
            "the rotation is not determined: the points span too few dimensions about their centre, or are a mirror "
            "image without a thinnest direction: add points off their common subspace, or undo the reflection"
        )
    left[:, -1] *= sign
    rotation = left @ right
    translation = y_centre - rotation @ x_centre
    rotation.setflags(write=False)
    translation.setflags(write=False)
    # of centred points, so that a far origin adds no round-off
    residual = np.sqrt(w @ np.sum((world - body @ rotation.T) ** 2, axis=1))
    return Displacement(rotation, translation, float(residual), float(gap / sigma[0]))
