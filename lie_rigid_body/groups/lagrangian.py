"""Lagrangian mechanics of free motion on a matrix Lie group with a left-invariant kinetic energy.

The motion is A(t) with Ȧ = A ωᵃTᵃ, and its Lagrangian L = ½ Mᵃᵇωᵃωᵇ; on SO(n) it is that of a free rigid body.
Components are those of the body frame, and [Tᵃ, Tᵇ] = f[a,b,c] Tᶜ. Equation numbers are those of A. Lucas, arXiv
1111.1275, from which this module departs in two ways:

- The paper takes the rate in the space frame, with M at the present centre A₀ of the chart exp(αᵃTᵃ)A₀. Here both are
  taken in the body frame, in which M is constant. At the centre of the chart A₀exp(αᵃTᵃ) every formula has the same
  form; `metric_at` is the paper's M.
- The paper's equations hold for totally antisymmetric structure constants. Here the indices are placed so that the
  equations hold on any group.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.arrays import Array
from lie_rigid_body.groups.coadjoint import coadjoint_action
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import require_metric, symmetrised
from lie_rigid_body.wording import call_repr


class Lagrangian:
    """The Lagrangian L = ½ Mᵃᵇωᵃωᵇ on a matrix Lie group, eq. (14).

    Parameters
    ----------
    group : MatrixLieGroup
        Of dimension d.
    metric : array_like, shape (d, d)
        M, symmetric positive definite, kg m²; see `require_metric`.

    Attributes
    ----------
    group : MatrixLieGroup
    metric, inverse_metric : ndarray, shape (d, d)
        M and M⁻¹. Read only.

    Raises
    ------
    InputError
        If M is of the wrong size, not finite, not symmetric or not positive definite.
    """

    __slots__ = ("group", "inverse_metric", "metric")

    def __init__(self, group: MatrixLieGroup, metric: ArrayLike) -> None:
        self.group = group
        self.metric: Array = require_metric(metric, group.dimension)
        self.inverse_metric: Array = symmetrised(np.linalg.inv(self.metric))
        for array in (self.metric, self.inverse_metric):
            array.setflags(write=False)

    def __reduce__(self) -> tuple[type[Lagrangian], tuple[MatrixLieGroup, Array]]:
        return Lagrangian, (self.group, self.metric)

    def __repr__(self) -> str:
        return call_repr(self, {"group": self.group, "metric": self.metric})

    def value(self, rate: ArrayLike) -> Array:
        """L(ω), eq. (14), which for free motion is the kinetic energy.

        Parameters
        ----------
        rate : array_like, shape (..., d)
            ω in the body frame, 1/s.

        Returns
        -------
        ndarray, shape (...)
            J.
        """
        w = self.group.as_components(rate, "rates")
        return np.asarray(0.5 * np.sum(w * self.momenta(w), axis=-1))

    def momenta(self, rate: ArrayLike) -> Array:
        """The momenta pᵃ = ∂L/∂ωᵃ = Mᵃᵇωᵇ, eq. (19); at the centre of the chart they are ∂L/∂α̇ᵃ.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            kg m²/s.
        """
        return np.asarray(self.group.as_components(rate, "rates") @ self.metric)

    def rates(self, momentum: ArrayLike) -> Array:
        """The rates ω = M⁻¹p of given momenta; inverse of `momenta`.

        Parameters
        ----------
        momentum : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
        """
        return np.asarray(self.group.as_components(momentum, "momenta") @ self.inverse_metric)

    def chart_force(self, rate: ArrayLike) -> Array:
        """∂L/∂αᵃ = ½ f[c,a,d] ωᶜ p_d at the centre α = 0 of the moving chart, where α̇ = ω.

        The derivative is taken at constant α̇, and ω = α̇ − ½[α, α̇] + … gives the factor ½. The other half of ṗ is in the
        time derivative of ∂L/∂α̇. Eq. (18) has no ½: it is the derivative at constant rate in the space frame.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            J.
        """
        return 0.5 * self.momentum_rate(rate)

    def momentum_rate(self, rate: ArrayLike) -> Array:
        """The rate of change of the momenta by the equations of motion, ṗᵃ = f[c,a,d] ωᶜ p_d: eq. (21).

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            kg m²/s².
        """
        w = self.group.as_components(rate, "rates")
        return coadjoint_action(self.group, w, self.momenta(w))

    def acceleration(self, rate: ArrayLike) -> Array:
        """The rate of change ω̇ by the equations of motion, Mᵃᵇω̇ᵇ = f[c,a,d] Mᵈᵇ ωᵇωᶜ.

        For totally antisymmetric structure constants this is eq. (21), Mᵃᵇω̇ᵇ = fᵃᵈᶜMᵈᵇωᵇωᶜ, and on SO(3) Euler's
        equation Mω̇ = Mω × ω, eq. (29).

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            1/s².
        """
        return np.asarray(self.momentum_rate(rate) @ self.inverse_metric)


def metric_at(lagrangian: Lagrangian, element: NDArray[Any]) -> Array:
    """The metric in the space frame at a group element, Ad(A)⁻ᵀ M Ad(A)⁻¹; of a body it is eq. (13) with A₀ = A.

    Parameters
    ----------
    lagrangian : Lagrangian
    element : ndarray, shape (..., n, n)
        A.

    Returns
    -------
    ndarray, shape (..., d, d)
        Exactly symmetric, kg m².

    Raises
    ------
    InputError
        If A is off the group.
    """
    group = lagrangian.group
    to_body = group.Ad(group.inverse(element))
    return symmetrised(np.swapaxes(to_body, -1, -2) @ lagrangian.metric @ to_body)
