"""The contract of a group's elements, what a matrix group needs to know beyond its algebra; and generated elements.

The elements of a group that is given by its generators alone are recognised by their principal logarithm.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Sizes
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import exponential
from lie_rigid_body.groups.algebra import SPAN_TOLERANCE, MatrixLieAlgebra, frobenius
from lie_rigid_body.groups.arguments import within_doubles
from lie_rigid_body.groups.exponential import HALF_TURN_MARGIN, Matrix

NEGLIGIBLE_ANGLE: Final = 1e-5
"""Largest imaginary part of an eigenvalue, relative to the norm of its matrix, that counts as round-off.

The eigenvalues of a nilpotent matrix are 0, and come out as large as a root of the round-off unit.
"""

CONDITION_LIMIT: Final = 1e15
"""Condition number, after rows and columns are scaled, from which a matrix is singular to within rounding."""

_ENTRY_ERROR: Final = 1e-12


class Elements(ABC):
    """Membership, projection, inverse, logarithm and random elements of one matrix group.

    Each constructor of a group supplies one of these. Matrices come finite, of shape (..., n, n), and of the
    group's number type; all methods are batched over the leading axes.
    """

    @abstractmethod
    def distance(self, A: Matrix) -> Array:
        """Distance of each matrix from fulfilling the group's equations, shape (...); infinite where undefined."""

    def certain_distance(self, A: Matrix) -> Array:
        """A lower bound of `distance`, shape (...), for groups with elements that `distance` does not recognise."""
        return self.distance(A)

    @abstractmethod
    def project(self, A: Matrix) -> Matrix:
        """An element near each matrix, shape (..., n, n); an InputError where several are equally near."""

    def restored(self, A: Matrix) -> Matrix:
        """Elements that round-off has carried a little off the group, projected back where that is safe."""
        return self.project(A)

    @abstractmethod
    def inverse(self, A: Matrix) -> Matrix:
        """The inverse of each element, shape (..., n, n)."""

    @abstractmethod
    def log(self, A: Matrix) -> Matrix:
        """The logarithm in the algebra, shape (..., n, n); an InputError where it is not unique."""

    def one_to_one(self, X: Matrix) -> Array:
        """The multiple t of each matrix of the algebra below which `log` takes exp(tX) back to tX, shape (...).

        The principal logarithm ends where an eigenvalue of tX first has the imaginary part ±π.
        """
        return multiple_until(np.pi, np.abs(np.linalg.eigvals(X).imag).max(axis=-1), X)

    @abstractmethod
    def random(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Independent random elements, shape (*shape, n, n)."""


def multiple_until(limit: float, angles: Array, X: Matrix) -> Array:
    """The multiple of matrices at which angles proportional to them reach a limit; infinite where nothing turns.

    Parameters
    ----------
    limit : float
        Angle, rad.
    angles : ndarray, shape (...)
        Imaginary parts of eigenvalues of X, or their differences, rad.
    X : ndarray, shape (..., n, n)
        Their norm tells which angles are round-off.
    """
    turns = angles > NEGLIGIBLE_ANGLE * within_doubles(frobenius)(X)
    return np.where(turns, limit / np.where(turns, angles, 1.0), np.inf)


def measured(A: Matrix, distance: Callable[[Matrix], Array]) -> Array:
    """Distances of matrices from a group, shape (...); infinite for matrices with entries that are not finite.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)
    distance : callable
        `Elements.distance` or `Elements.certain_distance`.
    """
    finite = np.isfinite(A).all(axis=(-2, -1))
    with np.errstate(all="ignore"):  # what overflows, or has the determinant 0, is no element
        return np.where(finite, distance(np.where(finite[..., np.newaxis, np.newaxis], A, 0.0)), np.inf)


class GeneratedElements(Elements):
    """Elements of a generated group, as far as their principal logarithm recognises them.

    Parameters
    ----------
    algebra : MatrixLieAlgebra
    """

    def __init__(self, algebra: MatrixLieAlgebra) -> None:
        self._algebra = algebra

    def distance(self, A: Matrix) -> Array:
        """Distance of the principal logarithm from the algebra; infinite where there is no principal logarithm."""
        logs = _principal_logs(A)
        off = self._algebra.off_span(np.nan_to_num(logs))
        return np.where(np.isfinite(logs).all(axis=(-2, -1)), off, np.inf)

    def certain_distance(self, A: Matrix) -> Array:
        """Distance of a matrix from the two conditions that every element meets, on its determinant and on its Ad.

        The conditions are necessary, not sufficient. The larger of the two distances is returned, and infinity for a
        matrix that is singular to within rounding. For a large condition number the distance is reduced by what an
        error of 1e-12 in the entries of an element can amount to.
        """
        regular = np.linalg.cond(_equilibrated(A)) < CONDITION_LIMIT
        A = np.where(regular[..., np.newaxis, np.newaxis], A, np.eye(A.shape[-1]))
        off = np.maximum(self._off_determinants(A), self._off_normaliser(A))
        return np.where(regular, off / np.maximum(1.0, _ENTRY_ERROR / SPAN_TOLERANCE * np.linalg.cond(A)), np.inf)

    def _off_determinants(self, A: Matrix) -> Array:
        """Distance of log det A, shape (...), from the algebra's traces, where these are all real or all imaginary."""
        traces = np.trace(self._algebra.generators, axis1=-2, axis2=-1)
        negligible = SPAN_TOLERANCE * frobenius(self._algebra.generators)
        sign, modulus = np.linalg.slogdet(A)
        real = np.where(np.all(np.abs(traces.real) <= negligible), modulus, 0.0)
        imaginary = np.where(np.all(np.abs(traces.imag) <= negligible), np.angle(sign), 0.0)
        return np.hypot(real, imaginary)

    def _off_normaliser(self, A: Matrix) -> Array:
        """Largest distance of A Tᵃ A⁻¹ from the algebra, relative to Tᵃ, shape (...)."""
        T = self._algebra.generators
        each = A[..., np.newaxis, :, :]
        off = self._algebra.off_span(each @ T @ np.linalg.inv(each)) / frobenius(T)
        return off.max(axis=-1)

    def project(self, A: Matrix) -> Matrix:
        """Refused: generators give no equations that a nearest element would fulfil."""
        raise InputError("generators give no equations to project onto: give elements, as products of exponentials")

    def restored(self, A: Matrix) -> Matrix:
        """The matrices unchanged: their principal logarithm may lead to another sheet of the group, or not exist."""
        return A

    def inverse(self, A: Matrix) -> Matrix:
        """The inverse by elimination."""
        return np.linalg.inv(A)

    def log(self, A: Matrix) -> Matrix:
        """The principal logarithm, where it lies in the algebra."""
        logs = _principal_logs(A)
        if not np.all(np.isfinite(logs)):
            raise InputError(
                "no principal logarithm: a matrix is singular, far from normal, or has an eigenvalue on the negative "
                f"real axis (within {HALF_TURN_MARGIN:g} rad); give an element closer to the identity"
            )
        worst = np.max(self._algebra.off_span(logs), initial=0.0)
        if not worst <= SPAN_TOLERANCE:
            raise InputError(
                f"a matrix is not recognised as an element: its principal logarithm leaves the span of the generators "
                f"by {worst:.3g} (limit {SPAN_TOLERANCE:g}); give an element closer to the identity"
            )
        return logs

    def random(self, rng: np.random.Generator, shape: Sizes) -> Matrix:
        """Exponentials of standard normal coordinates."""
        return exponential.exp(self._algebra.hat(rng.standard_normal((*shape, self._algebra.dimension))))


