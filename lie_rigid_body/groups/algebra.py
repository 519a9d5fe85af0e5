"""Matrix Lie algebras: generators, structure constants, coordinates, and the derivative of the exponential.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array, require_finite, shaped
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.groups import exponential
from lie_rigid_body.groups.arguments import MadeAnew, within_doubles
from lie_rigid_body.groups.exponential import Matrix

SPAN_TOLERANCE: Final = 1e-9
"""Largest distance of a matrix from a span, relative to the size of the matrix, that counts as round-off."""

DEPENDENCE_LIMIT: Final = 1e-7
"""Singular value of generators of unit size below which they count as linearly dependent."""

SIZE_LIMIT: Final = 1e50
"""Largest entry that a generator may have; the inverse is the least. Products of others leave the range of a double."""

MAX_GENERATORS: Final = 812
"""Largest dimension d of a named group: its structure constants, d³ doubles, take 4 GiB at most."""

# at the dependence limit the normal equations err by cond² ε ≈ 0.02, which three squarings take to round-off
_NEWTON_STEPS: Final = 3

DEXPINV_LIMIT: Final = 1e12
"""Largest entry that dexpinv may have: a larger one means that dexp is singular to within rounding."""


def frobenius(matrices: Matrix) -> Array:
    """Frobenius norm over the last two axes, shape (...)."""
    return np.linalg.norm(matrices, axis=(-2, -1))


def flattened(matrices: Matrix) -> Array:
    """Matrices as real vectors, real parts before imaginary parts, shape (..., n²) or (..., 2n²)."""
    flat = matrices.reshape(*matrices.shape[:-2], matrices.shape[-2] * matrices.shape[-1])
    return np.concatenate([flat.real, flat.imag], axis=-1) if np.iscomplexobj(flat) else flat


def dual_basis(flat: Array) -> Array:
    """The dual basis: linear forms that give the coordinates of vectors, by least squares outside the span.

    The normal equations are solved and refined by Newton steps for the pseudo-inverse, D ← (2 − D Fᵀ) D. These restore
    the digits that the normal equations lose, and leave an orthogonal basis exact.

    Parameters
    ----------
    flat : ndarray, shape (d, m)
        Linearly independent rows.

    Returns
    -------
    ndarray, shape (d, m)
    """
    dual = np.linalg.solve(flat @ flat.T, flat)
    for _ in range(_NEWTON_STEPS):
        dual = (2.0 * np.eye(len(flat)) - dual @ flat.T) @ dual
    return np.asarray(dual)


@short_dataclass(eq=False)
class MatrixLieAlgebra(MadeAnew):
    """The real span of matrices Tᵃ with [Tᵃ, Tᵇ] = fᵃᵇᶜTᶜ, eq. (42).

    Parameters
    ----------
    generators : ndarray, shape (d, n, n)
        Linearly independent over the reals and closed under commutation. Not checked here; see `closed_algebra`.
    """

    generators: Matrix

    def __post_init__(self) -> None:
        self.generators.setflags(write=False)

    @property
    def dimension(self) -> int:
        """Number of generators, d."""
        return len(self.generators)

    @property
    def size(self) -> int:
        """Rows of a matrix, n."""
        return int(self.generators.shape[-1])

    @cached_property
    def _dual(self) -> Array:
        return dual_basis(flattened(self.generators))

    @cached_property
    def _rows(self) -> Matrix:
        return self.generators.reshape(self.dimension, -1)

    @cached_property
    def structure_constants(self) -> Array:
        """The structure constants fᵃᵇᶜ of [Tᵃ, Tᵇ] = fᵃᵇᶜTᶜ, eq. (42), shape (d, d, d).

        On SO(3) they are ε, eq. (26). The product rule (17) needs no more of a group than these.
        """
        f = np.stack([self.coordinates(t @ self.generators - self.generators @ t) for t in self.generators])
        f.setflags(write=False)
        return f

    @cached_property
    def adjoint_representation(self) -> Array:
        """Matrices of ad Tᵃ, shape (d, d, d), with entry [a, c, b] equal to fᵃᵇᶜ; they obey the algebra of the Tᵃ.

        Eq. (43) prints the transposed matrices, which obey the algebra with −f.
        """
        return self.structure_constants.transpose(0, 2, 1)

    @cached_property
    def _adjoint_rows(self) -> Array:
        return self.adjoint_representation.reshape(self.dimension, -1)

    @within_doubles
    def scaled_trace(self, scale: float) -> Array:
        """The matrix scale · Re tr(Tᵃ†Tᵇ), shape (d, d)."""
        return np.asarray(real_array("scale", scale, ()) * np.real(self._rows.conj() @ self._rows.T))

    def as_components(self, x: ArrayLike, name: str = "coordinates") -> Array:
        """The argument as float64 components along the generators: coordinates, rates, momenta or gradients.

        Parameters
        ----------
        x : array_like, shape (..., d)
        name : str, optional
            Name of the argument in the error.

        Returns
        -------
        ndarray, shape (..., d)

        Raises
        ------
        ParameterError
            If they are not finite real numbers, or the last axis is not of length d.
        """
        return real_array(str(name), x, (..., self.dimension), empty=True)

    @within_doubles
    def hat(self, x: ArrayLike) -> Matrix:
        """The matrix xᵃTᵃ of the algebra, of coordinates x; Ȧ = A hat(ω) in eq. (8).

        Parameters
        ----------
        x : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        x = self.as_components(x)
        return (x @ self._rows).reshape(*x.shape[:-1], self.size, self.size)

    def as_matrices(self, X: Any) -> Matrix:
        """Matrices, shape (..., n, n), in the number type of the generators; a group also checks them."""
        return np.asarray(X, self.generators.dtype)

    @within_doubles
    def coordinates(self, X: Any) -> Array:
        """Coordinates of the nearest matrix of the algebra, shape (..., d); X has shape (..., n, n)."""
        return flattened(self.as_matrices(X)) @ self._dual.T

    @within_doubles
    def off_span(self, X: Any) -> Array:
        """Frobenius distance of matrices from the span, shape (...)."""
        X = self.as_matrices(X)
        return frobenius(X - self.hat(self.coordinates(X)))

    def vee(self, X: Any) -> Array:
        """Coordinates of matrices of the algebra; inverse of `hat`. Refuses matrices outside the span.

        A matrix is outside if its distance from the span exceeds 1e-9 of its own size. Round-off of a product of
        elements stays below that, unless cancellation has left little of the product.

        Parameters
        ----------
        X : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., d)
        """
        X = self.as_matrices(X)
        require_finite("matrix", X)
        x = self.coordinates(X)
        # measured in the largest entry, so that no square of an entry underflows or overflows
        size = np.abs(X).max(axis=(-2, -1), keepdims=True)
        unit = X / np.where(size > 0.0, size, 1.0)
        worst = np.max(self.off_span(unit) / np.maximum(1.0, frobenius(unit)), initial=0.0)
        if not worst <= SPAN_TOLERANCE:
            raise InputError(
                f"a matrix lies outside the span of the generators by {worst:.3g} of its size "
                f"(limit {SPAN_TOLERANCE:g}): give a combination of them"
            )
        return x

    @within_doubles
    def ad(self, x: ArrayLike) -> Array:
        """The matrix of y ↦ [x, y] in coordinates: xᵃfᵃᵇᶜ at [c, b].

        Parameters
        ----------
        x : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d, d)
        """
        x = self.as_components(x)
        return (x @ self._adjoint_rows).reshape(*x.shape, self.dimension)

    @within_doubles
    def dexp(self, x: ArrayLike) -> Array:
        """The Jacobian J with d/dt exp(x) = hat(J ẋ) exp(x), which is 1 at x = 0: eqs. (11) and (15).

        It is φ(ad x) with φ(z) = (e^z − 1)/z, for x of any norm. For SO(3) this is `so3.left_jacobian`; with
        exp(x) hat(J ẋ) instead, J is ``dexp(-x)`` (Iserles et al., Acta Numerica 9 (2000), section 2.3).

        Parameters
        ----------
        x : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d, d)
        """
        return exponential.phi(self.ad(x))

    @within_doubles
    def dexpinv(self, x: ArrayLike) -> Array:
        """The inverse of `dexp`, the rate of chart coordinates: ẋ = dexpinv(x) ω where exp(x) turns with rate ω.

        Parameters
        ----------
        x : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., d, d)

        Raises
        ------
        InputError
            Where dexp is singular: an eigenvalue of ad(x) is a non-zero multiple of 2πi.
        """
        inverse = exponential.phi_inverse(self.ad(x))
        largest = np.max(np.abs(inverse), initial=0.0)
        if not largest <= DEXPINV_LIMIT:
            raise InputError(
                f"dexpinv has entries of {largest:.3g} (limit {DEXPINV_LIMIT:g}): exp is not invertible there, as "
                "an eigenvalue of ad(x) is a multiple of 2πi; take x closer to 0"
            )
        return inverse


