"""Steady rotations: motions of constant body rate, and their stability."""

from __future__ import annotations

from enum import Enum
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.coadjoint import ad_star, coadjoint_directions, invariant_form
from lie_rigid_body.groups.exponential import Complex
from lie_rigid_body.groups.lagrangian import Lagrangian
from lie_rigid_body.mechanics.array_input import ROUND_OFF, symmetrised

STEADY_TOLERANCE: Final = 1e-9
"""Largest |ad*_ω Mω| of a steady rotation, relative to |ω|, |Mω| and the structure constants.

So far off may its momentum p be, and singular values of the orbit's tangent map up to that, relative to |p| and the
structure constants, count as 0.
"""


class Stability(Enum):
    """Stability of a steady rotation under a small disturbance."""

    STABLE = "stable"
    """The energy is a strict extremum on the coadjoint orbit of the momentum, so that the motion on it stays near the
    rotation for all time (V. I. Arnold), and what is linearised off the orbit does not grow."""

    LINEARLY_STABLE = "linearly stable"
    """The linearised motion stays bounded, as its eigenvalues are imaginary and semisimple, but the energy is no strict
    extremum and does not decide on the motion itself. Other integrals may, as Manakov's for a body in n dimensions.
    Examples: many coordinate planes of a body in four dimensions, every axis of a sphere."""

    MARGINAL = "marginal"
    """The linearised motion grows like a power of time: an imaginary eigenvalue is not semisimple."""

    UNSTABLE = "unstable"
    """The linearised motion grows exponentially."""


@short_dataclass(eq=False)
class RelativeEquilibrium:
    """A steady rotation (relative equilibrium), the eigenvalues of the motion linearised about it, and its stability.

    Parameters
    ----------
    rate : ndarray, shape (d,)
        ω in the body frame, 1/s.
    eigenvalues : ndarray, shape (m,)
        Complex, of the linearised Euler equations on the coadjoint orbit of p = Mω, of dimension m; 1/s. Those off the
        orbit are added where they are not all 0, as they are unless the orbits nearby have more dimensions. Sorted by
        real part, then by imaginary part.
    stability : Stability
    """

    rate: Array
    eigenvalues: Complex
    stability: Stability

    @property
    def growth_rate(self) -> float:
        """Largest real part λ of an eigenvalue, 1/s: a disturbance grows like exp(λt).

        Zero to round-off unless the rotation is unstable.
        """
        return float(self.eigenvalues.real.max(initial=0.0))

    @property
    def frequencies(self) -> Array:
        """Angular frequencies of disturbances, rad/s: imaginary parts of eigenvalues above round-off, ascending."""
        imaginary = self.eigenvalues.imag
        # a double eigenvalue 0 splits under round-off by its square root
        noise = np.sqrt(ROUND_OFF) * np.abs(self.eigenvalues).max(initial=0.0)
        return np.sort(imaginary[imaginary > noise])


def steady_axes(lagrangian: Lagrangian) -> Array:
    """Directions about which the rotation is steady at any rate: the solutions of Mω = λgω with `invariant_form` g.

    As g is invariant, ad*_ω Mω = λ ad*_ω gω = 0. On SO(3) these are the principal axes, on SO(n) with a diagonal second
    moment the coordinate planes. Where λ is degenerate every linear combination is a solution as well.

    Parameters
    ----------
    lagrangian : Lagrangian
        On a group with an invariant form, as compact and semisimple ones.

    Returns
    -------
    ndarray, shape (d, d)
        Rows are directions with components of norm 1, in ascending order of λ.

    Raises
    ------
    InputError
        If the group has no regular invariant form.
    """
    lower = np.linalg.cholesky(of_kind(lagrangian, Lagrangian).metric)
    # with ω = C⁻ᵀy and M = CCᵀ, the pencil Mω = λgω is the symmetric (Cᵀg⁻¹C) y = λy
    values, vectors = np.linalg.eigh(lower.T @ np.linalg.solve(invariant_form(lagrangian.group), lower))
    axes = np.linalg.solve(lower.T, vectors[:, np.argsort(values, kind="stable")]).T
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