def _equilibrated(A: Matrix) -> Matrix:
    """Matrices with columns, then rows, divided by their largest entries: singular only if the given ones are."""
    for axis in (-2, -1):
        largest = np.abs(A).max(axis=axis, keepdims=True)
        A = A / np.where(largest > 0.0, largest, 1.0)
    return A


def _principal_logs(A: Matrix) -> Matrix:
    """The principal logarithms of matrices, shape (..., n, n), NaN where there is none."""
    with np.errstate(all="ignore"):  # what is no logarithm is NaN
        return exponential.batched_log(A, _principal_or_nan)


def _principal_or_nan(A: Matrix) -> Matrix:
    """The principal logarithm of one matrix, shape (n, n), or NaN where it has none."""
    nothing = np.full_like(A, np.nan)
    eigenvalues = np.linalg.eigvals(A)
    if np.any(np.pi - np.abs(np.angle(eigenvalues)) <= HALF_TURN_MARGIN) or np.any(eigenvalues == 0.0):
        return nothing
    try:
        L = exponential.principal_log(A)
        back = exponential.exp(L)
    except ValueError:  # NumPy's LinAlgError, or SciPy's where powers of the matrix overflow
        return nothing
    # far from normal matrices can lose all digits on the way
    return L if np.abs(back - A).max() <= SPAN_TOLERANCE * max(1.0, (np.abs(A).max())) else nothing
