"""The Levi-Civita connection of a left-invariant metric: geodesics from structure constants and the metric.

Free motion is geodesic motion for every metric M: the remark after eq. (32) of A. Lucas, arXiv 1111.1275, has the case
M ∝ 1 and leaves open how Christoffel symbols and structure constants belong together.

References
----------
J. Milnor, "Curvatures of left invariant metrics on Lie groups", Advances in Mathematics 21 (1976) 293, section 5.
"""

from __future__ import annotations

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.groups.lagrangian import Lagrangian


def connection_coefficients(lagrangian: Lagrangian) -> Array:
    """The connection of the metric M in the frame of the left-invariant fields Tᵃ: ∇_Tᵃ Tᵇ = Γ[a,b,c] Tᶜ.

    By Koszul's formula 2⟨∇_X Y, Z⟩ = ⟨[X, Y], Z⟩ − ⟨[Y, Z], X⟩ + ⟨[Z, X], Y⟩, with ⟨X, Y⟩ = MᵃᵇXᵃYᵇ. Geodesics have the
    rates ω̇ᶜ = −Γ[a,b,c] ωᵃωᵇ, which is eq. (21); it is what the text after eq. (32) leaves open. For a bi-invariant
    metric Γ[a,b,c] = ½ f[a,b,c], and ω is constant.

    Parameters
    ----------
    lagrangian : Lagrangian
        The group, of dimension d, and M.

    Returns
    -------
    ndarray, shape (d, d, d)
    """
    bracket = lagrangian.group.structure_constants @ lagrangian.metric  # ⟨[Tᵃ, Tᵇ], Tᶜ⟩
    lowered = 0.5 * (bracket - np.einsum("bca->abc", bracket) + np.einsum("cab->abc", bracket))
    return np.asarray(lowered @ lagrangian.inverse_metric)


def christoffel_symbols(lagrangian: Lagrangian) -> Array:
    """The Christoffel symbols Γᶜ_ab at the centre of the chart A₀ exp(βᵃTᵃ), as [a, b, c]: symmetric in a and b.

    There β̈ᶜ = −Γᶜ_ab β̇ᵃβ̇ᵇ, as the text after eq. (32) asks for. They are the part of `connection_coefficients` that
    is symmetric in the first two indices, since ω̇ = β̈ at the centre. They vanish for a bi-invariant metric, whose
    geodesics are straight in this chart.

    Parameters
    ----------
    lagrangian : Lagrangian

    Returns
    -------
    ndarray, shape (d, d, d)
    """
    connection = connection_coefficients(lagrangian)
    return np.asarray(0.5 * (connection + np.swapaxes(connection, 0, 1)))