def closed_algebra(generators: ArrayLike) -> MatrixLieAlgebra:
    """The algebra of given generators, checked for shape, linear independence and closure under commutation.

    Parameters
    ----------
    generators : array_like, shape (d, n, n)

    Returns
    -------
    MatrixLieAlgebra

    Raises
    ------
    InputError
        See `MatrixLieGroup.from_generators`.
    """
    T = _as_generators(generators)
    _refuse_dependent(T)
    algebra = MatrixLieAlgebra(T)
    _refuse_open(algebra)
    return algebra


def _as_generators(generators: ArrayLike) -> Matrix:
    T = np.array(shaped("generators", generators, ("d", "n", "n"), np.complex128))
    if T.size == 0:
        raise ParameterError("generators", f"shape {T.shape} has no numbers: give at least one matrix")
    if not np.iscomplexobj(generators):
        T = T.real.copy()
    if not np.all(np.isfinite(T)):
        worst = np.argmin(np.isfinite(T).all(axis=(1, 2)))
        raise InputError(f"T{worst} has an entry that is not a finite number: give finite generators")
    return T


def _refuse_dependent(T: Matrix) -> None:
    """Refuse dependent generators, with the first that lies in the span of those before it."""
    _refuse_sizes(np.abs(T).max(axis=(1, 2)))
    flat = flattened(T) / frobenius(T)[:, np.newaxis]
    if _are_independent(flat):
        return
    first = next(k for k in range(len(flat)) if not _are_independent(flat[: k + 1]))
    raise InputError(f"the generators are dependent: T{first} is a combination of those before it: leave it out")


