"""The coadjoint action of a Lie algebra on momenta, and the invariant metric that identifies rates with momenta.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

INVARIANCE_TOLERANCE: Final = 1e-9
"""Largest violation of invariance still taken for round-off, relative to the structure constants."""


def coadjoint_action(group: MatrixLieGroup, rate: Array, momentum: Array) -> Array:
    """The coadjoint action ad*_ω p, with components ωᶜ f[c,a,d] p_d: ⟨ad*_ω p, η⟩ = ⟨p, [ω, η]⟩ for every η.

    On SO(3) it is p × ω. Free motion obeys ṗ = ad*_ω p, which is eq. (21), on SO(3) Euler's equations (Marsden & Ratiu,
    *Introduction to Mechanics and Symmetry*, on the Euler–Poincaré equations, left-invariant case).

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    rate : ndarray, shape (..., d)
        ω, 1/s, or any algebra element.
    momentum : ndarray, shape (..., d)
        p, kg m²/s; leading axes broadcast with those of the rate.

    Returns
    -------
    ndarray, shape (..., d)
    """
    turning = np.tensordot(rate, group.structure_constants, axes=1)
    return np.asarray((turning @ momentum[..., np.newaxis])[..., 0])


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


def invariant_metric(group: MatrixLieGroup) -> Array:
    """The trace metric g of a compact group, which is invariant: ω ↦ gω makes rates momenta, with ad*_ω gω = 0.

    Parameters
    ----------
    group : MatrixLieGroup

    Returns
    -------
    ndarray, shape (d, d)

    Raises
    ------
    InputError
        If g is not invariant, as on groups that are not compact: f[a,b,c] g[c,d] is not antisymmetric in b and d.
    """
    lowered = group.structure_constants @ group.trace_metric
    scale = float(np.abs(lowered).max(initial=0.0))
    off = float(np.abs(lowered + np.swapaxes(lowered, 1, 2)).max(initial=0.0))
    if off > INVARIANCE_TOLERANCE * scale:
        raise InputError(
            f"the trace metric of {group.name} is not invariant: it changes by {off / scale:.3g} of the structure "
            f"constants, the limit is {INVARIANCE_TOLERANCE:g}: give a group of orthogonal or unitary matrices"
        )
    return group.trace_metric
