"""The contract of a group's elements: what a matrix group needs to know beyond its algebra."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.groups.algebra import frobenius
from lie_rigid_body.groups.arguments import within_doubles
from lie_rigid_body.groups.exponential import Matrix

NEGLIGIBLE_ANGLE: Final = 1e-5
"""Largest imaginary part of an eigenvalue, relative to the norm of its matrix, that counts as round-off.

The eigenvalues of a nilpotent matrix are 0, and come out as large as a root of the round-off unit.
"""


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
        """The nearest element in the Frobenius norm, shape (..., n, n); an InputError where there is no nearest one."""

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
    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Matrix:
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
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is no element
        return np.where(finite, distance(np.where(finite[..., np.newaxis, np.newaxis], A, 0.0)), np.inf)