def _are_independent(flat: Array) -> bool:
    """Whether rows of unit size are linearly independent, within `DEPENDENCE_LIMIT`."""
    return bool(len(flat) <= flat.shape[1] and np.linalg.svd(flat, compute_uv=False)[-1] > DEPENDENCE_LIMIT)


def _refuse_sizes(largest: Array) -> None:
    """Refuse a generator that is zero, or whose products leave the range of a double."""
    if np.any(largest == 0.0):
        raise InputError(
            f"T{(np.argmin(largest))} is zero: leave it out; for an algebra with a centre give other matrices than "
            "the adjoint ones"
        )
    beyond = (largest > SIZE_LIMIT) | (largest < 1.0 / SIZE_LIMIT)
    if np.any(beyond):
        worst = np.argmax(beyond)
        raise InputError(
            f"the largest entry of T{worst} is {largest[worst]:.3g} (limits {1.0 / SIZE_LIMIT:g} and {SIZE_LIMIT:g}): "
            "rescale it, which changes the unit of its coordinate alone"
        )


def _refuse_open(algebra: MatrixLieAlgebra) -> None:
    """Refuse generators that are not closed, with the commutator farthest outside the span."""
    T = algebra.generators
    size = frobenius(algebra.generators)
    commutators = [t @ T - T @ t for t in T]
    off = np.stack([algebra.off_span(each) for each in commutators])
    allowed = SPAN_TOLERANCE * np.outer(size, size)
    if np.all(off <= allowed):
        return
    if np.iscomplexobj(T) and np.all(np.stack([algebra.off_span(1j * each) for each in commutators]) <= allowed):
        raise InputError(
            "the commutators are i times matrices of the span, and elements are exp(xᵃTᵃ) without an i: give −i times "
            "the generators"
        )
    a, b = np.unravel_index(np.argmax(np.where(off > allowed, off, 0.0)), off.shape)
    raise InputError(
        f"[T{a}, T{b}] leaves the span by {off[a, b]:.3g} (limit {allowed[a, b]:.3g}), "
        f"one of {np.count_nonzero(off > allowed) // 2} commutators that do: add the matrices that it needs"
    )