@within_doubles
def steady_rotation(lagrangian: Lagrangian, rate: ArrayLike) -> RelativeEquilibrium:
    """The steady rotation at a given rate, with its stability.

    Disturbances off the coadjoint orbit of p = Mω lead to neighbouring steady motions, unless the orbits nearby have
    more dimensions. There they count as far as the linearised motion tells: it may grow, as on the affine group of the
    line. If it does not, that is a proof of stability on compact groups only.

    The verdict depends on one relative tolerance ε: round-off, or the unsteadiness of the given rate if that is larger.
    Curvatures of the energy on the orbit, and linearised motions, within ε of their terms count as 0. Eigenvalues
    within √ε count as equal, as a double eigenvalue splits by that much. An indefinite curvature with an odd number of
    negative directions is unstable however slow the growth; on SO(3), whose orbits have two dimensions, the signs of
    the curvature decide.

    Parameters
    ----------
    lagrangian : Lagrangian
    rate : array_like, shape (d,)
        ω in the body frame, 1/s.

    Returns
    -------
    RelativeEquilibrium

    Raises
    ------
    InputError
        If the rotation at this rate is not steady: ad*_ω Mω is not 0.

    References
    ----------
    V. I. Arnold, *Mathematical Methods of Classical Mechanics*, appendix 2; J. E. Marsden, T. S. Ratiu, *Introduction
    to Mechanics and Symmetry*, on the energy–Casimir method.
    """
    w = of_kind(lagrangian, Lagrangian).group.as_components(rate, "rates").copy()
    resolution = max(ROUND_OFF, _unsteadiness(lagrangian, w))
    momentum = lagrangian.momenta(w)
    f = lagrangian.group.structure_constants
    directions = coadjoint_directions(lagrangian.group, momentum)
    size = np.linalg.norm(momentum) * np.abs(f).max(initial=0.0)
    if not np.isfinite(size):
        raise ParameterError("rates", "their squares are beyond double precision, 1.8e308: give smaller numbers")
    tangent, algebra, normal = _orbit(directions, STEADY_TOLERANCE * size)
    whole = linearisation(lagrangian, w)
    linear = tangent.T @ whole @ tangent
    off = normal.T @ whole @ normal
    curvature, scale = _energy_curvature(lagrangian, w, directions)
    signs = _signs(algebra.T @ curvature @ algebra, resolution * scale)
    eigenvalues = np.linalg.eigvals(linear).astype(np.complex128)
    turning = np.linalg.norm(np.tensordot(w, f, axes=1), 2)
    split = np.sqrt(resolution)
    stability = _verdict(linear, eigenvalues, signs, split, resolution * turning)
    if np.linalg.norm(off, 2) > split * turning:
        leaving = np.linalg.eigvals(off).astype(np.complex128)
        eigenvalues = np.append(eigenvalues, leaving)
        if leaving.real.max() > split * turning:
            stability = Stability.UNSTABLE
        elif stability is not Stability.UNSTABLE and not _semisimple(off, leaving, split * turning):
            stability = Stability.MARGINAL
    return RelativeEquilibrium(w, np.sort_complex(eigenvalues), stability)


@within_doubles
def linearisation(lagrangian: Lagrangian, rate: ArrayLike) -> Array:
    """Euler's equations linearised about p = Mω: the matrix of δp ↦ d/dt δp = ad*_{M⁻¹δp} p + ad*_ω δp.

    Parameters
    ----------
    lagrangian : Lagrangian
    rate : array_like, shape (..., d)

    Returns
    -------
    ndarray, shape (..., d, d)
        1/s.
    """
    w = of_kind(lagrangian, Lagrangian).group.as_components(rate, "rates")
    turning = np.tensordot(w, lagrangian.group.structure_constants, axes=1)
    directions = coadjoint_directions(lagrangian.group, lagrangian.momenta(w))
    return directions @ lagrangian.inverse_metric + turning


