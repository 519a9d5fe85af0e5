"""Symmetries of a body: the momenta in its own frame that its motion conserves, whatever the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.groups.lagrangian import require_metric

if TYPE_CHECKING:
    from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

Array = NDArray[np.float64]

_ROUND_OFF: Final = 1e-12
_TIE: Final = 1e-8


def conserved_momenta(group: MatrixLieGroup, metric: ArrayLike, *, tolerance: float = _ROUND_OFF) -> Array:
    """All directions ξ of the algebra whose momentum ξᵃpᵃ every motion conserves, in the body frame.

    They are the solutions of ξᵃ (f[c,a,d] Mᵈᵇ + f[b,a,d] Mᵈᶜ) = 0 for all b, c, and generate the subgroup of Ad that
    leaves M as it is: the axis of a symmetric top, every direction for M ∝ 1, none for an asymmetric top. (A. Lucas,
    arXiv 1111.1275, gives the condition 0 = fᵃᵈᶜMᵈᵇ + fᵃᵈᵇMᵈᶜ for one generator Tᵃ, in a basis that has it; we search
    all bases, and order the indices so that f need not be totally antisymmetric.)

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
        Orthonormal rows in components along the generators. The basis is a function of their span: each row is the
        normalised projection of one generator, after those of the rows before; the generator nearest to the span
        comes first, and of equally near ones the first.

    Raises
    ------
    InputError
        If M is not symmetric positive definite of size d.
    """
    m, f = require_metric(metric, group.dimension), group.structure_constants
    # generators scaled to unit inertia: otherwise a badly scaled basis would hide what is not conserved
    size = np.sqrt(np.diag(m))
    m, f = m / np.outer(size, size), f * size / np.multiply.outer(size, size)[:, :, None]
    # [c, a, b]: the part of d/dt pᵃ with ωᶜωᵇ, symmetrised in c and b
    change = f @ m
    condition = change + np.swapaxes(change, 0, 2)
    rows = np.swapaxes(condition, 1, 2).reshape(-1, group.dimension)
    _, sizes, directions = np.linalg.svd(rows, full_matrices=False)
    scale = float(np.linalg.norm(m, 2)) * float(np.abs(f).max(initial=0.0))
    conserved = directions[sizes <= tolerance * scale] / size
    return _canonical_basis(np.linalg.qr(conserved.T)[0].T)


def _canonical_basis(orthonormal: Array) -> Array:
    """The basis of the same span that depends on nothing but the span, by Gram–Schmidt on its projector."""
    projector = orthonormal.T @ orthonormal
    basis = np.empty_like(orthonormal)
    for row in range(len(basis)):
        nearness = np.diag(projector)
        nearest = int(np.argmax(nearness >= nearness.max() - _TIE))
        basis[row] = projector[nearest] / np.linalg.norm(projector[nearest])
        projector = projector - np.outer(basis[row], basis[row])
    return basis
