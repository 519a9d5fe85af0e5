"""Steady rotations: the motions whose rate does not change, and what becomes of a small push."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics.coadjoint import coadjoint_action, coadjoint_directions, invariant_metric
from lie_rigid_body.mechanics.components import require_components
from lie_rigid_body.mechanics.lagrangian import Lagrangian

Array = NDArray[np.float64]

STEADY_TOLERANCE: Final = 1e-9
"""A rate that turns its own momentum by more than this, relative to both and to the structure constants, is refused."""

_RANK: Final = 1e-10
# a double eigenvalue 0 splits under round-off by its square root
_GROWTH: Final = 1e-7
_DEFINITE: Final = 1e-9


class Stability(Enum):
    """What becomes of a small push that keeps the motion on its coadjoint orbit."""

    STABLE = "stable"
    """The energy is a strict extremum on the orbit, so that the motion stays near for ever (V. I. Arnold)."""

    MARGINAL = "marginal"
    """The linearised motion does not grow exponentially, but the energy is no strict extremum."""

    UNSTABLE = "unstable"
    """The linearised motion grows exponentially."""


@dataclass(frozen=True)
class SteadyRotation:
    """A steady rotation with its linearised motion.

    Parameters
    ----------
    rate : ndarray, shape (d,)
        ω in the body frame, 1/s.
    eigenvalues : ndarray, shape (m,)
        Complex, of the linearised Euler equations on the coadjoint orbit of p = Mω, of dimension m; 1/s. Sorted by
        real part, then by imaginary part.
    stability : Stability
    """

    rate: Array
    eigenvalues: NDArray[np.complex128]
    stability: Stability

    @property
    def growth_rate(self) -> float:
        """Largest real part of an eigenvalue, 1/s: a push grows by e in its inverse. Round-off, unless unstable."""
        return float(self.eigenvalues.real.max(initial=0.0))

    @property
    def frequencies(self) -> Array:
        """The imaginary parts above round-off, ascending, rad/s: with these a push oscillates about the rotation."""
        imaginary = self.eigenvalues.imag
        return np.asarray(np.sort(imaginary[imaginary > _GROWTH * np.abs(self.eigenvalues).max(initial=0.0)]))


def steady_axes(lagrangian: Lagrangian) -> Array:
    """Directions about which the body turns steadily at any rate: Mω is a multiple of ω read as a momentum.

    To read ω as a momentum takes the trace metric g, which is invariant: Mω = λgω makes ad*_ω Mω = λ ad*_ω gω = 0.
    On SO(3) these are the principal axes; on SO(n) with a diagonal second moment, the coordinate planes. Where λ is
    degenerate every combination is as good.

    Parameters
    ----------
    lagrangian : Lagrangian
        On a compact group, so that g is invariant.

    Returns
    -------
    ndarray, shape (d, d)
        Rows are directions with components of norm 1, in ascending order of λ.

    Raises
    ------
    InputError
        If g is not invariant.
    """
    lower = np.linalg.cholesky(lagrangian.metric)
    # with ω = C⁻ᵀy and M = CCᵀ, the pencil Mω = λgω is the symmetric (Cᵀg⁻¹C) y = λy
    values, vectors = np.linalg.eigh(lower.T @ np.linalg.solve(invariant_metric(lagrangian.group), lower))
    axes = np.linalg.solve(lower.T, vectors[:, np.argsort(values, kind="stable")]).T
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def steady_rotation(lagrangian: Lagrangian, rate: ArrayLike) -> SteadyRotation:
    """The stability of the body's steady rotation at a given rate.

    A push off the orbit of p adds nothing but a slow drift along neighbouring steady motions, so it is left out.

    Parameters
    ----------
    lagrangian : Lagrangian
    rate : array_like, shape (d,)
        ω in the body frame, 1/s.

    Returns
    -------
    SteadyRotation

    Raises
    ------
    InputError
        If the rotation at this rate is not steady: ad*_ω Mω is not 0.

    References
    ----------
    V. I. Arnold, *Mathematical Methods of Classical Mechanics*, appendix 2; J. E. Marsden, T. S. Ratiu, *Introduction
    to Mechanics and Symmetry*, on the energy–Casimir method.
    """
    w = require_components(lagrangian.group, rate, "rates").copy()
    _require_steady(lagrangian, w)
    linear = linearisation(lagrangian, w)
    tangent, algebra = _orbit(lagrangian, w)
    eigenvalues = np.sort_complex(np.linalg.eigvals(tangent.T @ linear @ tangent))
    growing = bool(eigenvalues.real.max(initial=0.0) > _GROWTH * np.linalg.norm(linear, 2))
    curvature = np.linalg.eigvalsh(algebra.T @ _energy_curvature(lagrangian, w) @ algebra)
    return SteadyRotation(w, eigenvalues, _verdict(growing, curvature))


def linearisation(lagrangian: Lagrangian, rate: Array) -> Array:
    """The matrix of δp ↦ d/dt δp = ad*_{M⁻¹δp} p + ad*_ω δp about p = Mω.

    Parameters
    ----------
    lagrangian : Lagrangian
    rate : ndarray, shape (..., d)

    Returns
    -------
    ndarray, shape (..., d, d)
        1/s.
    """
    turning = np.tensordot(rate, lagrangian.group.structure_constants, axes=1)
    directions = coadjoint_directions(lagrangian.group, lagrangian.momenta(rate))
    return np.asarray(directions @ lagrangian.inverse_metric + turning)


def _energy_curvature(lagrangian: Lagrangian, rate: Array) -> Array:
    """The second derivative of H along s ↦ exp(s ad*_ξ) p, as a quadratic form in ξ."""
    directions = coadjoint_directions(lagrangian.group, lagrangian.momenta(rate))
    brackets = np.einsum("abd,b->da", lagrangian.group.structure_constants, rate)  # ξ ↦ [ξ, ω]
    bent = directions.T @ brackets
    return np.asarray(directions.T @ lagrangian.inverse_metric @ directions + 0.5 * (bent + bent.T))


def _orbit(lagrangian: Lagrangian, rate: Array) -> tuple[Array, Array]:
    """Orthonormal columns: the tangent space of the orbit of p, and the algebra elements that move p along it."""
    directions = coadjoint_directions(lagrangian.group, lagrangian.momenta(rate))
    tangent, sizes, algebra = np.linalg.svd(directions)
    on_orbit = sizes > _RANK * sizes.max(initial=0.0)
    return tangent[:, on_orbit], algebra[on_orbit].T


def _require_steady(lagrangian: Lagrangian, rate: Array) -> None:
    if rate.ndim != 1 or not np.isfinite(rate).all():
        raise InputError(
            f"a steady rotation needs one rate of {lagrangian.group.dimension} finite numbers, given {rate.tolist()}: "
            "give one at a time"
        )
    momentum = lagrangian.momenta(rate)
    size = float(np.linalg.norm(rate) * np.linalg.norm(momentum))
    scale = size * float(np.abs(lagrangian.group.structure_constants).max(initial=0.0))
    turned = float(np.linalg.norm(coadjoint_action(lagrangian.group, rate, momentum)))
    if turned > STEADY_TOLERANCE * scale:
        raise InputError(
            f"the rotation at rate {rate.tolist()} is not steady: its momentum turns by {turned / scale:.3g} relative "
            f"to both, the limit is {STEADY_TOLERANCE:g}: take a multiple of one of steady_axes"
        )


def _verdict(growing: bool, curvature: NDArray[Any]) -> Stability:
    if growing:
        return Stability.UNSTABLE
    largest = float(np.abs(curvature).max(initial=0.0))
    definite = bool(np.all(curvature > _DEFINITE * largest) or np.all(curvature < -_DEFINITE * largest))
    return Stability.STABLE if definite else Stability.MARGINAL
