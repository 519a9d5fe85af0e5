"""Inertia tensors: the accepted forms of input, what no mass distribution can have, and the principal axes."""

from __future__ import annotations

import math
import sys
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import ParameterError

_NAME: Final = "inertia"
MOMENT_ROUND_OFF: Final = 8.0 * sys.float_info.epsilon
"""Rounding error of principal moments, relative to the largest: moments that differ by no more count as equal."""
SYMMETRY_ULPS: Final = 8.0
"""Largest difference of entries across the diagonal of a tensor, in units in the last place of its largest entry."""
MIN_ROUNDED_DIGITS: Final = 3
"""Least number of digits to which moments may have been rounded, where the message says that they seem to be."""


def inertia_matrix(inertia: ArrayLike) -> Array:
    """The inertia tensor from any accepted form; `require_physical` checks the moments.

    Parameters
    ----------
    inertia : array_like, shape (3,), (6,) or (3, 3)
        Principal moments along the body axes; or ``ixx ixy ixz iyy iyz izz`` (the off-diagonal entries of the tensor
        itself, as in URDF); or the symmetric tensor. kg m², body frame.

    Returns
    -------
    ndarray, shape (3, 3)

    Raises
    ------
    ParameterError
        If the shape is none of these, a number is not finite, or entries across the diagonal differ by more than
        `SYMMETRY_ULPS`. Below that the mean of the two is taken.
    """
    array = real_array(_NAME, inertia, (...,), empty=True)
    if array.shape == (3,):
        return np.diag(array)
    if array.shape == (6,):
        xx, xy, xz, yy, yz, zz = array
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if array.shape != (3, 3):
        raise ParameterError(
            _NAME,
            f"{array.size} numbers of shape {array.shape}: give 3 principal moments, ixx ixy ixz iyy iyz izz, or a "
            "tensor of shape (3, 3)",
        )
    gap = np.abs(array - array.T).max()
    allowed = SYMMETRY_ULPS * (np.spacing(np.abs(array).max()))
    if gap > allowed:
        raise ParameterError(
            _NAME,
            f"entries across the diagonal differ by up to {gap:.3g}, more than round-off ({allowed:.3g}): give a "
            "symmetric tensor, as (I + I.T) / 2",
        )
    return 0.5 * array + 0.5 * array.T


def principal_decomposition(matrix: Array) -> tuple[Array, Array]:
    """Principal moments in ascending order and the principal axes.

    Parameters
    ----------
    matrix : ndarray, shape (3, 3)
        Symmetric inertia tensor, kg m².

    Returns
    -------
    moments : ndarray, shape (3,)
        Ascending, kg m². Exactly the diagonal, if the matrix is diagonal.
    axes : ndarray, shape (3, 3)
        Columns are the principal axes in the body frame, right-handed.
    """
    diagonal = np.diagonal(matrix)
    if (matrix == np.diag(diagonal)).all():
        order = np.argsort(diagonal, kind="stable")
        moments = diagonal[order]
        axes = np.eye(3)[:, order]
    else:
        moments, axes = np.linalg.eigh(matrix)
    if np.linalg.det(axes) < 0.0:
        axes[:, 2] = -axes[:, 2]
    return moments, axes


def require_physical(moments: Array) -> None:
    """Refuse principal moments that no mass distribution has.

    Parameters
    ----------
    moments : ndarray, shape (3,)
        Ascending, kg m².

    Raises
    ------
    ParameterError
        If the smallest is not positive, or the largest exceeds the sum of the others by more than round-off.
    """
    small, middle, large = moments.tolist()
    if not small > 0.0:
        raise ParameterError(_NAME, f"smallest principal moment {small!r} is not positive: give moments above 0 kg m²")
    if large - middle > small + MOMENT_ROUND_OFF * large:
        gap = large - middle - small
        # rounding to d digits changes moments by up to half of 10**(1 - d) of themselves
        digits = math.floor(1.0 - math.log10(gap / large))
        rounded = f", as a flat body rounded to {digits} digits does" if digits >= MIN_ROUNDED_DIGITS else ""
        raise ParameterError(
            _NAME,
            f"principal moments {small!r}, {middle!r}, {large!r} break the triangle inequality by {gap:.3g}{rounded}: "
            f"lower the largest to at most {small + middle!r}; in Python groups.Lagrangian(SO(3), M) needs no mass",
        )


def apply_tensor(tensor: Array, vectors: Array) -> Array:
    """The product tensor @ vector over leading axes, by elementwise arithmetic: a batch gives the bits of its rows.

    Parameters
    ----------
    tensor : ndarray, shape (..., 3, 3)
    vectors : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)
    """
    x = vectors[..., 0:1]
    y = vectors[..., 1:2]
    z = vectors[..., 2:3]
    return x * tensor[..., 0] + y * tensor[..., 1] + z * tensor[..., 2]
