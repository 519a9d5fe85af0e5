"""Matrix Lie algebras: generators, structure constants, and the derivative of the exponential in coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups import exponential
from lie_rigid_body.groups.number_array import as_numbers

Array = NDArray[Any]
Real = NDArray[np.float64]

SPAN_TOLERANCE: Final = 1e-9
"""How far a matrix may lie outside a span, relative to its own size, and count as inside."""

DEPENDENCE_LIMIT: Final = 1e-7
"""Generators of unit size whose smallest singular value is below this are dependent."""

# from the relative error cond² ε ≈ 0.02 of the normal equations at the dependence limit to rounding
_NEWTON_STEPS: Final = 3

SINGULAR_LIMIT: Final = 1e12
"""Entries of dexpinv beyond this mean that dexp is singular to within rounding."""


def frobenius(matrices: Array) -> Real:
    """Frobenius norm over the last two axes, shape (...)."""
    return np.asarray(np.linalg.norm(matrices, axis=(-2, -1)))


def flattened(matrices: Array) -> Real:
    """Matrices as real vectors, real parts before imaginary parts, shape (..., n²) or (..., 2n²)."""
    flat = matrices.reshape(*matrices.shape[:-2], matrices.shape[-2] * matrices.shape[-1])
    return np.concatenate([flat.real, flat.imag], axis=-1) if np.iscomplexobj(flat) else flat


def dual_basis(flat: Real) -> Real:
    """The linear forms that read coordinates off vectors, least squares outside the span.

    The normal equations are followed by Newton steps for the pseudo-inverse, D ← (2 − D Fᵀ) D, which undo their loss of
    digits and leave an orthogonal basis exact.

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


@dataclass(frozen=True, eq=False)
class MatrixLieAlgebra:
    """The real span of matrices Tᵃ with [Tᵃ, Tᵇ] = fᵃᵇᶜTᶜ.

    Parameters
    ----------
    generators : ndarray, shape (d, n, n)
        Linearly independent over the reals and closed under commutation; trusted here, and checked for matrices from
        outside by `MatrixLieGroup.from_generators`.
    """

    generators: Array

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
    def _flat(self) -> Real:
        return flattened(self.generators)

    @cached_property
    def _dual(self) -> Real:
        return dual_basis(self._flat)

    @cached_property
    def _rows(self) -> Array:
        return self.generators.reshape(self.dimension, -1)

    @cached_property
    def structure_constants(self) -> Real:
        """The constants fᵃᵇᶜ of [Tᵃ, Tᵇ] = fᵃᵇᶜTᶜ, shape (d, d, d)."""
        f = np.stack([self.coordinates(t @ self.generators - self.generators @ t) for t in self.generators])
        f.setflags(write=False)
        return f

    @cached_property
    def adjoint_representation(self) -> Real:
        """Matrices of ad Tᵃ, shape (d, d, d): entry [a, c, b] is fᵃᵇᶜ, and they obey the algebra of the Tᵃ."""
        return self.structure_constants.transpose(0, 2, 1)

    @cached_property
    def _adjoint_rows(self) -> Real:
        return self.adjoint_representation.reshape(self.dimension, -1)

    def trace_metric(self, scale: float) -> Real:
        """The matrix scale · Re tr(Tᵃ†Tᵇ), shape (d, d)."""
        metric = scale * np.real(self._rows.conj() @ self._rows.T)
        metric.setflags(write=False)
        return metric

    def as_coordinates(self, x: ArrayLike) -> Real:
        """The argument as float64 coordinates, or an error that names its type or shape."""
        x = as_numbers("coordinates", x)
        if np.iscomplexobj(x):
            raise InputError(f"coordinates are real, given {x.dtype}: give their real part if that is meant")
        x = x.astype(np.float64, copy=False)
        if x.ndim == 0 or x.shape[-1] != self.dimension:
            raise InputError(
                f"coordinates need shape (..., {self.dimension}), given {x.shape}: "
                "put one component per generator on the last axis"
            )
        return x

    def hat(self, x: ArrayLike) -> Array:
        """The matrix xᵃTᵃ, shape (..., n, n), of coordinates x, shape (..., d)."""
        x = self.as_coordinates(x)
        matrices: Array = (x @ self._rows).reshape(*x.shape[:-1], self.size, self.size)
        return matrices

    def coordinates(self, X: Array) -> Real:
        """Coordinates of the nearest matrix of the algebra, shape (..., d); X has shape (..., n, n)."""
        if np.iscomplexobj(self.generators):
            X = X.astype(np.complex128, copy=False)
        return np.asarray(flattened(X) @ self._dual.T)

    def off_span(self, X: Array) -> Real:
        """Frobenius distance of matrices from the span, shape (...)."""
        return frobenius(X - self.hat(self.coordinates(X)))

    def vee(self, X: Array) -> Real:
        """Coordinates of matrices of the algebra; inverse of `hat`. Refuses matrices outside the span.

        Outside is what lies farther from the span than 1e-9 of the matrix's own size, so that a product of elements
        passes unless cancellation has left less of it than that.

        Parameters
        ----------
        X : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., d)
        """
        if not np.all(np.isfinite(X)):
            raise InputError("a matrix has entries that are not finite numbers: give a combination of the generators")
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

    def ad(self, x: ArrayLike) -> Real:
        """The matrix of y ↦ [x, y] in coordinates, xᵃfᵃᵇᶜ at [c, b], shape (..., d, d)."""
        x = self.as_coordinates(x)
        return np.asarray((x @ self._adjoint_rows).reshape(*x.shape, self.dimension))

    def dexp(self, x: ArrayLike) -> Real:
        """J with d/dt exp(x) = hat(J ẋ) exp(x); see `MatrixLieGroup.dexp`."""
        return exponential.phi(self.ad(x))

    def dexpinv(self, x: ArrayLike) -> Real:
        """The inverse of `dexp`; see `MatrixLieGroup.dexpinv`."""
        inverse = exponential.phi_inverse(self.ad(x))
        largest = np.max(np.abs(inverse), initial=0.0)
        if not largest <= SINGULAR_LIMIT:
            raise InputError(
                f"dexpinv has entries of {largest:.3g} (limit {SINGULAR_LIMIT:g}): exp is not invertible there, as "
                "an eigenvalue of ad(x) is a multiple of 2πi; take x closer to 0"
            )
        return inverse
