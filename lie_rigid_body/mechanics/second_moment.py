"""The second moment K = ∫ρ x xᵀ of a body in n dimensions, and the inertia tensor of a body in three.

K describes a body in every dimension (A. Lucas, arXiv 1111.1275, eq. 10); the inertia tensor I belongs to n = 3, where
each follows from the other: I = tr(K) 1 − K (eq. 28) and K = ½ tr(I) 1 − I.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.mechanics.array_input import (
    ROUND_OFF,
    orthogonal_matrix,
    symmetric_matrix,
    symmetrised,
)


@np.errstate(over="ignore", invalid="ignore")  # what goes beyond doubles is refused
def second_moment_matrix(second_moment: ArrayLike) -> Array:
    """A given second moment, checked to be one that some mass distribution has.

    Parameters
    ----------
    second_moment : array_like, shape (n, n)
        K, kg m². Symmetric within round-off.

    Returns
    -------
    ndarray, shape (n, n)
        A copy, exactly symmetric.

    Raises
    ------
    ParameterError
        If it is not a finite square matrix, not symmetric, or not positive semidefinite within round-off. Also if a
        sum of its entries is beyond double precision.
    """
    matrix = symmetric_matrix("second moment", second_moment)
    require_semidefinite("second moment", matrix, np.trace(matrix))
    return matrix


def require_semidefinite(name: str, matrix: Array, scale: float) -> None:
    """Refuse a symmetric matrix with an eigenvalue below 0 by more than round-off, or with sums that overflow.

    Parameters
    ----------
    name : str
        What it is called in the message.
    matrix : ndarray, shape (n, n)
        Symmetric.
    scale : float
        Size of the numbers that it was computed from, whose round-off is allowed.

    Raises
    ------
    ParameterError
    """
    if not np.isfinite([scale, *matrix.flat]).all():
        raise ParameterError(name, "a sum of its entries is beyond double precision, 1.8e308: give smaller numbers")
    smallest = np.linalg.eigvalsh(matrix)[0]
    limit = -ROUND_OFF * abs(scale)
    if smallest < limit:
        raise ParameterError(
            name,
            f"smallest eigenvalue {smallest:.9g} is below 0 by more than round-off ({limit:.3g}): "
            "give a positive semidefinite matrix, and check signs and units",
        )


@np.errstate(over="ignore", invalid="ignore")  # what goes beyond doubles is refused
def rotated_second_moment(second_moment: ArrayLike, rotation: ArrayLike) -> Array:
    """The second moment A K Aᵀ of a body in world axes: the A₀ K A₀ᵀ of Lucas (arXiv 1111.1275), eqs. (12), (13).

    Parameters
    ----------
    second_moment : array_like, shape (n, n)
        K in the body frame, kg m².
    rotation : array_like, shape (..., n, n)
        A, body to world.

    Returns
    -------
    ndarray, shape (..., n, n)
        World frame, kg m². Exactly symmetric.

    Raises
    ------
    ParameterError
        If K is not positive semidefinite or A not orthogonal.
    """
    K = second_moment_matrix(second_moment)
    A = orthogonal_matrix("rotation", rotation, len(K))
    return symmetrised(A @ K @ A.swapaxes(-1, -2))


def second_moment_about(second_moment: ArrayLike, mass: float, centre: ArrayLike, origin: ArrayLike) -> Array:
    """The second moment K about another origin, by the parallel axis theorem: K' = K + m [(c − o)(c − o)ᵀ − c cᵀ].

    It is eq. (10) of Lucas (arXiv 1111.1275) with x − o for x.

    Parameters
    ----------
    second_moment : array_like, shape (n, n)
        K about the present origin, kg m².
    mass : float
        m, kg.
    centre : array_like, shape (n,)
        Centre of mass c from the present origin, m.
    origin : array_like, shape (n,)
        The new origin o from the present one, m. With o = c the result is the central second moment.

    Returns
    -------
    ndarray, shape (n, n)
        kg m². Exactly symmetric.

    Raises
    ------
    ParameterError
        If sizes differ, or K is less than m c cᵀ, which no distribution of this mass and centre has.
    """
    K = second_moment_matrix(second_moment)
    m = real_array("mass", mass, ())
    c, o = (real_array(name, point, (len(K),)) for name, point in (("centre", centre), ("origin", origin)))
    require_semidefinite("second moment about the centre of mass", K - m * np.outer(c, c), (np.trace(K)))
    # written without c cᵀ, which would cancel
    return K + m * (np.outer(o, o) - np.outer(c, o) - np.outer(o, c))


def inertia_from_second_moment(second_moment: ArrayLike) -> Array:
    """The inertia tensor I = tr(K) 1 − K; Lucas (arXiv 1111.1275), eq. (28).

    Parameters
    ----------
    second_moment : array_like, shape (3, 3)
        K, kg m².

    Returns
    -------
    ndarray, shape (3, 3)
        kg m², about the same origin in the same axes.

    Raises
    ------
    ParameterError
        If K is not 3×3 or not positive semidefinite.
    """
    K = second_moment_matrix(second_moment)
    _require_three("second moment", len(K), "use mass_matrix in other dimensions")
    xx, yy, zz = np.diag(K)
    inertia = -K
    # sums of two, and not the trace minus the third, which would lose the digits of a needle
    np.fill_diagonal(inertia, [yy + zz, xx + zz, xx + yy])
    return inertia


@np.errstate(over="ignore", invalid="ignore")  # what goes beyond doubles is refused
def second_moment_from_inertia(inertia: ArrayLike) -> Array:
    """The second moment K = ½ tr(I) 1 − I of a given inertia tensor: Lucas (arXiv 1111.1275), eq. (28) solved for K.

    Parameters
    ----------
    inertia : array_like, shape (3, 3)
        I, kg m².

    Returns
    -------
    ndarray, shape (3, 3)
        kg m², about the same origin in the same axes. Positive semidefinite within round-off, which is equivalent to
        the triangle inequality of the principal moments.

    Raises
    ------
    ParameterError
        If I is not a symmetric 3×3 matrix, or breaks the triangle inequality.
    """
    tensor = symmetric_matrix("inertia", inertia)
    _require_three("inertia", len(tensor), "give the second moment itself in other dimensions")
    xx, yy, zz = np.diag(tensor)
    K = -tensor
    np.fill_diagonal(K, [0.5 * (yy + zz - xx), 0.5 * (xx + zz - yy), 0.5 * (xx + yy - zz)])
    require_semidefinite("second moment ½ tr(I) 1 − I of the inertia", K, (np.trace(tensor)))
    return K


def _require_three(name: str, n: int, remedy: str) -> None:
    if n != 3:
        raise ParameterError(name, f"{n} dimensions, where 3 have an inertia tensor: {remedy}")
