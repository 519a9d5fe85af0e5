"""The coadjoint action of a Lie algebra on momenta, and the invariant form that identifies rates with momenta.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

INVARIANCE_TOLERANCE: Final = 1e-9
"""Largest violation of invariance still taken for round-off, relative to the structure constants."""

REGULARITY_LIMIT: Final = 1e-9
"""Smallest singular value of a form, relative to the largest, from which on it counts as regular."""


@within_doubles
def ad_star(group: MatrixLieGroup, rate: ArrayLike, momentum: ArrayLike) -> Array:
    """The coadjoint action ad*_ω p, with components ωᶜ f[c,a,d] p_d: ⟨ad*_ω p, η⟩ = ⟨p, [ω, η]⟩ for every η.

    On SO(3) it is p × ω. Free motion obeys ṗ = ad*_ω p, which is eq. (21) and, as ṗ of body components, eq. (35b); on
    SO(3) Euler's equations (Marsden & Ratiu, *Introduction to Mechanics and Symmetry*, on the Euler–Poincaré equations,
    left-invariant case).

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    rate : array_like, shape (..., d)
        ω, 1/s, or any algebra element.
    momentum : array_like, shape (..., d)
        p, kg m²/s; leading axes broadcast with those of the rate.

    Returns
    -------
    ndarray, shape (..., d)
    """
    w = of_kind(group, MatrixLieGroup).as_components(rate, "rates")
    p = group.as_components(momentum, "momenta")
    turning = np.tensordot(w, group.structure_constants, axes=1)
    return (turning @ p[..., np.newaxis])[..., 0]


def coadjoint_directions(group: MatrixLieGroup, momentum: Array) -> Array:
    """The matrix with columns ad*_{Tᶜ} p, which span the tangent space of the coadjoint orbit of p.

    Parameters
    ----------
    group : MatrixLieGroup
    momentum : ndarray, shape (..., d)

    Returns
    -------
    ndarray, shape (..., d, d)
    """
    return np.asarray(np.einsum("cad,...d->...ac", group.structure_constants, momentum))


def killing_form(group: MatrixLieGroup) -> Array:
    """The Killing form tr(ad Tᵃ ad Tᵇ) = f[a,c,d] f[b,d,c], which is invariant on every group.

    It is regular exactly on semisimple groups (Cartan). On compact groups it is negative semidefinite, and 0 only along
    the centre; so it is wherever structure constants are totally antisymmetric in some basis, as the text after eq.
    (42) wants of every group.

    Parameters
    ----------
    group : MatrixLieGroup

    Returns
    -------
    ndarray, shape (d, d)
    """
    f = of_kind(group, MatrixLieGroup).structure_constants
    return np.asarray(np.einsum("acd,bdc->ab", f, f))


def invariant_form(group: MatrixLieGroup) -> Array:
    """An invariant quadratic form g of the algebra: ω ↦ gω makes rates momenta, with ad*_ω gω = 0.

    It is the trace metric where that is invariant, as on groups of orthogonal or unitary matrices. Else it is −Re
    tr(TᵃTᵇ), which is regular on every semisimple group (Cartan), and indefinite where that is not compact. The paper
    takes tr(TᵃTᵇ) ∝ δᵃᵇ before eq. (23), which can be had on compact groups only.

    Parameters
    ----------
    group : MatrixLieGroup

    Returns
    -------
    ndarray, shape (d, d)

    Raises
    ------
    InputError
        If neither will do, as on groups of rigid motions.
    """
    if _is_invariant(of_kind(group, MatrixLieGroup), group.trace_metric):
        return group.trace_metric
    flat = group.generators.reshape(group.dimension, -1)
    turned = np.swapaxes(group.generators, 1, 2).reshape(group.dimension, -1)
    form = -np.real(flat @ turned.T)
    if not _is_regular(form, np.sqrt(np.diag(group.trace_metric))):
        raise InputError(
            f"{group.name} has no regular invariant form, as tr(TᵃTᵇ) is singular: give a semisimple or compact group, "
            "or take quadratic_casimirs or steady_rotation"
        )
    return form


def _is_invariant(group: MatrixLieGroup, form: Array) -> bool:
    """Whether f[a,b,c] g[c,d] is antisymmetric in b and d."""
    lowered = group.structure_constants @ form
    off = float(np.abs(lowered + np.swapaxes(lowered, 1, 2)).max(initial=0.0))
    return off <= INVARIANCE_TOLERANCE * float(np.abs(lowered).max(initial=0.0))


def _is_regular(form: Array, sizes: Array) -> bool:
    """Whether a form is regular, for generators scaled to unit size."""
    values = np.linalg.svd(form / np.outer(sizes, sizes), compute_uv=False)
    return bool(values[-1] > REGULARITY_LIMIT * values[0])
