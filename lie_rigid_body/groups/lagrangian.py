"""Lagrangian mechanics of free motion on a matrix Lie group with a left-invariant kinetic energy.

The motion is A(t) with Ȧ = A ωᵃTᵃ, and its Lagrangian L = ½ Mᵃᵇωᵃωᵇ; on SO(n) it is that of a free rigid body.
Components are those of the body frame, and [Tᵃ, Tᵇ] = f[a,b,c] Tᶜ. Equation numbers are those of A. Lucas, arXiv
1111.1275, from which this module departs in three ways:

- The paper takes the rate in the space frame, with M at the present centre A₀ of the chart exp(αᵃTᵃ)A₀. Here both are
  taken in the body frame, in which M is constant. At the centre of the chart A₀exp(αᵃTᵃ) every formula has the same
  form; `metric_at` is the paper's M.
- The paper's equations hold for totally antisymmetric structure constants. Here the indices are placed so that the
  equations hold on any group.
- Derivatives by coordinates of the chart are taken at constant velocity of these coordinates, which makes them half of
  the printed ones; see `Lagrangian.chart_force`.

Free motion is geodesic motion for every metric M: the remark after eq. (32) has the case M ∝ 1 and leaves open how
Christoffel symbols and structure constants belong together.

References
----------
J. Milnor, "Curvatures of left invariant metrics on Lie groups", Advances in Mathematics 21 (1976) 293, section 5, for
the Levi-Civita connection of a left-invariant metric.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.groups.arguments import MadeAnew, of_kind, within_doubles
from lie_rigid_body.groups.coadjoint import ad_star
from lie_rigid_body.groups.exponential import Matrix
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import require_metric
from lie_rigid_body.mechanics.array_input import positive, symmetrised


@short_dataclass(eq=False)
class Lagrangian(MadeAnew):
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
    metric : ndarray, shape (d, d)
        M. Read only.

    Raises
    ------
    InputError
        If M is of the wrong size, not finite, not symmetric or not positive definite.
    """

    group: MatrixLieGroup
    metric: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "metric", require_metric(self.metric, of_kind(self.group, MatrixLieGroup).dimension))
        self.metric.setflags(write=False)

    @cached_property
    def inverse_metric(self) -> Array:
        """M⁻¹, shape (d, d), read only."""
        inverse = symmetrised(np.linalg.inv(self.metric))
        inverse.setflags(write=False)
        return inverse

    @within_doubles
    def value(self, rate: ArrayLike) -> Array:
        """The Lagrangian L(ω), eq. (14), which for free motion is the kinetic energy, of a body eqs. (7) and (9).

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

    @within_doubles
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
        return self.group.as_components(rate, "rates") @ self.metric

    @within_doubles
    def rates(self, momentum: ArrayLike) -> Array:
        """The rates ω = M⁻¹p of given momenta; inverse of `momenta`.

        Parameters
        ----------
        momentum : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
        """
        return self.group.as_components(momentum, "momenta") @ self.inverse_metric

    @within_doubles
    def chart_force(self, rate: ArrayLike) -> Array:
        """The force ∂L/∂βᵃ = ½ f[c,a,d] ωᶜ p_d at the centre β = 0 of the chart A₀ exp(βᵃTᵃ), where β̇ = ω.

        The derivative is taken at constant β̇, as Lagrange's equations ask: ω = β̇ − ½[β, β̇] + … gives the factor ½.
        In the paper's chart exp(αᵃTᵃ)A₀ the rate of the space frame, α̇ + ½[α, α̇] + …, gives the opposite. There M
        depends on α and gives twice this. The sum is the same. Eqs. (16) and (18) have the derivative of M alone, at
        constant rate in the space frame, and so twice this. The other half of eq. (21) comes from the left-hand side of
        Lagrange's equations, d/dt ∂L/∂β̇ = Mβ̈ − `chart_force`, where eq. (20) has Mβ̈ alone: two errors cancel.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            J.
        """
        return 0.5 * self.momentum_rate(rate)

    @within_doubles
    def momentum_rate(self, rate: ArrayLike) -> Array:
        """The rate of change of the momenta by the equations of motion, ṗᵃ = f[c,a,d] ωᶜ p_d: eq. (21), with (20).

        Of body components eq. (20), ṗ = Mω̇, holds as printed. The right-hand side is that of eqs. (16) and (18), the
        derivative of L along the group at constant rate in the space frame.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            kg m²/s².
        """
        w = self.group.as_components(rate, "rates")
        return ad_star(self.group, w, self.momenta(w))

    @within_doubles
    def acceleration(self, rate: ArrayLike) -> Array:
        """The rate of change ω̇ by the equations of motion, Mᵃᵇω̇ᵇ = f[c,a,d] Mᵈᵇ ωᵇωᶜ: the geodesics of the metric M.

        For totally antisymmetric structure constants this is eq. (21), Mᵃᵇω̇ᵇ = fᵃᵈᶜMᵈᵇωᵇωᶜ, and on SO(3) Euler's
        equation Mω̇ = Mω × ω, eq. (29). At the centre of the chart it is α̈, as in eq. (20).

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            1/s².
        """
        return self.momentum_rate(rate) @ self.inverse_metric

    @within_doubles
    def action(self, path: ArrayLike, step: float) -> Array:
        """The action ∫ L dt of a path, eq. (36), by its chords Aₖ₊₁ = Aₖ exp(h ω): Σ h L(ω), with an error of order h².

        Parameters
        ----------
        path : array_like, shape (..., N, n, n)
            Elements at equal intervals, neighbours within reach of `MatrixLieGroup.log`.
        step : float
            h, s.

        Returns
        -------
        ndarray, shape (...)
            J s.

        Raises
        ------
        InputError
            If an element is off the group, neighbours are too far apart, or the step is not positive.
        """
        A = self.group.as_matrices(path)
        step = float(positive("step", step, "s"))
        if A.ndim < 3:
            raise ParameterError("path", f"shape {A.shape} is one element: stack two or more, at equal intervals")
        chords = self.group.log(self.group.inverse(A[..., :-1, :, :]) @ A[..., 1:, :, :])
        return np.asarray(self.value(chords / step).sum(axis=-1) * step)


@within_doubles
def metric_at(lagrangian: Lagrangian, element: Matrix) -> Array:
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
    group = of_kind(lagrangian, Lagrangian).group
    to_body = group.Ad(group.inverse(element))
    return symmetrised(np.swapaxes(to_body, -1, -2) @ lagrangian.metric @ to_body)


@within_doubles
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
    bracket = of_kind(lagrangian, Lagrangian).group.structure_constants @ lagrangian.metric  # ⟨[Tᵃ, Tᵇ], Tᶜ⟩
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
    return 0.5 * (connection + np.swapaxes(connection, 0, 1))
