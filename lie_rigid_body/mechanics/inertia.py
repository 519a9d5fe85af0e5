"""Inertia tensors: the accepted forms of input, what no mass distribution can have, and the principal axes."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import ParameterError

_NAME: Final = "inertia"
MOMENT_ROUND_OFF: Final = 8.0 * float(np.finfo(np.float64).eps)
"""Rounding error of principal moments, relative to the largest: moments that differ by no more count as equal."""
SYMMETRY_ULPS: Final = 8.0
"""Largest difference of entries across the diagonal of a tensor, in units in the last place of its largest entry."""
MIN_ROUNDED_DIGITS: Final = 3
"""Least number of digits to which moments may have been rounded, where the message says that they seem to be."""


def inertia_matrix(inertia: ArrayLike) -> Array:
    """The inertia tensor from any accepted form; `require_physical` checks the moments.

    Parameters
    ----------
    inertia : array_like, shape (3,), (6,) or (..., 3, 3)
        Principal moments along the body axes; or ``ixx ixy ixz iyy iyz izz`` (the off-diagonal entries of the tensor
        itself, as in URDF); or the symmetric tensor, or a batch of them. kg m², body frame.

    Returns
    -------
    ndarray, shape (..., 3, 3)

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
    if array.shape[-2:] != (3, 3) or array.size == 0:
        raise ParameterError(
            _NAME,
            f"{array.size} numbers of shape {array.shape}: give 3 principal moments or ixx ixy ixz iyy iyz izz, and "
            "many bodies as tensors (..., 3, 3) or by from_principal_moments",
        )
    transposed = array.swapaxes(-1, -2)
    gap = np.abs(array - transposed).max(axis=(-2, -1))
    allowed = SYMMETRY_ULPS * np.spacing(np.abs(array).max(axis=(-2, -1)))
    if (gap > allowed).any():
        worst = np.argmax(gap / allowed)
        raise ParameterError(
            _NAME,
            f"entries across the diagonal differ by up to {gap.flat[worst]:.3g}, more than round-off "
            f"({allowed.flat[worst]:.3g}): give a symmetric tensor, as (I + I.T) / 2",
        )
    return np.asarray(0.5 * array + 0.5 * transposed)


def diagonal_matrix(moments: ArrayLike) -> Array:
    """The inertia tensors of principal moments along the body axes.

    Parameters
    ----------
    moments : array_like, shape (..., 3)
        kg m².

    Returns
    -------
    ndarray, shape (..., 3, 3)

    Raises
    ------
    ParameterError
        If the shape is another or a number is not finite.
    """
    return np.asarray(real_array(_NAME, moments, (..., 3))[..., np.newaxis] * np.eye(3))


def principal_decomposition(matrix: Array) -> tuple[Array, Array]:
    """Principal moments in ascending order and the principal axes.

    Parameters
    ----------
    matrix : ndarray, shape (..., 3, 3)
        Symmetric inertia tensor, kg m².

    Returns
    -------
    moments : ndarray, shape (..., 3)
        Ascending, kg m². Exactly the diagonal, if the matrix is diagonal.
    axes : ndarray, shape (..., 3, 3)
        Columns are the principal axes in the body frame, right-handed.
    """
    moments, axes = np.linalg.eigh(matrix)
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    order = np.argsort(diagonal, axis=-1, kind="stable")
    plain = (matrix == diagonal[..., np.newaxis] * np.eye(3)).all(axis=(-2, -1))[..., np.newaxis]
    moments = np.where(plain, np.take_along_axis(diagonal, order, axis=-1), moments)
    axes = np.where(plain[..., np.newaxis], np.eye(3)[order].swapaxes(-1, -2), axes)
    mirrored = np.linalg.det(axes) < 0.0
    axes[..., 2] = np.where(mirrored[..., np.newaxis], -axes[..., 2], axes[..., 2])
    return moments, axes


def require_physical(moments: Array) -> None:
    """Refuse principal moments that no mass distribution has.

    Parameters
    ----------
    moments : ndarray, shape (..., 3)
        Ascending, kg m².

    Raises
    ------
    ParameterError
        If the smallest is not positive, or the largest exceeds the sum of the others by more than round-off.
    """
    rows = moments.reshape(-1, 3)
    lacking = ~(rows[:, 0] > 0.0)
    if lacking.any():
        raise ParameterError(
            _NAME,
            f"smallest principal moment {float(rows[lacking][0, 0])!r} is not positive: give moments above 0 kg m²",
        )
    excess = rows[:, 2] - rows[:, 1] > rows[:, 0] + MOMENT_ROUND_OFF * rows[:, 2]
    if excess.any():
        small, middle, large = rows[excess][0].tolist()
        gap = large - middle - small
        # rounding to d digits changes moments by up to half of 10**(1 - d) of themselves
        digits = math.floor(1.0 - math.log10(gap / large))
        rounded = f", as a flat body rounded to {digits} digits does" if digits >= MIN_ROUNDED_DIGITS else ""
        raise ParameterError(
            _NAME,
            f"principal moments {small!r}, {middle!r}, {large!r} break the triangle inequality by {gap:.3g}{rounded}: "
            f"lower the largest to at most {small + middle!r}",
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
    x, y, z = vectors[..., 0:1], vectors[..., 1:2], vectors[..., 2:3]
    return np.asarray(x * tensor[..., 0] + y * tensor[..., 1] + z * tensor[..., 2])
