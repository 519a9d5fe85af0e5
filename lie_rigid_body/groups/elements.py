"""What sets a group's elements apart from other matrices: the part of a group that its algebra does not say."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Real = NDArray[np.float64]


class Elements(ABC):
    """The elements of one matrix group, as `MatrixLieGroup` needs them.

    Each constructor of a group supplies one of these. Matrices come finite, of shape (..., n, n), and of the
    group's number type; all methods are batched over the leading axes.
    """

    @abstractmethod
    def distance(self, A: Array) -> Real:
        """How far each matrix is from fulfilling the equations, shape (...); infinite where it cannot be said."""

    def certain_distance(self, A: Array) -> Real:
        """How much of `distance` is certain, shape (...): less where there are elements that it does not recognise."""
        return self.distance(A)

    @abstractmethod
    def project(self, A: Array) -> Array:
        """The nearest element in the Frobenius norm, shape (..., n, n); an InputError where there is no nearest one."""

    def restored(self, A: Array) -> Array:
        """Elements that round-off has carried a little off the group, brought back where that can be done safely."""
        return self.project(A)

    @abstractmethod
    def inverse(self, A: Array) -> Array:
        """The inverse of each element, shape (..., n, n)."""

    @abstractmethod
    def log(self, A: Array) -> Array:
        """The logarithm in the algebra, shape (..., n, n); an InputError where none is singled out."""

    @abstractmethod
    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Independent random elements, shape (*shape, n, n)."""


def measured(A: Array, distance: Callable[[Array], Real]) -> Real:
    """Distances of matrices, shape (...), infinite for entries that are not finite.

    Parameters
    ----------
    A : ndarray, shape (..., n, n)
    distance : callable
        `Elements.distance` or `Elements.certain_distance`.
    """
    finite = np.isfinite(A).all(axis=(-2, -1))
    return np.where(finite, distance(np.where(finite[..., np.newaxis, np.newaxis], A, 0.0)), np.inf)
