"""The double cover SU(2) → SO(3), and unit quaternions as the elements of SU(2): eq. (31) of Lucas, arXiv 1111.1275.

Conventions
-----------
An element of SU(2) and a unit quaternion, scalar last, are the same four numbers:

    U = w·1 − i(x σ¹ + y σ² + z σ³) = [[w − iz, −y − ix], [y − ix, w + iz]],

products going to products. With the generators −iσᵃ/2 of `SU(2)`, U = exp(−i vᵃσᵃ/2) covers the rotation by the
vector v, so that coordinates, angles and structure constants are those of SO(3). U and −U cover the same rotation.

All functions are batched over leading axes.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups.classical_groups import SO, SU
from lie_rigid_body.groups.exponential import Complex
from lie_rigid_body.groups.matrix_lie_group import ELEMENT_TOLERANCE
from lie_rigid_body.lie import quaternion

_SU2: Final = SU(2)
_SO3: Final = SO(3)
_BASIS: Final = np.concatenate([2.0 * _SU2.generators, _SU2.identity[np.newaxis]])
"""Elements of SU(2) of the quaternions i, j, k and 1."""

STEP_LIMIT: Final = 0.5 * np.pi
"""Largest rotation angle, rad, between neighbours of a path that `lift` accepts."""


def from_quaternion(q: ArrayLike) -> Complex:
    """The element of SU(2) of a unit quaternion.

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Unit quaternions, x, y, z, w.

    Returns
    -------
    ndarray, shape (..., 2, 2), complex
    """
    q = real_array("quaternions", q, (..., 4), empty=True)
    worst = np.max(np.abs(quaternion.norm(q) - 1.0), initial=0.0)
    if not worst <= ELEMENT_TOLERANCE:
        raise InputError(f"a quaternion's norm is {worst:.3g} off 1 (limit {ELEMENT_TOLERANCE:g}): normalize it")
    return np.tensordot(q, _BASIS, axes=1)


def to_quaternion(U: ArrayLike) -> Array:
    """The unit quaternion of an element of SU(2), with its sign; inverse of `from_quaternion`.

    Parameters
    ----------
    U : array_like, shape (..., 2, 2), complex

    Returns
    -------
    ndarray, shape (..., 4)
        x, y, z, w.
    """
    return np.asarray(0.5 * np.real(np.einsum("aij,...ij->...a", _BASIS.conj(), _SU2.as_elements(U))))


def rotation(U: ArrayLike) -> Array:
    """The rotation that an element of SU(2), eq. (31), covers: R with U σʲ U† = Rⁱʲσⁱ.

    Parameters
    ----------
    U : array_like, shape (..., 2, 2), complex

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    return quaternion.to_matrix(to_quaternion(U))


def preimages(R: ArrayLike) -> tuple[Complex, Complex]:
    """The two elements of SU(2), U and −U, that cover a rotation.

    Parameters
    ----------
    R : array_like, shape (..., 3, 3)

    Returns
    -------
    tuple of two ndarrays, shape (..., 2, 2), complex
        First the one nearer to 1; for a half turn, where both are equally near, either may come first.
    """
    q = quaternion.from_matrix(_SO3.as_elements(R))
    U = from_quaternion(np.where(q[..., 3:] < 0.0, -q, q))
    return U, -U


def lift(R: ArrayLike) -> Complex:
    """The lift of a path of rotations to SU(2), which starts from the preimage nearer to 1.

    A path around a full turn ends at the negative of its beginning, and closes after two turns.

    Parameters
    ----------
    R : array_like, shape (N, 3, 3)
        Rotations in the order of the path, neighbours at most π/2 apart.

    Returns
    -------
    ndarray, shape (N, 2, 2), complex

    Raises
    ------
    InputError
        If the path has no point, or neighbours are so far apart that the path between them is ambiguous.
    """
    R = _SO3.as_matrices(R)
    if R.ndim != 3 or len(R) == 0:
        raise InputError(f"a path needs shape (N, 3, 3) with N ≥ 1, given {R.shape}: stack its rotations")
    q = to_quaternion(preimages(R)[0])
    aligned = np.einsum("ki,ki->k", q[1:], q[:-1])
    steps = 2.0 * np.arccos(np.minimum(np.abs(aligned), 1.0))
    worst = np.max(steps, initial=0.0)
    if worst > STEP_LIMIT + ELEMENT_TOLERANCE:
        k = np.argmax(steps)
        raise InputError(
            f"the path turns by {worst:.3g} rad from point {k} to {k + 1} (limit π/2): sample it more finely"
        )
    signs = np.cumprod(np.concatenate([[1.0], np.where(aligned < 0.0, -1.0, 1.0)]))
    return from_quaternion(q * signs[:, np.newaxis])
