"""The contract of a group's elements: what a matrix group needs to know beyond its algebra."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.groups.exponential import Matrix


class Elements(ABC):
    """Membership, projection, inverse, logarithm and random elements of one matrix group.

    Each constructor of a group supplies one of these. Matrices come finite, of shape (..., n, n), and of the
    group's number type; all methods are batched over the leading axes.
    """

    @abstractmethod
    def distance(self, A: Matrix) -> Array:
        """How far each matrix is from fulfilling the group's equations, shape (...); infinite where undefined."""

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

    @abstractmethod
    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Matrix:
        """Independent random elements, shape (*shape, n, n)."""


def measured(A: Matrix, distance: Callable[[Matrix], Array]) -> Array:
    """Distances of matrices from a group, shape (...); infinite for matrices with entries that are not finite.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)
    distance : callable
        `Elements.distance` or `Elements.certain_distance`.
    """
    finite = np.isfinite(A).all(axis=(-2, -1))
    return np.where(finite, distance(np.where(finite[..., np.newaxis, np.newaxis], A, 0.0)), np.inf)
