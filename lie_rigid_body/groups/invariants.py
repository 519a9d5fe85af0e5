"""What every free motion on a group conserves whatever its body: the spatial momentum, and its Casimirs.

The energy is `Lagrangian.value` or `Hamiltonian.value`; what a body adds by its shape is in `symmetries` and `manakov`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.antihermitian import antihermitian_matrices, antisymmetric_matrices
from lie_rigid_body.groups.coadjoint import invariant_metric
from lie_rigid_body.groups.components import require_components
from lie_rigid_body.groups.pfaffian import pfaffian

if TYPE_CHECKING:
    from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

Array = NDArray[np.float64]


def spatial_momentum(group: MatrixLieGroup, element: ArrayLike, momentum: ArrayLike) -> Array:
    """The momentum in the space frame, Ad(A)⁻ᵀ p: conserved component by component (Noether).

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d, with n × n matrices.
    element : array_like, shape (..., n, n)
        A, which takes the body frame to the space frame.
    momentum : array_like, shape (..., d)
        p in the body frame, kg m²/s.

    Returns
    -------
    ndarray, shape (..., d)
        kg m²/s.

    Raises
    ------
    InputError
        If A is off the group.
    """
    p = require_components(group, momentum, "momenta")
    to_body = group.Ad(group.inverse(element))
    return np.asarray((p[..., np.newaxis, :] @ to_body)[..., 0, :])


def momentum_matrix(group: MatrixLieGroup, momentum: ArrayLike) -> NDArray[Any]:
    """The momentum as a matrix P of the algebra, with which Euler's equations are Ṗ = [P, Ω], Ω = A⁻¹Ȧ.

    P is hat(g⁻¹p), the matrix that pairs with the algebra through the trace metric g as p does with components: pᵃTᵃ on
    SO(n) and SU(n), and KΩ + ΩK for a body with second moment K.

    Parameters
    ----------
    group : MatrixLieGroup
        Compact, so that its trace metric is invariant.
    momentum : array_like, shape (..., d)

    Returns
    -------
    ndarray, shape (..., n, n)
        kg m²/s.

    Raises
    ------
    InputError
        If the trace metric is not invariant, as on groups that are not compact.
    """
    p = require_components(group, momentum, "momenta")
    return np.asarray(group.hat(p @ np.linalg.inv(invariant_metric(group))))


def rotation_casimirs(momentum: ArrayLike) -> Array:
    """The independent Casimirs of SO(n): tr(Pᵏ) for every even k < n, and for even n the Pfaffian of P.

    tr(Pⁿ) for even n would add nothing, since Pf² = det P; odd powers have no trace. There are ⌊n/2⌋, the rank.

    Parameters
    ----------
    momentum : array_like, shape (..., n, n)
        P, antisymmetric, kg m²/s; see `momentum_matrix`.

    Returns
    -------
    ndarray, shape (..., n // 2)
        By ascending degree in P; the Pfaffian comes last.

    Raises
    ------
    InputError
        If P is not square, real, finite and antisymmetric.
    """
    p = _nonempty(antisymmetric_matrices("P", momentum))
    n = p.shape[-1]
    traces = _power_traces(p)[..., 1 : n - 1 : 2]
    return traces if n % 2 else np.concatenate([traces, pfaffian(p)[..., np.newaxis]], axis=-1)


def unitary_casimirs(momentum: ArrayLike) -> Array:
    """The independent Casimirs of SU(n): tr((−iP)ᵏ) for 2 ≤ k ≤ n, which is real; for even k it is ± tr(Pᵏ).

    There are n − 1, the rank.

    Parameters
    ----------
    momentum : array_like, shape (..., n, n)
        P, anti-Hermitian, kg m²/s; see `momentum_matrix`.

    Returns
    -------
    ndarray, shape (..., n - 1)
        By ascending degree in P.

    Raises
    ------
    InputError
        If P is not square, finite and anti-Hermitian.
    """
    return np.asarray(_power_traces(-1j * _nonempty(antihermitian_matrices("P", momentum)))[..., 1:].real)


def _power_traces(p: NDArray[Any]) -> NDArray[Any]:
    """The traces of p, p², …, pⁿ on a new last axis."""
    powers = [p]
    while len(powers) < p.shape[-1]:
        powers.append(powers[-1] @ p)
    return np.stack([np.trace(power, axis1=-2, axis2=-1) for power in powers], axis=-1)


def _nonempty(p: NDArray[Any]) -> NDArray[Any]:
    if p.shape[-1] == 0:
        raise InputError(f"Casimirs need P of shape (..., n, n), given {p.shape}: give momentum_matrix(group, p)")
    return p