def _energy_curvature(lagrangian: Lagrangian, rate: Array, directions: Array) -> tuple[Array, float]:
    """The second derivative of H along s ↦ exp(s ad*_ξ) p, as a quadratic form in ξ, and the size of its terms.

    The terms cancel for a body that is nearly a sphere. The directions are ad*_{Tᶜ} p, as columns.
    """
    brackets = np.einsum("abd,b->da", lagrangian.group.structure_constants, rate)  # ξ ↦ [ξ, ω]
    kinetic = directions.T @ lagrangian.inverse_metric @ directions
    return kinetic + symmetrised(directions.T @ brackets), np.linalg.norm(kinetic, 2)


def _signs(form: Array, zero: float) -> NDArray[np.int_]:
    """The signs of the eigenvalues of a quadratic form, 0 for those below a limit."""
    values = np.linalg.eigvalsh(form)
    return np.where(np.abs(values) > zero, np.sign(values), 0.0).astype(np.int_)


def _orbit(directions: Array, zero: float) -> tuple[Array, Array, Array]:
    """Orthonormal columns: tangents of the orbit of p, the algebra elements that move p along it, and normals.

    Singular values of the tangent map up to `zero` count as 0.
    """
    tangent, sizes, algebra = np.linalg.svd(directions)
    on_orbit = sizes > zero
    return tangent[:, on_orbit], algebra[on_orbit].T, tangent[:, ~on_orbit]


def _unsteadiness(lagrangian: Lagrangian, rate: Array) -> float:
    """Size of ad*_ω Mω relative to |ω|, |Mω| and the structure constants; refused above `STEADY_TOLERANCE`."""
    if rate.ndim != 1:
        raise InputError(
            f"a steady rotation needs one rate of {lagrangian.group.dimension} numbers, given {rate.tolist()}: "
            "give one at a time"
        )
    momentum = lagrangian.momenta(rate)
    size = np.linalg.norm(rate) * np.linalg.norm(momentum)
    scale = size * np.abs(lagrangian.group.structure_constants).max(initial=0.0)
    turned = np.linalg.norm(ad_star(lagrangian.group, rate, momentum))
    if turned > STEADY_TOLERANCE * scale:
        raise InputError(
            f"the rotation at rate {rate.tolist()} is not steady: its momentum turns by {turned / scale:.3g} of "
            f"|ω||p|, the limit is {STEADY_TOLERANCE:g}: take a rate that keeps its momentum, as "
            "steady_axes are if there are any"
        )
    return turned / scale if scale else 0.0


def _verdict(linear: Array, eigenvalues: Complex, signs: NDArray[np.int_], split: float, zero: float) -> Stability:
    """The stability by the linearised motion and the signs of the energy's curvature on the orbit, of dimension m.

    A linearised motion no larger than `zero` is what its terms leave where they cancel: none.
    """
    if np.all(signs > 0) or np.all(signs < 0):
        return Stability.STABLE
    size = np.linalg.norm(linear, 2)
    # the determinant of the linearised motion has the sign of the curvature's: where it is < 0 there is a real pair ±λ
    odd = bool(np.prod(signs) < 0)
    # a growing mode has energy 0: with a semidefinite curvature it would be in the kernel, which does not move
    indefinite = bool(signs.min() < 0 < signs.max())
    if odd or (indefinite and eigenvalues.real.max() > split * size):
        return Stability.UNSTABLE
    rests = size <= zero or _semisimple(linear, eigenvalues, split * size)
    return Stability.LINEARLY_STABLE if rests else Stability.MARGINAL


def _semisimple(linear: Array, eigenvalues: Complex, split: float) -> bool:
    """Whether every eigenvalue has as many eigenvectors as its multiplicity, counted with those within 2·split."""
    for value in eigenvalues:
        multiplicity = np.count_nonzero(np.abs(eigenvalues - value) <= 2.0 * split)
        sizes = np.linalg.svd(linear - value * np.eye(len(linear)), compute_uv=False)
        if np.count_nonzero(sizes <= 4.0 * split) < multiplicity:
            return False
    return True
