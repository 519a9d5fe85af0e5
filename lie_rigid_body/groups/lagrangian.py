"""Lagrangian mechanics of free motion on a matrix Lie group with a left-invariant kinetic energy.

The motion is A(t) with Ȧ = A ωᵃTᵃ, and L = ½ Mᵃᵇωᵃωᵇ (A. Lucas, arXiv 1111.1275); on SO(n) it is that of a free rigid
body. Components are those of the body frame, and [Tᵃ, Tᵇ] = f[a,b,c] Tᶜ.

Two departures from the paper. It reads the rate in the space frame, with M at the present centre A₀ of the chart
exp(αᵃTᵃ)A₀, where we use the body frame, in which M is constant: at the centre of the chart A₀exp(αᵃTᵃ) every formula
has the same form, and `metric_at` gives the paper's M. And it writes its equations for totally antisymmetric structure
constants, where ours put the indices so that they hold on any group.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.coadjoint import coadjoint_action
from lie_rigid_body.groups.components import require_components

if TYPE_CHECKING:
    from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

Array = NDArray[np.float64]

_ROUND_OFF: Final = 64.0 * float(np.finfo(np.float64).eps)


class Lagrangian:
    """The Lagrangian L = ½ Mᵃᵇωᵃωᵇ on a matrix Lie group.

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
        self.inverse_metric: Array = _symmetric(np.linalg.inv(self.metric))
        for array in (self.metric, self.inverse_metric):
            array.setflags(write=False)

    def __repr__(self) -> str:
        return f"Lagrangian({self.group.name}, {self.metric.tolist()})"

    def value(self, rate: ArrayLike) -> Array:
        """L(ω), which for free motion is the kinetic energy.

        Parameters
        ----------
        rate : array_like, shape (..., d)
            ω in the body frame, 1/s.

        Returns
        -------
        ndarray, shape (...)
            J.
        """
        w = require_components(self.group, rate, "rates")
        return np.asarray(0.5 * np.sum(w * self.momenta(w), axis=-1))

    def momenta(self, rate: ArrayLike) -> Array:
        """The momenta pᵃ = ∂L/∂ωᵃ = Mᵃᵇωᵇ; at the centre of the chart they are ∂L/∂α̇ᵃ.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            kg m²/s.
        """
        return np.asarray(require_components(self.group, rate, "rates") @ self.metric)

    def rates(self, momentum: ArrayLike) -> Array:
        """The rates ω = M⁻¹p of given momenta; inverse of `momenta`.

        Parameters
        ----------
        momentum : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
        """
        return np.asarray(require_components(self.group, momentum, "momenta") @ self.inverse_metric)

    def chart_force(self, rate: ArrayLike) -> Array:
        """∂L/∂αᵃ = ½ f[c,a,d] ωᶜ p_d at the centre α = 0 of the moving chart, where α̇ = ω.

        In the chart ω = α̇ − ½[α, α̇] + …, hence the ½; the other half of ṗ comes from the time derivative of ∂L/∂α̇.

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
        """The rate of change of the momenta that the equations of motion give, ṗᵃ = f[c,a,d] ωᶜ p_d.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            kg m²/s².
        """
        w = require_components(self.group, rate, "rates")
        return coadjoint_action(self.group, w, self.momenta(w))

    def acceleration(self, rate: ArrayLike) -> Array:
        """The rate of change ω̇ that the equations of motion give.

        Mᵃᵇω̇ᵇ = f[c,a,d] Mᵈᵇ ωᵇωᶜ, which for totally antisymmetric structure constants is the paper's
        Mᵃᵇω̇ᵇ = fᵃᵈᶜMᵈᵇωᵇωᶜ, and on SO(3) Euler's Mω̇ = Mω × ω.

        Parameters
        ----------
        rate : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d)
            1/s².
        """
        return np.asarray(self.momentum_rate(rate) @ self.inverse_metric)


def require_metric(metric: ArrayLike, dimension: int) -> Array:
    """A metric as float64, or a refusal.

    Parameters
    ----------
    metric : array_like, shape (d, d)
        M, symmetric to round-off (64 units in the last place of its largest entry), which is then averaged away, and
        positive definite.
    dimension : int
        d of the group.

    Returns
    -------
    ndarray, shape (d, d)
        A copy, exactly symmetric.

    Raises
    ------
    InputError
        If M is of the wrong size, not finite, not symmetric or not positive definite.
    """
    m = _square(metric, dimension)
    i, j = np.unravel_index(np.argmax(np.abs(m - m.T)), m.shape)
    if abs(m[i, j] - m[j, i]) > _ROUND_OFF * float(np.abs(m).max()):
        raise InputError(
            f"M is not symmetric: M[{i},{j}] = {m[i, j]:.17g} but M[{j},{i}] = {m[j, i]:.17g}: give (M + Mᵀ)/2"
        )
    m = _symmetric(m)
    eigenvalues = np.linalg.eigvalsh(m)
    if not eigenvalues[0] > _ROUND_OFF * eigenvalues[-1]:
        raise InputError(
            f"M is not positive definite beyond round-off: its smallest eigenvalue is {eigenvalues[0]:.6g} where the "
            f"largest is {eigenvalues[-1]:.6g}, and must be above {_ROUND_OFF:.2g} of that: give inertia about every "
            "axis, or scale the generators so that inertias are alike"
        )
    return m


def metric_at(lagrangian: Lagrangian, element: NDArray[Any]) -> Array:
    """The metric in the space frame at a group element, Ad(A)⁻ᵀ M Ad(A)⁻¹: the paper's M at the chart's centre A₀.

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
    return _symmetric(np.swapaxes(to_body, -1, -2) @ lagrangian.metric @ to_body)


def _square(metric: ArrayLike, d: int) -> Array:
    try:
        given = np.asarray(metric)
        m = np.array(given, dtype=np.float64) if not np.iscomplexobj(given) else None
    except (TypeError, ValueError):
        m = None
    if m is None:
        raise InputError(f"M is not an array of real numbers: give {d} rows of {d} numbers")
    if m.shape != (d, d):
        raise InputError(f"M has shape {m.shape}, the group needs ({d}, {d}): give one row for each generator")
    if not np.isfinite(m).all():
        raise InputError(f"M is not finite, it has {m[~np.isfinite(m)][0]} in it: give finite numbers in kg m²")
    return m


def _symmetric(m: Array) -> Array:
    return np.asarray(0.5 * (m + np.swapaxes(m, -1, -2)))
