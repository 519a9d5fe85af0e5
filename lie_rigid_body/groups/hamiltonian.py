"""Hamiltonian mechanics of free motion on a matrix Lie group: Hamilton's equations and the Lie–Poisson bracket.

The momenta are elements of the dual of the Lie algebra. Its Lie–Poisson bracket has here the sign that belongs to body
components (J. E. Marsden, T. S. Ratiu, *Introduction to Mechanics and Symmetry*, on Lie–Poisson reduction). Equation
numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.short_dataclass import short_dataclass, short_repr
from lie_rigid_body.groups.arguments import MadeAnew, of_kind, within_doubles
from lie_rigid_body.groups.coadjoint import ad_star, coadjoint_directions
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import require_metric
from lie_rigid_body.mechanics.array_input import symmetrised


class HamiltonsEquations(NamedTuple):
    """The two sides of Hamilton's equations, eqs. (35a) and (35b).

    Attributes
    ----------
    rate : ndarray, shape (..., d)
        ω = ∂H/∂p of Ȧ = A ωᵃTᵃ, 1/s.
    momentum_rate : ndarray, shape (..., d)
        ṗ = {p, H}, kg m²/s².
    """

    rate: Array
    momentum_rate: Array

    def __repr__(self) -> str:
        return short_repr(self)


@short_dataclass(eq=False)
class Hamiltonian(MadeAnew):
    """The Hamiltonian H = ½ (M⁻¹)ᵃᵇpᵃpᵇ on a matrix Lie group, eq. (34).

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    inverse_metric : array_like, shape (d, d)
        M⁻¹, symmetric positive definite, 1/(kg m²). From a Lagrangian, take `legendre_transform`.

    Attributes
    ----------
    group : MatrixLieGroup
    inverse_metric : ndarray, shape (d, d)
        Read only.

    Raises
    ------
    InputError
        If M⁻¹ is of the wrong size, not finite, not symmetric or not positive definite.
    """

    group: MatrixLieGroup
    inverse_metric: Array

    def __post_init__(self) -> None:
        dimension = of_kind(self.group, MatrixLieGroup).dimension
        object.__setattr__(self, "inverse_metric", require_metric(self.inverse_metric, dimension, "inverse_metric"))
        self.inverse_metric.setflags(write=False)

    @within_doubles
    def value(self, momentum: ArrayLike) -> Array:
        """The Hamiltonian H(p), eq. (34).

        Parameters
        ----------
        momentum : array_like, shape (..., d)
            p in the body frame, kg m²/s.

        Returns
        -------
        ndarray, shape (...)
            J.
        """
        p = self.group.as_components(momentum, "momenta")
        return np.asarray(0.5 * np.sum(p * self.rates(p), axis=-1))

    @within_doubles
    def rates(self, momentum: ArrayLike) -> Array:
        """The rates ω = ∂H/∂p = M⁻¹p, eq. (35a).

        Parameters
        ----------
        momentum : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            1/s.
        """
        return self.group.as_components(momentum, "momenta") @ self.inverse_metric

    def equations(self, momentum: ArrayLike) -> HamiltonsEquations:
        """Hamilton's equations, ω = ∂H/∂p and ṗᵃ = f[c,a,d] ωᶜ p_d: eqs. (35a) and (35b).

        Parameters
        ----------
        momentum : array_like, shape (..., d)

        Returns
        -------
        HamiltonsEquations
        """
        p = self.group.as_components(momentum, "momenta")
        rate = self.rates(p)
        return HamiltonsEquations(rate, ad_star(self.group, rate, p))


def legendre_transform(lagrangian: Lagrangian) -> Hamiltonian:
    """The Hamiltonian H(p) = pᵃωᵃ − L(ω) at p = ∂L/∂ω, eq. (33).

    Parameters
    ----------
    lagrangian : Lagrangian

    Returns
    -------
    Hamiltonian
    """
    return Hamiltonian(of_kind(lagrangian, Lagrangian).group, lagrangian.inverse_metric)


def inverse_legendre_transform(hamiltonian: Hamiltonian) -> Lagrangian:
    """The Lagrangian L(ω) = pᵃωᵃ − H(p) at ω = ∂H/∂p; inverse of `legendre_transform`.

    Parameters
    ----------
    hamiltonian : Hamiltonian

    Returns
    -------
    Lagrangian
    """
    return Lagrangian(of_kind(hamiltonian, Hamiltonian).group, symmetrised(np.linalg.inv(hamiltonian.inverse_metric)))


@within_doubles
def poisson_tensor(group: MatrixLieGroup, momentum: ArrayLike) -> Array:
    """The Poisson tensor: the brackets {pᵃ, pᵇ} = −f[a,b,c] p_c of the momenta.

    Parameters
    ----------
    group : MatrixLieGroup
    momentum : array_like, shape (..., d)

    Returns
    -------
    ndarray, shape (..., d, d)
        Antisymmetric; its rank is the dimension of the coadjoint orbit of p.
    """
    return coadjoint_directions(group, of_kind(group, MatrixLieGroup).as_components(momentum, "momenta"))


@within_doubles
def lie_poisson_bracket(
    group: MatrixLieGroup, momentum: ArrayLike, first_gradient: ArrayLike, second_gradient: ArrayLike
) -> Array:
    """The Lie–Poisson bracket {F, G}(p) = −p_c f[a,b,c] (∂F/∂pᵃ)(∂G/∂pᵇ), with which Ḟ = {F, H}.

    Parameters
    ----------
    group : MatrixLieGroup
    momentum : array_like, shape (..., d)
    first_gradient, second_gradient : array_like, shape (..., d)
        ∂F/∂p and ∂G/∂p at the momentum; leading axes broadcast.

    Returns
    -------
    ndarray, shape (...)
    """
    p = of_kind(group, MatrixLieGroup).as_components(momentum, "momenta")
    first, second = (group.as_components(v, "gradients") for v in (first_gradient, second_gradient))
    return np.asarray(np.sum(first * ad_star(group, second, p), axis=-1))
