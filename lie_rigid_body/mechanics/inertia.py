"""Reading an inertia in its accepted forms, and refusing what no mass distribution can have."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import ParameterError

Array = NDArray[np.float64]

_NAME: Final = "inertia"
_ROUND_OFF: Final = 8.0 * float(np.finfo(np.float64).eps)


def inertia_matrix(inertia: ArrayLike) -> Array:
    """The inertia tensor from any accepted form, unvalidated but for its form.

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
        If the form is another, a number is not finite, or a matrix is not symmetric.
    """
    try:
        array = np.array(inertia, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(
            _NAME, f"{inertia!r} is not numbers: give 3 principal moments or 6 tensor entries"
        ) from None
    if array.shape not in ((3,), (6,), (3, 3)):
        raise ParameterError(
            _NAME, f"{array.size} numbers of shape {array.shape}: give 3 principal moments or ixx ixy ixz iyy iyz izz"
        )
    if not np.isfinite(array).all():
        raise ParameterError(_NAME, f"{array.tolist()} is not finite: give finite numbers in kg m²")
    if array.shape == (3,):
        return np.diag(array)
    if array.shape == (6,):
        xx, xy, xz, yy, yz, zz = array
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not np.array_equal(array, array.T):
        raise ParameterError(_NAME, f"{array.tolist()} is not symmetric: give equal entries across the diagonal")
    return array


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
    diagonal = np.diag(matrix)
    if np.array_equal(matrix, np.diag(diagonal)):
        order = np.argsort(diagonal, kind="stable")
        moments, axes = diagonal[order], np.eye(3)[:, order]
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
    small, middle, large = (float(m) for m in moments)
    if not small > 0.0:
        raise ParameterError(
            _NAME, f"smallest principal moment {small!r} is not positive: every moment must be above 0 kg m²"
        )
    if large - middle > small + _ROUND_OFF * large:
        raise ParameterError(
            _NAME,
            f"principal moments {small!r}, {middle!r}, {large!r} break the triangle inequality: "
            "the largest may not exceed the sum of the other two (a flat body has equality)",
        )


def apply_tensor(tensor: Array, vectors: Array) -> Array:
    """Tensor @ vector over leading axes, elementwise, so that a batch gives the bits of its rows.

    Parameters
    ----------
    tensor : ndarray, shape (3, 3)
    vectors : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3)
    """
    x, y, z = vectors[..., 0:1], vectors[..., 1:2], vectors[..., 2:3]
    return np.asarray(x * tensor[:, 0] + y * tensor[:, 1] + z * tensor[:, 2])
