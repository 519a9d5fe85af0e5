"""Momenta that symmetries conserve (Noether): in the space frame all, in the body frame those of a symmetric body.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import require_metric

_TOLERANCE: Final = 1e-12
_TIE: Final = 1e-8
"""Difference of squared distances to the span below which two generators count as equally near."""


@within_doubles
def spatial_momentum(group: MatrixLieGroup, element: ArrayLike, momentum: ArrayLike) -> Array:
    """The momentum in the space frame, Ad(A)⁻ᵀ p, of which every component is conserved.

    The symmetry is that of L under left translations A ↦ BA with a constant B, as B = exp(αᵃTᵃ): shifts of the
    paper's chart. Eq. (22) is not needed for it, which is about components in the body.

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
    p = of_kind(group, MatrixLieGroup).as_components(momentum, "momenta")
    to_body = group.Ad(group.inverse(element))
    return (p[..., np.newaxis, :] @ to_body)[..., 0, :]


def conserved_momenta(group: MatrixLieGroup, metric: ArrayLike, *, tolerance: float = _TOLERANCE) -> Array:
    """The directions ξ of the algebra whose momentum ξᵃpᵃ in the body frame is constant in every motion.

    They are the solutions of ξᵃ (f[c,a,d] Mᵈᵇ + f[b,a,d] Mᵈᶜ) = 0 for all b, c, and generate the subgroup of Ad that
    leaves M unchanged. On SO(3) it is the axis of a symmetric top, eq. (30), every direction for M ∝ 1, none for an
    asymmetric top. Eq. (22) is the condition 0 = fᵃᵈᶜMᵈᵇ + fᵃᵈᵇMᵈᶜ for one generator Tᵃ and totally antisymmetric f.
    Here ξ is any direction, and the indices are placed so that the condition holds on any group.

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    metric : array_like, shape (d, d)
        M, symmetric positive definite, kg m².
    tolerance : float, optional
        Asymmetry of M, relative to its norm, that counts as round-off.

    Returns
    -------
    ndarray, shape (k, d)
        Orthonormal rows in components along the generators, a function of their span by `canonical_basis`.

    Raises
    ------
    InputError
        If M is not symmetric positive definite of size d.
    """
    m = require_metric(metric, of_kind(group, MatrixLieGroup).dimension)
    f = group.structure_constants
    # generators scaled to unit inertia: in a badly scaled basis small entries of the condition would pass for round-off
    size = np.sqrt(np.diag(m))
    m = m / np.outer(size, size)
    f = f * size / np.multiply.outer(size, size)[:, :, None]
    # entry [c, a, b] of f[c,a,d] Mᵈᵇ is the coefficient of ωᶜωᵇ in d/dt pᵃ, symmetrised in c and b
    change = f @ m
    condition = change + np.swapaxes(change, 0, 2)
    rows = np.swapaxes(condition, 1, 2).reshape(-1, group.dimension)
    _, sizes, directions = np.linalg.svd(rows, full_matrices=False)
    scale = (np.linalg.norm(m, 2)) * (np.abs(f).max(initial=0.0))
    conserved = directions[sizes <= real_array("tolerance", tolerance, ()) * scale] / size
    return canonical_basis(np.linalg.qr(conserved.T)[0].T)


def canonical_basis(orthonormal: Array) -> Array:
    """The orthonormal basis of a span that is a function of the span alone, by Gram–Schmidt on the unit vectors.

    Each row is the normalised projection of a unit vector onto what the rows before it leave of the span. The nearest
    unit vector is taken, and of equally near ones the first.

    Parameters
    ----------
    orthonormal : ndarray, shape (k, d)
        Orthonormal rows.

    Returns
    -------
    ndarray, shape (k, d)
    """
    rest = orthonormal
    basis = np.empty_like(orthonormal)
    for row in range(len(basis)):
        nearness = np.sum(rest * rest, axis=0)
        nearest = np.argmax(nearness >= nearness.max() - _TIE)
        basis[row] = rest[:, nearest] @ rest / np.sqrt(nearness[nearest])
        rest = rest - np.outer(rest @ basis[row], basis[row])
    return basis
